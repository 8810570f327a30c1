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

/// The largest trace of the squares of the patterns' frequencies over the square of that of the strains' bound: a folded
/// element, whose patterns move next to no mass, has no more stiffness than that.
const SLOW: f64 = 0.5;
/// Stress of the full plastic moment of a rectangle over that at which its edge yields.
const PLASTIC_MOMENT: f64 = 1.5;
/// What is left of it at least under full uniform stress, so that no pattern is free.
const LEAST_MOMENT: f64 = 0.05;

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
        // A value of its own: what the loop reads and writes in the scratch memory could be one, and would keep it from
        // becoming one of vectors.
        let mut assumed = scratch.enhanced[scratch.at];
        let factor = constants.hourglass.enhanced;
        for l in 0..LANES {
            let (r, z) = (column(&scratch.r, l), column(&scratch.z, l));
            let (v_r, v_z) = (column(&scratch.v_r, l), column(&scratch.v_z, l));
            let g = operators::<AREA>(r, z);
            let shape = shape(r, z, &g);
            let q = [dot(shape, v_r), dot(shape, v_z)];
            let [first, second] = patterns(r, z, &g);
            let [along, beside] = moduli(middle.bulk[l], middle.shear[l]);
            // Squares of frequencies: of the strains by the bound of all corners, of the patterns by their trace; both times
            // three volumes.
            let inverse = column(&self.inverse_mass, l);
            let strains = dot(squares(g.r, g.z, g.hoop), inverse) * (middle.bulk[l] + 4.0 / 3.0 * middle.shear[l]);
            let light = products(shape, inverse);
            let bends = trace(&first, [along, beside], light, shape, inverse)
                + trace(&second, [along, beside], light, shape, inverse);
            let (bends, most) = (factor * g.volume * g.volume * bends, 3.0 * SLOW * strains);
            let slowed = if bends > most { factor * most / bends } else { factor };
            // A triangle, with two corners in one place, has no pattern.
            let triangle = (r[2] == r[3]) & (z[2] == z[3]);
            let (before, share) = (middle.shares[0][l], middle.shares[1][l]);
            let remains = if before > 0.0 { share / before } else { 0.0 };
            let grows = if triangle { 0.0 } else { dt * slowed * share };
            let moduli = [grows * along, grows * beside];

            let left = kept.returned[l];
            let mises = left * middle.trial[l];
            let known = assumed.limit[l];
            let unflown = if known > 0.0 { known } else { f64::INFINITY };
            let limit = if left < 1.0 { mises } else { unflown };
            // Moment beside force in a rectangle of what is perfectly plastic.
            let used = mises / limit;
            let rest = 1.0 - used * used;
            let rest = if rest > LEAST_MOMENT { rest } else { LEAST_MOMENT };
            let yields = Yields {
                deviator: column(&middle.deviator, l),
                left,
                along,
                beside,
                most: (1.0 - left) / (2.0 * middle.shear[l]),
                bound: PLASTIC_MOMENT * share * limit * rest,
            };
            let (rates_1, rates_2) =
                ([first.strain(q), dot(first.hoop, v_r)], [second.strain(q), dot(second.hoop, v_r)]);
            let old_1 = [remains * assumed.stress[0][0][l], remains * assumed.stress[0][1][l]];
            let old_2 = [remains * assumed.stress[1][0][l], remains * assumed.stress[1][1][l]];
            let (mut new_1, mut new_2) = (elastic(old_1, rates_1, moduli), elastic(old_2, rates_2, moduli));
            if FLOWS {
                new_1 = yields.flow(&first, new_1);
                new_2 = yields.flow(&second, new_2);
                // What melts flows at no stress, which is not the same as a stress that is not known.
                let flown = if mises > 0.0 { mises } else { f64::MIN_POSITIVE };
                assumed.limit[l] = if left < 1.0 { flown } else { known };
            }
            let power = (assumed.stress[0][0][l] + new_1[0]) * rates_1[0]
                + (assumed.stress[0][1][l] + new_1[1]) * rates_1[1]
                + (assumed.stress[1][0][l] + new_2[0]) * rates_2[0]
                + (assumed.stress[1][1][l] + new_2[1]) * rates_2[1];
            assumed.stress[0][0][l] = new_1[0];
            assumed.stress[0][1][l] = new_1[1];
            assumed.stress[1][0][l] = new_2[0];
            assumed.stress[1][1][l] = new_2[1];
            let third = UNIT * g.volume * (1.0 / 3.0);
            scratch.sums.artificial[l] += 0.5 * dt * scratch.weight[l] * third * power;
            let flat = if AREA { 1.0 / (1.5 * UNIT * ((r[0] + r[1]) + (r[2] + r[3]))) } else { 1.0 };
            let acts = flat * third;
            let (bent_1, bent_2) = (0.25 * acts * first.per * new_1[0], 0.25 * acts * second.per * new_2[0]);
            let bent_r = bent_1 * first.side[0] + bent_2 * second.side[0];
            let bent_z = bent_1 * first.side[1] + bent_2 * second.side[1];
            let (turned_1, turned_2) = (acts * new_1[1], acts * new_2[1]);
            for i in 0..4 {
                corners.0[2 * i][l] -= bent_r * shape[i] + (turned_1 * first.hoop[i] + turned_2 * second.hoop[i]);
                corners.0[2 * i + 1][l] -= bent_z * shape[i];
            }
        }
        scratch.enhanced[scratch.at] = assumed;
    }
}

/// How the edges of an element flow.
struct Yields {
    deviator: [f64; 4],
    /// Part of the trial stress that is left in the middle.
    left: f64,
    along: f64,
    beside: f64,
    /// Plastic strain of the middle over its trial stress.
    most: f64,
    /// Largest von Mises stress of a pattern.
    bound: f64,
}

impl Yields {
    /// What flow leaves of the stresses of a pattern: the edge flows along the stress of the middle and no further than that
    /// does.
    #[inline(always)]
    fn flow(&self, p: &Pattern, [t, h]: [f64; 2]) -> [f64; 2] {
        let [a_r, a_z] = p.side;
        let [rr, zz, hoop, rz] = self.deviator;
        let (s_t, s_h) = (p.per * (a_r * (a_r * rr + 2.0 * a_z * rz) + a_z * a_z * zz), hoop);
        let (w_t, w_h) = (self.along * s_t + self.beside * s_h, self.along * s_h + self.beside * s_t);
        let norm = s_t * w_t + s_h * w_h;
        let wanted = (s_t * t + s_h * h) / if norm > 0.0 { norm } else { 1.0 };
        let flowed = if wanted > self.most { self.most } else { wanted };
        let flowed = if flowed < -self.most { -self.most } else { flowed };
        let (t, h) = (self.left * (t - flowed * w_t), self.left * (h - flowed * w_h));
        let size = (t * t + h * h - t * h).sqrt();
        let scale = if size > self.bound { self.bound / size } else { 1.0 };
        [scale * t, scale * h]
    }
}

/// Stresses after an elastic increment.
#[inline(always)]
fn elastic([t, h]: [f64; 2], [rate_t, rate_h]: [f64; 2], [along, beside]: [f64; 2]) -> [f64; 2] {
    [t + (along * rate_t + beside * rate_h), h + (along * rate_h + beside * rate_t)]
}

#[inline(always)]
fn products(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]]
}

#[inline(always)]
fn squares(a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
    [
        a[0] * a[0] + b[0] * b[0] + c[0] * c[0],
        a[1] * a[1] + b[1] * b[1] + c[1] * c[1],
        a[2] * a[2] + b[2] * b[2] + c[2] * c[2],
        a[3] * a[3] + b[3] * b[3] + c[3] * c[3],
    ]
}

/// Trace of a pattern's stiffness over the masses, by three over the volume; `light` is the shape over the masses.
#[inline(always)]
fn trace(p: &Pattern, [along, beside]: [f64; 2], light: [f64; 4], shape: [f64; 4], inverse: [f64; 4]) -> f64 {
    let turned = dot(products(p.hoop, p.hoop), inverse);
    let (bent, both) = (0.0625 * p.per * dot(light, shape), 0.5 * p.per * p.side[0] * dot(light, p.hoop));
    along * (bent + turned) + beside * both
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
