//! Options of `goblet render` that choose how rays meet bodies of revolution.

use clap::error::ErrorKind;
use clap::{ArgMatches, Args, Command, FromArgMatches, ValueEnum};

use super::values::whole_number;
use crate::gpu_scene::pack::{Envelopes, RevolutionSolver};

/// The options as they are written.
#[derive(Args, Clone, Copy, Debug)]
struct SolverArgs {
    /// How rays meet bodies of revolution
    #[arg(long, value_enum, value_name = "SOLVER", default_value_t, help_heading = "Research")]
    revolution_solver: SolverName,

    /// Newton: pieces of each start approximation, per segment of a profile [default: 16]
    #[arg(long, value_name = "M", value_parser = segments, help_heading = "Research")]
    #[arg(allow_negative_numbers = true)]
    newton_segments: Option<u32>,

    /// Newton: approximations of a profile that give starts [default: both]
    #[arg(long, value_enum, value_name = "WHICH", help_heading = "Research")]
    newton_envelopes: Option<Envelopes>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum SolverName {
    /// Misses no root
    #[default]
    Certified,
    /// The classical method, for comparison: misses some
    Newton,
}

fn segments(text: &str) -> Result<u32, String> {
    whole_number(text, RevolutionSolver::SEGMENTS)
}

impl SolverArgs {
    fn solver(self) -> Result<RevolutionSolver, clap::Error> {
        let Self { revolution_solver, newton_segments, newton_envelopes } = self;
        match (revolution_solver, newton_segments, newton_envelopes) {
            (SolverName::Newton, segments, envelopes) => Ok(RevolutionSolver::Newton {
                segments: segments.unwrap_or(RevolutionSolver::DEFAULT_SEGMENTS),
                envelopes: envelopes.unwrap_or_default(),
            }),
            (SolverName::Certified, None, None) => Ok(RevolutionSolver::Certified),
            (SolverName::Certified, segments, _) => {
                let option = if segments.is_some() { "--newton-segments" } else { "--newton-envelopes" };
                let message = format!("{option} requires --revolution-solver newton");
                Err(clap::Error::raw(ErrorKind::MissingRequiredArgument, message))
            }
        }
    }
}

// clap lets an option require another, but not with a certain value.
impl FromArgMatches for RevolutionSolver {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        SolverArgs::from_arg_matches(matches)?.solver()
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for RevolutionSolver {
    fn augment_args(command: Command) -> Command {
        SolverArgs::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        SolverArgs::augment_args_for_update(command)
    }
}
