//! The model: a deck with all names resolved and nothing decided. Validated data, each piece with the span that asked for it.
//! Never here: arrays for solving, decisions about effects.

use std::str::FromStr;
use std::sync::Arc;

use std::collections::HashMap;

use indexmap::IndexMap;

use super::element_nodes::ElementNodes;
use super::name::Name;
use super::shared::Shared;
use super::units::Units;
use crate::deck::{Sources, Span, Word};
pub use crate::kernel::interaction::{Friction, GapHeat, Law, Overclosure};
pub use crate::kernel::profile::{Profile, Segment};
use crate::variables::Place;
use crate::variables::asked::Asked;
use crate::variables::statistic::Statistic;

/// Everything a deck describes, or a scene composed in Rust: what is wrong with one is told when it is planned.
///
/// ```
/// use revolve::job;
/// use revolve::model::{ElementKind, Load, Model, Side, Sides, Step};
/// use revolve::user::Routines;
///
/// let mut model = Model::default();
/// let nodes = [model.node(0.0, 0.0), model.node(0.1, 0.0)];
/// let disc = model.element(ElementKind::Rax2, &nodes);
/// model.rigid_body("DISC", nodes[0], &[disc]);
/// model.mass(nodes[0], 2.0);
/// let top = Sides::new("TOP", &[(disc, Side::Positive)]);
/// model.steps.push(Step::new("push", 1e-3).with_load(Load::pressure(top.clone(), 1e4)));
/// let (outcome, _) = job::run_in_memory(&job::prepare_model(&model, &Routines::none()));
/// assert!(outcome.halt.is_none());
///
/// // There is no second amplitude.
/// model.steps[0].loads.push(Load::pressure(top, 1e4).with_amplitude(1));
/// let refused = job::prepare_model(&model, &Routines::none()).diagnostics;
/// assert!(refused.iter().any(|d| d.code == "M112"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Where its spans lead; empty if it is composed in Rust.
    pub sources: Arc<Sources>,
    /// The last card of the deck; `None` if it is composed in Rust.
    pub last_card: Option<Span>,
    /// The `*HEADING` text.
    pub title: String,
    /// Names of units; `None` where the deck gives none.
    pub units: Option<Units>,
    /// Nodes and elements, parts and instances flattened.
    pub mesh: Shared<Mesh>,
    /// Node sets by upper-case name (qualified `INSTANCE.SET` where they belong to an instance); members ascending.
    pub node_sets: IndexMap<String, Set>,
    /// Element sets, as node sets.
    pub element_sets: IndexMap<String, Set>,
    /// Surfaces by upper-case name.
    pub surfaces: IndexMap<String, Surface>,
    /// Materials in deck order.
    pub materials: Vec<Material>,
    /// `*SOLID SECTION` assignments.
    pub sections: Vec<SolidSection>,
    /// `*SHELL SECTION` assignments.
    pub shell_sections: Vec<ShellSection>,
    /// `*SECTION CONTROLS`.
    pub controls: Vec<SectionControls>,
    /// `*EROSION`.
    pub erosions: Vec<Erosion>,
    /// Amplitudes in deck order.
    pub amplitudes: Vec<Amplitude>,
    /// `*TIME POINTS` in deck order.
    pub time_points: Vec<TimePoints>,
    /// Whether all that bodies are made of has been read without error: what a plan says of bodies is true then.
    pub bodies_read: bool,
    /// Rigid bodies in deck order.
    pub rigid_bodies: Vec<RigidBody>,
    /// `*MASS` on nodes.
    pub point_masses: Vec<PointMass>,
    /// Absolute zero of temperature, of `*PHYSICAL CONSTANTS`; 0 if not given.
    pub absolute_zero: f64,
    /// Analytical surfaces by upper-case name.
    pub rigid_surfaces: IndexMap<String, RigidSurface>,
    /// Surfaces of nodes by upper-case name.
    pub node_surfaces: IndexMap<String, Vec<usize>>,
    /// `*SURFACE INTERACTION`s.
    pub interactions: Vec<Interaction>,
    /// `*SPRING` and `*DASHPOT`.
    pub connectors: Vec<ConnectorProperty>,
    /// `*EQUATION`s, one node a term.
    pub equations: Vec<Equation>,
    /// `*MPC`s and `*COUPLING`s.
    pub links: Vec<Link>,
    /// `*TIE`s.
    pub surface_ties: Vec<SurfaceTie>,
    /// `*INITIAL CONDITIONS`.
    pub initial_conditions: Vec<InitialCondition>,
    /// `*ATTITUDE`.
    pub attitudes: Vec<Attitude>,
    /// `*ROTARY INERTIA` on nodes.
    pub rotary_inertias: Vec<RotaryInertia>,
    /// `*TARGET` stacks.
    pub targets: Vec<Target>,
    /// Precision of what can be in either.
    pub precision: Precision,
    /// Steps; each lists everything in force in it (propagation and OP=NEW already worked out).
    pub steps: Vec<Step>,
    /// `*OUTPUT EXPRESSION`: history columns that follow from others.
    pub expressions: Vec<OutputExpression>,
    /// Cards that were read but change nothing in this deck: keyword, span, why.
    pub inert: Vec<Inert>,
}

/// Precision of the numbers of elements. Nodes, sums and energies are in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 53 bits.
    #[default]
    Double,
    /// 24 bits, of elements that have it; faster.
    Single,
}

/// A word that names no precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("double and single there are")]
pub struct UnknownPrecision;

impl FromStr for Precision {
    type Err = UnknownPrecision;

    fn from_str(text: &str) -> Result<Self, UnknownPrecision> {
        match text {
            "double" => Ok(Precision::Double),
            "single" => Ok(Precision::Single),
            _ => Err(UnknownPrecision),
        }
    }
}

impl Precision {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Precision::Double => "double",
            Precision::Single => "single",
        }
    }
}

/// Nodes and elements.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Node names as the deck knows them (`12` or `INSTANCE.12`).
    pub node_names: Vec<Name>,
    /// Node coordinates `[r, z]`, in the deck's length unit.
    pub points: Vec<[f64; 2]>,
    /// Elements.
    pub elements: Vec<Element>,
}

impl Mesh {
    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        let names: usize = self.node_names.iter().map(Name::bytes_elsewhere).sum();
        let element = |e: &Element| e.name.bytes_elsewhere() + e.nodes.bytes_elsewhere();
        names
            + size_of::<Name>() * self.node_names.capacity()
            + size_of::<[f64; 2]>() * self.points.capacity()
            + size_of::<Element>() * self.elements.capacity()
            + self.elements.iter().map(element).sum::<usize>()
    }

    /// Makes room for so many nodes more.
    pub(super) fn room_for_nodes(&mut self, more: usize) {
        self.points.reserve(more);
        self.node_names.reserve(more);
    }

    /// Makes room for so many elements more.
    pub(super) fn room_for_elements(&mut self, more: usize) {
        self.elements.reserve(more);
    }

    /// The corners of a solid element, counter-clockwise. A triangle is a quadrilateral whose last two corners coincide:
    /// the formulas of polygons hold, and every motion of three nodes is linear, so hourglass control finds nothing.
    pub fn corners(&self, element: usize) -> [usize; 4] {
        let nodes = &self.elements[element].nodes;
        [0, 1, 2, 3].map(|i: usize| nodes[i.min(nodes.len() - 1)])
    }

    /// The ends of one side of an element, the way it runs counter-clockwise; `None` if it has no such side.
    pub fn ends(&self, element: usize, side: Side) -> Option<[usize; 2]> {
        let nodes = &self.elements[element].nodes;
        let (from, to) = match side {
            Side::Positive | Side::Negative => (0, 1),
            Side::Face(n) => (usize::from(n).checked_sub(1)?, usize::from(n) % nodes.len()),
        };
        Some([*nodes.get(from)?, *nodes.get(to)?])
    }

    /// Faces of solids that lie outside: those that one element alone has, by element and number.
    pub fn outside(&self) -> Vec<(usize, Side)> {
        let faces = |e: usize| {
            let nodes = &self.elements[e].nodes;
            let count = if nodes.len() > 2 { nodes.len() } else { 0 };
            (0..count).map(move |i| (i, [nodes[i], nodes[(i + 1) % count]])).filter(|(_, [a, b])| a != b)
        };
        let all = || (0..self.elements.len()).flat_map(move |e| faces(e).map(move |(i, edge)| (e, i, edge)));
        let mut shared: HashMap<[usize; 2], usize> = HashMap::new();
        for (.., [a, b]) in all() {
            *shared.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
        let bare = all().filter(|&(.., [a, b])| shared[&[a.min(b), a.max(b)]] == 1);
        bare.map(|(e, i, _)| (e, Side::Face(i as u8 + 1))).collect()
    }
}

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementKind {
    /// Two-node axisymmetric rigid surface element.
    Rax2,
    /// Two-node axisymmetric shell.
    Sax1,
    /// Three-node axisymmetric triangle.
    Cax3,
    /// Four-node axisymmetric quadrilateral, one integration point.
    Cax4r,
    /// The triangle with temperatures at its nodes.
    Cax3t,
    /// The quadrilateral with temperatures at its nodes.
    Cax4rt,
    /// One-node point mass.
    Mass,
    /// One-node rotary inertia.
    RotaryInertia,
    /// Spring along the line between two nodes.
    SpringA,
    /// Spring between a node and the ground.
    Spring1,
    /// Dashpot along the line between two nodes.
    DashpotA,
    /// Dashpot between a node and the ground.
    Dashpot1,
}

/// One element.
#[derive(Clone, Debug)]
pub struct Element {
    /// Name as the deck knows it.
    pub name: Name,
    /// Type.
    pub kind: ElementKind,
    /// Indices into [`Mesh::points`]; as many as the type has nodes.
    pub nodes: ElementNodes,
    /// The data line (or mesh card) that made it.
    pub span: Span,
}

/// A named set of indices.
#[derive(Clone, Debug, Default)]
pub struct Set {
    /// Ascending, without repetition.
    pub members: Vec<usize>,
    /// First definition.
    pub span: Span,
}

/// A side of an element that faces outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The side of the positive normal of a RAX2 or a SAX1: first to second node turned 90 degrees counter-clockwise in (r, z).
    Positive,
    /// The other side.
    Negative,
    /// Face number (1-based) of a solid element: S1 is nodes 1-2, S2 nodes 2-3, and so on.
    Face(u8),
}

/// A surface made of element sides.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// The name as written.
    pub name: String,
    /// `(element index, side)` in deck order.
    pub faces: Vec<(usize, Side)>,
    /// Elements of which all that lies bare is meant: no side was named.
    pub whole: Vec<usize>,
    /// First definition.
    pub span: Span,
}

/// A material.
#[derive(Clone, Debug, Default)]
pub struct Material {
    /// Upper-case name.
    pub name: String,
    /// `*MATERIAL` card.
    pub span: Span,
    /// Mass per volume, at the initial temperature.
    pub density: Option<f64>,
    /// Rows of the mass per volume and temperature; empty where there is no temperature.
    pub densities: Vec<[f64; 2]>,
    /// Young's modulus and Poisson's ratio; of a table the stiffest row.
    pub elastic: Option<[f64; 2]>,
    /// Rows of Young's modulus, Poisson's ratio, temperature and field variables, as many in each, the temperature varying
    /// fastest; empty where the moduli are constant.
    pub elastic_table: Vec<Vec<f64>>,
    /// Shear modulus, of an `*ELASTIC, TYPE=SHEAR`.
    pub shear_modulus: Option<f64>,
    /// `*HYPERELASTIC`.
    pub hyperelastic: Option<Hyperelastic>,
    /// Equation of state.
    pub eos: Option<EquationOfState>,
    /// `*DETONATION POINT`: `[r, z]` and total time of each.
    pub detonation: Vec<[f64; 3]>,
    /// Yield description.
    pub plastic: Option<Plastic>,
    /// `*CRUSHABLE FOAM` and the card.
    pub foam: Option<(FoamShape, Span)>,
    /// `*CRUSHABLE FOAM HARDENING`: rows of the yield stress in uniaxial compression and the plastic strain.
    pub foam_hardening: Vec<[f64; 2]>,
    /// `*DAMPING, ALPHA`, 1/time, and the card; `None` where it is zero.
    pub damping: Option<(f64, Span)>,
    /// Whether the yield stress goes on beyond the last plastic strain of a table as between its last two rows
    /// (`EXTRAPOLATION=LINEAR`).
    pub extrapolates: bool,
    /// Rate dependence.
    pub rate: Option<RateDependence>,
    /// Fraction of plastic work turned into heat.
    pub inelastic_heat_fraction: Option<f64>,
    /// Rows of the heat per mass and temperature, and the temperature (NaN where absent).
    pub specific_heat: Option<Vec<[f64; 2]>>,
    /// Rows of the heat a time, length and temperature, and the temperature (NaN where absent), with the card.
    pub conductivity: Option<(Vec<[f64; 2]>, Span)>,
    /// `*EXPANSION`.
    pub expansion: Option<Expansion>,
    /// Failure by the plastic strain, in the order of the deck.
    pub failures: Vec<FailureCriterion>,
    /// `*TENSILE FAILURE`.
    pub tensile_failure: Option<TensileFailure>,
    /// `*CAVITY EXPANSION` (extension).
    pub cavity: Option<CavityExpansion>,
    /// `*USER MATERIAL`: its constants.
    pub user: Option<Vec<f64>>,
    /// `*USER DEFINED FIELD`: constants of its routine, and the card.
    pub fields: Option<(Vec<f64>, Span)>,
    /// `*CHARACTERISTIC LENGTH, DEFINITION=USER`: constants of its routine, and the card.
    pub lengths: Option<(Vec<f64>, Span)>,
    /// `*DEPVAR`.
    pub state: StateVariables,
    /// Names that `*DEPVAR` gives variables, which are counted from 0.
    pub state_names: Vec<(usize, String)>,
}

/// `*EXPANSION`: thermal strain from a reference temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// Rows of the coefficient and the temperature (NaN where absent).
    pub rows: Vec<[f64; 2]>,
    /// Reference temperature (`ZERO`).
    pub zero: f64,
    /// The card.
    pub span: Span,
}

/// `*DEPVAR`: what the user's routines keep at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateVariables {
    /// How many variables.
    pub count: usize,
    /// The one, counted from 0, that deletes an element when it becomes zero (`DELETE`).
    pub delete: Option<usize>,
}

/// `*HYPERELASTIC`.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperelastic {
    /// Energy of a change of shape.
    pub shape: RubberShape,
    /// D1, D2, ... of the energy of a change of volume; all zero where the card gives no compressibility.
    pub compressibility: Vec<f64>,
    /// The card.
    pub span: Span,
}

/// Form of the energy of rubber and its constants.
#[derive(Clone, Debug, PartialEq)]
pub enum RubberShape {
    /// C10.
    NeoHooke(f64),
    /// Each C_ij with i and j.
    Polynomial(Vec<(f64, usize, usize)>),
    /// Each mu and alpha.
    Ogden(Vec<[f64; 2]>),
}

impl RubberShape {
    /// Initial shear modulus.
    pub fn shear(&self) -> f64 {
        match self {
            RubberShape::NeoHooke(c10) => 2.0 * c10,
            RubberShape::Polynomial(terms) => 2.0 * terms.iter().filter(|t| t.1 + t.2 == 1).map(|t| t.0).sum::<f64>(),
            RubberShape::Ogden(terms) => terms.iter().map(|t| t[0]).sum(),
        }
    }
}

/// How the yield surface of foam grows, and its shape at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoamShape {
    /// By compaction: strength in uniaxial compression, and in hydrostatic tension, over that in hydrostatic compression.
    Volumetric([f64; 2]),
    /// Alike in all directions: strength in uniaxial over that in hydrostatic compression, plastic Poisson's ratio.
    Isotropic([f64; 2]),
}

/// `*EOS`.
#[derive(Clone, Debug, PartialEq)]
pub struct EquationOfState {
    /// Form and constants.
    pub kind: EosKind,
    /// The card.
    pub span: Span,
}

/// Form of an equation of state.
#[derive(Clone, Debug, PartialEq)]
pub enum EosKind {
    /// Ideal gas: gas constant (energy a mass and temperature) and ambient pressure.
    IdealGas([f64; 2]),
    /// Linear shock speed: c0, s, Grueneisen coefficient.
    UsUp([f64; 3]),
    /// Rows of f1, f2 and the volumetric strain, which descends.
    Tabular(Vec<[f64; 3]>),
    /// Explosive: speed of the detonation, A, B, omega, R1, R2, energy a mass, bulk modulus before the detonation.
    Jwl([f64; 8]),
}

/// `*SHEAR FAILURE`, or `*DAMAGE INITIATION` with its `*DAMAGE EVOLUTION`.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureCriterion {
    /// Plastic strain at which the element fails or its damage begins.
    pub strain: StrainAtFailure,
    /// What follows.
    pub evolution: DamageEvolution,
    /// The card.
    pub span: Span,
}

impl FailureCriterion {
    /// Whether what follows depends on the length of an element.
    pub fn takes_length(&self) -> bool {
        matches!(self.evolution, DamageEvolution::Displacement(_) | DamageEvolution::Energy(_))
    }
}

/// Plastic strain at failure.
#[derive(Clone, Debug, PartialEq)]
pub enum StrainAtFailure {
    /// A constant.
    Constant(f64),
    /// d1 to d5; melting temperature, transition temperature and reference rate, which `*SHEAR FAILURE` takes from
    /// `*PLASTIC` and `*RATE DEPENDENT`.
    JohnsonCook([f64; 5], Option<[f64; 3]>),
    /// Rows of strain, triaxiality, rate and temperature; the first variable varies fastest.
    Ductile(Vec<[f64; 4]>),
    /// Rows of strain, rate, pressure over von Mises stress, and temperature, likewise.
    Shear(Vec<[f64; 4]>),
}

/// How damage grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DamageEvolution {
    /// The element is deleted at once.
    Sudden,
    /// Not at all: no `*DAMAGE EVOLUTION`.
    Absent,
    /// Linear in the displacement; its value at failure.
    Displacement(f64),
    /// Linear, by the energy an area.
    Energy(f64),
}

/// `*TENSILE FAILURE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensileFailure {
    /// Mean stress that is not exceeded.
    pub cutoff: f64,
    /// Whether the element that reaches it is deleted.
    pub deletes: bool,
    /// The card.
    pub span: Span,
}

/// `*PLASTIC`.
#[derive(Clone, Debug)]
pub enum Plastic {
    /// Rows of yield stress, plastic strain, temperature (NaN where absent).
    Tabular(Vec<[f64; 3]>),
    /// A, B, n, m, melting temperature, transition temperature.
    JohnsonCook([f64; 6]),
    /// Linear kinematic: yield stress without plastic strain, slope of the stress over it, temperature (NaN where absent).
    Kinematic(Vec<[f64; 3]>),
    /// The routine of the user gives the yield stress, with these constants.
    User(Vec<f64>),
    /// Rows of yield stress, plastic strain, temperature and field variables, as many in each, the plastic strain varying
    /// fastest.
    OverFields(Vec<Vec<f64>>),
}

/// `*RATE DEPENDENT`.
#[derive(Clone, Debug)]
pub enum RateDependence {
    /// C and the reference strain rate.
    JohnsonCook([f64; 2]),
    /// Rows of D, n and temperature (NaN where absent).
    PowerLaw(Vec<[f64; 3]>),
    /// Rows of yield stress ratio, strain rate and temperature, likewise.
    YieldRatio(Vec<[f64; 3]>),
}

/// Resistance of a material to an expanding cavity: `sigma_n = Y (A + B x + C x^2)`, `x = v_n sqrt(rho / Y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityExpansion {
    /// Y, stress.
    pub yield_stress: f64,
    /// A, dimensionless.
    pub a: f64,
    /// B, dimensionless.
    pub b: f64,
    /// C, dimensionless.
    pub c: f64,
    /// Where A, B and C come from, if the card derives them.
    pub derived: Option<Derivation>,
    /// The card.
    pub span: Span,
}

/// How constants were derived from a material's own curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivation {
    /// Range of velocities of the fit.
    pub range: [f64; 2],
    /// Root of the weighted mean square of what the fit leaves over, over Y.
    pub residual: f64,
    /// The largest relative difference of the law from the pressure, and the velocity there.
    pub worst: [f64; 2],
    /// Pressure at rest over Y.
    pub still: f64,
}

/// `*SOLID SECTION`.
#[derive(Clone, Debug)]
pub struct SolidSection {
    /// Element indices.
    pub elements: Vec<usize>,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// Name of its section controls, upper case.
    pub controls: Option<String>,
    /// The card.
    pub span: Span,
}

/// `*SHELL SECTION`.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellSection {
    /// Element indices.
    pub elements: Vec<usize>,
    /// Index into [`Model::materials`].
    pub material: usize,
    /// Thickness, length.
    pub thickness: f64,
    /// Points of Simpson's rule through it, odd and at least 3.
    pub points: usize,
    /// Mass per area beside that of the material (`DENSITY`).
    pub per_area: f64,
    /// How the thickness changes (`POISSON`).
    pub thinning: ShellThinning,
    /// The card.
    pub span: Span,
}

/// `POISSON` of `*SHELL SECTION`: how the thickness follows from strains in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShellThinning {
    /// By the material at the points through the thickness (`MATERIAL`).
    #[default]
    Material,
    /// By the Poisson's ratio of the material (`ELASTIC`).
    Elastic,
    /// By a ratio; 0 keeps the thickness.
    Ratio(f64),
}

/// `*EROSION`: limits whose passing deletes an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Erosion {
    /// The card.
    pub span: Span,
    /// Its elements, ascending; `None` for all that deform.
    pub elements: Option<Vec<usize>>,
    /// Least scaled Jacobian, from 0 (folded) on and below 1.
    pub distortion: Option<f64>,
    /// Largest equivalent plastic strain.
    pub plastic: Option<f64>,
    /// Largest principal logarithmic strain.
    pub strain: Option<f64>,
    /// Least stable increment of an element, time.
    pub increment: Option<f64>,
}

/// `*SECTION CONTROLS`.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionControls {
    /// Upper-case name.
    pub name: String,
    /// What resists hourglassing; by the material where the card says nothing.
    pub hourglass: Option<Hourglass>,
    /// Factor on it.
    pub factor: f64,
    /// Whether the equation of motion is weighted by area instead of by volume.
    pub by_area: bool,
    /// LENGTH RATIO of distortion control; `None` without it.
    pub distortion: Option<f64>,
    /// MAX DEGRADATION: the damage at which an element is deleted or that it keeps; 1 or, where it is kept, 0.99 if the deck says
    /// nothing.
    pub most_damage: f64,
    /// `AVERAGED PRESSURE`, where the deck says it: whether triangles average their dilation over nodes.
    pub averaged: Option<bool>,
    /// SUBZONAL: whether quarters of elements push back; `None` where the deck says nothing.
    pub subzonal: Option<bool>,
    /// `ELEMENT DELETION=NO`, where the deck says so.
    pub keeps_failed: Option<Span>,
}

/// What resists hourglassing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hourglass {
    /// A spring whose force relaxes as the material flows: what elements have without a word.
    RelaxStiffness,
    /// A spring.
    Stiffness,
    /// A dashpot.
    Viscous,
    /// Both: this weight for the spring, the rest for the dashpot.
    Combined(f64),
    /// The stresses of assumed strains that vary across the element.
    Enhanced,
}

/// A function of time that scales a load or a motion.
#[derive(Clone, Debug)]
pub struct Amplitude {
    /// Upper-case name.
    pub name: String,
    /// What gives its values.
    pub definition: AmplitudeDefinition,
    /// Whether its values are magnitudes themselves, and those of loads and motions mean nothing (`VALUE=ABSOLUTE`).
    pub absolute: bool,
    /// The card.
    pub span: Span,
}

/// What gives an amplitude its values.
#[derive(Clone, Debug)]
pub enum AmplitudeDefinition {
    /// Points.
    Curve {
        /// `(time, value)` with ascending times; constant before the first and after the last.
        points: Vec<[f64; 2]>,
        /// `DEFINITION=SMOOTH STEP`.
        smooth: bool,
        /// `TIME=TOTAL TIME`.
        total_time: bool,
    },
    /// `DEFINITION=USER`.
    User {
        /// Constants on the data lines.
        properties: Vec<f64>,
        /// How many variables the routine keeps.
        variables: usize,
    },
}

/// A rigid body.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// Name of the element set that makes it, for messages.
    pub name: String,
    /// Reference node.
    pub reference: usize,
    /// Its elements.
    pub elements: Vec<usize>,
    /// Nodes tied or pinned in addition to the elements' own.
    pub nodes: Vec<usize>,
    /// Thickness of its RAX2 elements (0 if not given), length.
    pub thickness: f64,
    /// Mass per volume of its RAX2 elements (0 if not given).
    pub density: f64,
    /// The card.
    pub span: Span,
}

/// Attitude of a rigid body at the start, and how it is followed if its impact is oblique (extension).
#[derive(Clone, Debug)]
pub struct Attitude {
    /// Reference node of the body.
    pub reference: usize,
    /// Angles in degrees by which it is turned about its reference node: about direction 3, in the plane in which targets are
    /// tilted, and then about direction 1, out of it.
    pub angles: [f64; 2],
    /// Stations around the axis at which resistance is taken.
    pub stations: usize,
    /// Whether its mass is spread evenly over the volume that its meridian encloses, for its centre and its inertia.
    pub uniform: bool,
    /// The card.
    pub span: Span,
}

/// Stations around the axis unless `*ATTITUDE` says how many.
pub const STATIONS: usize = 64;

/// A rotary inertia on a node.
#[derive(Clone, Copy, Debug)]
pub struct RotaryInertia {
    /// Node index.
    pub node: usize,
    /// Moment of inertia about the axis of symmetry, and about any axis across it through the node.
    pub axial_transverse: [f64; 2],
    /// The card.
    pub span: Span,
}

/// A mass on a node.
#[derive(Clone, Copy, Debug)]
pub struct PointMass {
    /// Node index.
    pub node: usize,
    /// Mass.
    pub mass: f64,
    /// The card.
    pub span: Span,
}

/// An analytical rigid surface of lines and arcs.
#[derive(Clone, Debug)]
pub struct RigidSurface {
    /// Its segments in order; the front is to the left of the way along them.
    pub profile: Profile,
    /// Reference node of the rigid body that carries it.
    pub reference: Option<usize>,
    /// The card.
    pub span: Span,
}

/// How surfaces interact.
#[derive(Clone, Debug)]
pub struct Interaction {
    /// Upper-case name.
    pub name: String,
    /// What it does.
    pub law: Law,
    /// Its cards of heat.
    pub heat_cards: Vec<(&'static str, Span)>,
}

/// Contact of two surfaces of elements, of one with itself, or of one with an analytical surface.
#[derive(Clone, Debug)]
pub struct SurfaceContact {
    /// Both surfaces; the same twice where one meets itself.
    pub sides: [Sides; 2],
    /// Of an analytical surface and what meets it; `None` of surfaces of elements.
    pub analytical: Option<AnalyticalSide>,
    /// Whether it is one of general contact.
    pub general: bool,
    /// Whether shells meet at their middle surface (`NO THICKNESS`).
    pub thin: bool,
    /// What gaps at the start are taken as; `None` as they are.
    pub clearance: Option<Clearance>,
    /// Factor on the stiffness of penalty springs; `None` where surfaces do not give way.
    pub penalty: Option<f64>,
    /// Name of the set of pairs that it belongs to (`CPSET`), upper case.
    pub cpset: Option<String>,
    /// Name of its surface interaction, which may be defined anywhere in the deck.
    pub interaction: Option<Word>,
    /// What that does.
    pub law: Law,
    /// The data line.
    pub span: Span,
}

impl SurfaceContact {
    /// Whether it is a surface that may meet itself.
    pub fn is_of_one(&self) -> bool {
        self.sides[0].name == self.sides[1].name
    }
}

/// Which side of a pair is an analytical surface, and what meets it.
#[derive(Clone, Debug)]
pub struct AnalyticalSide {
    /// The side; it has the upper-case name of the surface and no faces.
    pub side: usize,
    /// Nodes of the other surface, ascending; that has no faces either where it is one of nodes.
    pub nodes: Vec<usize>,
}

/// What gaps at the start are taken as: no node is moved, and nothing is strained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The gap, length.
    pub gap: f64,
    /// Gaps up to this are, length; `None` is a tenth of the elements.
    pub above: Option<f64>,
    /// Overlaps up to this are, length; `None` is a tenth of the elements.
    pub below: Option<f64>,
}

/// What a word of general contact means.
#[derive(Clone, Debug)]
pub enum ContactDomain {
    /// All that is outside.
    All,
    /// A surface.
    Surface(Sides),
}

/// General contact (`*CONTACT`): which surfaces may meet is found from the mesh.
#[derive(Clone, Debug, Default)]
pub struct GeneralContact {
    /// The card.
    pub span: Span,
    /// Whether all that is outside may meet everything (`ALL EXTERIOR`).
    pub all: bool,
    /// What may meet beside that, with its data line.
    pub included: Vec<([ContactDomain; 2], Span)>,
    /// What may not.
    pub excluded: Vec<[ContactDomain; 2]>,
    /// How they interact; the last that covers a pair counts.
    pub assigned: Vec<AssignedInteraction>,
    /// What gaps at the start are taken as; the last that covers a pair counts.
    pub clearances: Vec<AssignedClearance>,
    /// Factors on penalty springs, which what they cover has; the last that covers a pair counts.
    pub penalties: Vec<([ContactDomain; 2], f64)>,
    /// Whether nodes that no element has any more meet nothing (`NODAL EROSION=YES`).
    pub drops_points: bool,
}

/// What gaps at the start of general contact are taken as.
#[derive(Clone, Debug)]
pub struct AssignedClearance {
    /// What it is given to.
    pub domains: [ContactDomain; 2],
    /// Its name, which may be defined anywhere in the deck.
    pub name: Word,
    /// What it says.
    pub clearance: Option<Clearance>,
}

/// An interaction of general contact.
#[derive(Clone, Debug)]
pub struct AssignedInteraction {
    /// What it is given to.
    pub domains: [ContactDomain; 2],
    /// Its name.
    pub interaction: Word,
    /// What it does.
    pub law: Law,
}

/// What springs or dashpots of a set do.
#[derive(Clone, Debug)]
pub struct ConnectorProperty {
    /// Element indices.
    pub elements: Vec<usize>,
    /// 1 = r, 2 = z, for those between a node and the ground.
    pub dof: u8,
    /// Law.
    pub law: ConnectorLaw,
    /// The card.
    pub span: Span,
}

/// Law of a spring or a dashpot.
#[derive(Clone, Debug, PartialEq)]
pub enum ConnectorLaw {
    /// Force a length.
    Spring(f64),
    /// Rows of relative displacement and force.
    Table(Vec<[f64; 2]>),
    /// Force a velocity.
    Dashpot(f64),
    /// Rows of relative velocity and force.
    DashpotTable(Vec<[f64; 2]>),
}

/// A linear equation, sum of coefficient times displacement or temperature = 0.
#[derive(Clone, Debug)]
pub struct Equation {
    /// Node index, degree of freedom (1 = r, 2 = z, 11 = temperature, in all terms or in none) and coefficient of each term.
    pub terms: Vec<(usize, u8, f64)>,
    /// The data line that begins it.
    pub span: Span,
}

impl Equation {
    /// Whether it is one between temperatures.
    pub fn is_thermal(&self) -> bool {
        self.terms.iter().any(|t| t.1 == 11)
    }
}

/// Nodes whose motion is that of a reference node (`*MPC`, `*COUPLING`).
#[derive(Clone, Debug)]
pub struct Link {
    /// What the deck calls it, for messages.
    pub name: String,
    /// How they are joined.
    pub kind: LinkKind,
    /// Reference node.
    pub reference: usize,
    /// The others.
    pub nodes: Vec<usize>,
    /// The data line or card.
    pub span: Span,
}

/// How nodes are joined to a reference node.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkKind {
    /// They move as it does, along r, along z, or both.
    Rigid([bool; 2]),
    /// It moves along z as they do in the mean with these weights, one for each, and hands its loads on by them.
    Distributing(Vec<f64>),
}

/// A surface whose nodes follow another surface (`*TIE`).
#[derive(Clone, Debug)]
pub struct SurfaceTie {
    /// Upper-case name.
    pub name: String,
    /// Nodes of the slave surface, ascending.
    pub slaves: Vec<usize>,
    /// Sides of the master surface.
    pub masters: Vec<(usize, Side)>,
    /// Whether tied nodes are first put on the master surface.
    pub adjust: bool,
    /// How far from the master surface a node may lie; 5 % of its facets' mean length if not given.
    pub tolerance: Option<f64>,
    /// The nodes that are tied whatever their distance, and no others (`TIED NSET`), ascending.
    pub chosen: Option<Vec<usize>>,
    /// The data line.
    pub span: Span,
}

/// An initial condition.
#[derive(Clone, Debug)]
pub struct InitialCondition {
    /// What is given.
    pub kind: InitialKind,
    /// Nodes (velocity, temperature) or elements (stress, energy) it is given for.
    pub members: Vec<usize>,
    /// The data line.
    pub span: Span,
}

/// What an initial condition gives.
#[derive(Clone, Debug, PartialEq)]
pub enum InitialKind {
    /// Degree of freedom (1 = r, 2 = z, 6 = rotation; of oblique bodies 1 to 3 along 1, 2, 3, and 4 to 6 about them) and velocity.
    Velocity(u8, f64),
    /// Temperature.
    Temperature(f64),
    /// Stress components as the card lists them.
    Stress(Vec<f64>),
    /// Energy a mass.
    Energy(f64),
    /// Equivalent plastic strain.
    Hardening(f64),
    /// State variables of the user's, from the first.
    State(Vec<f64>),
    /// A field variable, counted from 0, and its value.
    Field(usize, f64),
}

/// A target that is not meshed: layers of material, one behind the other (extension).
#[derive(Clone, Debug)]
pub struct Target {
    /// Upper-case name.
    pub name: String,
    /// z of the impact face.
    pub front: f64,
    /// +1 or -1: the way the layers follow each other along z.
    pub direction: f64,
    /// Angle in degrees by which its planes are turned about direction 3, through the point where the front meets the axis.
    pub obliquity: f64,
    /// From the front on.
    pub layers: Vec<Layer>,
    /// Which of its faces weaken what it resists with.
    pub free_surfaces: FreeSurfaces,
    /// Depth of the crater over which the resistance grows, length.
    pub crater: Option<f64>,
    /// Shear stress at which a plug is sheared out.
    pub shear_strength: Option<f64>,
    /// Whether the wall of the tunnel stays where the body has pushed it.
    pub separation: bool,
    /// The card.
    pub span: Span,
}

/// Which faces of a target are free surfaces that weaken what it resists with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeSurfaces {
    /// None: layers are as strong as a body without end.
    Off,
    /// Those that border on nothing: the outer ones, those at gaps, lateral ones.
    Plates,
    /// Those of every layer: layers lie on each other and do not hold together.
    Layers,
}

/// One layer of a target.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Index into [`Model::materials`], of a material with density and cavity expansion; `None` in a gap between plates.
    pub material: Option<usize>,
    /// Thickness, length; may be infinite.
    pub thickness: f64,
    /// Radius of its lateral face, length; may be infinite.
    pub radius: f64,
    /// The data line.
    pub span: Span,
}

/// One step.
#[derive(Clone, Debug)]
pub struct Step {
    /// Name (or `Step-1`, …).
    pub name: String,
    /// The `*DYNAMIC` card.
    pub span: Span,
    /// Length of the step, time.
    pub duration: f64,
    /// How the increment is chosen.
    pub increment: IncrementControl,
    /// Factor on an automatic increment.
    pub scale_factor: f64,
    /// What velocity a load is shown.
    pub load_velocity: LoadVelocity,
    /// Linear and quadratic bulk viscosity.
    pub bulk_viscosity: [f64; 2],
    /// Whether heat stays where plastic work makes it (`ADIABATIC`).
    pub adiabatic: bool,
    /// Whether temperatures of nodes are solved for (`*DYNAMIC TEMPERATURE-DISPLACEMENT`).
    pub coupled: bool,
    /// Prescribed motions in force, each with the nodes on which no later one acts.
    pub boundaries: Vec<Boundary>,
    /// Loads in force, each at the places where no later step gives another of its kind.
    pub loads: Vec<Load>,
    /// Field variables in force, each with the nodes to which no later one gives another value.
    pub fields: Vec<PrescribedField>,
    /// Contact of pairs of surfaces in force.
    pub surface_contacts: Vec<SurfaceContact>,
    /// General contact in force.
    pub general_contact: Option<GeneralContact>,
    /// Mass scaling in force, in the order of the deck.
    pub mass_scalings: Vec<MassScaling>,
    /// Limits on energies in force.
    pub energy_limit: Option<EnergyLimit>,
    /// Output requests in force.
    pub outputs: Vec<OutputRequest>,
    /// When the state is kept, if the deck asks.
    pub restart: Option<Restart>,
}

impl Step {
    /// Whether anything may meet.
    pub fn has_contact(&self) -> bool {
        !self.surface_contacts.is_empty() || self.general_contact.is_some()
    }

    /// Friction of all surfaces that may meet.
    pub fn frictions(&self) -> impl Iterator<Item = &Friction> {
        let assigned = self.general_contact.iter().flat_map(|g| &g.assigned).map(|a| &a.law);
        self.surface_contacts.iter().map(|c| &c.law).chain(assigned).map(|law| &law.friction)
    }

    /// The same, to be changed.
    pub fn frictions_mut(&mut self) -> impl Iterator<Item = &mut Friction> {
        let assigned = self.general_contact.iter_mut().flat_map(|g| &mut g.assigned).map(|a| &mut a.law);
        self.surface_contacts.iter_mut().map(|c| &mut c.law).chain(assigned).map(|law| &mut law.friction)
    }
}

/// `*RESTART, WRITE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart {
    /// How often.
    pub interval: Interval,
    /// The card.
    pub span: Span,
}

/// `*ENERGY LIMIT`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyLimit {
    /// The card.
    pub span: Span,
    /// Of the drift of ETOTAL over the largest energy.
    pub error: Option<f64>,
    /// Of ALLAE over ALLIE.
    pub artificial: Option<f64>,
    /// Whether the run halts; otherwise it warns.
    pub halts: bool,
}

/// `*FIXED MASS SCALING` or `*VARIABLE MASS SCALING`.
#[derive(Clone, Debug, PartialEq)]
pub struct MassScaling {
    /// The card.
    pub span: Span,
    /// Elements; all if `None`.
    pub elements: Option<Vec<usize>>,
    /// Factor on the mass (1 if not given).
    pub factor: f64,
    /// Stable increment aimed at, time, and how.
    pub target: Option<(ScalingType, f64)>,
    /// When it is done again; `None` for a fixed one, which is done once.
    pub rhythm: Option<ScalingRhythm>,
}

/// `TYPE` of mass scaling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingType {
    /// Elements below the target are brought up to it.
    BelowMin,
    /// One factor for all.
    Uniform,
    /// All are brought to it.
    SetEqual,
}

/// How often `*VARIABLE MASS SCALING` is done again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalingRhythm {
    /// `FREQUENCY`: every so many increments.
    Increments(u64),
    /// `NUMBER INTERVAL`: so many times in the step.
    Intervals(u64),
}

/// How the increment is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IncrementControl {
    /// By the stability limit, or by an error estimate where nothing limits it; `accuracy` is the relative error aimed at.
    Automatic {
        /// Relative error of the motion aimed at (default 1e-4).
        accuracy: f64,
        /// `ELEMENT BY ELEMENT`.
        element_by_element: bool,
        /// Largest increment, time; infinite where the deck gives none.
        largest: f64,
    },
    /// `DIRECT USER CONTROL`: this increment.
    Fixed(f64),
}

/// What velocity a load is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadVelocity {
    /// A second-order estimate at the increment's own time (default).
    Predicted,
    /// The mid-increment velocity behind, as ABAQUS passes it.
    Lagged,
}

/// A prescribed motion.
#[derive(Clone, Debug)]
pub struct Boundary {
    /// Node indices.
    pub nodes: Vec<usize>,
    /// What the deck called them.
    pub set: String,
    /// 1 = r, 2 = z, 6 = rotation, 11 = temperature.
    pub dof: u8,
    /// What is prescribed.
    pub kind: Motion,
    /// Whether the user's routine gives the value (`USER`).
    pub user: bool,
    /// Magnitude (0 = held).
    pub value: f64,
    /// Index into [`Model::amplitudes`].
    pub amplitude: Option<usize>,
    /// The data line.
    pub span: Span,
}

/// A field variable at nodes over time (`*FIELD`).
#[derive(Clone, Debug)]
pub struct PrescribedField {
    /// The variable, counted from 0.
    pub variable: usize,
    /// Node indices, ascending.
    pub nodes: Vec<usize>,
    /// What the deck called them.
    pub set: String,
    /// Value at amplitude 1.
    pub value: f64,
    /// Index into [`Model::amplitudes`].
    pub amplitude: Option<usize>,
    /// The data line.
    pub span: Span,
}

/// What a boundary prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Displacement; in a step, since its beginning: none jumps.
    Displacement,
    /// Velocity.
    Velocity,
    /// Acceleration.
    Acceleration,
    /// Temperature (degree of freedom 11).
    Temperature,
}

/// A load in force in a step.
#[derive(Clone, Debug)]
pub struct Load {
    /// What acts.
    pub kind: LoadKind,
    /// Magnitude as on the data line (1 where the load has none).
    pub magnitude: f64,
    /// Index into [`Model::amplitudes`].
    pub amplitude: Option<usize>,
    /// The data line.
    pub span: Span,
}

/// What a load acts on and how.
#[derive(Clone, Debug)]
pub enum LoadKind {
    /// `*CLOAD`: a force on each node in a degree of freedom.
    Concentrated {
        /// Node indices.
        nodes: Vec<usize>,
        /// 1 = r, 2 = z.
        dof: u8,
        /// What the deck called them.
        set: String,
    },
    /// `*DLOAD … GRAV`: an acceleration; the direction is a unit vector `[r, z]`.
    Gravity {
        /// Element indices; `None` means everything with mass.
        elements: Option<Vec<usize>>,
        /// Unit vector `[r, z]`.
        direction: [f64; 2],
    },
    /// `P`: a pressure on sides.
    Pressure(Sides),
    /// `PNU`, `P1NU` to `P4NU`: the user's routine gives the pressure.
    User {
        /// Where.
        sides: Sides,
        /// VDLOAD's code of the load, `jltyp`.
        load_type: i32,
    },
    /// `BRNU`, `BZNU`: the user's routine gives the force a volume along r or z.
    UserBody {
        /// Element indices.
        elements: Vec<usize>,
        /// What the deck called them.
        set: String,
        /// VDLOAD's code of the load, `jltyp`: 1 along r, 2 along z.
        load_type: i32,
    },
    /// `CAVITY` (extension): a target's resistance.
    Cavity {
        /// Where.
        sides: Sides,
        /// Index into [`Model::targets`].
        target: usize,
        /// Coulomb friction coefficient.
        friction: f64,
    },
    /// `*CFLUX`: heat a time into each node.
    NodalHeat {
        /// Node indices.
        nodes: Vec<usize>,
        /// What the deck called them.
        set: String,
    },
    /// `*DFLUX S1` to `S4`, `*DSFLUX`: heat a time and area into the body.
    SurfaceHeat(Sides),
    /// `*DFLUX BF`: heat a time and volume.
    BodyHeat {
        /// Element indices.
        elements: Vec<usize>,
        /// What the deck called them.
        set: String,
    },
    /// `*FILM`, `*SFILM`: the magnitude is the temperature of the fluid.
    Film {
        /// Where.
        sides: Sides,
        /// Heat a time, area and temperature.
        coefficient: f64,
        /// Index into [`Model::amplitudes`] of the coefficient's amplitude.
        amplitude: Option<usize>,
    },
}

/// Where a distributed load acts.
#[derive(Clone, Debug)]
pub struct Sides {
    /// Name of the surface or element set, as written.
    pub name: String,
    /// Whether it came by `*DSLOAD` (a surface) or `*DLOAD` (elements).
    pub surface: bool,
    /// `(element index, side)`.
    pub faces: Vec<(usize, Side)>,
    /// Elements of which all that lies bare is meant, as others are deleted too.
    pub whole: Vec<usize>,
}

/// What to write and when.
#[derive(Clone, Debug)]
pub struct OutputRequest {
    /// Fields into frames, or histories into columns.
    pub kind: OutputKind,
    /// How often.
    pub interval: Interval,
    /// The card that asks: `PRESELECT` and `ALL` mean what lives there.
    pub card: OutputCard,
    /// What is asked for.
    pub variables: Vec<Asked>,
    /// Where fields of elements are shown.
    pub position: Position,
    /// What the variables are taken from.
    pub region: Region,
    /// What histories show of the whole set (`STATISTICS`); a column for each member where empty.
    pub statistics: Vec<Statistic>,
    /// Name of the sensor that it is (`SENSOR, NAME=`), upper case.
    pub sensor: Option<String>,
    /// The card.
    pub span: Span,
}

/// A history column that follows from others.
#[derive(Clone, Debug)]
pub struct OutputExpression {
    /// Its name, upper case.
    pub name: String,
    /// The expression over names of history columns, as written.
    pub text: String,
    /// Where the definition stands.
    pub span: Span,
    /// Where the expression stands.
    pub place: Span,
}

/// Frames or histories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// `*OUTPUT, FIELD`.
    Field,
    /// `*OUTPUT, HISTORY`.
    History,
}

/// The card of an output request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputCard {
    /// `*OUTPUT, VARIABLE=` itself.
    Output,
    /// `*NODE OUTPUT`.
    Node,
    /// `*ELEMENT OUTPUT`.
    Element,
    /// `*ENERGY OUTPUT`.
    Energy,
    /// `*INCREMENTATION OUTPUT`.
    Incrementation,
    /// `*INTEGRATED OUTPUT`.
    Integrated,
    /// `*CONTACT OUTPUT`.
    Contact,
}

impl OutputCard {
    /// Where the variables live that it may ask for.
    pub fn places(self) -> &'static [Place] {
        match self {
            OutputCard::Output => {
                &[Place::Node, Place::Point, Place::Element, Place::Facet, Place::Energy, Place::Increment]
            }
            OutputCard::Node => &[Place::Node],
            OutputCard::Element => &[Place::Point, Place::Element, Place::Facet],
            OutputCard::Energy => &[Place::Energy],
            OutputCard::Incrementation => &[Place::Increment],
            OutputCard::Integrated => &[Place::Section],
            OutputCard::Contact => &[Place::Node, Place::Pair],
        }
    }
}

/// `POSITION` of `*ELEMENT OUTPUT`: where a frame shows variables of integration points. An element has one such point, in
/// its middle, so that those and centroids are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Position {
    /// `INTEGRATION POINTS`, `CENTROIDAL`: on elements.
    #[default]
    Element,
    /// `NODES`, `AVERAGED AT NODES`: on nodes, the mean over the elements around.
    Nodes,
}

/// How often output is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interval {
    /// Every so much time.
    Time(f64),
    /// So many times over the step, evenly.
    Number(u32),
    /// Every so many increments.
    Increments(u32),
    /// At times of the step: an index into [`Model::time_points`].
    Points(usize),
    /// Never (`FREQUENCY=0`).
    Never,
    /// The program's default.
    Default,
}

/// `*TIME POINTS`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimePoints {
    /// Name, upper case.
    pub name: String,
    /// Times of the step, ascending.
    pub times: Vec<f64>,
}

/// What output variables are taken from.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// The whole model.
    Whole,
    /// A node set by upper-case name.
    Nodes(String),
    /// An element set by upper-case name.
    Elements(String),
    /// A surface of element faces by upper-case name, and what its columns are called.
    Surface(String, String),
    /// Pairs of surfaces in contact.
    Pairs(WhichPairs),
}

/// Which pairs of surfaces are meant: those that are all of what is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WhichPairs {
    /// The set of pairs, upper case.
    pub cpset: Option<String>,
    /// The surface interaction, upper case.
    pub interaction: Option<String>,
    /// Whether those of general contact alone.
    pub general: bool,
    /// Surfaces by upper-case name, or parts of which the pair has.
    pub surfaces: Vec<String>,
}

impl WhichPairs {
    /// Whether a pair is meant.
    pub fn means(&self, pair: &SurfaceContact) -> bool {
        let interaction = pair.interaction.as_ref().map(|word| word.text.to_uppercase());
        let has = |name: &String| {
            let is = |s: &Sides| {
                s.name == *name
                    || s.name.strip_suffix(name.as_str()).is_some_and(|b| b.ends_with('.') && !b.ends_with(".NOT."))
            };
            pair.sides.iter().any(is)
        };
        self.cpset.as_ref().is_none_or(|set| pair.cpset.as_ref() == Some(set))
            && self.interaction.as_ref().is_none_or(|name| interaction.as_ref() == Some(name))
            && (!self.general || pair.general)
            && self.surfaces.iter().all(has)
    }
}

/// A card that was read but changes nothing here.
#[derive(Clone, Debug)]
pub struct Inert {
    /// Keyword.
    pub keyword: String,
    /// The card.
    pub span: Span,
    /// Why it changes nothing.
    pub why: String,
}
