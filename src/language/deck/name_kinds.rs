//! Which parameters and fields of the keyword table hold names, and of what: for editors, which follow a name from its
//! definition to its uses. The kinds follow from the names of the parameters and fields, so that a card is described
//! once, in `table/`.

use super::keywords::{InputRule, InputUsage, Keyword};
use super::value::ValueKind;

/// Defines the kinds of names, each with its words.
macro_rules! name_kinds {
    ($($kind:ident $words:literal)*) => {
        /// Kind of object that a name identifies.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum NameKind {
            $(#[doc = concat!("A name of ", $words, ".")] $kind,)*
        }

        impl NameKind {
            /// Returns the kind in words, for example `node set`.
            pub fn words(self) -> &'static str {
                match self {
                    $(NameKind::$kind => $words,)*
                }
            }
        }
    };
}

name_kinds! {
    NodeSet "node set"
    ElementSet "element set"
    Surface "surface"
    Material "material"
    Amplitude "amplitude"
    Interaction "surface interaction"
    SectionControls "section controls"
    AdaptiveControls "adaptive mesh controls"
    Part "part"
    Instance "instance"
    Step "step"
    Target "target"
    ContactPairSet "set of contact pairs"
    TimePoints "time points"
    OutputSection "section of integrated output"
    Clearance "contact clearance"
    ContactInitialization "contact initialization data"
    WaveProperty "incident wave property"
    Orientation "orientation"
    Parameter "parameter"
}

/// How a parameter or field refers to a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NameUsage {
    /// Kind of object that has the name.
    pub kind: NameKind,
    /// Whether the card defines the name.
    pub defines: bool,
}

impl NameKind {
    /// Returns whether each part has names of this kind that do not collide with those of other parts.
    pub fn is_scoped(self) -> bool {
        matches!(self, NameKind::NodeSet | NameKind::ElementSet | NameKind::Surface)
    }
}

/// Returns how a parameter of a card refers to a name; `None` if its value is not a name of the deck.
pub fn parameter_name_usage(keyword: &Keyword, rule: &InputRule) -> Option<NameUsage> {
    let supported = matches!(rule.usage, InputUsage::Read | InputUsage::Inert(_));
    if !supported || rule.value.kind != ValueKind::Text {
        return None;
    }
    let adds_members = |kind, cards: &[&str]| Some(NameUsage { kind, defines: cards.contains(&keyword.name) });
    let reference = |kind| Some(NameUsage { kind, defines: false });
    match rule.name {
        "NAME" | "CONSTRAINT NAME" => defined_by(keyword.name).map(|kind| NameUsage { kind, defines: true }),
        "NSET" => adds_members(NameKind::NodeSet, &["NSET", "NODE", "NGEN", "NFILL", "NCOPY", "MESH"]),
        "ELSET" if keyword.name == "RIGID SURFACE" => Some(NameUsage { kind: NameKind::Surface, defines: true }),
        "ELSET" => adds_members(NameKind::ElementSet, &["ELSET", "ELEMENT", "ELGEN", "ELCOPY", "MESH"]),
        "NEW SET" | "OLD SET" => {
            let kind = if keyword.name == "ELCOPY" { NameKind::ElementSet } else { NameKind::NodeSet };
            Some(NameUsage { kind, defines: rule.name == "NEW SET" })
        }
        "REF NODE" | "PIN NSET" | "TIE NSET" | "TIED NSET" => reference(NameKind::NodeSet),
        "SURFACE" | "SECOND SURFACE" | "MASTER" | "SLAVE" | "ANALYTICAL SURFACE" => reference(NameKind::Surface),
        "MATERIAL" => reference(NameKind::Material),
        "AMPLITUDE" | "FILM AMPLITUDE" => reference(NameKind::Amplitude),
        "INTERACTION" | "CONTACT PAIR" => reference(NameKind::Interaction),
        "CONTROLS" if keyword.name == "ADAPTIVE MESH" => reference(NameKind::AdaptiveControls),
        "CONTROLS" => reference(NameKind::SectionControls),
        "PART" => reference(NameKind::Part),
        "INSTANCE" => reference(NameKind::Instance),
        "TARGET" => reference(NameKind::Target),
        "CPSET" => adds_members(NameKind::ContactPairSet, &["CONTACT PAIR"]),
        "TIME POINTS" => reference(NameKind::TimePoints),
        "SECTION" => reference(NameKind::OutputSection),
        "ORIENTATION" => reference(NameKind::Orientation),
        "PROPERTY" if keyword.name == "INCIDENT WAVE INTERACTION" => reference(NameKind::WaveProperty),
        _ => None,
    }
}

/// Returns what the parameter `NAME` of a card defines.
fn defined_by(keyword: &str) -> Option<NameKind> {
    Some(match keyword {
        "SURFACE" | "RIGID SURFACE" => NameKind::Surface,
        "MATERIAL" => NameKind::Material,
        "AMPLITUDE" => NameKind::Amplitude,
        "SURFACE INTERACTION" => NameKind::Interaction,
        "SECTION CONTROLS" => NameKind::SectionControls,
        "ADAPTIVE MESH CONTROLS" => NameKind::AdaptiveControls,
        "PART" => NameKind::Part,
        "INSTANCE" => NameKind::Instance,
        "STEP" => NameKind::Step,
        "TARGET" => NameKind::Target,
        "TIME POINTS" => NameKind::TimePoints,
        "INTEGRATED OUTPUT SECTION" => NameKind::OutputSection,
        "CONTACT CLEARANCE" => NameKind::Clearance,
        "CONTACT INITIALIZATION DATA" => NameKind::ContactInitialization,
        "INCIDENT WAVE INTERACTION PROPERTY" => NameKind::WaveProperty,
        "ORIENTATION" => NameKind::Orientation,
        _ => return None,
    })
}

/// Returns what a field of a data line refers to, unless it holds a number; `None` if it holds no name.
pub fn field_name_kind(rule: &InputRule) -> Option<NameKind> {
    match rule.name {
        "node or set" | "reference node or set" | "first set" | "second set" => Some(NameKind::NodeSet),
        "element or set" => Some(NameKind::ElementSet),
        "surface" | "first surface" | "second surface" | "master surface" | "slave surface" => Some(NameKind::Surface),
        "material" => Some(NameKind::Material),
        "interaction" => Some(NameKind::Interaction),
        "clearance name" => Some(NameKind::Clearance),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::deck::keywords::{KeywordTier, keywords};

    #[test]
    fn every_kind_of_name_is_defined_by_a_card() {
        let mut used = BTreeSet::new();
        let mut defined = BTreeSet::new();
        for keyword in keywords() {
            for usage in keyword.parameters.iter().filter_map(|rule| parameter_name_usage(keyword, rule)) {
                used.insert(usage.kind);
                defined.extend(usage.defines.then_some(usage.kind));
            }
            used.extend(keyword.data.iter().flat_map(|d| d.shape.rules()).filter_map(field_name_kind));
        }
        assert_eq!(used, defined);
    }

    /// Text parameters that are not names of a deck, and names that no card refers to.
    const FREE_TEXT: &[&str] = &[
        "ADJUST",
        "CHANGE NUMBER",
        "CONSTRAINT NAME",
        "ELEMENT SHIFT",
        "FILLET RADIUS",
        "INPUT",
        "LINE",
        "NAME",
        "OFFSET",
        "POISSON",
        "SHIFT NODES",
        "STATISTICS",
        "TYPE",
    ];

    #[test]
    fn every_text_parameter_is_a_name_or_free_text() {
        let mut free = BTreeSet::new();
        for keyword in keywords().filter(|k| k.tier == KeywordTier::Used) {
            let rules = keyword.parameters.iter().filter(|rule| rule.usage == InputUsage::Read);
            let texts = rules.filter(|rule| rule.value.kind == ValueKind::Text);
            free.extend(texts.filter(|rule| parameter_name_usage(keyword, rule).is_none()).map(|rule| rule.name));
        }
        assert_eq!(free, FREE_TEXT.iter().copied().collect());
    }

    #[test]
    fn every_field_that_names_a_set_or_surface_has_a_kind() {
        let is_name = |name: &str| name.ends_with("or set") || name.ends_with("surface") && !name.contains(' ');
        for rule in keywords().flat_map(|k| k.data.iter().flat_map(|d| d.shape.rules())) {
            assert!(!is_name(rule.name) || field_name_kind(rule).is_some(), "{}", rule.name);
        }
    }
}
