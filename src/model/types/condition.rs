//! Amplitudes, initial conditions, prescribed motions and fields.
//! Never here: what becomes of them over the steps.

use super::handle::AmplitudeId;
use crate::deck::Span;

/// A function of time that scales a load or a motion.
#[derive(Clone, Debug, PartialEq)]
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
#[derive(Clone, Debug, PartialEq)]
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

impl InitialKind {
    /// Whether it is given for elements in place of nodes.
    pub fn is_of_elements(&self) -> bool {
        matches!(self, Self::Stress(_) | Self::Energy(_) | Self::Hardening(_) | Self::State(_))
    }
}

/// A prescribed motion.
#[derive(Clone, Debug, PartialEq)]
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
    /// The amplitude, if it varies.
    pub amplitude: Option<AmplitudeId>,
    /// The data line.
    pub span: Span,
}

/// A field variable at nodes over time (`*FIELD`).
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedField {
    /// The variable, counted from 0.
    pub variable: usize,
    /// Node indices, ascending.
    pub nodes: Vec<usize>,
    /// What the deck called them.
    pub set: String,
    /// Value at amplitude 1.
    pub value: f64,
    /// The amplitude, if it varies.
    pub amplitude: Option<AmplitudeId>,
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
