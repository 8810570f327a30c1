//! The normal distribution and Student's t distribution.

pub mod normal;
pub mod students_t;
