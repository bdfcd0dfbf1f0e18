//! The type table: the types of each directive, and the parameters of each type.

use std::collections::BTreeMap;

use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::instead;
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::{Param, ParamList};
use crate::scene::format::version3;

/// The support of goblet for a type or parameter of the pbrt format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Supported as in pbrt.
    Full,
    /// Accepted without effect, because it cannot change the image.
    Ignored,
    /// Not supported yet: an error.
    Later,
}

/// A parameter that some type accepts.
#[derive(Clone, Copy, Debug)]
pub struct ParamSpec {
    /// Name of the parameter.
    pub name: &'static str,
    /// Types that the parameter may be declared with.
    pub kinds: &'static [Kind],
    /// Support of the parameter.
    pub support: Support,
}

/// A type of a directive, such as `"sphere"` of `Shape`.
#[derive(Clone, Copy, Debug)]
pub struct TypeSpec {
    /// Name of the type.
    pub name: &'static str,
    /// Support of the type.
    pub support: Support,
    /// Parameters that the type accepts; empty if the type is not supported.
    pub parameters: &'static [ParamSpec],
}

/// A directive with a type and parameters, and all its types.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Name of the directive.
    pub directive: &'static str,
    /// Types of the directive.
    pub types: &'static [TypeSpec],
}

/// The parameters of a scene that cannot change its image: each by its type, with the place of the first.
#[derive(Debug, Default)]
pub(in crate::scene) struct Ignored(BTreeMap<String, String>);

impl Ignored {
    fn note(&mut self, param: &Param, of: &str) {
        self.0.entry(format!("{param} of {of}")).or_insert_with(|| param.location.to_string());
    }

    /// Adds what another list has.
    pub fn add(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Returns a line for each parameter, with its place.
    pub fn lines(&self) -> Vec<String> {
        self.0.iter().map(|(what, place)| format!("{place}: {what}")).collect()
    }
}

/// Returns the entry of a parameter that is supported as in pbrt.
pub(in crate::scene) const fn full(name: &'static str, kinds: &'static [Kind]) -> ParamSpec {
    ParamSpec { name, kinds, support: Support::Full }
}

/// Returns the entry of a parameter that cannot change the image.
pub(in crate::scene) const fn ignored(name: &'static str, kinds: &'static [Kind]) -> ParamSpec {
    ParamSpec { name, kinds, support: Support::Ignored }
}

/// Returns the entry of a parameter that is not supported yet.
pub(in crate::scene) const fn later(name: &'static str, kinds: &'static [Kind]) -> ParamSpec {
    ParamSpec { name, kinds, support: Support::Later }
}

/// Returns the entry of a type that is supported.
pub(in crate::scene) const fn supported(name: &'static str, parameters: &'static [ParamSpec]) -> TypeSpec {
    TypeSpec { name, support: Support::Full, parameters }
}

/// Returns the entry of a type that is not supported yet.
pub(in crate::scene) const fn not_yet(name: &'static str) -> TypeSpec {
    TypeSpec { name, support: Support::Later, parameters: &[] }
}

impl Family {
    /// Finds the type `name`, checks the names and types of the parameters, and notes those that are ignored.
    /// `defaults` come from `Attribute`; defaults that the type does not accept are dropped, as in pbrt.
    pub(in crate::scene) fn check(
        &self,
        name: &str,
        location: &Location,
        params: &mut ParamList,
        defaults: &ParamList,
        ignored: &mut Ignored,
    ) -> Result<&'static TypeSpec, SceneError> {
        let directive = self.directive;
        let found = self.types.iter().find(|t| t.name == name);
        let spec = found.ok_or_else(|| {
            location.invalid(format!(
                "unknown {directive} \"{}\"; expected one of: {}{}",
                shorten(name),
                self.supported_types(),
                version3::hint_at(directive, name)
            ))
        })?;
        if spec.support == Support::Later {
            let supported = self.supported_types() + instead::of(directive, name);
            return Err(location.unsupported(&format!("{directive} \"{name}\""), &supported));
        }
        for default in &defaults.items {
            let usable = spec.parameters.iter().any(|p| p.name == default.name);
            if usable && params.get(&default.name).is_none() {
                default.read_again().map_err(location.over())?;
                params.items.push(default.clone());
            }
        }
        for param in &params.items {
            self.check_param(spec, param, ignored)?;
        }
        Ok(spec)
    }

    /// Returns true if any of the types has a parameter of that name.
    pub(in crate::scene) fn knows(&self, name: &str) -> bool {
        self.types.iter().flat_map(|t| t.parameters).any(|parameter| parameter.name == name)
    }

    fn check_param(&self, spec: &TypeSpec, param: &Param, ignored: &mut Ignored) -> Result<(), SceneError> {
        let what = format!("{} \"{}\"", self.directive, spec.name);
        let Some(accepted) = spec.parameters.iter().find(|p| p.name == param.name) else {
            let hint = version3::hint_at_parameter(self.directive, &param.name);
            return Err(param
                .location
                .invalid(format!("unknown parameter {param}; {what} accepts: {}{hint}", spec.accepted())));
        };
        if !accepted.kinds.contains(&param.kind) {
            return Err(param
                .location
                .invalid(format!("{param} has the wrong type; {what} accepts: {}", spec.accepted())));
        }
        match accepted.support {
            Support::Full => {}
            Support::Ignored => ignored.note(param, &what),
            Support::Later => {
                return Err(param.location.unsupported(&format!("{param} of {what}"), &spec.accepted()));
            }
        }
        Ok(())
    }

    fn supported_types(&self) -> String {
        let names: Vec<String> =
            self.types.iter().filter(|t| t.support != Support::Later).map(|t| format!("\"{}\"", t.name)).collect();
        names.join(", ")
    }
}

impl TypeSpec {
    fn accepted(&self) -> String {
        let mut declarations = Vec::new();
        for param in self.parameters {
            if param.support != Support::Later {
                for kind in param.kinds {
                    declarations.push(format!("\"{} {}\"", kind.word(), param.name));
                }
            }
        }
        if declarations.is_empty() {
            return "no parameters".to_string();
        }
        declarations.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::format::lexer::TokenStream;

    const FAMILY: Family = Family {
        directive: "Shape",
        types: &[
            supported(
                "ball",
                &[
                    full("size", &[Kind::Float]),
                    later("alpha", &[Kind::Float]),
                    full("tint", &[Kind::Rgb, Kind::Texture]),
                ],
            ),
            not_yet("cone"),
        ],
    };

    fn check(name: &str, text: &str) -> Result<ParamList, String> {
        let mut stream = TokenStream::new(text.to_string(), "t", None);
        let mut read = || {
            let mut params = ParamList::read(&mut stream)?;
            params.take_repeated()?;
            let location = stream.end().clone();
            FAMILY.check(name, &location, &mut params, &ParamList::default(), &mut Ignored::default())?;
            Ok(params)
        };
        read().map_err(|e: SceneError| e.to_string())
    }

    #[test]
    fn values_are_read() {
        let params = check("ball", "\"float size\" 2.5 \"rgb tint\" [1 .5 0]").unwrap();
        assert_eq!(params.float("size").unwrap(), Some(2.5));
        assert_eq!(params.triples("tint"), [DVec3::new(1.0, 0.5, 0.0)]);
    }

    #[test]
    fn complaints_list_what_is_accepted() {
        for (name, text, expected) in [
            (
                "ball",
                "\"float sise\" 1",
                "t:1:1: unknown parameter \"float sise\"; Shape \"ball\" accepts: \"float size\", \"rgb tint\", \"texture tint\"",
            ),
            ("ball", "\"integer size\" 1", "\"integer size\" has the wrong type"),
            ("ball", "\"float alpha\" 1", "\"float alpha\" of Shape \"ball\" is not supported yet"),
            ("ball", "\"texture size\" \"x\"", "\"texture size\" has the wrong type"),
            ("ball", "\"float size\" [1", "ends here; expected a value of \"float size\", or `]`"),
            ("ball", "\"float size\" \"1\"", "t:1:14: found \"1\" as a value"),
            ("ball", "\"rgb tint\" [1 2]", "2 values; expected a multiple of 3"),
            ("ball", "\"integer n\" 1.5", "expected a whole number"),
            ("ball", "\"float size\" nan", "found `nan` as a value"),
            ("ball", "\"size\" 1", "expected \"type name\""),
            ("ball", "\"colour size\" 1", "unknown parameter type `colour`"),
            ("ball", "\"float size\" 1 \"integer size\" 2", "is given a second time, before as \"float\""),
            ("ball", "\"integer n\" 2.0", "found `2.0` as a value of \"integer n\"; expected a whole number"),
            ("ball", "\"integer n\" [ 1 -3e0 ]", "found `-3e0` as a value of \"integer n\"; expected a whole number"),
            ("ball", "\"spectrum s\" [1 \"x\"]", "found \"x\" as a value"),
            ("cone", "", "Shape \"cone\" is not supported yet; supported here: \"ball\""),
            ("cube", "", "unknown Shape \"cube\"; expected one of: \"ball\""),
        ] {
            let error = check(name, text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn attribute_defaults_apply_where_the_type_has_them() {
        let list = |text: &str| ParamList::read(&mut TokenStream::new(text.to_string(), "t", None)).unwrap();
        let mut params = list("");
        let location = TokenStream::new(String::new(), "t", None).end().clone();
        let defaults = list("\"float size\" 3 \"float unknown\" 1");
        FAMILY.check("ball", &location, &mut params, &defaults, &mut Ignored::default()).unwrap();
        assert_eq!(params.float("size").unwrap(), Some(3.0));
        assert_eq!(params.items.len(), 1);
    }
}
