//! Hourglass control by stresses of assumed strains that vary across an element (HOURGLASS=ENHANCED). They have the
//! bending stiffness of the material and follow its plastic flow.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::NullaryFnOnce;

use super::block::{CornerNodes, ElementBlock, TaskWorkspace};
use super::constants::ElementConstants;
use super::control::EnhancedInput;
use super::edges::{EdgeYield, largest};
use super::middle::CentroidState;
use crate::kernel::assumed::AssumedDirections;
use crate::kernel::lanes::{BlockCornerForces, LANES, Lanes, column, dispatch_outlined, inline_from_fn};
use crate::kernel::quad::{UNIT, at_corners};
use crate::material::{Material, PlasticFlow};

/// Returns the stress fraction that damage leaves in each lane.
#[inline(always)]
fn shares<M: Material>(material: &M, state: &M::State) -> Lanes {
    if M::FAILS { inline_from_fn(|l| material.share(state, l)) } else { [1.0; LANES] }
}

impl<S: Clone> ElementBlock<S> {
    /// Returns the stress fraction that damage leaves at the start of the increment.
    #[inline(always)]
    pub(super) fn shares<M: Material<State = S>>(&self, material: &M) -> Lanes {
        shares(material, &self.state)
    }

    /// Adds the stresses and forces of assumed strains for an increment; `before` is the stress fraction left by damage
    /// at its start.
    #[inline(always)]
    pub(super) fn enhance<M: Material<State = S>>(
        &self,
        (material, before): (&M, Lanes),
        (constants, dt): (&ElementConstants, f64),
        (seen, nodes): (&EnhancedInput, &CornerNodes),
        scratch: &mut TaskWorkspace,
        corners: &mut BlockCornerForces,
    ) {
        let mut middle = CentroidState::of(constants, scratch);
        if M::FAILS {
            middle.fail(&before, &shares(material, &self.state));
        }
        if M::MODULI_VARY {
            middle.vary::<M>(constants, scratch);
        }
        if matches!(M::FLOW, PlasticFlow::Coupled) {
            middle.undo_flow(&mut scratch.stress);
        }
        let at = scratch.at;
        if scratch.task.enhanced[at].limit[0] == 0.0
            && let Some(limit) = material.yield_stress(&self.state, constants.shear, scratch.strain.count)
        {
            scratch.task.enhanced[at].limit = limit;
        }
        let (factor, by_area, arch) = (constants.hourglass.enhanced, constants.by_area, scratch.arch);
        let inverse_mass = &self.inverse_mass;
        let patterns = AssumedForces { factor, by_area, dt, inverse_mass, seen, middle: &middle, nodes };
        // The conditions are constants of the material: only one branch is compiled.
        if M::FAILS && matches!(M::FLOW, PlasticFlow::None) {
            dispatch_outlined(arch, AddForces::<true, false> { patterns, scratch, corners });
        } else if M::FAILS {
            dispatch_outlined(arch, AddForces::<true, true> { patterns, scratch, corners });
        } else if matches!(M::FLOW, PlasticFlow::None) {
            dispatch_outlined(arch, AddForces::<false, false> { patterns, scratch, corners });
        } else {
            dispatch_outlined(arch, AddForces::<false, true> { patterns, scratch, corners });
        }
    }
}

/// Input of the forces of assumed strains. Materials with the same failure and flow properties share the compiled code.
struct AssumedForces<'a> {
    factor: f64,
    by_area: bool,
    dt: f64,
    inverse_mass: &'a [Lanes; 4],
    seen: &'a EnhancedInput,
    middle: &'a CentroidState,
    nodes: &'a CornerNodes,
}

/// Operation that adds the forces of assumed strains to the corner forces.
struct AddForces<'a, const FAILS: bool, const FLOWS: bool> {
    patterns: AssumedForces<'a>,
    scratch: &'a mut TaskWorkspace,
    corners: &'a mut BlockCornerForces,
}

impl<const FAILS: bool, const FLOWS: bool> NullaryFnOnce for AddForces<'_, FAILS, FLOWS> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.patterns.add::<FAILS, FLOWS>(self.scratch, self.corners);
    }
}

impl AssumedForces<'_> {
    /// Updates the stresses of the patterns to the end of the increment, and adds their corner forces. The loop has no
    /// branches and shares divisions.
    #[inline(always)]
    fn add<const FAILS: bool, const FLOWS: bool>(&self, scratch: &mut TaskWorkspace, corners: &mut BlockCornerForces) {
        let AssumedForces { factor, by_area, dt, inverse_mass, seen, middle, nodes } = *self;
        // A local copy: possible aliasing within the scratch memory would prevent vectorization.
        let mut assumed = scratch.task.enhanced[scratch.at];
        for l in 0..LANES {
            let (r, z) = (column(&scratch.r, l), column(&scratch.z, l));
            let (directions, operators) = (AssumedDirections::of(r, z, seen.ring[l]), seen.operators(l));
            let modulus = [middle.along[l], middle.transverse[l]];
            // Squared frequencies, both times three over the volume and the direct modulus: of the strains by the bound
            // over all corners, of the patterns by their trace.
            let trace = directions.trace(operators, column(inverse_mass, l), middle.ratio[l]);
            let slowest = middle.slow[l] * seen.squares[l] / trace;
            let slowed = if slowest < factor { slowest } else { factor };
            // A triangle, with two coincident corners, has no pattern.
            let [of_r, of_z] = nodes.places(l);
            let triangle = (of_r[2] == of_r[3]) & (of_z[2] == of_z[3]);
            let mut grows = if triangle { 0.0 } else { dt * slowed };
            if FAILS {
                grows *= middle.share[l];
            }
            let [along, transverse] = [grows * modulus[0], grows * modulus[1]];

            let strained = directions.along([seen.rate[0][l], seen.rate[1][l]]);
            let turned = directions.around([seen.hoop_rate[0][l], seen.hoop_rate[1][l]]);
            let mut stress = [[0.0; 2]; 2];
            for p in 0..2 {
                stress[p] = [assumed.stress[p][0][l], assumed.stress[p][1][l]];
                if FAILS {
                    stress[p] = [middle.remains[l] * stress[p][0], middle.remains[l] * stress[p][1]];
                }
                stress[p][0] += along * strained[p] + transverse * turned[p];
                stress[p][1] += along * turned[p] + transverse * strained[p];
            }
            if FLOWS {
                let (left, known) = (scratch.stress.returned[l], assumed.limit[l]);
                let mises = left * middle.trial[l];
                let unflown = if known > 0.0 { known } else { f64::INFINITY };
                let limit = if left < 1.0 { mises } else { unflown };
                let mut bound = largest(mises, limit);
                if FAILS {
                    bound *= middle.share[l];
                }
                // The yield stress of a molten material is zero, whereas 0 means unknown.
                let flown = if mises > 0.0 { mises } else { f64::MIN_POSITIVE };
                assumed.limit[l] = if left < 1.0 { flown } else { known };
                let yields = EdgeYield {
                    normal: directions.normal([middle.deviator[0][l], middle.deviator[1][l], middle.deviator[3][l]]),
                    hoop: middle.deviator[2][l],
                    left,
                    modulus,
                    most: (1.0 - left) * middle.compliance[l],
                    bound,
                };
                stress = yields.flow(stress);
            }
            let mut power = 0.0;
            for p in 0..2 {
                let [t, h] = stress[p];
                power += (assumed.stress[p][0][l] + t) * strained[p] + (assumed.stress[p][1][l] + h) * turned[p];
                assumed.stress[p][0][l] = t;
                assumed.stress[p][1][l] = h;
            }
            let third = UNIT / 3.0 * seen.volume[l];
            scratch.sums.artificial[l] += 0.5 * dt * scratch.weight[l] * (third * power);
            let acts = if by_area { third / (4.0 * UNIT * r[0]) } else { third };
            let [first, second] = stress;
            let [bent, turned] =
                directions.forces([acts * first[0], acts * second[0]], [acts * first[1], acts * second[1]]);
            let (shape, [by_r, by_z]) = operators;
            let ring = |i: usize| turned[0] * by_r[i] + turned[1] * by_z[i];
            let along_r = at_corners([
                ring(0),
                bent[0] * shape[0] + ring(1),
                bent[0] * shape[1] + ring(2),
                bent[0] * shape[2] + ring(3),
            ]);
            let along_z = at_corners([0.0, bent[1] * shape[0], bent[1] * shape[1], bent[1] * shape[2]]);
            for i in 0..4 {
                corners[i][0][l] -= along_r[i];
                corners[i][1][l] -= along_z[i];
            }
        }
        scratch.task.enhanced[scratch.at] = assumed;
    }
}
