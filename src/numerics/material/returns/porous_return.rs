//! Return of a trial stress to the yield surface of a porous metal (Aravas 1987, Int. J. Numer. Meth. Eng. 24, 1395:
//! two unknowns, the deviatoric and the volumetric flow).

use super::porous_metal::VoidNucleation;
use super::root::bracketed_root;
use crate::kernel::hardening::TableLine;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::transcendental::{exp_of, expm1_of};

/// Most Newton steps; more are needed for increments many times the yield strain only, which are bracketed.
pub(super) const NEWTON_STEPS: usize = 12;
/// Values of the yield function, and relative errors of the flow, that are zero.
pub(super) const TOLERANCE: f64 = 1e-8;

/// Largest 1.5 q2 p/y in the yield function. Voids of a fraction below 1e-9 are closed: they do not depend on the
/// pressure, for no number could represent them at a higher one.
const LARGEST_RATIO: f64 = 20.0;

/// Plastic strain, hardening of the matrix and void volume fraction before an increment; invariants of the trial.
#[derive(Clone, Copy)]
pub(super) struct PorousIncrement<'a> {
    pub strain: f64,
    pub hardening: TableLine<'a>,
    pub voids: f64,
    pub mises: f64,
    pub mean: f64,
}

/// State after an increment with a given flow.
#[derive(Clone, Copy)]
pub(super) struct Flowed {
    pub mises: f64,
    pub mean: f64,
    pub strain: f64,
    pub voids: f64,
    /// Nucleating void volume fraction per plastic strain.
    pub nucleation: f64,
    pub yield_stress: f64,
    /// Effective void volume fraction f*, and its derivative by the void volume fraction.
    pub effective: [f64; 2],
    /// Hyperbolic cosine and sine of 1.5 q2 mean/yield.
    pub cosh: f64,
    pub sinh: f64,
    /// Yield function.
    pub excess: f64,
    /// Plastic dilation less that of the flow rule.
    pub mismatch: f64,
}

/// Constants of the returns of a law.
#[derive(Clone, Copy)]
pub(super) struct PorousConstants {
    /// q1, q2, q3.
    pub constants: [f64; 3],
    pub moduli: ElasticModuli,
    /// 1 over the bulk modulus, and over three times the shear modulus.
    pub per_bulk: f64,
    pub per_shear3: f64,
    /// The compiler knows whether there is one in loops over lanes.
    pub nucleation: Option<VoidNucleation>,
    /// Void volume fraction at which voids begin to coalesce (infinite if they do not), slope of the effective fraction above
    /// it, and the largest effective fraction.
    pub critical: f64,
    pub coalescence: f64,
    pub most: f64,
}

/// Methods with `LINE` use the line of the table alone, also beyond its end, as loops over lanes need.
impl PorousConstants {
    /// Returns the effective void volume fraction f*, and its derivative. It stays so far below the fraction without
    /// strength that a small yield surface remains. Equation (20.32).
    #[inline(always)] // Into the return of each point.
    fn effective(&self, voids: f64) -> [f64; 2] {
        let (value, slope) = if voids > self.critical {
            (self.critical + self.coalescence * (voids - self.critical), self.coalescence)
        } else {
            (voids, 1.0)
        };
        if value > self.most { [self.most, 0.0] } else { [value, slope] }
    }

    /// Returns the state after an increment. `flow` is the trial over the final von Mises stress, less 1: 6 G/y² times
    /// the plastic multiplier. Equation (20.30).
    #[inline(always)] // Into the return of each point.
    pub(super) fn flowed<const LINE: bool>(&self, before: &PorousIncrement<'_>, flow: f64, dilation: f64) -> Flowed {
        let mises = before.mises / (1.0 + flow);
        let mean = before.mean - self.moduli.bulk * dilation;
        let work = mises * (before.mises - mises) * self.per_shear3 + mean * dilation;
        let work = if work > 0.0 { work } else { 0.0 };
        // Growth of voids in an incompressible matrix, whose work is done at the yield stress in the middle.
        let grown = before.voids - (1.0 - before.voids) * expm1_of(-dilation);
        let scaled_work = work / (1.0 - 0.5 * (before.voids + grown));
        let middle = before.strain + 0.5 * scaled_work / before.hardening.value;
        let gained = scaled_work / before.hardening.value_at::<LINE>(middle);
        let strain = before.strain + gained;
        let nucleation = match self.nucleation {
            Some(voids) if mean > 0.0 => voids.density(before.strain + 0.5 * gained),
            _ => 0.0,
        };
        let voids = grown + nucleation * gained;
        let voids = if voids > 0.0 { voids } else { 0.0 };
        let yield_stress = before.hardening.value_at::<LINE>(strain);
        let effective = self.effective(voids);
        let per_yield = 1.0 / yield_stress;
        let [cosh, sinh] = self.hyperbolic(mean * per_yield);
        let excess = self.excess(mises * per_yield, effective[0], cosh);
        let mismatch = dilation - flow * self.dilatancy(yield_stress) * effective[0] * sinh;
        Flowed { mises, mean, strain, voids, nucleation, yield_stress, effective, cosh, sinh, excess, mismatch }
    }

    /// Returns the hyperbolic cosine and sine of 1.5 q2 mean/yield.
    #[inline(always)] // Into the return of each point.
    fn hyperbolic(&self, mean_over_yield: f64) -> [f64; 2] {
        let ratio = 1.5 * self.constants[1] * mean_over_yield;
        let exponential = exp_of(ratio.clamp(-LARGEST_RATIO, LARGEST_RATIO));
        let inverse = 1.0 / exponential;
        [0.5 * (exponential + inverse), 0.5 * (exponential - inverse)]
    }

    /// Returns the yield function for the von Mises stress over the yield stress, f*, and the hyperbolic cosine.
    /// Equation (20.29).
    #[inline(always)] // Into the return of each point.
    fn excess(&self, ratio: f64, effective: f64, cosh: f64) -> f64 {
        let [q1, _, q3] = self.constants;
        ratio * ratio + 2.0 * q1 * effective * cosh - 1.0 - q3 * effective * effective
    }

    /// Returns the state of the trial, without nucleation: [`Self::flowed`] without flow, but faster.
    #[inline(always)] // Into the return of each point.
    pub(super) fn trial(&self, before: &PorousIncrement<'_>) -> Flowed {
        let &PorousIncrement { strain, hardening, voids, mises, mean } = before;
        let yield_stress = hardening.value;
        let per_yield = 1.0 / yield_stress;
        let [cosh, sinh] = self.hyperbolic(mean * per_yield);
        let effective = self.effective(voids);
        let excess = self.excess(mises * per_yield, effective[0], cosh);
        Flowed {
            mises,
            mean,
            strain,
            voids,
            nucleation: 0.0,
            yield_stress,
            effective,
            cosh,
            sinh,
            excess,
            mismatch: 0.0,
        }
    }

    /// Returns the plastic dilation over flow, f* and the hyperbolic sine.
    #[inline(always)] // Into the return of each point.
    fn dilatancy(&self, yield_stress: f64) -> f64 {
        1.5 * self.constants[0] * self.constants[1] * yield_stress * self.per_shear3
    }

    /// Returns flow and dilation of the next step of Newton's method.
    #[inline(always)] // Into the return of each point.
    pub(super) fn newton_step<const LINE: bool>(
        &self,
        before: &PorousIncrement<'_>,
        now: &Flowed,
        [flow, dilation]: [f64; 2],
    ) -> [f64; 2] {
        let [q1, q2, q3] = self.constants;
        let ElasticModuli { bulk, .. } = self.moduli;
        let largest = before.mean * self.per_bulk;
        let gained = now.strain - before.strain;
        let Flowed { mises, mean, yield_stress, effective: [effective, growth], cosh, sinh, .. } = *now;
        // Partial derivatives: of the yield stress and f* by the work on the matrix, ...
        let solid = 1.0 - now.voids;
        let slope = if !LINE && gained > 0.0 {
            (yield_stress - before.hardening.value) / gained
        } else {
            before.hardening.slope
        };
        let per_work = 1.0 / (solid * yield_stress);
        let (per_yield, per_flow) = (solid * per_work, 1.0 / (1.0 + flow));
        let (yield_by_work, voids_by_work) = (slope * per_work, growth * now.nucleation * per_work);
        // of the yield function and the flow rule by these two, ...
        let (square, angle) = ((mises * per_yield) * (mises * per_yield), 1.5 * q2 * per_yield);
        let spread = self.dilatancy(yield_stress);
        let by_yield = -2.0 * (square + q1 * effective * sinh * angle * mean) * per_yield;
        let by_voids = 2.0 * (q1 * cosh - q3 * effective);
        let flow_by_yield = -flow * spread * effective * (sinh - cosh * angle * mean) * per_yield;
        let flow_by_voids = -flow * spread * sinh;
        let by_work = by_yield * yield_by_work + by_voids * voids_by_work;
        let flow_by_work = flow_by_yield * yield_by_work + flow_by_voids * voids_by_work;
        // and of the work. Then those of the yield function (a, b) and the flow rule (c, d) by flow and dilation.
        let work_by_flow = mises * per_flow * (2.0 * mises - before.mises) * self.per_shear3;
        let work_by_dilation = mean - bulk * dilation;
        let a = by_work * work_by_flow - 2.0 * square * per_flow;
        let b = by_work * work_by_dilation + by_voids * growth * solid - 2.0 * q1 * effective * sinh * angle * bulk;
        let c = flow_by_work * work_by_flow - spread * effective * sinh;
        let d = flow_by_work * work_by_dilation
            + flow_by_voids * growth * solid
            + (1.0 + flow * spread * effective * cosh * angle * bulk);
        let per_determinant = 1.0 / (a * d - b * c);
        // The yield function without voids is linear in (1 + flow)^-2; so a step is straight in this variable.
        let step = (now.mismatch * b - now.excess * d) * per_determinant;
        let straight = 1.0 - 2.0 * step * per_flow;
        let next_flow = if straight > 0.1 { (1.0 + flow) / straight.sqrt() - 1.0 } else { flow + step };
        let next_dilation = dilation - (now.mismatch * a - now.excess * c) * per_determinant;
        // The mean stress does not change its sign.
        let [least, most] = if largest < 0.0 { [largest, 0.0] } else { [0.0, largest] };
        let next_dilation = if next_dilation > least { next_dilation } else { least };
        let next_dilation = if next_dilation < most { next_dilation } else { most };
        [if next_flow > 0.0 { next_flow } else { 0.0 }, next_dilation]
    }

    /// Returns whether a state is on the yield surface.
    #[inline(always)] // Into the return of each point.
    pub(super) fn is_end(&self, now: &Flowed) -> bool {
        now.excess.abs() <= TOLERANCE && now.mismatch.abs() * self.moduli.bulk <= TOLERANCE * now.yield_stress
    }

    /// Returns the state on the yield surface by Newton's method from the trial; `None` if it does not converge.
    pub(super) fn newton(&self, before: &PorousIncrement<'_>, trial: Flowed) -> Option<Flowed> {
        let (mut now, mut path) = (trial, [0.0; 2]);
        for _ in 0..NEWTON_STEPS {
            path = self.newton_step::<false>(before, &now, path);
            now = self.flowed::<false>(before, path[0], path[1]);
            if self.is_end(&now) {
                return Some(now);
            }
        }
        None
    }

    /// Returns the state on the yield surface for any increment.
    pub(super) fn bracketed(&self, before: &PorousIncrement<'_>) -> Flowed {
        let largest = before.mean / self.moduli.bulk;
        let sign = if largest < 0.0 { -1.0 } else { 1.0 };
        let along = |flow: f64| {
            let mismatch = |dilation: f64| sign * self.flowed::<false>(before, flow, dilation).mismatch;
            let dilation = bracketed_root(largest, 0.0, 1e-15 * largest.abs(), mismatch);
            self.flowed::<false>(before, flow, dilation)
        };
        // Nearly linear also far outside.
        let outside = |flow: f64| {
            let Flowed { excess, effective, .. } = along(flow);
            libm::log1p(excess / (1.0 + self.constants[2] * effective[0] * effective[0]))
        };
        let mut most = 1.0;
        while outside(most) > 0.0 && most < 1e12 {
            most *= 8.0;
        }
        along(bracketed_root(0.0, most, TOLERANCE, outside))
    }
}
