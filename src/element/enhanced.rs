//! Hourglass control by the stresses of assumed strains that vary across an element (HOURGLASS=ENHANCED): they bend as the
//! material does and flow with it.
//! Never here: the geometry of the strains, uniform stress.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::{Block, Kept, Workspace, column, dot};
use super::constants::Constants;
use crate::kernel::assumed::{Pattern, moduli, patterns, shape};
use crate::kernel::lanes::{Corners, LANES, Lanes};
use crate::kernel::quad::{UNIT, operators};
use crate::kernel::stress::mises;
use crate::material::failure::Failure;
use crate::material::plasticity::{Flow, Hardening};
use crate::material::volumetric::Volumetric;
use crate::state::archive::{Archive, Persist, persist_fields};

/// The largest trace of the squares of the patterns' frequencies over the square of that of the strains' bound: a folded
/// element, whose patterns move next to no mass, has no more stiffness than that.
const SLOW: f64 = 0.5;
/// Stress of the full plastic moment of a rectangle over that at which its edge yields.
const PLASTIC_MOMENT: f64 = 1.5;
/// What is left of it at least under full uniform stress, so that no pattern is free.
const LEAST_MOMENT: f64 = 0.05;

/// What a block keeps of its patterns.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Assumed {
    /// Stress of each pattern at the edge of the element: along its direction, and hoop.
    stress: [[Lanes; 2]; 2],
    /// Von Mises stress at which the element flows as far as it is known; 0 if not.
    limit: Lanes,
}

impl Assumed {
    /// Takes the stresses of a lane away.
    pub(super) fn clear(&mut self, lane: usize) {
        self.stress.as_flattened_mut().iter_mut().for_each(|s| s[lane] = 0.0);
    }
}

/// What the middle of each element says of what flows at its edges.
pub(super) struct Middle {
    /// Deviator of the elastic trial, reckoned from the middle of the yield surface, and its von Mises stress.
    pub deviator: [Lanes; 4],
    pub trial: Lanes,
    /// Moduli.
    pub bulk: Lanes,
    pub shear: Lanes,
    /// Part of the stress that damage leaves, before and after.
    pub shares: [Lanes; 2],
}

impl Middle {
    /// Of a material without damage that has these moduli everywhere.
    #[inline(always)]
    pub fn of(constants: &Constants, scratch: &Workspace) -> Middle {
        Middle {
            deviator: scratch.deviator,
            trial: scratch.trial,
            bulk: [constants.bulk; LANES],
            shear: [constants.shear; LANES],
            shares: [[1.0; LANES]; 2],
        }
    }
}

/// What damage leaves of the stress of each lane.
#[inline(always)]
fn shares<F: Failure>(failure: &F, state: &F::State) -> Lanes {
    if F::FAILS { std::array::from_fn(|l| failure.share(state, l)) } else { [1.0; LANES] }
}

impl<S: Clone, Q: Clone, X: Clone> Block<S, Q, X> {
    /// What damage leaves, before it goes on.
    #[inline(always)]
    pub(super) fn shares<F: Failure<State = X>>(&self, failure: &F) -> Lanes {
        shares(failure, &self.failure)
    }

    /// The patterns' share of an increment of laws that are built in.
    #[inline(always)]
    pub(super) fn enhance<H: Hardening<State = S>, V: Volumetric, F: Failure<State = X>, const AREA: bool>(
        &self,
        (hardening, failure, before): (&H, &F, Lanes),
        constants: &Constants,
        dt: f64,
        kept: &mut Kept,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        let mut middle = Middle::of(constants, scratch);
        middle.shares = [before, shares(failure, &self.failure)];
        if V::EOS {
            self.moduli::<V>(constants, &mut middle, scratch);
        }
        if V::FLOWS {
            middle.unflow(kept, scratch);
        }
        if H::PLASTIC && scratch.enhanced[scratch.at].limit[0] == 0.0 {
            scratch.enhanced[scratch.at].limit = first_yield(hardening, &self.state, constants.shear, scratch.count);
        }
        if H::PLASTIC || V::FLOWS {
            self.resist::<true, AREA>(constants, dt, &middle, kept, scratch, corners);
        } else {
            self.resist::<false, AREA>(constants, dt, &middle, kept, scratch, corners);
        }
    }

    /// Moduli of now where they vary.
    #[inline(always)]
    fn moduli<V: Volumetric>(&self, constants: &Constants, middle: &mut Middle, scratch: &Workspace) {
        for l in 0..LANES {
            let mut bulk = scratch.bulk[l];
            if V::TOTAL {
                let shear = scratch.shear[l];
                bulk += 4.0 / 3.0 * (constants.shear - shear);
                bulk = if bulk > shear { bulk } else { shear };
                middle.shear[l] = shear;
            }
            middle.bulk[l] = bulk;
        }
    }

    /// Stresses of the patterns at the end of the increment, and their corner forces.
    #[inline(always)]
    pub(super) fn resist<const FLOWS: bool, const AREA: bool>(
        &self,
        constants: &Constants,
        dt: f64,
        middle: &Middle,
        kept: &Kept,
        scratch: &mut Workspace,
        corners: &mut Corners,
    ) {
        let mut assumed = scratch.enhanced[scratch.at];
        let factor = constants.hourglass.enhanced;
        for l in 0..LANES {
            let (r, z) = (column(&scratch.r, l), column(&scratch.z, l));
            let (v_r, v_z) = (column(&scratch.v_r, l), column(&scratch.v_z, l));
            let g = operators::<AREA>(r, z);
            let shape = shape(r, z, &g);
            let q = [dot(shape, v_r), dot(shape, v_z)];
            let patterns = patterns(r, z, &g);
            let (bulk, shear) = (middle.bulk[l], middle.shear[l]);
            let [along, beside] = moduli(bulk, shear);
            // A triangle, with two corners in one place, has no pattern.
            let triangle = (r[2] == r[3]) & (z[2] == z[3]);
            let [before, share] = [middle.shares[0][l], middle.shares[1][l]];
            let kept_share = if before > 0.0 { share / before } else { 0.0 };

            // Squares of frequencies: of the strains by the bound of all corners, of the patterns by their trace; both times
            // three volumes.
            let over = |i: usize, x: f64| x * self.inverse_mass[i][l];
            let sum = |x: [f64; 4]| (over(0, x[0]) + over(1, x[1])) + (over(2, x[2]) + over(3, x[3]));
            let squares = [0, 1, 2, 3].map(|i| g.r[i] * g.r[i] + g.z[i] * g.z[i] + g.hoop[i] * g.hoop[i]);
            let strains = 3.0 * SLOW * (bulk + 4.0 / 3.0 * shear) * sum(squares);
            let pattern_squares = sum([0, 1, 2, 3].map(|i| shape[i] * shape[i]));
            let trace = |p: &Pattern| {
                let hoop = sum(p.hoop.map(|h| h * h));
                let both = sum([0, 1, 2, 3].map(|i| p.hoop[i] * shape[i]));
                along * (0.0625 * p.per * pattern_squares + hoop) + 0.5 * beside * p.per * p.side[0] * both
            };
            let bends = factor * g.volume * g.volume * (trace(&patterns[0]) + trace(&patterns[1]));
            let slowed = if bends > strains { factor * strains / bends } else { factor };
            let grows = if triangle { 0.0 } else { dt * slowed * share };

            let left = kept.returned[l];
            let mises = left * middle.trial[l];
            let deviator = column(&middle.deviator, l);
            let limit = assumed.limit[l];
            let limit = if left < 1.0 {
                mises
            } else if limit > 0.0 {
                limit
            } else {
                f64::INFINITY
            };
            let third = UNIT * g.volume * (1.0 / 3.0);
            let (mut power, mut f_r, mut f_z) = (0.0, [0.0; 4], [0.0; 4]);
            for (k, p) in patterns.iter().enumerate() {
                let (e_t, e_h) = (p.strain(q), dot(p.hoop, v_r));
                let (old_t, old_h) = (assumed.stress[k][0][l], assumed.stress[k][1][l]);
                let mut t = kept_share * old_t + grows * (along * e_t + beside * e_h);
                let mut h = kept_share * old_h + grows * (along * e_h + beside * e_t);
                if FLOWS {
                    // The edge flows along the stress of the middle, no further than the middle does.
                    let [a_r, a_z] = p.side;
                    let plane = a_r * (a_r * deviator[0] + 2.0 * a_z * deviator[3]) + a_z * a_z * deviator[1];
                    let (s_t, s_h) = (p.per * plane, deviator[2]);
                    let (w_t, w_h) = (along * s_t + beside * s_h, along * s_h + beside * s_t);
                    let norm = s_t * w_t + s_h * w_h;
                    let wanted = (s_t * t + s_h * h) / if norm > 0.0 { norm } else { 1.0 };
                    let most = (1.0 - left) / (2.0 * shear);
                    let flowed = if wanted > most { most } else { wanted };
                    let flowed = if flowed < -most { -most } else { flowed };
                    t = left * (t - flowed * w_t);
                    h = left * (h - flowed * w_h);
                    // Moment beside force in a rectangle of what is perfectly plastic.
                    let used = mises / limit;
                    let rest = 1.0 - used * used;
                    let rest = if rest > LEAST_MOMENT { rest } else { LEAST_MOMENT };
                    let bound = PLASTIC_MOMENT * share * limit * rest;
                    let size = (t * t + h * h - t * h).sqrt();
                    let scale = if size > bound { bound / size } else { 1.0 };
                    (t, h) = (scale * t, scale * h);
                }
                assumed.stress[k][0][l] = t;
                assumed.stress[k][1][l] = h;
                power += (old_t + t) * e_t + (old_h + h) * e_h;
                let bent = 0.25 * third * p.per * t;
                let (bent_r, bent_z, turned) = (bent * p.side[0], bent * p.side[1], third * h);
                for i in 0..4 {
                    f_r[i] += bent_r * shape[i] + turned * p.hoop[i];
                    f_z[i] += bent_z * shape[i];
                }
            }
            if FLOWS {
                // What melts flows at no stress, which is not the same as a stress that is not known.
                let flown = if mises > 0.0 { mises } else { f64::MIN_POSITIVE };
                assumed.limit[l] = if left < 1.0 { flown } else { assumed.limit[l] };
            }
            scratch.sums.artificial[l] += 0.5 * dt * scratch.weight[l] * third * power;
            let flat = if AREA { 1.0 / (1.5 * UNIT * ((r[0] + r[1]) + (r[2] + r[3]))) } else { 1.0 };
            for i in 0..4 {
                corners.0[2 * i][l] -= flat * f_r[i];
                corners.0[2 * i + 1][l] -= flat * f_z[i];
            }
        }
        scratch.enhanced[scratch.at] = assumed;
    }
}

impl Middle {
    /// Of what flows without a hardening law: the trial from the plastic strain, and the part of it that is left.
    #[inline(always)]
    fn unflow(&mut self, kept: &mut Kept, scratch: &Workspace) {
        for l in 0..LANES {
            let plastic = column(&scratch.back, l);
            let mean = (plastic[0] + plastic[1] + plastic[2]) * (1.0 / 3.0);
            let end = column(&self.deviator, l);
            let twice = 2.0 * self.shear[l];
            let normal = |i: usize| end[i] + twice * (plastic[i] - mean);
            let trial = [normal(0), normal(1), normal(2), end[3] + twice * plastic[3]];
            for i in 0..4 {
                self.deviator[i][l] = trial[i];
            }
            self.trial[l] = mises(trial);
            let flows = scratch.flow[l] > 0.0;
            kept.returned[l] = if flows { mises(end) / self.trial[l] } else { 1.0 };
        }
    }
}

/// Von Mises stress at which each lane begins to flow at rest, as its law is now: found by asking it.
#[cold]
#[inline(never)]
fn first_yield<H: Hardening>(hardening: &H, state: &H::State, shear: f64, count: usize) -> Lanes {
    let shear3 = 3.0 * shear;
    let flows = |trial: &Lanes| {
        let (mut state, mut increment) = (state.clone(), [0.0; LANES]);
        let flow = &mut Flow { trial, shear3, dt: f64::MAX, count, increment: &mut increment };
        hardening.flow(&mut state, flow);
        increment.map(|dp| dp > 0.0)
    };
    let (mut low, mut high) = ([0.0; LANES], [1e-12 * shear; LANES]);
    // Up to what no material bears.
    for _ in 0..60 {
        for (l, flown) in flows(&high).into_iter().enumerate() {
            if !flown {
                (low[l], high[l]) = (high[l], 2.0 * high[l]);
            }
        }
    }
    for _ in 0..30 {
        let between: Lanes = std::array::from_fn(|l| 0.5 * (low[l] + high[l]));
        for (l, flown) in flows(&between).into_iter().enumerate() {
            *(if flown { &mut high[l] } else { &mut low[l] }) = between[l];
        }
    }
    high
}

impl Persist for Assumed {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Assumed { stress, limit } = self;
        persist_fields!(archive; stress, limit);
    }
}
