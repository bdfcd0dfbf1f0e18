//! Types of parameters.

/// The declared type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `true` or `false`.
    Bool,
    /// A whole number.
    Integer,
    /// A number.
    Float,
    /// Two numbers.
    Point2,
    /// Two numbers.
    Vector2,
    /// Three numbers.
    Point3,
    /// Three numbers.
    Vector3,
    /// Three numbers.
    Normal,
    /// Linear RGB in the sRGB primaries.
    Rgb,
    /// A named spectrum, or pairs of a wavelength in nm and a value.
    Spectrum,
    /// The temperature of a black body, in K.
    Blackbody,
    /// Quoted text.
    String,
    /// The name of a `Texture`.
    Texture,
}

impl Kind {
    pub(in crate::scene) const ALL: [(Kind, &'static str); 13] = [
        (Kind::Bool, "bool"),
        (Kind::Integer, "integer"),
        (Kind::Float, "float"),
        (Kind::Point2, "point2"),
        (Kind::Vector2, "vector2"),
        (Kind::Point3, "point3"),
        (Kind::Vector3, "vector3"),
        (Kind::Normal, "normal"),
        (Kind::Rgb, "rgb"),
        (Kind::Spectrum, "spectrum"),
        (Kind::Blackbody, "blackbody"),
        (Kind::String, "string"),
        (Kind::Texture, "texture"),
    ];

    pub(in crate::scene) fn from_word(word: &str) -> Option<Kind> {
        // Scenes contain both spellings; pbrt itself has used either.
        let word = if word == "normal3" { "normal" } else { word };
        Self::ALL.iter().find(|(_, name)| *name == word).map(|(kind, _)| *kind)
    }

    /// Returns the word that declares the type in a scene file.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// Returns the number of numbers in one value of the type: a list has a multiple of it.
    pub(in crate::scene) fn group(self) -> usize {
        match self {
            Kind::Point2 | Kind::Vector2 => 2,
            Kind::Point3 | Kind::Vector3 | Kind::Normal | Kind::Rgb => 3,
            _ => 1,
        }
    }
}
