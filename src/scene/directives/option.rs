//! The `Option` directive: options of pbrt itself, most of which have no effect in goblet.

use crate::scene::directives::state::SceneOptions;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::{TokenStream, shorten};
use crate::scene::format::params::{Param, ParamList};

/// The options of pbrt-v4, with the types of their values.
const OPTIONS: &[(&str, Kind)] = &[
    ("disablepixeljitter", Kind::Bool),
    ("disabletexturefiltering", Kind::Bool),
    ("disablewavelengthjitter", Kind::Bool),
    ("displacementedgescale", Kind::Float),
    ("forcediffuse", Kind::Bool),
    ("msereferenceimage", Kind::String),
    ("msereferenceout", Kind::String),
    ("pixelstats", Kind::Bool),
    ("rendercoordsys", Kind::String),
    ("seed", Kind::Integer),
    ("wavefront", Kind::Bool),
];

/// Reads the rest of an `Option` directive and executes it. An option is a bare name and one value, as
/// `"seed" 42`, or a declared parameter, as `"integer seed" [ 42 ]`.
pub(in crate::scene) fn read(stream: &mut TokenStream, options: &mut SceneOptions) -> Result<(), SceneError> {
    let (name, location) = stream.string("the name of an option")?;
    let option = if name.trim().contains([' ', '\t']) {
        declared(stream, &name, location)?
    } else {
        let Some((known, kind)) = find(&name) else {
            return Err(unknown(&location, &format!("\"{}\"", shorten(&name))));
        };
        Param::read_undeclared(stream, *kind, known, location)?
    };
    apply(option, options)
}

fn declared(stream: &mut TokenStream, declaration: &str, location: Location) -> Result<Param, SceneError> {
    let mut option = Param::read(stream, declaration, location)?;
    match find(&option.name) {
        Some((known, kind)) if *kind == option.kind => option.name = (*known).to_string(),
        _ => return Err(unknown(&option.location, &option.to_string())),
    }
    Ok(option)
}

/// Finds an option by its name. As in pbrt, case, `-` and `_` do not matter.
fn find(name: &str) -> Option<&'static (&'static str, Kind)> {
    let plain: String =
        name.trim().chars().filter(|c| !matches!(c, '-' | '_')).map(|c| c.to_ascii_lowercase()).collect();
    OPTIONS.iter().find(|(known, _)| *known == plain)
}

fn unknown(location: &Location, what: &str) -> SceneError {
    let known: Vec<String> = OPTIONS.iter().map(|(name, kind)| format!("\"{name}\" ({})", kind.word())).collect();
    location.invalid(format!("unknown Option {what}; expected one of: {}", known.join(", ")))
}

fn apply(option: Param, options: &mut SceneOptions) -> Result<(), SceneError> {
    let params = ParamList::of(option);
    let option = &params.items[0];
    match option.name.as_str() {
        "forcediffuse" if params.flag("forcediffuse")? => {
            return Err(option.location.unsupported(&format!("{option} true"), "false"));
        }
        "disablepixeljitter" => options.without_jitter = params.flag("disablepixeljitter")?,
        "seed" => options.seed = Some(seed(option)?),
        "rendercoordsys" if !matches!(option.text(), Some("camera" | "cameraworld" | "world")) => {
            return Err(option.bad_value("\"camera\", \"cameraworld\" or \"world\""));
        }
        _ => {}
    }
    Ok(())
}

/// Returns the seed as 32 bits; pbrt's seeds may be negative.
fn seed(option: &Param) -> Result<u32, SceneError> {
    let [value] = option.one()?;
    if !(f64::from(i32::MIN)..=f64::from(u32::MAX)).contains(&value) {
        return Err(option.bad_value(&format!("a whole number from {} to {}", i32::MIN, u32::MAX)));
    }
    Ok(value as i64 as u32)
}
