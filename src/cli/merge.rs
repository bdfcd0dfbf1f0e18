//! The subcommand `goblet merge`: adds the checkpoints of shards and writes their image.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::outputs::{AN_IMAGE, Files, THE_CHECKPOINT, Written};
use super::render::{at, read_checkpoint, warn_of_other_maker, write_images};
use super::{Failure, MergeArgs, terminal};
use crate::image::file;
use crate::render::aov;
use crate::render::checkpoint::{Checkpoint, CheckpointError, ranges};

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
    let mut files = BTreeMap::new();
    for path in &args.checkpoints {
        let checkpoint = read_checkpoint(path)?;
        let shards: Vec<u32> = checkpoint.done.keys().copied().collect();
        match &mut sum {
            Some(sum) => {
                sum.merge(&checkpoint).map_err(|reason| in_both(path, reason, &files, sum.shards))?;
                if !args.quiet {
                    warn_of_other_maker(path, &checkpoint.made_by, &sum.made_by);
                }
            }
            None => sum = Some(checkpoint),
        }
        files.extend(shards.into_iter().map(|shard| (shard, path)));
    }
    // The command line requires at least one checkpoint.
    let Some(sum) = sum else { return Ok(()) };
    if !args.quiet {
        warn_of_missing(&sum);
    }
    let channels = aov::channels(&args.aov, &sum.estimate)?;
    let mut written = Written::default();
    if let Some(path) = &args.checkpoint {
        let outcome = sum.write(path).map_err(|reason| at(path, reason));
        if outcome.is_ok() && !args.quiet {
            terminal::say(format_args!("wrote {}", path.display()));
        }
        written.note(outcome);
    }
    let metadata = sum.metadata();
    written.note(write_images(&args.output, &sum.estimate, &channels, &metadata, args.exposure, args.quiet));
    written.end()
}

/// Returns the failure for a checkpoint that cannot be added. `files` has the files before it, by their shards.
fn in_both(path: &Path, reason: CheckpointError, files: &BTreeMap<u32, &PathBuf>, shards: u32) -> Failure {
    match reason {
        CheckpointError::Twice(shard) if files.contains_key(&shard) => Failure::ShardTwice {
            path: path.to_owned(),
            other: files[&shard].clone(),
            shard: format!("{shard}/{shards}"),
        },
        reason => at(path, reason),
    }
}

fn warn_of_missing(sum: &Checkpoint) {
    let missing = sum.missing();
    let shards = sum.shards;
    let what = match missing[..] {
        [] => return,
        [index] => format!("shard {index} of {shards}, counted from 0 (--shard {index}/{shards})"),
        [first, ..] => {
            format!(
                "shards {} of {shards}, counted from 0 (--shard {first}/{shards} and so on)",
                ranges(missing.iter())
            )
        }
    };
    terminal::warn(format_args!("missing: {what}; without what is missing, the image has more noise"));
}
