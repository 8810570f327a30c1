//! Hourglass control by stresses of assumed strains that vary across an element (HOURGLASS=ENHANCED). They have the
//! bending stiffness of the material and follow its plastic flow.

use pulp::Simd;

use super::assumed::AssumedStresses;
use super::constants::ElementConstants;
use super::edges::{EdgeFlow, EdgeLimit};
use super::forces::{HourglassScheme, PatternForces, PatternMotion};
use super::workspace::{ControlStresses, TaskWorkspace};
use crate::kernel::assumed::{AssumedDirections, hoop, moduli, ring};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::pack::{Pack, PackPosition};
use crate::kernel::quad::{SquareSums, UNIT, dot3};
use crate::kernel::real::Real;
use crate::kernel::stress::mises;
use crate::material::increment::StressUpdate;
use crate::material::{Material, PlasticFlow};

/// Largest ratio of the trace of the patterns' squared frequencies to the squared frequency bound of the strains. It
/// limits the stiffness of folded elements, whose patterns move almost no mass.
const SLOW: f64 = 0.5;
/// Factor on the estimate of the trace, so that rounding does not matter.
const MARGIN: f64 = 1.0 + 1e-6;

/// Assumed strains of a block in an increment.
pub(super) struct AssumedStrains<'a> {
    constants: &'a ElementConstants,
    stresses: &'a mut AssumedStresses,
    /// Moduli of a strain for the stress in its direction and for the transverse stress, where moduli are constant.
    moduli: [f64; 2],
    /// Stress fraction that damage leaves, and its ratio to the previous one.
    share: Lanes,
    remains: Lanes,
}

/// Returns the stress fraction that damage leaves.
#[inline(always)]
pub(super) fn shares<M: Material>(material: &M, state: &M::State) -> Lanes {
    if M::FAILS { inline_from_fn(|l| material.share(state, l)) } else { [1.0; LANES] }
}

impl<'a> AssumedStrains<'a> {
    /// Creates the assumed strains after the stress update; `before` is the stress fraction that damage left at the
    /// start of the increment.
    #[inline(always)]
    pub(super) fn new<M: Material>(
        (material, state): (&M, &M::State),
        before: Lanes,
        constants: &'a ElementConstants,
        stresses: &'a mut AssumedStresses,
        scratch: &mut TaskWorkspace,
    ) -> AssumedStrains<'a> {
        let share = shares(material, state);
        let remains = |l: usize| if before[l] > 0.0 { share[l] / before[l] } else { 0.0 };
        let remains = if M::FAILS { inline_from_fn(remains) } else { share };
        if matches!(M::FLOW, PlasticFlow::Coupled) {
            scratch.stress.undo_flow();
        }
        if stresses.limit[0] == 0.0
            && let Some(limit) = material.yield_stress(state, constants.shear, scratch.strain.count)
        {
            stresses.limit = limit;
        }
        let moduli = moduli(constants.bulk, constants.shear);
        AssumedStrains { constants, stresses, moduli, share, remains }
    }
}

impl StressUpdate {
    /// Restores the trial stress from the plastic strain of coupled flow, and the ratio of returned to trial stress.
    #[inline(always)]
    fn undo_flow(&mut self) {
        for l in 0..LANES {
            let plastic = column(&self.plastic, l);
            let pressed = (plastic[0] + plastic[1] + plastic[2]) * (1.0 / 3.0);
            let (end, twice) = (column(&self.deviator, l), 2.0 * self.shear[l]);
            let normal = |i: usize| end[i] + twice * (plastic[i] - pressed);
            let trial = [normal(0), normal(1), normal(2), end[3] + twice * plastic[3]];
            for (list, value) in self.deviator.iter_mut().zip(trial) {
                list[l] = value;
            }
            self.trial[l] = mises(trial);
            self.returned[l] = if self.flow[l] > 0.0 { mises(end) / self.trial[l] } else { 1.0 };
        }
    }
}

/// Moduli of a pack.
struct PackModuli<T> {
    shear: T,
    /// Modulus of longitudinal waves.
    wave: T,
    /// Moduli of a strain for the stress in its direction and for the transverse stress.
    along: T,
    transverse: T,
}

impl HourglassScheme for AssumedStrains<'_> {
    /// Equation (5.10).
    #[inline(always)]
    fn resist<S: Simd, const VARY: bool, const EOS: bool>(
        &mut self,
        pattern: PatternMotion<'_, S>,
        _kept: &mut ControlStresses,
        scratch: &mut TaskWorkspace,
    ) -> PatternForces<Pack<S>> {
        let PatternMotion { at, factors, lane, rate, .. } = pattern;
        let (r, z, zero) = (at.load_all(&scratch.r), at.load_all(&scratch.z), at.splat(0.0));
        let directions = AssumedDirections::of(r, z, ring(&lane.g, lane.per * lane.per));
        let moduli = self.moduli::<S, VARY, EOS>(scratch, at);
        let slowed = self.slowed(&pattern, &directions, &moduli);
        // A triangle, with two coincident corners, has no pattern.
        let apart = (r[1] + r[3]).size() + (z[1] + z[3]).size();
        let grows = at.load(&self.share) * zero.if_less(apart, factors.dt * slowed, zero);
        let [along, transverse] = [grows * moduli.along, grows * moduli.transverse];

        let g = &lane.g;
        let (by_r, by_z) = (dot3(g.r, lane.along[0]), dot3(g.z, lane.along[0]));
        let by_r = by_r - dot3(g.hoop, [lane.v_r[0], lane.v_r[1], lane.v_r[2]]);
        let (strained, turned) = (directions.along(rate), directions.around([by_r, by_z]));
        let [first, second] = &self.stresses.stress;
        let previous = [at.load_all(first), at.load_all(second)];
        let remains = at.load(&self.remains);
        let grown = [0, 1].inline_map(
            #[inline(always)]
            |p: usize| {
                let ([direct, hoop], [e, h]) = (previous[p], [strained[p], turned[p]]);
                [remains * direct + (along * e + transverse * h), remains * hoop + (along * h + transverse * e)]
            },
        );
        let stress = self.flow(grown, &directions, &moduli, scratch, at);
        at.store_all(stress[0], &mut self.stresses.stress[0]);
        at.store_all(stress[1], &mut self.stresses.stress[1]);

        let power = [0, 1].inline_map(
            #[inline(always)]
            |p: usize| (previous[p][0] + stress[p][0]) * strained[p] + (previous[p][1] + stress[p][1]) * turned[p],
        );
        let third = UNIT / 3.0 * g.volume;
        let work = 0.5 * factors.dt * at.load(&scratch.weight) * (third * (power[0] + power[1]));
        at.add(work, &mut scratch.sums.artificial);
        let [[direct_a, hoop_a], [direct_c, hoop_c]] = stress;
        let [pattern, hoop] = directions.forces([third * direct_a, third * direct_c], [third * hoop_a, third * hoop_c]);
        PatternForces { pattern, hoop: Some(hoop) }
    }
}

impl AssumedStrains<'_> {
    /// Returns the moduli of a pack.
    #[inline(always)]
    fn moduli<S: Simd, const VARY: bool, const EOS: bool>(
        &self,
        scratch: &TaskWorkspace,
        at: PackPosition<S>,
    ) -> PackModuli<Pack<S>> {
        let ElementConstants { bulk, shear, .. } = *self.constants;
        if !VARY {
            let [along, transverse] = self.moduli;
            let moduli = [shear, bulk + 4.0 / 3.0 * shear, along, transverse];
            let [shear, wave, along, transverse] =
                [at.splat(moduli[0]), at.splat(moduli[1]), at.splat(moduli[2]), at.splat(moduli[3])];
            return PackModuli { shear, wave, along, transverse };
        }
        let (mut bulk, mut now) = (at.load(&scratch.stress.bulk), at.splat(shear));
        if !EOS {
            now = at.load(&scratch.stress.shear);
            bulk = bulk + 4.0 / 3.0 * (at.splat(shear) - now);
            bulk = now.if_less(bulk, bulk, now);
        }
        let [along, transverse] = moduli(bulk, now);
        PackModuli { shear: now, wave: bulk + 4.0 / 3.0 * now, along, transverse }
    }

    /// Returns the factor on the stiffness of the assumed strains. It is lower in folded elements: squared frequencies,
    /// of the strains by the bound over all corners and of the patterns by their trace, are both times three over the
    /// volume.
    #[inline(always)]
    fn slowed<S: Simd>(
        &self,
        PatternMotion { at, lane, inverse_mass, .. }: &PatternMotion<'_, S>,
        directions: &AssumedDirections<Pack<S>>,
        PackModuli { wave, along, transverse, .. }: &PackModuli<Pack<S>>,
    ) -> Pack<S> {
        let factor = at.splat(self.constants.hourglass.enhanced);
        let inverse_mass = at.load_all(*inverse_mass);
        let squares = lane.squares * (lane.per * lane.per);
        let fast = 3.0 * SLOW * *wave * squares;
        let pattern = SquareSums::of_gradient(lane.shape).weighted(inverse_mass);
        let bound = (*along + transverse.size()) * directions.largest_trace(pattern, lane.squares);
        if !fast.any_less(MARGIN * factor * bound) {
            return factor;
        }
        let zero = at.splat(0.0);
        let per = zero.if_less(*along, 1.0 / *along, zero);
        let trace = directions.trace((lane.shape, hoop(&lane.g)), inverse_mass, *transverse * per);
        (fast * per / trace).at_most(factor)
    }

    /// Returns the stresses after plastic flow.
    #[inline(always)]
    fn flow<S: Simd>(
        &mut self,
        mut stress: [[Pack<S>; 2]; 2],
        directions: &AssumedDirections<Pack<S>>,
        moduli: &PackModuli<Pack<S>>,
        scratch: &TaskWorkspace,
        at: PackPosition<S>,
    ) -> [[Pack<S>; 2]; 2] {
        let (zero, unity) = (at.splat(0.0), at.splat(1.0));
        let (returned, known) = (at.load(&scratch.stress.returned), at.load(&self.stresses.limit));
        let mises = returned * at.load(&scratch.stress.trial);
        if returned.any_less(unity) {
            let [rr, zz, around, rz] = at.load_all(&scratch.stress.deviator);
            let flow = EdgeFlow {
                normal: directions.normal([rr, zz, rz]),
                hoop: around,
                modulus: [moduli.along, moduli.transverse],
                most: (unity - returned) * zero.if_less(moduli.shear, 0.5 / moduli.shear, zero),
            };
            stress = flow.apply(stress);
            // The yield stress of a molten material is zero, whereas 0 means unknown.
            let flown = zero.if_less(mises, mises, at.splat(f64::MIN_POSITIVE));
            at.store(returned.if_less(unity, flown, known), &mut self.stresses.limit);
        }
        let unflown = zero.if_less(known, known, at.splat(f64::INFINITY));
        let limit = EdgeLimit::new(mises, returned.if_less(unity, mises, unflown), at.load(&self.share), returned);
        let squares = [EdgeLimit::square(stress[0]), EdgeLimit::square(stress[1])];
        if limit.is_exceeded(squares) {
            return limit.apply(stress, squares);
        }
        let [[t_a, h_a], [t_c, h_c]] = stress;
        [[returned * t_a, returned * h_a], [returned * t_c, returned * h_c]]
    }
}

#[cfg(test)]
mod tests {
    use super::super::constants::HourglassControl;
    use super::super::group::{ElementGroup as _, ElementPass};
    use super::super::quad::QuadGroup;
    use super::*;
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::{assumed, quad};
    use crate::material::plasticity::ElasticOnly;
    use crate::material::volumetric::ConstantBulkModulus;
    use crate::material::von_mises::VonMises;
    use crate::routines::PointRoutines;
    use crate::state::Instant;
    use crate::state::nodes::{Node, NodeAccelerations};

    const SQUARE: [[f64; 2]; 4] = [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]];
    const MODULI: [f64; 2] = [3e3, 1e3];

    /// Returns the force on a corner along an axis that acts after an increment in which only this corner moves, along
    /// this axis with velocity 1. The element was a square of density 2 at the start.
    fn force(corners: [[f64; 2]; 4], [corner, axis]: [usize; 2], dt: f64, enhanced: f64) -> f64 {
        let hourglass = HourglassControl { stiffness: 0.0, viscosity: 0.0, relaxes: false, enhanced };
        let [bulk, shear] = MODULI;
        let bulk_viscosity = BulkViscosity::NONE;
        let constants =
            ElementConstants { bulk, shear, hourglass, bulk_viscosity, shear_viscosity: 0.0, by_area: false };
        let at_rest = |[r, z]: [f64; 2]| Node { r, z, ..Node::default() };
        let material = VonMises::new(ElasticOnly, ConstantBulkModulus);
        let mut quads = QuadGroup::new(material, constants, 2.0, &[[0, 1, 2, 3]], &SQUARE.map(at_rest));
        let mut nodes = corners.map(at_rest);
        *[&mut nodes[corner].v_r, &mut nodes[corner].v_z][axis] = 1.0;
        let mut forces = vec![[[[0.0; LANES]; 2]; 4]];
        quads.update(ElementPass {
            nodes: &nodes,
            dt,
            before: NodeAccelerations::default(),
            now: &Instant::default(),
            threads: false,
            user: PointRoutines::default(),
            corners: &mut forces,
            tiles: None,
            dilation_correction: None,
            prefetches: false,
        });
        forces[0][corner][axis][0]
    }

    /// The trace of the stiffness of assumed strains over the masses is that of their plane stress moduli, and at most half of
    /// the squared frequency bound of the strains (4.7), which it reaches in folded elements. Tolerance: rounding of forces
    /// over an increment of 1e-6.
    #[test]
    fn folded_elements_have_half_of_the_frequency_bound() {
        let (masses, [bulk, shear], dt) = (quad::corner_masses(SQUARE, 2.0), MODULI, 1e-6);
        let mut limited = 0;
        // Both upper corners move along their edge, and past each other.
        for inward in [0.0, 0.3, 0.6, 0.7, 0.8, 0.9] {
            let corners = [SQUARE[0], SQUARE[1], [2.0 - inward, 1.0], [1.0 + inward, 1.0]];
            let dofs = (0..4).flat_map(|corner| [[corner, 0], [corner, 1]]);
            let stiffness = |dof| (force(corners, dof, dt, 0.0) - force(corners, dof, dt, 1.0)) / dt;
            let trace: f64 = dofs.clone().map(|dof| stiffness(dof) / masses[dof[0]]).sum();
            let matrix = assumed::stiffness(corners, MODULI);
            let own: f64 =
                dofs.map(|[corner, axis]| matrix[2 * corner + axis][2 * corner + axis] / masses[corner]).sum();
            let g = quad::gradient(corners.map(|c| c[0]), corners.map(|c| c[1]));
            let squares = |i: usize| (g.r[i] * g.r[i] + g.z[i] * g.z[i] + g.hoop[i] * g.hoop[i]) / masses[i];
            let bound = (bulk + 4.0 / 3.0 * shear) * UNIT * (0..4).map(squares).sum::<f64>() / g.volume;
            let expected = own.min(0.5 * bound);
            println!("{inward}: {:.4} of the bound, without limit {:.4}", trace / bound, own / bound);
            assert!((trace / expected - 1.0).abs() < 1e-4, "{inward}: {trace} {expected}");
            limited += usize::from(own > 0.5 * bound);
        }
        assert!((1..6).contains(&limited), "{limited}");
    }
}
