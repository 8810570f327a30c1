//! Names of nodes and elements. Short names, which are nearly all, are stored inline.

use std::collections::HashMap;
use std::fmt;
use std::io::Write as _;
use std::ops::Deref;

/// Largest number of bytes of an inline name.
const SHORT: usize = 14;

/// The immutable name of a node or element: `12` or `INSTANCE.12`.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EntityName(NameStorage);

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(clippy::box_collection, reason = "smaller than a String, and long names are rare")]
enum NameStorage {
    Short(u8, [u8; SHORT]),
    Long(Box<String>),
}

impl EntityName {
    /// Returns the name of a label in a scope: `label`, or `INSTANCE.label`.
    pub(super) fn of_label(scope: &str, label: i64) -> EntityName {
        let mut bytes = [0; SHORT];
        let mut remaining = &mut bytes[..];
        if scope.is_empty() && write!(remaining, "{label}").is_ok() {
            let length = SHORT - remaining.len();
            return EntityName(NameStorage::Short(length as u8, bytes));
        }
        EntityName::from(super::names::qualified(scope, &label.to_string()))
    }

    /// Returns the name as text.
    pub fn as_str(&self) -> &str {
        match &self.0 {
            // The bytes were copied from a valid text.
            NameStorage::Short(length, bytes) => {
                std::str::from_utf8(&bytes[..usize::from(*length)]).unwrap_or_default()
            }
            NameStorage::Long(text) => text,
        }
    }

    /// Returns the heap memory in bytes.
    pub(super) fn bytes_elsewhere(&self) -> usize {
        match &self.0 {
            NameStorage::Short(..) => 0,
            NameStorage::Long(text) => size_of::<String>() + text.capacity(),
        }
    }
}

/// Labels of new nodes or elements: above the largest label of their part instance.
#[derive(Default)]
pub(super) struct NewLabels {
    largest: HashMap<String, i64>,
}

impl NewLabels {
    /// Creates labels above those of existing names.
    pub(super) fn above<'a>(names: impl Iterator<Item = &'a EntityName>) -> NewLabels {
        let mut labels = NewLabels::default();
        for name in names {
            let (scope, label) = name.rsplit_once('.').unwrap_or(("", name));
            let label = label.parse().unwrap_or(0);
            match labels.largest.get_mut(scope) {
                Some(largest) => *largest = label.max(*largest),
                None => drop(labels.largest.insert(scope.to_owned(), label)),
            }
        }
        labels
    }

    /// Returns the name of the next node or element in the part instance of `like`.
    pub(super) fn next(&mut self, like: &EntityName) -> EntityName {
        let scope = like.rsplit_once('.').map_or("", |(scope, _)| scope);
        let Some(largest) = self.largest.get_mut(scope) else { return like.clone() };
        *largest = largest.saturating_add(1);
        EntityName::of_label(scope, *largest)
    }
}

impl Default for EntityName {
    fn default() -> Self {
        EntityName(NameStorage::Short(0, [0; SHORT]))
    }
}

impl From<&str> for EntityName {
    fn from(text: &str) -> Self {
        let mut bytes = [0; SHORT];
        match bytes.get_mut(..text.len()) {
            Some(place) => {
                place.copy_from_slice(text.as_bytes());
                EntityName(NameStorage::Short(text.len() as u8, bytes))
            }
            None => EntityName(NameStorage::Long(Box::new(text.to_owned()))),
        }
    }
}

impl From<String> for EntityName {
    fn from(text: String) -> Self {
        if text.len() <= SHORT {
            EntityName::from(text.as_str())
        } else {
            EntityName(NameStorage::Long(Box::new(text)))
        }
    }
}

impl Deref for EntityName {
    type Target = str;

    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl fmt::Display for EntityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for EntityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl PartialEq<str> for EntityName {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for EntityName {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

impl PartialEq<String> for EntityName {
    fn eq(&self, other: &String) -> bool {
        self.as_str() == other
    }
}

#[cfg(test)]
mod tests {
    use super::EntityName;

    #[test]
    fn short_and_long_names_compare_as_text() {
        for text in ["", "12", "PLATE.12345678", "PLATE.123456789", "Pl\u{e4}tte.1234567"] {
            let name = EntityName::from(text);
            let owned = EntityName::from(String::from(text));
            assert!(name == text && name == owned && name.as_str() == text);
            assert_eq!(format!("{name:?} {name:>20}"), format!("{text:?} {text:>20}"));
        }
        for label in [0, 7, -12, i64::MAX, i64::MIN] {
            assert_eq!(EntityName::of_label("", label), label.to_string());
            assert_eq!(EntityName::of_label("A", label), format!("A.{label}"));
        }
        assert_eq!(size_of::<EntityName>(), 16);
    }
}
