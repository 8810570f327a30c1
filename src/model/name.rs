//! Names of nodes and elements, of which a mesh has millions: short ones lie where they are held.
//! Never here: how a word of a deck is looked up (`names`).

use std::fmt;
use std::io::Write as _;
use std::ops::Deref;

/// Bytes of a short name: all numbers that a mesh has.
const SHORT: usize = 14;

/// A name as the deck knows it, `12` or `INSTANCE.12`: a text that cannot be changed.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Name(Held);

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(clippy::box_collection, reason = "half as long as a text itself: few are of this kind")]
enum Held {
    Short(u8, [u8; SHORT]),
    Long(Box<String>),
}

impl Name {
    /// The name of a label: the number, behind its scope where it has one (an upper-case instance).
    pub(super) fn of_label(scope: &str, label: i64) -> Name {
        let mut bytes = [0; SHORT];
        let mut rest = &mut bytes[..];
        if scope.is_empty() && write!(rest, "{label}").is_ok() {
            let length = SHORT - rest.len();
            return Name(Held::Short(length as u8, bytes));
        }
        Name::from(super::names::qualified(scope, &label.to_string()))
    }

    /// As text.
    pub fn as_str(&self) -> &str {
        match &self.0 {
            // What was text is text.
            Held::Short(length, bytes) => std::str::from_utf8(&bytes[..usize::from(*length)]).unwrap_or_default(),
            Held::Long(text) => text,
        }
    }

    /// Bytes beside its own.
    pub(super) fn bytes_elsewhere(&self) -> usize {
        match &self.0 {
            Held::Short(..) => 0,
            Held::Long(text) => size_of::<String>() + text.capacity(),
        }
    }
}

impl Default for Name {
    fn default() -> Self {
        Name(Held::Short(0, [0; SHORT]))
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        let mut bytes = [0; SHORT];
        match bytes.get_mut(..text.len()) {
            Some(place) => {
                place.copy_from_slice(text.as_bytes());
                Name(Held::Short(text.len() as u8, bytes))
            }
            None => Name(Held::Long(Box::new(text.to_owned()))),
        }
    }
}

impl From<String> for Name {
    fn from(text: String) -> Self {
        if text.len() <= SHORT { Name::from(text.as_str()) } else { Name(Held::Long(Box::new(text))) }
    }
}

impl Deref for Name {
    type Target = str;

    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl PartialEq<str> for Name {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl PartialEq<String> for Name {
    fn eq(&self, other: &String) -> bool {
        self.as_str() == other
    }
}

#[cfg(test)]
mod tests {
    use super::Name;

    #[test]
    fn names_are_texts_short_or_long() {
        for text in ["", "12", "PLATE.12345678", "PLATE.123456789", "Pl\u{e4}tte.1234567"] {
            let name = Name::from(text);
            let owned = Name::from(String::from(text));
            assert!(name == text && name == owned && name.as_str() == text);
            assert_eq!(format!("{name:?} {name:>20}"), format!("{text:?} {text:>20}"));
        }
        for label in [0, 7, -12, i64::MAX, i64::MIN] {
            assert_eq!(Name::of_label("", label), label.to_string());
            assert_eq!(Name::of_label("A", label), format!("A.{label}"));
        }
        assert_eq!(size_of::<Name>(), 16);
    }
}
