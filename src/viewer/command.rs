//! The subcommand `goblet view`.

use crate::cli::outputs::{AN_IMAGE, Files, THE_STATISTICS};
use crate::cli::stats::{Stats, write_json};
use crate::cli::{Failure, RenderArgs, terminal};
use crate::render::error::RenderError;
use crate::scene::Scene;

/// Shows a scene until the window is closed.
///
/// # Errors
/// The scene or an option is invalid, there is no display, or the device or an output fails.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    refuse(args)?;
    if let Some(path) = &args.stats {
        Stats::check_writable(path)?;
    }
    let scene = Scene::load_within(&args.scene, args.scene_memory.budget())?;
    let files = Files::default().reads_scene(&args.scene, &scene);
    files.writes(AN_IMAGE, &args.output).writes(THE_STATISTICS, &args.stats).check()?;
    for warning in scene.warnings.iter().filter(|_| !args.quiet) {
        terminal::warn(warning);
    }
    let stats = super::run(args, scene)?;
    args.stats.as_ref().map_or(Ok(()), |path| write_json(path, &stats))
}

/// Refuses the arguments that only `goblet render` accepts.
fn refuse(args: &RenderArgs) -> Result<(), Failure> {
    let others = [
        ("--time", args.request.limits.time.is_some()),
        ("--target-error", args.request.limits.target_error.is_some()),
        ("--rounds", args.request.limits.rounds.is_some()),
        ("--checkpoint", args.checkpoint.is_some()),
        ("--resume", args.resume.is_some()),
        ("--shard", args.shard.is_some()),
        ("--record-times", args.record_times),
    ];
    match others.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => Err(RenderError::Option(format!("{name} is of goblet render, not of goblet view")).into()),
        None => Ok(()),
    }
}
