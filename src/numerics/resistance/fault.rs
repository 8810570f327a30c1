//! Errors of the resistance of a target.

use thiserror::Error;

/// Error of the computation of a resistance; velocities and stresses are in the units of the material.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ResistanceError {
    /// Invalid target material.
    #[error("{0}")]
    Target(String),
    /// Cavity velocity above the range of the similarity solution.
    #[error(
        "no similarity solution at velocity {velocity}: the plastic front would be a shock; the largest velocity is {fastest}"
    )]
    Fast {
        /// Requested velocity of the cavity wall.
        velocity: f64,
        /// Largest velocity with a solution.
        fastest: f64,
    },
    /// Invalid velocity range or number of points.
    #[error("{0}")]
    Range(String),
    /// Integration of the plastic zone failed.
    #[error("the plastic zone cannot be integrated to the cavity wall: {0}")]
    Lost(String),
    /// The pressure depends on the step of the integration.
    #[error(
        "the pressure at velocity {velocity} changes by {:.1} % with half the step: the law softens without a length, so that \
         it has no steady expansion",
        100.0 * change
    )]
    Unsteady {
        /// Velocity of the cavity wall.
        velocity: f64,
        /// Relative difference of the pressure with the longer step.
        change: f64,
    },
    /// No fit without negative constants.
    #[error("no fit with constants of at least zero: {0}")]
    Negative(String),
}

impl ResistanceError {
    /// Returns the stable diagnostic code.
    pub fn code(&self) -> &'static str {
        match self {
            ResistanceError::Target(_) => "C001",
            ResistanceError::Fast { .. } => "C002",
            ResistanceError::Range(_) => "C003",
            ResistanceError::Lost(_) => "C004",
            ResistanceError::Negative(_) => "C005",
            ResistanceError::Unsteady { .. } => "C006",
        }
    }
}
