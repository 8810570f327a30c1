//! Bulk viscosity: its coefficients, and the high-pass filter of its linear term.
//!
//! With the damping fraction b1 the linear term is a pressure b1 ρ c_d L ε̇_v, ε̇_v the volumetric strain rate. It damps
//! the oscillation of a mesh after a front, but also smears the front over a width that grows with the root of L, so
//! that results converge with order 1/2. The term therefore acts on the part of the rate that changes quickly: on
//! ε̇_v - s, with τ ds/dt = ε̇_v - s and τ = 4/ω, ω the highest frequency of the element. A mode of frequency f keeps
//! the share (f τ)²/(1 + (f τ)²) of its damping: the highest mode 94 %, resolved waves a share of the order L². In
//! mechanics, it is a dashpot in series with an inerter (M. C. Smith 2002, IEEE Trans. Autom. Control 47, 1648): a
//! passive element, whose work over any motion from rest is never negative.

use super::real::Real;

/// Coefficients of bulk viscosity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BulkViscosity {
    /// Linear coefficient, a fraction of the critical damping of the highest mode.
    pub linear: f64,
    /// Quadratic coefficient, which acts in compression only.
    pub quadratic: f64,
    /// Whether the linear term acts on the quickly changing part of the rate only.
    pub filtered: bool,
}

/// Time constant of the filter in units of one over the highest frequency of an element.
const TIME_CONSTANT: f64 = 4.0;

impl Default for BulkViscosity {
    /// The coefficients of ABAQUS (Analysis User's Guide 6.3.3, "Bulk viscosity"), with the filter.
    fn default() -> Self {
        BulkViscosity { linear: 0.06, quadratic: 1.2, filtered: true }
    }
}

impl BulkViscosity {
    /// No bulk viscosity.
    pub const NONE: BulkViscosity = BulkViscosity { linear: 0.0, quadratic: 0.0, filtered: false };

    /// Returns whether both coefficients are zero.
    pub fn is_none(&self) -> bool {
        self.linear == 0.0 && self.quadratic == 0.0
    }

    /// Returns whether elements store the slow part of the rate.
    pub fn filters(&self) -> bool {
        self.filtered && self.linear != 0.0
    }

    /// Returns one over the time constant times the highest frequency; 0 without the filter.
    pub fn filter(&self) -> f64 {
        if self.filters() { 1.0 / TIME_CONSTANT } else { 0.0 }
    }

    /// Returns the same coefficients without the filter. Materials with an equation of state use them: in a strong shock
    /// the whole linear term prevents the overshoot that would unload the deviatoric stress. Area weighting uses them:
    /// some of its modes grow without the whole term.
    pub fn unfiltered(self) -> BulkViscosity {
        BulkViscosity { filtered: false, ..self }
    }

    /// Returns both coefficients and the kind of the linear term for the ledger.
    pub fn detail(&self) -> String {
        let kind = if self.filters() { ", linear term on quick changes of the rate" } else { "" };
        format!("{}, {}{kind}", self.linear, self.quadratic)
    }
}

/// Returns the slow part of a rate after an increment over which the highest frequency turns by the angle `turn`, from
/// the slow part before. `filter` is that of [`BulkViscosity::filter`]. Equation (7.6).
#[inline(always)]
pub fn slow_rate<T: Real>(before: T, rate: T, turn: T, filter: T) -> T {
    let unit = turn.like(1.0);
    let x = (turn * filter).at_most(unit);
    // 1 - exp(-x) to second order.
    before + x * (unit - unit.like(0.5) * x) * (rate - before)
}
