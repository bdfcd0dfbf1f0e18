//! The options of [`OPTIONS`] as arguments of clap.

use clap::builder::{PossibleValue, PossibleValuesParser, ValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use crate::base::names::Named;
use crate::render::options::Dispersion;
use crate::render::options::request::Request;
use crate::render::options::table::{Fallback, Kind, Needs, OPTIONS, RenderOption, find};
use crate::render::options::written::Refusal;

/// The option that a flag turns off, and the flag.
const DISPERSION: &RenderOption = find("dispersion");
const NO_DISPERSION: &str = "no-dispersion";

impl Args for Request {
    fn augment_args(command: Command) -> Command {
        command.args(OPTIONS.iter().map(argument)).arg(
            Arg::new(NO_DISPERSION)
                .long(NO_DISPERSION)
                .action(ArgAction::SetTrue)
                .help_heading(DISPERSION.group)
                .conflicts_with(DISPERSION.name)
                .help("Short for --dispersion off"),
        )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Request {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        // A default is left out, because its option may be invalid without the value of another option.
        let is_given = |option: &&RenderOption| matches.value_source(option.name) == Some(ValueSource::CommandLine);
        let value = |option: &'static RenderOption| Some((option, matches.get_one::<String>(option.name)?.as_str()));
        let off = matches.get_flag(NO_DISPERSION).then_some((DISPERSION, Dispersion::Off.name()));
        let values: Vec<_> = OPTIONS.iter().filter(is_given).filter_map(value).chain(off).collect();
        Self::from_values(&values).map_err(|refusal| {
            let kind = match refusal {
                Refusal::Value { .. } => ErrorKind::ValueValidation,
                Refusal::Requires { .. } => ErrorKind::MissingRequiredArgument,
                Refusal::Excludes { .. } => ErrorKind::ArgumentConflict,
            };
            clap::Error::raw(kind, refusal)
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn argument(option: &'static RenderOption) -> Arg {
    let mut argument = Arg::new(option.name)
        .long(option.name)
        .value_name(option.placeholder)
        .help_heading(option.group)
        // With this, a negative number is refused as a value and not as an unknown option.
        .allow_hyphen_values(true)
        .value_parser(parser(option));
    let mut help = option.help.to_owned();
    match option.fallback {
        Fallback::Name(name) => argument = argument.default_value(name()),
        _ if option.default_text().is_empty() => {}
        _ => help += &format!(" [default: {}]", option.default_text()),
    }
    let mut long_help = vec![help.clone()];
    long_help.extend(Some(option.more.to_owned()).filter(|more| !more.is_empty()));
    if !matches!(option.kind, Kind::Named { .. }) {
        long_help.push(format!("Value: {}.", option.kind.expected()));
    }
    argument = argument.long_help(long_help.join("\n\n"));
    if let Needs::Absence(other) = option.needs {
        argument = argument.conflicts_with(other);
    }
    argument.help(help)
}

/// Returns a parser that checks a value and keeps its text. [`Request::from_values`] reads the texts, in the
/// order of the table.
fn parser(option: &'static RenderOption) -> ValueParser {
    if let Kind::Named { names, .. } = option.kind {
        let names = names.iter().map(|(name, line)| {
            let value = PossibleValue::new(*name);
            if line.is_empty() { value } else { value.help(line.trim()) }
        });
        return PossibleValuesParser::new(names).into();
    }
    let check = move |text: &str| option.set(&mut Request::default(), text).map(|()| text.to_owned());
    ValueParser::new(check)
}
