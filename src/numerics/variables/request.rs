//! Parsing of output requests: a variable, one of its components, a name of several variables, or a variable that is
//! not simulated.

use super::{Variable, VariableComponent, VariablePlace};
use crate::names::nearest;

/// Meaning of a word in an output request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VariableRequest {
    /// `PRESELECT`: the default variables.
    Preselect,
    /// `ALL`: all variables of the model.
    All,
    /// A variable with all its components.
    Whole(Variable),
    /// A component, or a numbered variable.
    One(VariableComponent),
    /// Several variables under one name.
    VariableFamily(&'static VariableFamily),
    /// A variable of ABAQUS that is not simulated.
    NotSimulated(&'static UnsimulatedVariable),
}

/// Section point of a shell at which output is available.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionPoint {
    /// The first one, on the side SNEG.
    Bottom,
    /// The middle one of an odd number of section points.
    Middle,
    /// The last one, on the side SPOS.
    Top,
}

impl VariableRequest {
    /// Returns the request at a section point; `None` for a component that is zero there. Variables without section
    /// points are unchanged.
    pub fn at(self, point: SectionPoint) -> Option<VariableRequest> {
        let at_point = |variable| {
            Some(match (variable, point) {
                (_, SectionPoint::Middle) => return None,
                (Variable::Stress, SectionPoint::Bottom) => Variable::BottomStress,
                (Variable::Stress, SectionPoint::Top) => Variable::TopStress,
                (Variable::Mises, SectionPoint::Bottom) => Variable::BottomMises,
                (Variable::Mises, SectionPoint::Top) => Variable::TopMises,
                (Variable::PlasticStrain, SectionPoint::Bottom) => Variable::BottomPlasticStrain,
                (Variable::PlasticStrain, SectionPoint::Top) => Variable::TopPlasticStrain,
                (Variable::LogarithmicStrain, SectionPoint::Bottom) => Variable::BottomStrain,
                (Variable::LogarithmicStrain, SectionPoint::Top) => Variable::TopStrain,
                (Variable::Temperature, SectionPoint::Bottom) => Variable::BottomTemperature,
                (Variable::Temperature, SectionPoint::Top) => Variable::TopTemperature,
                _ => return None,
            })
        };
        match self {
            VariableRequest::Whole(variable) => Some(at_point(variable).map_or(self, VariableRequest::Whole)),
            VariableRequest::One(part) => match at_point(part.variable) {
                None => Some(self),
                Some(variable) => {
                    let count = variable.row().labels.len().max(1);
                    (part.component < count).then_some(VariableRequest::One(VariableComponent { variable, ..part }))
                }
            },
            _ => Some(self),
        }
    }
}

/// A name of several variables.
#[derive(Debug, PartialEq)]
pub struct VariableFamily {
    /// Upper-case name, as in output requests.
    pub name: &'static str,
    /// Variables that a request by this name selects.
    pub members: &'static [Variable],
    /// Description in the manual.
    pub words: &'static str,
}

/// Names of several variables.
pub const FAMILIES: &[VariableFamily] = &[
    VariableFamily {
        name: "ENER",
        members: &[Variable::StrainEnergy, Variable::PlasticEnergy],
        words: "Energies per unit of current volume",
    },
    VariableFamily {
        name: "ELEN",
        members: &[
            Variable::ElementStrainEnergy,
            Variable::ElementPlasticEnergy,
            Variable::ElementArtificialEnergy,
            Variable::ElementDamageEnergy,
        ],
        words: "Energies of an element",
    },
    VariableFamily {
        name: "CSTRESS",
        members: &[Variable::ContactPressure, Variable::ContactShear],
        words: "Contact pressure and shear stress",
    },
    VariableFamily {
        name: "CDISP",
        members: &[Variable::ContactOpening, Variable::ContactSlip],
        words: "Contact opening and slip",
    },
    VariableFamily {
        name: "CFORCE",
        members: &[Variable::NormalContactForce, Variable::ShearContactForce],
        words: "Contact forces of a pair",
    },
    VariableFamily { name: "P", members: &[Variable::FacetPressure], words: "Pressure load on faces" },
];

/// A variable of ABAQUS that is not simulated.
#[derive(Debug, PartialEq)]
pub struct UnsimulatedVariable {
    /// Upper-case name in ABAQUS.
    pub name: &'static str,
    /// Location of the variable in ABAQUS.
    pub place: VariablePlace,
    /// Description in the manual.
    pub words: &'static str,
}

const fn known(name: &'static str, place: VariablePlace, words: &'static str) -> UnsimulatedVariable {
    UnsimulatedVariable { name, place, words }
}

/// Output variables of ABAQUS/Explicit that are not available.
pub const NOT_SIMULATED: &[UnsimulatedVariable] = &[
    known("CF", VariablePlace::Node, "concentrated forces"),
    known("UT", VariablePlace::Node, "translations apart from rotations"),
    known("VT", VariablePlace::Node, "translational velocities apart from rotations"),
    known("AT", VariablePlace::Node, "translational accelerations apart from rotations"),
    known("RT", VariablePlace::Node, "reaction forces apart from moments"),
    known("INV3", VariablePlace::Point, "third stress invariant"),
    known("EP", VariablePlace::Point, "principal total strains"),
    known("EE", VariablePlace::Point, "elastic strain"),
    known("NE", VariablePlace::Point, "nominal strain"),
    known("NEP", VariablePlace::Point, "principal nominal strains"),
    known("CE", VariablePlace::Point, "creep strain"),
    known("CEEQ", VariablePlace::Point, "equivalent creep strain"),
    known("EVF", VariablePlace::Point, "volume fraction of an Eulerian material"),
    known("SVAVG", VariablePlace::Point, "stress averaged over Eulerian materials"),
    known("PEVAVG", VariablePlace::Point, "plastic strain averaged over Eulerian materials"),
    known("PEEQVAVG", VariablePlace::Point, "equivalent plastic strain averaged over Eulerian materials"),
    known("TEMPMAVG", VariablePlace::Point, "temperature averaged over Eulerian materials"),
    known("ELEDEN", VariablePlace::Element, "energy densities of an element"),
    known("EDT", VariablePlace::Element, "stable increment of an element"),
    known("ALLCD", VariablePlace::Energy, "energy dissipated by viscoelasticity"),
    known("ALLFC", VariablePlace::Energy, "fluid cavity energy"),
    known("CSLIPR", VariablePlace::Node, "rate of contact slip"),
    known("CNORMF", VariablePlace::Node, "normal contact force"),
    known("CSHEARF", VariablePlace::Node, "frictional force"),
    known("CSTATUS", VariablePlace::Node, "contact status"),
    known("CMN", VariablePlace::Node, "moment of contact pressure"),
    known("CMS", VariablePlace::Node, "moment of friction"),
    known("CMT", VariablePlace::Node, "total contact moment"),
    known("CTHICK", VariablePlace::Node, "contact thickness"),
    known("CRSTS", VariablePlace::Node, "contact stress of cracks"),
    known("CTF", VariablePlace::Node, "connector forces"),
    known("CM", VariablePlace::Node, "concentrated moments"),
    known("FSLIP", VariablePlace::Node, "frictional slip"),
    known("FSLIPR", VariablePlace::Node, "rate of frictional slip"),
    known("HTL", VariablePlace::Node, "heat through contact"),
    known("HTLA", VariablePlace::Node, "heat through contact"),
    known("SFDR", VariablePlace::Node, "heat of friction"),
    known("SFDRA", VariablePlace::Node, "heat of friction"),
    known("CFL", VariablePlace::Node, "concentrated heat flux"),
    known("BDSTAT", VariablePlace::Node, "bond status"),
    known("DBT", VariablePlace::Node, "debonding time"),
    known("DBS", VariablePlace::Node, "debonding stress"),
    known("DBSF", VariablePlace::Node, "debonding"),
    known("BONDSTAT", VariablePlace::Node, "spot weld status"),
    known("BONDLOAD", VariablePlace::Node, "spot weld load"),
    known("PABS", VariablePlace::Node, "acoustic absolute pressure"),
    known("POR", VariablePlace::Node, "acoustic or pore pressure"),
    known("PCAV", VariablePlace::Node, "pressure of a fluid cavity"),
    known("CVOL", VariablePlace::Node, "volume of a fluid cavity"),
    known("CTEMP", VariablePlace::Node, "temperature of a fluid cavity"),
    known("CMASS", VariablePlace::Node, "mass of a fluid cavity"),
    known("CMF", VariablePlace::Node, "mole fraction of a fluid cavity"),
    known("MFL", VariablePlace::Node, "mass flow of a fluid cavity"),
    known("NFORC", VariablePlace::Node, "forces of element stresses at nodes"),
    known("SOM", VariablePlace::Node, "moment over a surface"),
    known("SOCF", VariablePlace::Node, "centre of the force over a surface"),
    known("XN", VariablePlace::Node, "force of debonding"),
    known("XS", VariablePlace::Node, "force of debonding"),
    known("XT", VariablePlace::Node, "time of debonding"),
    known("ALPHA", VariablePlace::Point, "backstress"),
    known("ALPHAP", VariablePlace::Point, "principal backstresses"),
    known("YIELDS", VariablePlace::Point, "yield stress"),
    known("YIELDPOT", VariablePlace::Point, "yield potential"),
    known("PEEQR", VariablePlace::Point, "rate of the equivalent plastic strain"),
    known("PEEQMAX", VariablePlace::Point, "largest equivalent plastic strain"),
    known("PEVOL", VariablePlace::Point, "volumetric plastic strain"),
    known("CEMAG", VariablePlace::Point, "magnitude of the creep strain"),
    known("CESW", VariablePlace::Point, "swelling strain"),
    known("CEP", VariablePlace::Point, "principal creep strains"),
    known("IE", VariablePlace::Point, "inelastic strain"),
    known("IEP", VariablePlace::Point, "principal inelastic strains"),
    known("THE", VariablePlace::Point, "thermal strain"),
    known("THEP", VariablePlace::Point, "principal thermal strains"),
    known("EEP", VariablePlace::Point, "principal elastic strains"),
    known("VE", VariablePlace::Point, "viscous strain"),
    known("VEEQ", VariablePlace::Point, "equivalent viscous strain"),
    known("DG", VariablePlace::Point, "deformation gradient"),
    known("SINV", VariablePlace::Point, "stress invariants"),
    known("EV", VariablePlace::Point, "volumetric strain"),
    known("LEV", VariablePlace::Point, "volumetric logarithmic strain"),
    known("FV", VariablePlace::Point, "field variables"),
    known("MFR", VariablePlace::Point, "mass flow rates"),
    known("UVARM", VariablePlace::Point, "variables of a user subroutine"),
    known("VUVARM", VariablePlace::Point, "variables of a user subroutine"),
    known("VVFG", VariablePlace::Point, "growth of voids"),
    known("VVFN", VariablePlace::Point, "nucleation of voids"),
    known("DBURNF", VariablePlace::Point, "rate of the burn fraction"),
    known("PALPHMIN", VariablePlace::Point, "least distension of a porous material"),
    known("RHOE", VariablePlace::Point, "density of the unreacted explosive"),
    known("RHOP", VariablePlace::Point, "density of the products"),
    known("SHRCRT", VariablePlace::Point, "shear damage initiation"),
    known("FLDCRT", VariablePlace::Point, "forming limit damage initiation"),
    known("FLSDCRT", VariablePlace::Point, "forming limit stress damage initiation"),
    known("MSFLDCRT", VariablePlace::Point, "forming limit damage initiation"),
    known("MKCRT", VariablePlace::Point, "Marciniak-Kuczynski damage initiation"),
    known("ERPRATIO", VariablePlace::Point, "ratio of principal strain rates"),
    known("SHRRATIO", VariablePlace::Point, "shear stress ratio"),
    known("HSNFTCRT", VariablePlace::Point, "fibre damage initiation"),
    known("HSNFCCRT", VariablePlace::Point, "fibre damage initiation"),
    known("HSNMTCRT", VariablePlace::Point, "matrix damage initiation"),
    known("HSNMCCRT", VariablePlace::Point, "matrix damage initiation"),
    known("CFAILURE", VariablePlace::Point, "failure measures of composites"),
    known("MAXPSCRT", VariablePlace::Point, "damage initiation of cracks"),
    known("MAXPECRT", VariablePlace::Point, "damage initiation of cracks"),
    known("DAMAGESHR", VariablePlace::Point, "shear damage"),
    known("DAMAGEFT", VariablePlace::Point, "fibre damage"),
    known("DAMAGEFC", VariablePlace::Point, "fibre damage"),
    known("DAMAGEMT", VariablePlace::Point, "matrix damage"),
    known("DAMAGEMC", VariablePlace::Point, "matrix damage"),
    known("CKE", VariablePlace::Point, "cracking strain"),
    known("CKLE", VariablePlace::Point, "cracking strain"),
    known("CKEMAG", VariablePlace::Point, "magnitude of the cracking strain"),
    known("CKSTAT", VariablePlace::Point, "crack status"),
    known("CKLS", VariablePlace::Point, "cracking stress"),
    known("MISESMAX", VariablePlace::Point, "largest Mises stress"),
    known("MISESONLY", VariablePlace::Point, "Mises stress alone"),
    known("PRESSONLY", VariablePlace::Point, "pressure alone"),
    known("TSHR", VariablePlace::Point, "transverse shear stress"),
    known("CTSHR", VariablePlace::Point, "transverse shear stress"),
    known("SSAVG", VariablePlace::Point, "mean shell stress"),
    known("EFLX", VariablePlace::Point, "electric flux"),
    known("CENER", VariablePlace::Point, "creep energy per volume"),
    known("VENER", VariablePlace::Point, "viscous energy per volume"),
    known("DMENER", VariablePlace::Point, "damage energy per volume"),
    known("MFLT", VariablePlace::Point, "mass flow"),
    known("DENSITYVAVG", VariablePlace::Point, "density averaged over Eulerian materials"),
    known("EFABRIC", VariablePlace::Point, "strain of fabrics"),
    known("SFABRIC", VariablePlace::Point, "stress of fabrics"),
    known("SEQUT", VariablePlace::Point, "equivalent stress"),
    known("LOCALDIR", VariablePlace::Point, "directions of a material"),
    known("ROC", VariablePlace::Point, "rate of change"),
    known("ELCD", VariablePlace::Element, "energy of creep in an element"),
    known("ELVD", VariablePlace::Element, "viscous energy of an element"),
    known("ELIHE", VariablePlace::Element, "internal heat energy of an element"),
    known("ELDC", VariablePlace::Element, "distortion control energy of an element"),
    known("ELKE", VariablePlace::Element, "kinetic energy of an element"),
    known("EASEDEN", VariablePlace::Element, "artificial energy density of an element"),
    known("ECDDEN", VariablePlace::Element, "creep energy density of an element"),
    known("EDCDEN", VariablePlace::Element, "distortion control energy density of an element"),
    known("EIHEDEN", VariablePlace::Element, "heat energy density of an element"),
    known("EKEDEN", VariablePlace::Element, "kinetic energy density of an element"),
    known("EPDDEN", VariablePlace::Element, "plastic energy density of an element"),
    known("ESEDDEN", VariablePlace::Element, "strain energy density of an element"),
    known("ESEDEN", VariablePlace::Element, "strain energy density of an element"),
    known("EVDDEN", VariablePlace::Element, "viscous energy density of an element"),
    known("EDMDDEN", VariablePlace::Element, "damage energy density of an element"),
    known("EDMICRTMAX", VariablePlace::Element, "largest damage initiation of an element"),
    known("GRAV", VariablePlace::Element, "gravity load"),
    known("BF", VariablePlace::Element, "body force"),
    known("SBF", VariablePlace::Element, "body force of stagnation"),
    known("CENTMAG", VariablePlace::Element, "centrifugal load"),
    known("CORIOMAG", VariablePlace::Element, "Coriolis load"),
    known("ROTAMAG", VariablePlace::Element, "rotary load"),
    known("IWCONWEP", VariablePlace::Element, "blast pressure"),
    known("TRNOR", VariablePlace::Element, "normal traction"),
    known("TRSHR", VariablePlace::Element, "shear traction"),
    known("VP", VariablePlace::Element, "viscous pressure"),
    known("HP", VariablePlace::Element, "hydrostatic pressure"),
    known("FILM", VariablePlace::Element, "film condition"),
    known("RAD", VariablePlace::Element, "radiation condition"),
    known("QUANT", VariablePlace::Element, "mass flow"),
    known("RBANG", VariablePlace::Element, "angle of reinforcement"),
    known("RBFOR", VariablePlace::Element, "force in reinforcement"),
    known("RBROT", VariablePlace::Element, "rotation of reinforcement"),
    known("MVF", VariablePlace::Element, "volume fraction"),
    known("CTM", VariablePlace::Element, "connector moments"),
    known("CEF", VariablePlace::Element, "connector elastic forces"),
    known("CU", VariablePlace::Element, "connector displacements"),
    known("CRF", VariablePlace::Element, "connector reaction forces"),
    known("CDMG", VariablePlace::Element, "connector damage"),
    known("STATUSXFEM", VariablePlace::Element, "status of cracked elements"),
    known("NODENUMBER", VariablePlace::Element, "number of a node"),
    known("ALLCCDW", VariablePlace::Energy, "energy of contact constraint discontinuity work"),
    known("ALLCCE", VariablePlace::Energy, "contact constraint energy"),
    known("ALLCCEN", VariablePlace::Energy, "contact constraint energy"),
    known("ALLCCET", VariablePlace::Energy, "contact constraint energy"),
    known("ALLCCSD", VariablePlace::Energy, "contact stabilisation energy"),
    known("ALLCCSDN", VariablePlace::Energy, "contact stabilisation energy"),
    known("ALLCCSDT", VariablePlace::Energy, "contact stabilisation energy"),
    known("ALLEE", VariablePlace::Energy, "electrostatic energy"),
    known("ALLJD", VariablePlace::Energy, "electric energy"),
    known("ALLKL", VariablePlace::Energy, "energy lost at impact"),
    known("ALLQB", VariablePlace::Energy, "energy of infinite elements"),
    known("ALLSD", VariablePlace::Energy, "energy of stabilisation"),
    known("ALLDTI", VariablePlace::Energy, "energy of particles"),
    known("EFENRRTR", VariablePlace::Energy, "energy release rate"),
    known("ENRRT", VariablePlace::Energy, "energy release rate"),
    known("ALLVDE", VariablePlace::Energy, "viscous energy"),
    known("MASSSCALE", VariablePlace::Increment, "mass scaling"),
    known("XCOM", VariablePlace::Increment, "centre of mass"),
    known("YCOM", VariablePlace::Increment, "centre of mass"),
    known("ZCOM", VariablePlace::Increment, "centre of mass"),
    known("STEPTIME", VariablePlace::Increment, "time of the step"),
];

impl VariableRequest {
    /// Parses an upper-case word; `None` if it names no variable.
    pub fn parse(word: &str) -> Option<VariableRequest> {
        match word {
            "PRESELECT" => return Some(VariableRequest::Preselect),
            "ALL" => return Some(VariableRequest::All),
            _ => {}
        }
        let whole = Variable::ALL.iter().find(|v| v.name() == word).map(|v| VariableRequest::Whole(*v));
        whole
            .or_else(|| VariableComponent::parse(word).map(VariableRequest::One))
            .or_else(|| FAMILIES.iter().find(|f| f.name == word).map(VariableRequest::VariableFamily))
            .or_else(|| NOT_SIMULATED.iter().find(|k| is_name(word, k.name)).map(VariableRequest::NotSimulated))
    }

    /// Returns the word of the request, as in the deck.
    pub fn name(self) -> String {
        match self {
            VariableRequest::Preselect => "PRESELECT".into(),
            VariableRequest::All => "ALL".into(),
            VariableRequest::Whole(variable) => variable.name().into(),
            VariableRequest::One(part) => part.label(),
            VariableRequest::VariableFamily(family) => family.name.into(),
            VariableRequest::NotSimulated(known) => known.name.into(),
        }
    }

    /// Returns the variables that the request selects.
    pub fn variables(self) -> Vec<Variable> {
        match self {
            VariableRequest::Whole(variable) => vec![variable],
            VariableRequest::One(part) => vec![part.variable],
            VariableRequest::VariableFamily(family) => family.members.to_vec(),
            _ => Vec::new(),
        }
    }
}

/// Returns whether a word is a name, or a name with a component number.
fn is_name(word: &str, name: &str) -> bool {
    word.strip_prefix(name).is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

impl VariableComponent {
    /// Returns the component, scalar or numbered variable with this upper-case label.
    pub fn parse(label: &str) -> Option<VariableComponent> {
        let numbered = || {
            let component_of = |v: &Variable| {
                let number: usize = label.strip_prefix(v.name())?.parse().ok()?;
                Some(VariableComponent { variable: *v, component: number.checked_sub(1)? })
            };
            Variable::ALL.iter().filter(|v| v.row().numbered).find_map(component_of)
        };
        let unnumbered = Variable::ALL.iter().filter(|v| !v.row().numbered);
        unnumbered.flat_map(|v| v.parts()).find(|p| p.label() == label).or_else(numbered)
    }
}

/// Returns a suggestion for a word that names no variable: the components of the variable that it begins with, the
/// nearest name, or the variables at these locations.
pub fn help(word: &str, places: &[VariablePlace]) -> String {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    if let Some(variable) = Variable::ALL.iter().find(|v| v.name() == stem && stem != word) {
        let labels = variable.row().labels;
        let what =
            if labels.is_empty() { "no components".into() } else { format!("the components {}", labels.join(", ")) };
        return format!("{stem} has {what}");
    }
    let available: Vec<_> = Variable::ALL.iter().filter(|v| places.contains(&v.place())).map(|v| v.name()).collect();
    let list = format!("available variables: {}", available.join(", "));
    match nearest_name(word) {
        Some(near) => format!("did you mean {near}? {}{}", list[..1].to_uppercase(), &list[1..]),
        None => list,
    }
}

/// Returns the name nearest to a word that names no variable.
pub fn nearest_name(word: &str) -> Option<&'static str> {
    let names = Variable::ALL.iter().map(|v| v.name());
    if word.contains("PRINC") {
        return Some(Variable::PrincipalStress.name());
    }
    if let Some(inside) = names.clone().find(|n| n.len() >= 4 && word.contains(n)) {
        return Some(inside);
    }
    nearest(word, names.chain(FAMILIES.iter().map(|f| f.name)).chain(NOT_SIMULATED.iter().map(|k| k.name)))
}

impl From<Variable> for VariableRequest {
    fn from(variable: Variable) -> VariableRequest {
        VariableRequest::Whole(variable)
    }
}

impl From<VariableComponent> for VariableRequest {
    fn from(part: VariableComponent) -> VariableRequest {
        VariableRequest::One(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_decks_are_parsed() {
        let part = |variable, component| Some(VariableRequest::One(VariableComponent { variable, component }));
        assert_eq!(VariableRequest::parse("U"), Some(VariableRequest::Whole(Variable::Displacement)));
        assert_eq!(VariableRequest::parse("U2"), part(Variable::Displacement, 1));
        assert_eq!(VariableRequest::parse("COOR1"), part(Variable::Coordinate, 0));
        assert_eq!(VariableRequest::parse("S33"), part(Variable::Stress, 2));
        assert_eq!(VariableRequest::parse("SDV12"), part(Variable::State, 11));
        assert_eq!(VariableRequest::parse("PEEQ"), Some(VariableRequest::Whole(Variable::PlasticStrain)));
        for word in ["U4", "S13", "SDV0", "MISES1", "NOSUCH", ""] {
            assert_eq!(VariableRequest::parse(word), None, "{word}");
        }
        for word in ["CF", "CF2", "EDT"] {
            assert!(matches!(VariableRequest::parse(word), Some(VariableRequest::NotSimulated(_))), "{word}");
        }
        assert_eq!(help("S13", &[]), "S has the components S11, S22, S33, S12");
        assert_eq!(nearest_name("MAXPRINCIPAL"), Some("SP"));
        assert!(help("PEQ", &[VariablePlace::Node]).starts_with("did you mean PEEQ?"));
    }

    #[test]
    fn names_are_unique() {
        let labels = Variable::ALL.iter().flat_map(|v| v.parts()).map(VariableComponent::label);
        let vectors =
            Variable::ALL.iter().filter(|v| v.parts().count() > 1 || v.row().numbered).map(|v| v.name().into());
        let known = NOT_SIMULATED.iter().map(|k| k.name.into());
        let mut names: Vec<String> =
            labels.chain(vectors).chain(known).chain(FAMILIES.iter().map(|f| f.name.into())).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
