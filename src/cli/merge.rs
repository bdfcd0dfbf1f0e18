//! `goblet merge`: checkpoints of shards to the image of all.

use super::render::{at, metadata, read_checkpoint, warn_of_other_maker, write_images};
use super::{Failure, MergeArgs};
use crate::checkpoint::Checkpoint;
use crate::output;

/// Adds checkpoints, and writes every output.
///
/// # Errors
/// A checkpoint cannot be read or does not belong to the others, or an output cannot be
/// written.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    for path in &args.output {
        output::check_writable(path)?;
    }
    if let Some(path) = &args.checkpoint {
        Checkpoint::check_writable(path).map_err(|reason| at(path, reason))?;
    }
    let mut sum: Option<Checkpoint> = None;
    for path in &args.checkpoints {
        let checkpoint = read_checkpoint(path)?;
        match &mut sum {
            Some(sum) => {
                sum.merge(&checkpoint).map_err(|reason| at(path, reason))?;
                if !args.quiet {
                    warn_of_other_maker(path, &checkpoint.made_by, &sum.made_by);
                }
            }
            None => sum = Some(checkpoint),
        }
    }
    // The command line has at least one.
    let Some(sum) = sum else { return Ok(()) };
    if !args.quiet {
        warn_of_missing(&sum);
    }
    if let Some(path) = &args.checkpoint {
        sum.write(path).map_err(|reason| at(path, reason))?;
    }
    let metadata = metadata(&sum.scene, &sum.made_by, &sum.estimate, sum.tally.emitted);
    write_images(&args.output, &sum.estimate, &args.aov, &metadata, args.quiet)
}

fn warn_of_missing(sum: &Checkpoint) {
    let missing: Vec<String> = sum.missing().iter().map(u32::to_string).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        eprintln!("warning: of {} shards, {missing} are not here: the image has more noise", sum.shards);
    }
}
