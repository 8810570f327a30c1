//! What the words of an output request mean: a variable, a component of one, several under one name, or one that is known
//! and not simulated.
//! Never here: the table of what is simulated (`variables.rs`), decks.

use super::{Part, Place, Variable};
use crate::deck::names::nearest;

/// The meaning of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VariableRequest {
    /// `PRESELECT`: what is shown by default.
    Preselect,
    /// `ALL`: whatever the scene has.
    All,
    /// A variable with all its components.
    Whole(Variable),
    /// A component, or a numbered variable.
    One(Part),
    /// Several variables under one name.
    VariableFamily(&'static VariableFamily),
    /// A variable of ABAQUS that is not simulated.
    NotSimulated(&'static UnsimulatedVariable),
}

/// A section point of a shell that output knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionPoint {
    /// The first, on the side SNEG.
    Bottom,
    /// In the middle.
    Middle,
    /// The last, on the side SPOS.
    Top,
}

impl VariableRequest {
    /// The same at a section point; `None` of a component that is zero there. What is not one of section points stays.
    pub fn at(self, point: SectionPoint) -> Option<VariableRequest> {
        let there = |variable| {
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
            VariableRequest::Whole(variable) => Some(there(variable).map_or(self, VariableRequest::Whole)),
            VariableRequest::One(part) => match there(part.variable) {
                None => Some(self),
                Some(variable) => {
                    let count = variable.row().labels.len().max(1);
                    (part.component < count).then_some(VariableRequest::One(Part { variable, ..part }))
                }
            },
            _ => Some(self),
        }
    }
}

/// A name that stands for several variables.
#[derive(Debug, PartialEq)]
pub struct VariableFamily {
    /// Name.
    pub name: &'static str,
    /// What it stands for.
    pub members: &'static [Variable],
    /// What it is.
    pub words: &'static str,
}

/// Names that stand for other variables.
pub const FAMILIES: &[VariableFamily] = &[
    VariableFamily {
        name: "ENER",
        members: &[Variable::StrainEnergy, Variable::PlasticEnergy],
        words: "Energies per unit of current volume",
    },
    VariableFamily {
        name: "ELEN",
        members: &[Variable::ElementStrainEnergy, Variable::ElementPlasticEnergy],
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
    /// Name.
    pub name: &'static str,
    /// Where it lives.
    pub place: Place,
    /// What it is.
    pub words: &'static str,
}

const fn known(name: &'static str, place: Place, words: &'static str) -> UnsimulatedVariable {
    UnsimulatedVariable { name, place, words }
}

/// What decks for ABAQUS/Explicit ask for and nothing here has.
pub const NOT_SIMULATED: &[UnsimulatedVariable] = &[
    known("CF", Place::Node, "concentrated forces"),
    known("UT", Place::Node, "translations apart from rotations"),
    known("VT", Place::Node, "translational velocities apart from rotations"),
    known("AT", Place::Node, "translational accelerations apart from rotations"),
    known("RT", Place::Node, "reaction forces apart from moments"),
    known("INV3", Place::Point, "third stress invariant"),
    known("E", Place::Point, "total strain"),
    known("EP", Place::Point, "principal total strains"),
    known("EE", Place::Point, "elastic strain"),
    known("NE", Place::Point, "nominal strain"),
    known("NEP", Place::Point, "principal nominal strains"),
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
    known("ALLFC", Place::Energy, "fluid cavity energy"),
    known("DMASS", Place::Increment, "change of mass by mass scaling"),
    known("CSLIPR", Place::Node, "rate of contact slip"),
    known("CNORMF", Place::Node, "normal contact force"),
    known("CSHEARF", Place::Node, "frictional force"),
    known("CSTATUS", Place::Node, "contact status"),
    known("CMN", Place::Node, "moment of contact pressure"),
    known("CMS", Place::Node, "moment of friction"),
    known("CMT", Place::Node, "total contact moment"),
    known("CTHICK", Place::Node, "contact thickness"),
    known("CSDMG", Place::Node, "damage of cohesive surfaces"),
    known("CSMAXSCRT", Place::Node, "damage initiation of cohesive surfaces"),
    known("CSQUADSCRT", Place::Node, "damage initiation of cohesive surfaces"),
    known("CSMAXUCRT", Place::Node, "damage initiation of cohesive surfaces"),
    known("CSQUADUCRT", Place::Node, "damage initiation of cohesive surfaces"),
    known("CRSTS", Place::Node, "contact stress of cracks"),
    known("CTF", Place::Node, "connector forces"),
    known("CM", Place::Node, "concentrated moments"),
    known("FSLIP", Place::Node, "frictional slip"),
    known("FSLIPR", Place::Node, "rate of frictional slip"),
    known("HTL", Place::Node, "heat through contact"),
    known("HTLA", Place::Node, "heat through contact"),
    known("SFDR", Place::Node, "heat of friction"),
    known("SFDRA", Place::Node, "heat of friction"),
    known("CFL", Place::Node, "concentrated heat flux"),
    known("BDSTAT", Place::Node, "bond status"),
    known("DBT", Place::Node, "debonding time"),
    known("DBS", Place::Node, "debonding stress"),
    known("DBSF", Place::Node, "debonding"),
    known("BONDSTAT", Place::Node, "spot weld status"),
    known("BONDLOAD", Place::Node, "spot weld load"),
    known("PABS", Place::Node, "acoustic absolute pressure"),
    known("POR", Place::Node, "acoustic or pore pressure"),
    known("PCAV", Place::Node, "pressure of a fluid cavity"),
    known("CVOL", Place::Node, "volume of a fluid cavity"),
    known("CTEMP", Place::Node, "temperature of a fluid cavity"),
    known("CMASS", Place::Node, "mass of a fluid cavity"),
    known("CMF", Place::Node, "mole fraction of a fluid cavity"),
    known("MFL", Place::Node, "mass flow of a fluid cavity"),
    known("NFORC", Place::Node, "forces of element stresses at nodes"),
    known("SOM", Place::Node, "moment over a surface"),
    known("SOCF", Place::Node, "centre of the force over a surface"),
    known("XN", Place::Node, "force of debonding"),
    known("XS", Place::Node, "force of debonding"),
    known("XT", Place::Node, "time of debonding"),
    known("ALPHA", Place::Point, "backstress"),
    known("ALPHAP", Place::Point, "principal backstresses"),
    known("YIELDS", Place::Point, "yield stress"),
    known("YIELDPOT", Place::Point, "yield potential"),
    known("PEEQT", Place::Point, "equivalent plastic strain in tension"),
    known("PEEQR", Place::Point, "rate of the equivalent plastic strain"),
    known("PEEQMAX", Place::Point, "largest equivalent plastic strain"),
    known("PEQC", Place::Point, "equivalent plastic strain of caps"),
    known("PEVOL", Place::Point, "volumetric plastic strain"),
    known("CEMAG", Place::Point, "magnitude of the creep strain"),
    known("CESW", Place::Point, "swelling strain"),
    known("CEP", Place::Point, "principal creep strains"),
    known("IE", Place::Point, "inelastic strain"),
    known("IEP", Place::Point, "principal inelastic strains"),
    known("THE", Place::Point, "thermal strain"),
    known("THEP", Place::Point, "principal thermal strains"),
    known("EEP", Place::Point, "principal elastic strains"),
    known("VE", Place::Point, "viscous strain"),
    known("VEEQ", Place::Point, "equivalent viscous strain"),
    known("DG", Place::Point, "deformation gradient"),
    known("SINV", Place::Point, "stress invariants"),
    known("EV", Place::Point, "volumetric strain"),
    known("LEV", Place::Point, "volumetric logarithmic strain"),
    known("FV", Place::Point, "field variables"),
    known("MFR", Place::Point, "mass flow rates"),
    known("UVARM", Place::Point, "variables of a user routine"),
    known("VUVARM", Place::Point, "variables of a user routine"),
    known("VVF", Place::Point, "void volume fraction"),
    known("VVFG", Place::Point, "growth of voids"),
    known("VVFN", Place::Point, "nucleation of voids"),
    known("RD", Place::Point, "relative density"),
    known("DBURNF", Place::Point, "rate of the burn fraction"),
    known("PALPH", Place::Point, "distension of a porous material"),
    known("PALPHMIN", Place::Point, "least distension of a porous material"),
    known("RHOE", Place::Point, "density of the unreacted explosive"),
    known("RHOP", Place::Point, "density of the products"),
    known("SHRCRT", Place::Point, "shear damage initiation"),
    known("FLDCRT", Place::Point, "forming limit damage initiation"),
    known("FLSDCRT", Place::Point, "forming limit stress damage initiation"),
    known("MSFLDCRT", Place::Point, "forming limit damage initiation"),
    known("MKCRT", Place::Point, "Marciniak-Kuczynski damage initiation"),
    known("ERPRATIO", Place::Point, "ratio of principal strain rates"),
    known("SHRRATIO", Place::Point, "shear stress ratio"),
    known("HSNFTCRT", Place::Point, "fibre damage initiation"),
    known("HSNFCCRT", Place::Point, "fibre damage initiation"),
    known("HSNMTCRT", Place::Point, "matrix damage initiation"),
    known("HSNMCCRT", Place::Point, "matrix damage initiation"),
    known("CFAILURE", Place::Point, "failure measures of composites"),
    known("MAXSCRT", Place::Point, "traction damage initiation"),
    known("QUADSCRT", Place::Point, "traction damage initiation"),
    known("MAXECRT", Place::Point, "separation damage initiation"),
    known("QUADECRT", Place::Point, "separation damage initiation"),
    known("MAXPSCRT", Place::Point, "damage initiation of cracks"),
    known("MAXPECRT", Place::Point, "damage initiation of cracks"),
    known("DAMAGEC", Place::Point, "compressive damage of concrete"),
    known("DAMAGET", Place::Point, "tensile damage of concrete"),
    known("DAMAGESHR", Place::Point, "shear damage"),
    known("DAMAGEFT", Place::Point, "fibre damage"),
    known("DAMAGEFC", Place::Point, "fibre damage"),
    known("DAMAGEMT", Place::Point, "matrix damage"),
    known("DAMAGEMC", Place::Point, "matrix damage"),
    known("CKE", Place::Point, "cracking strain"),
    known("CKLE", Place::Point, "cracking strain"),
    known("CKEMAG", Place::Point, "magnitude of the cracking strain"),
    known("CKSTAT", Place::Point, "crack status"),
    known("CKLS", Place::Point, "cracking stress"),
    known("MISESMAX", Place::Point, "largest Mises stress"),
    known("MISESONLY", Place::Point, "Mises stress alone"),
    known("PRESSONLY", Place::Point, "pressure alone"),
    known("TSHR", Place::Point, "transverse shear stress"),
    known("CTSHR", Place::Point, "transverse shear stress"),
    known("SSAVG", Place::Point, "mean shell stress"),
    known("EFLX", Place::Point, "electric flux"),
    known("CENER", Place::Point, "creep energy per volume"),
    known("VENER", Place::Point, "viscous energy per volume"),
    known("DMENER", Place::Point, "damage energy per volume"),
    known("MFLT", Place::Point, "mass flow"),
    known("DENSITYVAVG", Place::Point, "density averaged over Eulerian materials"),
    known("EFABRIC", Place::Point, "strain of fabrics"),
    known("SFABRIC", Place::Point, "stress of fabrics"),
    known("SEQUT", Place::Point, "equivalent stress"),
    known("LOCALDIR", Place::Point, "directions of a material"),
    known("ROC", Place::Point, "rate of change"),
    known("ELCD", Place::Element, "energy of creep in an element"),
    known("ELVD", Place::Element, "viscous energy of an element"),
    known("ELASE", Place::Element, "artificial energy of an element"),
    known("ELIHE", Place::Element, "internal heat energy of an element"),
    known("ELDMD", Place::Element, "damage energy of an element"),
    known("ELDC", Place::Element, "distortion control energy of an element"),
    known("ELKE", Place::Element, "kinetic energy of an element"),
    known("EASEDEN", Place::Element, "artificial energy density of an element"),
    known("ECDDEN", Place::Element, "creep energy density of an element"),
    known("EDCDEN", Place::Element, "distortion control energy density of an element"),
    known("EIHEDEN", Place::Element, "heat energy density of an element"),
    known("EKEDEN", Place::Element, "kinetic energy density of an element"),
    known("EPDDEN", Place::Element, "plastic energy density of an element"),
    known("ESEDDEN", Place::Element, "strain energy density of an element"),
    known("ESEDEN", Place::Element, "strain energy density of an element"),
    known("EVDDEN", Place::Element, "viscous energy density of an element"),
    known("EDMDDEN", Place::Element, "damage energy density of an element"),
    known("EDMICRTMAX", Place::Element, "largest damage initiation of an element"),
    known("GRAV", Place::Element, "gravity load"),
    known("BF", Place::Element, "body force"),
    known("SBF", Place::Element, "body force of stagnation"),
    known("CENTMAG", Place::Element, "centrifugal load"),
    known("CORIOMAG", Place::Element, "Coriolis load"),
    known("ROTAMAG", Place::Element, "rotary load"),
    known("IWCONWEP", Place::Element, "blast pressure"),
    known("TRNOR", Place::Element, "normal traction"),
    known("TRSHR", Place::Element, "shear traction"),
    known("VP", Place::Element, "viscous pressure"),
    known("HP", Place::Element, "hydrostatic pressure"),
    known("FILM", Place::Element, "film condition"),
    known("RAD", Place::Element, "radiation condition"),
    known("QUANT", Place::Element, "mass flow"),
    known("RBANG", Place::Element, "angle of reinforcement"),
    known("RBFOR", Place::Element, "force in reinforcement"),
    known("RBROT", Place::Element, "rotation of reinforcement"),
    known("MVF", Place::Element, "volume fraction"),
    known("CTM", Place::Element, "connector moments"),
    known("CEF", Place::Element, "connector elastic forces"),
    known("CU", Place::Element, "connector displacements"),
    known("CRF", Place::Element, "connector reaction forces"),
    known("CDMG", Place::Element, "connector damage"),
    known("STATUSXFEM", Place::Element, "status of cracked elements"),
    known("NODENUMBER", Place::Element, "number of a node"),
    known("ALLCCDW", Place::Energy, "energy of contact constraint discontinuity work"),
    known("ALLCCE", Place::Energy, "contact constraint energy"),
    known("ALLCCEN", Place::Energy, "contact constraint energy"),
    known("ALLCCET", Place::Energy, "contact constraint energy"),
    known("ALLCCSD", Place::Energy, "contact stabilisation energy"),
    known("ALLCCSDN", Place::Energy, "contact stabilisation energy"),
    known("ALLCCSDT", Place::Energy, "contact stabilisation energy"),
    known("ALLEE", Place::Energy, "electrostatic energy"),
    known("ALLJD", Place::Energy, "electric energy"),
    known("ALLKL", Place::Energy, "energy lost at impact"),
    known("ALLQB", Place::Energy, "energy of infinite elements"),
    known("ALLSD", Place::Energy, "energy of stabilisation"),
    known("ALLDTI", Place::Energy, "energy of particles"),
    known("EFENRRTR", Place::Energy, "energy release rate"),
    known("ENRRT", Place::Energy, "energy release rate"),
    known("ALLVDE", Place::Energy, "viscous energy"),
    known("MASSSCALE", Place::Increment, "mass scaling"),
    known("XCOM", Place::Increment, "centre of mass"),
    known("YCOM", Place::Increment, "centre of mass"),
    known("ZCOM", Place::Increment, "centre of mass"),
    known("STEPTIME", Place::Increment, "time of the step"),
];

impl VariableRequest {
    /// The meaning of an upper-case word; `None` where it names no variable.
    pub fn parse(word: &str) -> Option<VariableRequest> {
        match word {
            "PRESELECT" => return Some(VariableRequest::Preselect),
            "ALL" => return Some(VariableRequest::All),
            _ => {}
        }
        let whole = Variable::ALL.iter().find(|v| v.name() == word).map(|v| VariableRequest::Whole(*v));
        whole
            .or_else(|| Part::parse(word).map(VariableRequest::One))
            .or_else(|| FAMILIES.iter().find(|f| f.name == word).map(VariableRequest::VariableFamily))
            .or_else(|| NOT_SIMULATED.iter().find(|k| is_name(word, k.name)).map(VariableRequest::NotSimulated))
    }

    /// The word.
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

    /// Variables it names.
    pub fn variables(self) -> Vec<Variable> {
        match self {
            VariableRequest::Whole(variable) => vec![variable],
            VariableRequest::One(part) => vec![part.variable],
            VariableRequest::VariableFamily(family) => family.members.to_vec(),
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
    let there: Vec<_> = Variable::ALL.iter().filter(|v| places.contains(&v.place())).map(|v| v.name()).collect();
    let list = format!("there are {}", there.join(", "));
    match like(word) {
        Some(near) => format!("did you mean {near}? {}{}", list[..1].to_uppercase(), &list[1..]),
        None => list,
    }
}

/// The name most like a word that names no variable.
pub fn like(word: &str) -> Option<&'static str> {
    let names = Variable::ALL.iter().map(|v| v.name());
    if word.contains("PRINC") {
        return Some(Variable::PrincipalStress.name());
    }
    if let Some(inside) = names.clone().find(|n| n.len() >= 4 && word.contains(n)) {
        return Some(inside);
    }
    nearest(word, names.chain(FAMILIES.iter().map(|f| f.name)).chain(NOT_SIMULATED.iter().map(|k| k.name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_as_decks_have_them() {
        let part = |variable, component| Some(VariableRequest::One(Part { variable, component }));
        assert_eq!(VariableRequest::parse("U"), Some(VariableRequest::Whole(Variable::Displacement)));
        assert_eq!(VariableRequest::parse("U2"), part(Variable::Displacement, 1));
        assert_eq!(VariableRequest::parse("COOR1"), part(Variable::Coordinate, 0));
        assert_eq!(VariableRequest::parse("S33"), part(Variable::Stress, 2));
        assert_eq!(VariableRequest::parse("SDV12"), part(Variable::State, 11));
        assert_eq!(VariableRequest::parse("PEEQ"), Some(VariableRequest::Whole(Variable::PlasticStrain)));
        for word in ["U4", "S13", "SDV0", "MISES1", "NOSUCH", ""] {
            assert_eq!(VariableRequest::parse(word), None, "{word}");
        }
        for word in ["CF", "CF2", "EMSF"] {
            assert!(matches!(VariableRequest::parse(word), Some(VariableRequest::NotSimulated(_))), "{word}");
        }
        assert_eq!(help("S13", &[]), "S has the components S11, S22, S33, S12");
        assert_eq!(like("MAXPRINCIPAL"), Some("SP"));
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
