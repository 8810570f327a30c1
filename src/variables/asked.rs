//! What the words of an output request mean: a variable, a component of one, several under one name, or one that is known
//! and not simulated.
//! Never here: the table of what is simulated (`variables.rs`), decks.

use super::{Part, Place, Variable};
use crate::deck::names::nearest;

/// The meaning of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// `PRESELECT`: what is shown by default.
    Preselect,
    /// `ALL`: whatever the scene has.
    All,
    /// A variable with all its components.
    Whole(Variable),
    /// A component, or a numbered variable.
    One(Part),
    /// Several variables under one name.
    Family(&'static Family),
    /// A variable of ABAQUS that is not simulated.
    NotSimulated(&'static Known),
}

/// A name that stands for several variables.
#[derive(Debug, PartialEq)]
pub struct Family {
    /// Name.
    pub name: &'static str,
    /// What it stands for.
    pub members: &'static [Variable],
    /// What it is.
    pub words: &'static str,
}

/// Names that stand for other variables.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "ENER",
        members: &[Variable::StrainEnergy, Variable::PlasticEnergy],
        words: "Energies per unit of current volume",
    },
    Family {
        name: "ELEN",
        members: &[Variable::ElementStrainEnergy, Variable::ElementPlasticEnergy],
        words: "Energies of an element",
    },
    Family { name: "P", members: &[Variable::FacetPressure], words: "Pressure load on faces" },
];

/// A variable of ABAQUS that is not simulated.
#[derive(Debug, PartialEq)]
pub struct Known {
    /// Name.
    pub name: &'static str,
    /// Where it lives.
    pub place: Place,
    /// What it is.
    pub words: &'static str,
}

const fn known(name: &'static str, place: Place, words: &'static str) -> Known {
    Known { name, place, words }
}

/// What decks for ABAQUS/Explicit ask for and nothing here has.
pub const NOT_SIMULATED: &[Known] = &[
    known("CF", Place::Node, "concentrated forces"),
    known("NT", Place::Node, "temperature at nodes"),
    known("UT", Place::Node, "translations apart from rotations"),
    known("VT", Place::Node, "translational velocities apart from rotations"),
    known("AT", Place::Node, "translational accelerations apart from rotations"),
    known("RT", Place::Node, "reaction forces apart from moments"),
    known("UR", Place::Node, "rotations"),
    known("VR", Place::Node, "rotational velocities"),
    known("AR", Place::Node, "rotational accelerations"),
    known("RM", Place::Node, "reaction moments"),
    known("CSTRESS", Place::Node, "contact pressure and shear"),
    known("CDISP", Place::Node, "contact displacements"),
    known("CFORCE", Place::Node, "contact forces"),
    known("CFN", Place::Node, "total force of contact pressure"),
    known("CFS", Place::Node, "total force of contact friction"),
    known("TRESC", Place::Point, "Tresca equivalent stress"),
    known("INV3", Place::Point, "third stress invariant"),
    known("SP", Place::Point, "principal stresses"),
    known("E", Place::Point, "total strain"),
    known("EP", Place::Point, "principal total strains"),
    known("EE", Place::Point, "elastic strain"),
    known("LEP", Place::Point, "principal logarithmic strains"),
    known("NE", Place::Point, "nominal strain"),
    known("NEP", Place::Point, "principal nominal strains"),
    known("PEP", Place::Point, "principal plastic strains"),
    known("PEMAG", Place::Point, "magnitude of the plastic strain"),
    known("ERP", Place::Point, "principal strain rates"),
    known("ERV", Place::Point, "volumetric strain rate"),
    known("CE", Place::Point, "creep strain"),
    known("CEEQ", Place::Point, "equivalent creep strain"),
    known("EVF", Place::Point, "volume fraction of an Eulerian material"),
    known("SVAVG", Place::Point, "stress averaged over Eulerian materials"),
    known("PEVAVG", Place::Point, "plastic strain averaged over Eulerian materials"),
    known("PEEQVAVG", Place::Point, "equivalent plastic strain averaged over Eulerian materials"),
    known("TEMPMAVG", Place::Point, "temperature averaged over Eulerian materials"),
    known("ELEDEN", Place::Element, "energy densities of an element"),
    known("EDT", Place::Element, "stable increment of an element"),
    known("EMSF", Place::Element, "mass scaling factor of an element"),
    known("ALLCD", Place::Energy, "energy dissipated by viscoelasticity"),
    known("ALLDMD", Place::Energy, "energy dissipated by damage"),
    known("ALLMW", Place::Energy, "work done in propelling mass added by mass scaling"),
    known("ALLPW", Place::Energy, "work of contact penalties"),
    known("ALLFC", Place::Energy, "fluid cavity energy"),
    known("ALLHF", Place::Energy, "external heat energy through fluxes"),
    known("ALLIHE", Place::Energy, "internal heat energy"),
    known("DMASS", Place::Increment, "change of mass by mass scaling"),
];

impl Asked {
    /// The meaning of an upper-case word; `None` where it names no variable.
    pub fn parse(word: &str) -> Option<Asked> {
        match word {
            "PRESELECT" => return Some(Asked::Preselect),
            "ALL" => return Some(Asked::All),
            _ => {}
        }
        let whole = Variable::ALL.iter().find(|v| v.name() == word).map(|v| Asked::Whole(*v));
        whole
            .or_else(|| Part::parse(word).map(Asked::One))
            .or_else(|| FAMILIES.iter().find(|f| f.name == word).map(Asked::Family))
            .or_else(|| NOT_SIMULATED.iter().find(|k| is_name(word, k.name)).map(Asked::NotSimulated))
    }

    /// The word.
    pub fn name(self) -> String {
        match self {
            Asked::Preselect => "PRESELECT".into(),
            Asked::All => "ALL".into(),
            Asked::Whole(variable) => variable.name().into(),
            Asked::One(part) => part.label(),
            Asked::Family(family) => family.name.into(),
            Asked::NotSimulated(known) => known.name.into(),
        }
    }

    /// Variables it names.
    pub fn variables(self) -> Vec<Variable> {
        match self {
            Asked::Whole(variable) => vec![variable],
            Asked::One(part) => vec![part.variable],
            Asked::Family(family) => family.members.to_vec(),
            _ => Vec::new(),
        }
    }
}

/// Whether a word is a name, or one of its components by number.
fn is_name(word: &str, name: &str) -> bool {
    word.strip_prefix(name).is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

impl Part {
    /// The component, scalar or numbered variable of that upper-case label.
    pub fn parse(label: &str) -> Option<Part> {
        let numbered = || {
            let of = |v: &Variable| {
                let number: usize = label.strip_prefix(v.name())?.parse().ok()?;
                Some(Part { variable: *v, component: number.checked_sub(1)? })
            };
            Variable::ALL.iter().filter(|v| v.row().numbered).find_map(of)
        };
        let plain = Variable::ALL.iter().filter(|v| !v.row().numbered);
        plain.flat_map(|v| v.parts()).find(|p| p.label() == label).or_else(numbered)
    }
}

/// What would have been right in place of a word that names no variable: components of the variable it begins with, the
/// nearest name, or what there is at these places.
pub fn help(word: &str, places: &[Place]) -> String {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    if let Some(variable) = Variable::ALL.iter().find(|v| v.name() == stem && stem != word) {
        let labels = variable.row().labels;
        let what =
            if labels.is_empty() { "no components".into() } else { format!("the components {}", labels.join(", ")) };
        return format!("{stem} has {what}");
    }
    let names = Variable::ALL.iter().map(|v| v.name());
    let near = nearest(word, names.chain(FAMILIES.iter().map(|f| f.name)).chain(NOT_SIMULATED.iter().map(|k| k.name)));
    let there: Vec<_> = Variable::ALL.iter().filter(|v| places.contains(&v.place())).map(|v| v.name()).collect();
    let list = format!("there are {}", there.join(", "));
    match near {
        Some(near) => format!("did you mean {near}? {}{}", list[..1].to_uppercase(), &list[1..]),
        None => list,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_as_decks_have_them() {
        let part = |variable, component| Some(Asked::One(Part { variable, component }));
        assert_eq!(Asked::parse("U"), Some(Asked::Whole(Variable::Displacement)));
        assert_eq!(Asked::parse("U2"), part(Variable::Displacement, 1));
        assert_eq!(Asked::parse("COOR1"), part(Variable::Coordinate, 0));
        assert_eq!(Asked::parse("S33"), part(Variable::Stress, 2));
        assert_eq!(Asked::parse("SDV12"), part(Variable::State, 11));
        assert_eq!(Asked::parse("PEEQ"), Some(Asked::Whole(Variable::PlasticStrain)));
        for word in ["U3", "S13", "SDV0", "MISES1", "NOSUCH", ""] {
            assert_eq!(Asked::parse(word), None, "{word}");
        }
        for word in ["CF", "CF2", "EMSF"] {
            assert!(matches!(Asked::parse(word), Some(Asked::NotSimulated(_))), "{word}");
        }
        assert_eq!(help("S13", &[]), "S has the components S11, S22, S33, S12");
        assert!(help("PEQ", &[Place::Node]).starts_with("did you mean PEEQ?"));
    }

    #[test]
    fn no_name_stands_twice() {
        let labels = Variable::ALL.iter().flat_map(|v| v.parts()).map(Part::label);
        let vectors =
            Variable::ALL.iter().filter(|v| v.parts().count() > 1 || v.row().numbered).map(|v| v.name().into());
        let known = NOT_SIMULATED.iter().map(|k| k.name.into());
        let mut all: Vec<String> =
            labels.chain(vectors).chain(known).chain(FAMILIES.iter().map(|f| f.name.into())).collect();
        let count = all.len();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
