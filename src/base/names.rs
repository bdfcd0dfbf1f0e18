//! Enums whose values have names, which the command line, checkpoints and documents use.

/// A name of a value, and one line that says what the value does.
pub type Name = (&'static str, &'static str);

/// An enum whose values have names. The macro `named!` implements it.
pub trait Named: Copy + PartialEq + 'static {
    /// All values, in the order in which they are listed.
    const ALL: &'static [Self];
    /// The names of [`Named::ALL`], in the same order. A line has no full stop at its end, and begins with a
    /// space, as doc comments do.
    const NAMES: &'static [Name];

    /// The name of this value, such as `hash-grid`.
    fn name(self) -> &'static str;

    /// The value that has a name.
    ///
    /// # Errors
    /// No value has it; the message lists the names, as in `expected a, b or c`.
    fn from_name(name: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|value| value.name() == name);
        found.copied().ok_or_else(|| expected_name(Self::NAMES))
    }
}

/// As in `expected a, b or c`.
pub(crate) fn expected_name(names: &[Name]) -> String {
    let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("expected {} or {last}", rest.join(", ")),
        _ => format!("expected {}", names.join("")),
    }
}

/// Defines an enum that is [`Named`]. The value after `=` is the default. The doc comment of a
/// value is one line, which `--help` prints too.
macro_rules! named {
    (
        $(#[doc = $text:literal])+
        pub enum $Enum:ident = $Default:ident {
            $(#[doc = $line:literal] $Value:ident: $name:literal),+ $(,)?
        }
    ) => {
        $(#[doc = $text])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Enum {
            $(#[doc = $line] $Value),+
        }

        impl $crate::base::names::Named for $Enum {
            const ALL: &'static [Self] = &[$(Self::$Value),+];
            const NAMES: &'static [$crate::base::names::Name] = &[$(($name, $line)),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$Value => $name),+
                }
            }
        }

        #[allow(clippy::derivable_impls, reason = "a macro cannot mark the default value")]
        impl Default for $Enum {
            fn default() -> Self {
                Self::$Default
            }
        }

        impl std::fmt::Display for $Enum {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str($crate::base::names::Named::name(*self))
            }
        }

        impl std::str::FromStr for $Enum {
            type Err = String;

            fn from_str(name: &str) -> Result<Self, String> {
                $crate::base::names::Named::from_name(name)
            }
        }
    };
}
pub(crate) use named;

#[cfg(test)]
mod tests {
    use super::*;

    named! {
        /// Three values.
        pub enum Three = Second {
            /// The first one
            First: "first",
            /// The second one
            Second: "second-one",
            /// The third one
            Third: "third",
        }
    }

    #[test]
    fn a_value_is_found_by_its_name_only() {
        assert_eq!(Three::default(), Three::Second);
        for (value, (name, line)) in Three::ALL.iter().zip(Three::NAMES) {
            assert_eq!((name.parse(), value.to_string().as_str()), (Ok(*value), *name));
            assert!(line.starts_with(" The "));
        }
        assert_eq!("Second".parse::<Three>(), Err("expected first, second-one or third".to_owned()));
    }
}
