//! The subcommand `goblet merge`: adds the checkpoints of shards and writes their image.

use super::outputs::{AN_IMAGE, Files, THE_CHECKPOINT, Written};
use super::render::{at, read_checkpoint, warn_of_other_maker, write_images};
use super::{Failure, MergeArgs, terminal};
use crate::image::file;
use crate::render::aov;
use crate::render::checkpoint::Checkpoint;

/// Adds checkpoints, and writes every output.
///
/// # Errors
/// A checkpoint cannot be read or does not belong to the others, or an output cannot be written.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    let inputs =
        args.checkpoints.iter().fold(Files::default(), |files, path| files.reads("a checkpoint to merge", path));
    inputs.writes(AN_IMAGE, &args.output).writes(THE_CHECKPOINT, &args.checkpoint).check()?;
    for path in &args.output {
        file::check_writable(path)?;
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
    // The command line requires at least one checkpoint.
    let Some(sum) = sum else { return Ok(()) };
    if !args.quiet {
        warn_of_missing(&sum);
    }
    let channels = aov::channels(&args.aov, &sum.estimate)?;
    let mut written = Written::default();
    if let Some(path) = &args.checkpoint {
        written.note(sum.write(path).map_err(|reason| at(path, reason)));
    }
    let metadata = sum.metadata();
    written.note(write_images(&args.output, &sum.estimate, &channels, &metadata, args.exposure, args.quiet));
    written.end()
}

fn warn_of_missing(sum: &Checkpoint) {
    let missing: Vec<String> = sum.missing().iter().map(u32::to_string).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        let shards = sum.shards;
        terminal::warn(format_args!("of {shards} shards, {missing} are not here: the image has more noise"));
    }
}
