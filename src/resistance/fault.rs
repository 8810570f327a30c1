//! Why there is no resistance.

use thiserror::Error;

/// The reason, in words; velocities and stresses in the target's own units.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ResistanceError {
    /// A target that cannot be.
    #[error("{0}")]
    Target(String),
    /// A cavity that opens faster than there is a solution for.
    #[error(
        "no similar solution at {velocity}: its plastic front would be a shock; the fastest cavity opens at {fastest}"
    )]
    Fast {
        /// What was asked for.
        velocity: f64,
        /// Up to where there is a solution.
        fastest: f64,
    },
    /// A range or a number of points that gives no fit.
    #[error("{0}")]
    Range(String),
    /// An integration that comes to no end.
    #[error("the plastic zone cannot be followed to the cavity: {0}")]
    Lost(String),
    /// Constants below zero.
    #[error("no constants that are not below zero fit: {0}")]
    Negative(String),
}

impl ResistanceError {
    /// Its stable code.
    pub fn code(&self) -> &'static str {
        match self {
            ResistanceError::Target(_) => "C001",
            ResistanceError::Fast { .. } => "C002",
            ResistanceError::Range(_) => "C003",
            ResistanceError::Lost(_) => "C004",
            ResistanceError::Negative(_) => "C005",
        }
    }
}
