//! The one table of output variables: name, where it lives, labels of its components, the words of the manual, and how it
//! is read. Decks, `explain`, histories, frames, norms, the page of variables and messages read it; a new variable is one
//! entry here, and what holds its value answers for it (`value(.., Variable)`).
//! Never here: which of them a deck asks for, where in a file they stand.
//!
//! Source of names and meanings: Abaqus Analysis User's Guide, "Abaqus/Explicit output variable identifiers".

pub mod dimension;
pub mod manual;
pub mod request;
pub mod statistic;

use crate::kernel::stress;
use dimension::*;

/// Where a variable lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At nodes.
    Node,
    /// At the integration point of an element, which lies in its middle.
    Point,
    /// In a whole element.
    Element,
    /// On facets of loaded surfaces.
    Facet,
    /// An energy of the whole model.
    Energy,
    /// Of an increment.
    Increment,
    /// Of a surface that integrals are taken over.
    Section,
    /// Of two surfaces that meet.
    Pair,
}

/// When a field is shown without being asked for by its name (`PRESELECT`, or no request at all).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preselected {
    /// Not at all.
    Never,
    /// In every scene.
    Always,
    /// Where something deforms.
    Deforming,
    /// Where elements can be deleted.
    Deleting,
    /// Where temperatures of nodes are solved for; the variable exists only there.
    Conducting,
    /// Where surfaces of elements are in contact; the variable exists only there.
    Meeting,
    /// Where contact has penalty springs; the variable exists only there.
    Springing,
    /// Where a rigid body has six degrees of freedom; the variable exists only there.
    Oblique,
}

/// One entry of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name in decks and files.
    pub name: &'static str,
    /// Names of the components; empty for a scalar and for numbered variables.
    pub labels: &'static [&'static str],
    /// Where it lives.
    pub place: Place,
    /// What it is.
    pub words: &'static str,
    /// Whether frames show it without a request by name.
    pub preselected: Preselected,
    /// Whether it exists only where something deforms.
    pub deforming: bool,
    /// Whether its name is followed by a number of its own (`SDV1`).
    pub numbered: bool,
    /// Whether elements follow it only if an output asks.
    pub followed: bool,
    /// What an element must have to have this, where it cannot be seen before it is followed.
    pub needs: Option<Variable>,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// How it follows from other variables of the element; `None` where its holder answers.
    pub formula: Option<Formula>,
    /// Combines the values of several loads on one facet: the value so far and the next one.
    pub combined: fn(f64, f64) -> f64,
    /// Its dimension.
    pub dimension: Powers,
}

/// A component of a variable by what else the element has; `None` where it lacks that.
pub type Formula = fn(&dyn ElementValues, usize) -> Option<f64>;

/// An element as formulas see it.
pub trait ElementValues {
    /// A component of a variable that the element holds; `None` where it does not have it.
    fn held(&self, variable: Variable, component: usize) -> Option<f64>;
    /// Volume now.
    fn volume(&self) -> f64;
}

/// Declares the variables: an enumeration and the table, in one order. Frames and energies keep this order.
macro_rules! variables {
    ($($variant:ident: $row:expr,)*) => {
        /// An output variable; what it is says its row.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // The words are in the rows.
        pub enum Variable { $($variant,)* }

        impl Variable {
            /// All of them, in the order of outputs.
            pub const ALL: &'static [Variable] = &[$(Variable::$variant,)*];
        }

        const ROWS: &[Row] = &[$($row,)*];
    };
}

variables! {
    Displacement: node("U", &["U1", "U2"], "Displacement along r and z").preselected(Preselected::Always).dimension(LENGTH),
    Velocity: node("V", &["V1", "V2"], "Velocity along r and z").preselected(Preselected::Always).dimension(VELOCITY),
    Acceleration: node("A", &["A1", "A2"], "Acceleration along r and z").preselected(Preselected::Always).dimension(ACCELERATION),
    Reaction: node("RF", &["RF1", "RF2"], "Reaction force of what is prescribed; of a rigid body at its reference node")
        .preselected(Preselected::Deforming).dimension(FORCE),
    Coordinate: node("COORD", &["COOR1", "COOR2"], "Current coordinates; the points of a frame are these").dimension(LENGTH),
    NodalTemperature: node("NT", &["NT11"], "Temperature of a node, where it is solved for").conducting().dimension(TEMPERATURE),
    ReactionFlux: node("RFL", &["RFL11"], "Heat a time that holding a temperature takes, positive into the body").conducting().dimension(POWER),
    Rotation: node("UR", &["UR3"], "Rotation of nodes of shells in the r-z plane, counter-clockwise, radians")
        .preselected(Preselected::Always),
    RotationalVelocity: node("VR", &["VR3"], "Rotational velocity of nodes of shells").dimension(PER_TIME),
    RotationalAcceleration: node("AR", &["AR3"], "Rotational acceleration of nodes of shells").dimension([0, 0, -2, 0]),
    ReactionMoment: node("RM", &["RM3"], "Reaction moment of rotations of shells that are prescribed").dimension(ENERGY),
    ContactPressure: node("CPRESS", &[], "Contact pressure, at the nodes of the surface of a pair that carries it").meeting().dimension(STRESS),
    ContactShear: node("CSHEAR", &["CSHEAR1"], "Frictional shear stress there, positive to the left of the way out of the surface").meeting().dimension(STRESS),
    ContactOpening: node("COPEN", &[], "Gap there, below zero of an overlap, where something is near").meeting().dimension(LENGTH),
    ContactSlip: node("CSLIP", &["CSLIP1"], "Slip so far there while in contact").meeting().dimension(LENGTH),
    ThirdDisplacement: node("U3", &[], "Displacement of oblique bodies along 3").oblique().dimension(LENGTH),
    ThirdVelocity: node("V3", &[], "Velocity of oblique bodies along 3").oblique().dimension(VELOCITY),
    ThirdAcceleration: node("A3", &[], "Acceleration of oblique bodies along 3").oblique().dimension(ACCELERATION),
    OutwardRotation: node("UROUT", &["UR1", "UR2"], "Rotation of oblique bodies about 1 and 2: with UR3 the rotation vector, radians").oblique(),
    OutwardRotationalVelocity: node("VROUT", &["VR1", "VR2"], "Rotational velocity of oblique bodies about 1 and 2").oblique().dimension(PER_TIME),
    OutwardRotationalAcceleration: node("AROUT", &["AR1", "AR2"], "Rotational acceleration of oblique bodies about 1 and 2").oblique().dimension([0, 0, -2, 0]),
    Yaw: node("YAW", &[], "Angle between the axis of an oblique body and its velocity, degrees, 0 to 90").oblique(),
    Tilt: node("TILT", &[], "Angle between the axis of an oblique body and direction 2, degrees").oblique(),
    Stress: point("S", &["S11", "S22", "S33", "S12"], "Stress: radial, axial, hoop, shear; of shells at the middle section point: meridian, hoop").preselected(Preselected::Deforming).dimension(STRESS),
    Mises: point("MISES", &[], "Mises equivalent stress").preselected(Preselected::Deforming)
        .by(|e, _| Some(stress::mises(tensor(e, Variable::Stress)?))).dimension(STRESS),
    Pressure: point("PRESS", &[], "Equivalent pressure stress, positive in compression")
        .preselected(Preselected::Deforming).by(|e, _| Some(stress::pressure(tensor(e, Variable::Stress)?))).dimension(STRESS),
    PrincipalStress: point("SP", &["SP1", "SP2", "SP3"], "Principal stresses, ascending").by(|e, i| Some(stress::principal(tensor(e, Variable::Stress)?)[i])).dimension(STRESS),
    Tresca: point("TRESC", &[], "Tresca equivalent stress: the difference of the outer principal stresses")
        .by(|e, _| Some(stress::tresca(tensor(e, Variable::Stress)?))).dimension(STRESS),
    Triaxiality: point("TRIAX", &[], "Stress triaxiality: minus PRESS over MISES; 0 without stress")
        .by(|e, _| Some(stress::triaxiality(tensor(e, Variable::Stress)?))),
    PlasticStrain: point("PEEQ", &[], "Equivalent plastic strain").preselected(Preselected::Deforming),
    Temperature: point("TEMP", &[], "Temperature, where the material follows it").dimension(TEMPERATURE),
    HeatFlux: point("HFL", &["HFL1", "HFL2"], "Heat flux along r and z, where temperatures are solved for").conducting().dimension([0, 1, -3, 0]),
    LogarithmicStrain: point("LE", &["LE11", "LE22", "LE33", "LE12"], "Logarithmic strain; LE12 is the engineering shear")
        .preselected(Preselected::Deforming).followed(None),
    PrincipalStrain: point("LEP", &["LEP1", "LEP2", "LEP3"], "Principal logarithmic strains, ascending").followed(None)
        .by(|e, i| Some(stress::principal(strain(e, Variable::LogarithmicStrain)?)[i])),
    PlasticComponents: point("PE", &["PE11", "PE22", "PE33", "PE12"], "Plastic strain; PE12 is the engineering shear")
        .preselected(Preselected::Deforming).followed(Some(Variable::PlasticStrain)),
    PrincipalPlasticStrain: point("PEP", &["PEP1", "PEP2", "PEP3"], "Principal plastic strains, ascending")
        .followed(Some(Variable::PlasticStrain)).by(|e, i| Some(stress::principal(strain(e, Variable::PlasticComponents)?)[i])),
    PlasticMagnitude: point("PEMAG", &[], "Magnitude of the plastic strain: sqrt(2/3 PE:PE)").followed(Some(Variable::PlasticStrain))
        .by(|e, _| Some(stress::magnitude(strain(e, Variable::PlasticComponents)?))),
    StrainRate: point("ER", &["ER11", "ER22", "ER33", "ER12"], "Strain rate of the last increment; ER12 is the engineering shear")
        .followed(None).dimension(PER_TIME),
    PrincipalStrainRate: point("ERP", &["ERP1", "ERP2", "ERP3"], "Principal strain rates, ascending").followed(None)
        .by(|e, i| Some(stress::principal(strain(e, Variable::StrainRate)?)[i])).dimension(PER_TIME),
    VolumetricStrainRate: point("ERV", &[], "Volumetric strain rate").followed(None)
        .by(|e, _| Some(-3.0 * stress::pressure(strain(e, Variable::StrainRate)?))).dimension(PER_TIME),
    StrainEnergy: point("SENER", &[], "Elastic strain energy per unit of current volume").followed(None)
        .by(|e, _| Some(e.held(Variable::ElementStrainEnergy, 0)? / volume(e))).dimension(STRESS),
    PlasticEnergy: point("PENER", &[], "Energy dissipated by plastic flow per unit of current volume").followed(None)
        .by(|e, _| Some(e.held(Variable::ElementPlasticEnergy, 0)? / volume(e))).dimension(STRESS),
    BottomStress: point("S_SNEG", &["S11_SNEG", "S22_SNEG"], "Stress of shells at section point 1, the side SNEG: meridian, hoop")
        .preselected(Preselected::Deforming).ours().dimension(STRESS),
    TopStress: point("S_SPOS", &["S11_SPOS", "S22_SPOS"], "Stress of shells at the last section point, the side SPOS: meridian, hoop")
        .preselected(Preselected::Deforming).ours().dimension(STRESS),
    BottomMises: point("MISES_SNEG", &[], "Mises equivalent stress of shells at the side SNEG").preselected(Preselected::Deforming)
        .ours().by(|e, _| Some(stress::mises(tensor(e, Variable::BottomStress)?))).dimension(STRESS),
    TopMises: point("MISES_SPOS", &[], "Mises equivalent stress of shells at the side SPOS").preselected(Preselected::Deforming)
        .ours().by(|e, _| Some(stress::mises(tensor(e, Variable::TopStress)?))).dimension(STRESS),
    BottomPlasticStrain: point("PEEQ_SNEG", &[], "Equivalent plastic strain of shells at the side SNEG")
        .preselected(Preselected::Deforming).ours(),
    TopPlasticStrain: point("PEEQ_SPOS", &[], "Equivalent plastic strain of shells at the side SPOS")
        .preselected(Preselected::Deforming).ours(),
    BottomStrain: point("LE_SNEG", &["LE11_SNEG", "LE22_SNEG", "LE33_SNEG"], "Logarithmic strain of shells at the side SNEG: meridian, hoop, thickness")
        .preselected(Preselected::Deforming).followed(Some(Variable::Thickness)).ours(),
    TopStrain: point("LE_SPOS", &["LE11_SPOS", "LE22_SPOS", "LE33_SPOS"], "Logarithmic strain of shells at the side SPOS: meridian, hoop, thickness")
        .preselected(Preselected::Deforming).followed(Some(Variable::Thickness)).ours(),
    BottomTemperature: point("TEMP_SNEG", &[], "Temperature of shells at the side SNEG").ours().dimension(TEMPERATURE),
    TopTemperature: point("TEMP_SPOS", &[], "Temperature of shells at the side SPOS").ours().dimension(TEMPERATURE),
    Thickness: point("STH", &[], "Thickness of shells").preselected(Preselected::Deforming).dimension(LENGTH),
    SectionForce: point("SF", &["SF1", "SF2", "SF4"], "Section force of shells a length: meridian, hoop, transverse shear").dimension([0, 1, -2, 0]),
    SectionMoment: point("SM", &["SM1", "SM2"], "Section moment of shells a length: meridian, hoop; positive stretches the side SPOS").dimension(FORCE),
    SectionStrain: point("SE", &["SE1", "SE2", "SE4"], "Section strain of shells: meridian, hoop, transverse shear")
        .followed(Some(Variable::Thickness)),
    SectionCurvature: point("SK", &["SK1", "SK2"], "Change of curvature of shells: meridian, hoop").followed(Some(Variable::Thickness)).dimension([-1, 0, 0, 0]),
    Status: element("STATUS", "1 where an element carries, 0 where it is deleted").preselected(Preselected::Deleting),
    Volume: element("EVOL", "Current volume of an element").by(|e, _| Some(volume(e))).dimension(VOLUME),
    Density: point("DENSITY", &[], "Mass per unit of current volume").by(|e, _| Some(e.held(Variable::Mass, 0)? / volume(e))).dimension([-3, 1, 0, 0]),
    ElementStrainEnergy: element("ELSE", "Elastic strain energy of an element").followed(None).dimension(ENERGY),
    ElementPlasticEnergy: element("ELPD", "Energy dissipated by plastic flow in an element").followed(None).dimension(ENERGY),
    Mass: element("MASS", "Mass of an element").ours().dimension(MASS),
    SpecificEnergy: point("SPECIFIC_ENERGY", &[], "Internal energy per unit of mass, where an equation of state follows it").ours().dimension([2, 0, -2, 0]),
    Degradation: point("SDEG", &[], "Scalar stiffness degradation: the share of the stress that damage has taken"),
    DamageInitiation: point("DMICRT", &[], "How far the criteria of the beginning of damage have come, the largest of them; 1 where it begins"),
    DuctileInitiation: point("DUCTCRT", &[], "How far the ductile criterion of the beginning of damage has come"),
    JohnsonCookInitiation: point("JCCRT", &[], "How far the Johnson-Cook criterion of the beginning of damage has come"),
    BurnFraction: point("BURNF", &[], "Share of an explosive that the detonation has burnt"),
    State: point("SDV", &[], "Solution-dependent state variables of a user's material; SDV1 is the first").numbered(),
    FacetPressure: facet("PRESSURE", "Pressure of the loads on a facet", |sum, next| sum + next).dimension(STRESS),
    NormalVelocity: facet("NORMAL_VELOCITY", "Velocity of a facet along its outward normal", |_, last| last).dimension(VELOCITY),
    Layer: facet("LAYER", "Number (from 1) of the layer of a target that takes the largest part of a facet; 0 outside", f64::max),
    SurfaceForce: section("SOF", &["SOF1", "SOF2"], "Force on a surface, of what deforms behind it: the reaction that holds it").dimension(FORCE),
    SectionArea: section("SOAREA", &[], "Current area of a surface").dimension(AREA),
    NormalContactForce: pair("CFN", &["CFN1", "CFN2"], "Force of contact pressure on the first surface of a pair: radial, summed around, and axial").dimension(FORCE),
    ShearContactForce: pair("CFS", &["CFS1", "CFS2"], "Force of friction on the first surface of a pair").dimension(FORCE),
    ContactForce: pair("CFT", &["CFT1", "CFT2"], "Force of contact, CFN and CFS, on the first surface of a pair").dimension(FORCE),
    NormalContactMagnitude: pair("CFNM", &[], "Magnitude of CFN").dimension(FORCE),
    ShearContactMagnitude: pair("CFSM", &[], "Magnitude of CFS").dimension(FORCE),
    ContactMagnitude: pair("CFTM", &[], "Magnitude of CFT").dimension(FORCE),
    ContactArea: pair("CAREA", &[], "Area in contact").dimension(AREA),
    KineticEnergy: energy("ALLKE", "Kinetic energy"),
    Work: energy("ALLWK", "External work: of prescribed loads and motions"),
    FrictionEnergy: energy("ALLFD", "Energy dissipated by friction"),
    CavityEnergy: energy("ALLCAV", "Energy dissipated by opening the cavity in targets").ours(),
    InternalEnergy: energy("ALLIE", "Internal energy: ALLSE + ALLPD + ALLAE").only_deforming(),
    AllStrainEnergy: energy("ALLSE", "Recoverable strain energy").only_deforming(),
    AllPlasticEnergy: energy("ALLPD", "Energy dissipated by plastic flow").only_deforming(),
    ViscousEnergy: energy("ALLVD", "Energy dissipated by bulk viscosity, dashpots and damping").only_deforming(),
    ArtificialEnergy: energy("ALLAE", "Artificial strain energy: taken by hourglass control").only_deforming(),
    ConstraintWork: energy("ALLCW", "Constraint work: lost where surfaces meet").only_deforming(),
    PenaltyWork: energy("ALLPW", "Held and lost by penalty springs of contact").springing(),
    DistortionEnergy: energy("ALLDC", "Energy dissipated by distortion control").only_deforming(),
    ExternalHeat: energy("ALLHF", "Heat from outside: through fluxes, films and temperatures that are held").conducting(),
    InternalHeat: energy("ALLIHE", "Heat taken up: ALLHF and what plastic work makes").conducting(),
    RemovedMass: energy("EROMASS", "Mass of elements that were deleted").deleting().dimension(MASS),
    RemovedEnergy: energy("EROIE", "Internal energy that deleted elements had taken up, part of ALLIE").deleting(),
    PointMass: energy("EROPMASS", "Mass of nodes whose elements were all deleted, which fly on as points").deleting().dimension(MASS),
    PointKineticEnergy: energy("EROPKE", "Kinetic energy of those nodes, part of ALLKE").deleting(),
    PointMomentum: energy("EROPMOM", "Momentum of those nodes along z").deleting().dimension([1, 1, -1, 0]),
    TotalEnergy: energy("ETOTAL", "Energy balance, constant: ALLKE + ALLIE + ALLVD + ALLFD + ALLCW + ALLPW + ALLDC + ALLCAV - ALLWK"),
    TimeIncrement: Row { place: Place::Increment, ..energy("DT", "Time increment") }.dimension(TIME),
}

const fn node(name: &'static str, labels: &'static [&'static str], words: &'static str) -> Row {
    Row {
        name,
        labels,
        place: Place::Node,
        words,
        preselected: Preselected::Never,
        deforming: false,
        numbered: false,
        followed: false,
        needs: None,
        extension: false,
        formula: None,
        combined: |_, last| last,
        dimension: NONE,
    }
}

const fn point(name: &'static str, labels: &'static [&'static str], words: &'static str) -> Row {
    Row { place: Place::Point, deforming: true, ..node(name, labels, words) }
}

const fn element(name: &'static str, words: &'static str) -> Row {
    Row { place: Place::Element, deforming: true, ..node(name, &[], words) }
}

const fn facet(name: &'static str, words: &'static str, combined: fn(f64, f64) -> f64) -> Row {
    Row { place: Place::Facet, extension: true, combined, ..node(name, &[], words) }
}

const fn section(name: &'static str, labels: &'static [&'static str], words: &'static str) -> Row {
    Row { place: Place::Section, deforming: true, ..node(name, labels, words) }
}

const fn pair(name: &'static str, labels: &'static [&'static str], words: &'static str) -> Row {
    Row { place: Place::Pair, deforming: true, ..node(name, labels, words) }
}

const fn energy(name: &'static str, words: &'static str) -> Row {
    Row { place: Place::Energy, dimension: ENERGY, ..node(name, &[], words) }
}

impl Row {
    const fn preselected(self, preselected: Preselected) -> Row {
        Row { preselected, ..self }
    }

    const fn by(self, formula: Formula) -> Row {
        Row { formula: Some(formula), ..self }
    }

    const fn followed(self, needs: Option<Variable>) -> Row {
        Row { followed: true, needs, ..self }
    }

    const fn dimension(self, dimension: Powers) -> Row {
        Row { dimension, ..self }
    }

    const fn numbered(self) -> Row {
        Row { numbered: true, ..self }
    }

    const fn ours(self) -> Row {
        Row { extension: true, ..self }
    }

    const fn conducting(self) -> Row {
        Row { preselected: Preselected::Conducting, deforming: true, ..self }
    }

    const fn deleting(self) -> Row {
        Row { preselected: Preselected::Deleting, deforming: true, extension: true, ..self }
    }

    const fn springing(self) -> Row {
        Row { preselected: Preselected::Springing, deforming: true, ..self }
    }

    /// Of rigid bodies with six degrees of freedom.
    const fn oblique(self) -> Row {
        Row { preselected: Preselected::Oblique, extension: true, ..self }
    }

    /// Of contact.
    const fn meeting(self) -> Row {
        Row { preselected: Preselected::Meeting, deforming: true, ..self }
    }

    const fn only_deforming(self) -> Row {
        Row { deforming: true, ..self }
    }
}

fn tensor(element: &dyn ElementValues, variable: Variable) -> Option<[f64; 4]> {
    let component = |i| element.held(variable, i);
    Some([component(0)?, component(1)?, component(2)?, component(3)?])
}

/// A strain with the shear of a tensor, half the engineering shear.
fn strain(element: &dyn ElementValues, variable: Variable) -> Option<[f64; 4]> {
    let [rr, zz, hoop, rz] = tensor(element, variable)?;
    Some([rr, zz, hoop, 0.5 * rz])
}

fn volume(element: &dyn ElementValues) -> f64 {
    element.volume()
}

impl Variable {
    /// Its entry of the table.
    pub fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Where it lives.
    pub fn place(self) -> Place {
        self.row().place
    }

    /// Whether it is one of nodes.
    pub fn is_of_nodes(self) -> bool {
        self.place() == Place::Node
    }

    /// Whether it is one of nodes that turn.
    pub fn is_of_rotations(self) -> bool {
        matches!(
            self,
            Variable::Rotation
                | Variable::RotationalVelocity
                | Variable::RotationalAcceleration
                | Variable::ReactionMoment
        )
    }

    /// Whether only shells, or their nodes, have it.
    pub fn is_of_shells(self) -> bool {
        let first = Variable::BottomStress as usize;
        self.is_of_rotations() || (first..=Variable::SectionCurvature as usize).contains(&(self as usize))
    }

    /// Whether it is one of elements.
    pub fn is_of_elements(self) -> bool {
        matches!(self.place(), Place::Point | Place::Element)
    }

    /// Its components; one for a scalar. Of a numbered variable a component is a number, and there is no telling how many.
    pub fn parts(self) -> impl Iterator<Item = Part> {
        (0..self.row().labels.len().max(1)).map(move |component| Part { variable: self, component })
    }

    /// A component of it in an element, by its formula or by what the element holds; `None` where it does not have it.
    pub fn of(self, component: usize, element: &dyn ElementValues) -> Option<f64> {
        match self.row().formula {
            Some(formula) => formula(element, component),
            None => element.held(self, component),
        }
    }
}

/// One number of a variable: a component, or a numbered variable, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Part {
    /// The variable.
    pub variable: Variable,
    /// Its component.
    pub component: usize,
}

impl Part {
    /// Its label, as histories and frames have it: `S11`, `PEEQ`, `SDV2`.
    pub fn label(self) -> String {
        let row = self.variable.row();
        match row.labels.get(self.component) {
            Some(label) => (*label).to_owned(),
            None if row.numbered => format!("{}{}", row.name, self.component + 1),
            None => row.name.to_owned(),
        }
    }
}

impl From<Variable> for Part {
    /// A scalar, or the first component.
    fn from(variable: Variable) -> Part {
        Part { variable, component: 0 }
    }
}
