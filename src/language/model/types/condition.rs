//! Amplitudes, initial conditions, prescribed motions and prescribed fields.

use super::handle::AmplitudeId;
use crate::deck::Span;

/// A function of time that scales a load or a prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitude {
    /// Upper-case name.
    pub name: String,
    /// Tabulated curve or user subroutine.
    pub definition: AmplitudeDefinition,
    /// Whether the values are absolute magnitudes (`VALUE=ABSOLUTE`); the reference magnitude of the load or motion is
    /// then ignored.
    pub absolute: bool,
    /// Source position of the keyword line.
    pub span: Span,
}

/// Source of the amplitude values.
#[derive(Clone, Debug, PartialEq)]
pub enum AmplitudeDefinition {
    /// Tabulated curve.
    Curve {
        /// `(time, value)` with ascending times; constant before the first point and after the last.
        points: Vec<[f64; 2]>,
        /// Whether values are interpolated by smooth steps (`DEFINITION=SMOOTH STEP`).
        smooth: bool,
        /// Whether times are total times (`TIME=TOTAL TIME`) and not step times.
        total_time: bool,
    },
    /// User subroutine VUAMP (`DEFINITION=USER`).
    User {
        /// Properties given on the data lines.
        properties: Vec<f64>,
        /// Number of state variables of the subroutine.
        variables: usize,
    },
}

/// Initial value of a quantity at nodes or elements (`*INITIAL CONDITIONS`).
#[derive(Clone, Debug)]
pub struct InitialCondition {
    /// Quantity and value.
    pub kind: InitialKind,
    /// Node indices (velocity, temperature, field) or element indices (stress, energy, hardening, state), ascending.
    pub members: Vec<usize>,
    /// Source position of the data line.
    pub span: Span,
}

/// Quantity and value of an initial condition.
#[derive(Clone, Debug, PartialEq)]
pub enum InitialKind {
    /// Degree of freedom and velocity. 1 = r, 2 = z, 6 = rotation; for a rigid body in oblique impact 1 to 3 are
    /// translations along directions 1 to 3 and 4 to 6 rotations about them.
    Velocity(u8, f64),
    /// Initial temperature.
    Temperature(f64),
    /// Stress components in the order of the card.
    Stress(Vec<f64>),
    /// Specific energy, energy per mass.
    Energy(f64),
    /// Equivalent plastic strain.
    Hardening(f64),
    /// Solution-dependent state variables, starting with the first.
    State(Vec<f64>),
    /// Field variable, counted from 0, and its value.
    Field(usize, f64),
}

impl InitialKind {
    /// Returns whether the condition is defined on elements; all others are defined on nodes.
    pub fn applies_to_elements(&self) -> bool {
        matches!(self, Self::Stress(_) | Self::Energy(_) | Self::Hardening(_) | Self::State(_))
    }

    /// Returns the temperature that the condition prescribes, if any.
    pub fn temperature(&self) -> Option<f64> {
        if let Self::Temperature(value) = self { Some(*value) } else { None }
    }
}

/// A boundary condition (`*BOUNDARY`): a prescribed motion or temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryCondition {
    /// Node indices.
    pub nodes: Vec<usize>,
    /// Name of the node set, or the node, as written in the deck.
    pub set: String,
    /// Degree of freedom: 1 = r, 2 = z, 6 = rotation, 11 = temperature.
    pub dof: u8,
    /// Prescribed quantity.
    pub kind: MotionKind,
    /// Whether a user subroutine gives the value (`USER`).
    pub user: bool,
    /// Magnitude; 0 fixes the degree of freedom.
    pub value: f64,
    /// Amplitude; `None` for a constant value.
    pub amplitude: Option<AmplitudeId>,
    /// Source position of the data line.
    pub span: Span,
}

impl BoundaryCondition {
    /// Returns whether it prescribes a temperature.
    pub fn is_thermal(&self) -> bool {
        self.kind == MotionKind::Temperature
    }
}

/// Quantity prescribed at nodes that materials read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PredefinedVariable {
    /// Temperature (`*TEMPERATURE`).
    Temperature,
    /// Field variable (`*FIELD`), counted from 0.
    Field(usize),
}

/// A temperature or field variable prescribed at nodes (`*TEMPERATURE`, `*FIELD`).
#[derive(Clone, Debug, PartialEq)]
pub struct PrescribedField {
    /// Prescribed quantity.
    pub variable: PredefinedVariable,
    /// Node indices, ascending.
    pub nodes: Vec<usize>,
    /// Name of the node set, or the node, as written in the deck.
    pub set: String,
    /// Number of variables that user subroutine VUFIELD sets together, from `variable` on (`USER`, `NUMBER`); `None` if the
    /// value is given.
    pub user: Option<usize>,
    /// Value, scaled by the amplitude.
    pub value: f64,
    /// Amplitude; `None` for a constant value.
    pub amplitude: Option<AmplitudeId>,
    /// Source position of the data line.
    pub span: Span,
}

impl PrescribedField {
    /// Returns whether both prescribe a variable.
    pub fn shares_variable(&self, other: &PrescribedField) -> bool {
        match (self.variable, other.variable) {
            (PredefinedVariable::Field(a), PredefinedVariable::Field(b)) => {
                a < b + other.user.unwrap_or(1) && b < a + self.user.unwrap_or(1)
            }
            (a, b) => a == b,
        }
    }
}

/// Quantity that a boundary condition prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionKind {
    /// Displacement relative to the start of the step: displacements never jump.
    Displacement,
    /// The amplitude gives the velocity.
    Velocity,
    /// The amplitude gives the acceleration.
    Acceleration,
    /// Temperature (degree of freedom 11).
    Temperature,
}
