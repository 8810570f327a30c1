//! Subzonal pressures: the quarter of an element at each corner keeps its mass, and resists if its density differs from
//! that of the element. They control the hourglass patterns of materials with an equation of state and without shear
//! modulus (Caramana and Shashkov 1998, J. Comput. Phys. 142, 521).
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use pulp::{Simd, WithSimd};

use super::lane_sums::is_larger;
use super::workspace::{CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, InlineMap, LANES, Lanes, column, dispatch_outlined};
use crate::kernel::quad::{UNIT, VolumeGradient, at_corners, volume_gradient};
use crate::state::archive::Persist;
use crate::state::nodes::Node;

/// Smallest fraction of its nominal volume at which the pressure of a quarter still increases.
const LEAST: f64 = 0.01;

/// Subzonal state of a block.
#[derive(Clone, Copy, Debug, Default, Persist)]
#[repr(C, align(64))]
// The mass fractions follow from the mesh.
#[persist(derived: share)]
pub(super) struct SubzonalPressures {
    /// Mass of each quarter over that of the element.
    share: [Lanes; 4],
    /// Pressure of each quarter minus that of the element.
    pressure: [Lanes; 4],
}

/// Returns the quarter at a corner; its other corners are the midpoints of the two sides and the centre of the element.
#[inline(always)]
fn quarter(corner: usize, r: &[f64; 4], z: &[f64; 4]) -> VolumeGradient {
    let (next, previous) = ((corner + 1) % 4, (corner + 3) % 4);
    let corners = |x: &[f64; 4]| {
        let middle = 0.25 * ((x[0] + x[1]) + (x[2] + x[3]));
        [x[corner], 0.5 * (x[corner] + x[next]), middle, 0.5 * (x[previous] + x[corner])]
    };
    let VolumeGradient { volume, by_r, by_z } = volume_gradient(corners(r), corners(z));
    let spread = |d: [f64; 4]| {
        let mut terms = [0.25 * d[2]; 4];
        terms[corner] += d[0] + 0.5 * (d[1] + d[3]);
        terms[next] += 0.5 * d[1];
        terms[previous] += 0.5 * d[3];
        terms
    };
    VolumeGradient { volume, by_r: spread(by_r), by_z: spread(by_z) }
}

/// Returns the inverse masses of the corners from their combination by base vectors.
#[inline(always)]
fn by_corner(inverse_mass: &[Lanes; 4]) -> [Lanes; 4] {
    let mut list = [[0.0; LANES]; 4];
    for l in 0..LANES {
        for (i, inverse) in at_corners(column(inverse_mass, l)).into_iter().enumerate() {
            list[i][l] = 0.25 * inverse;
        }
    }
    list
}

/// Returns the pressure of a quarter minus that of the element where both have the same largest tension, from the
/// difference without this limit and the excess of the element's tension over it.
#[inline(always)]
fn limited(difference: f64, excess: f64) -> f64 {
    let (unstressed, least) = if excess > 0.0 { (excess, 0.0) } else { (0.0, excess) };
    let pressure = difference - unstressed;
    // NaN is kept, so that the run halts.
    if pressure < least { least } else { pressure }
}

impl SubzonalPressures {
    /// Creates the state for a block's elements in the initial configuration; lanes after the last element repeat it.
    pub fn of(elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        let mut zones = SubzonalPressures::default();
        for l in 0..LANES {
            let corners = elements[l.min(elements.len() - 1)].inline_map(|n| nodes[n as usize].place());
            let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
            let volumes = [0, 1, 2, 3].inline_map(|c| quarter(c, &r, &z).volume);
            let whole: f64 = volumes.iter().sum();
            (0..4).for_each(|c| zones.share[c][l] = volumes[c] / whole);
        }
        zones
    }

    /// Adds the pressure forces of the quarters at one corner. Equation (7.11).
    #[inline(always)]
    fn add_quarter<const CORNER: usize>(
        &mut self,
        scratch: &TaskWorkspace,
        (whole, nodes): (&Lanes, &CornerNodes),
        inverse_mass: &[Lanes; 4],
        answers: &mut SubzonalForces,
    ) {
        for l in 0..LANES {
            let ([r, z], [v_r, v_z]) = (nodes.places(l), nodes.velocities(l));
            let VolumeGradient { volume, by_r, by_z } = quarter(CORNER, &r, &z);
            let nominal = self.share[CORNER][l] * whole[l];
            let bounded = if volume > LEAST * nominal { volume } else { LEAST * nominal };
            let pressure =
                limited(scratch.stress.bulk[l] * (nominal / bounded - 1.0), scratch.stress.tension_excess[l]);
            let mean = 0.5 * (self.pressure[CORNER][l] + pressure);
            self.pressure[CORNER][l] = pressure;
            let growth = |i: usize| by_r[i] * v_r[i] + by_z[i] * v_z[i];
            let light = |i: usize| (by_r[i] * by_r[i] + by_z[i] * by_z[i]) * inverse_mass[i][l];
            for i in 0..4 {
                answers.forces[i][0][l] += pressure * by_r[i];
                answers.forces[i][1][l] += pressure * by_z[i];
            }
            answers.power[l] -= mean * ((growth(0) + growth(1)) + (growth(2) + growth(3)));
            answers.stiff[l] += ((light(0) + light(1)) + (light(2) + light(3))) / bounded;
        }
    }
}

/// Results of the quarters of a block: forces over [`UNIT`], power, and the trace that bounds the time increment.
struct SubzonalForces {
    forces: BlockCornerForces,
    power: Lanes,
    stiff: Lanes,
}

/// Update of the quarters of a block.
struct SubzonalUpdate<'a> {
    scratch: &'a mut TaskWorkspace,
    zones: SubzonalPressures,
    increment: (f64, f64),
    nodes: &'a CornerNodes,
    inverse_mass: &'a [Lanes; 4],
    corners: &'a mut BlockCornerForces,
}

impl WithSimd for SubzonalUpdate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let SubzonalUpdate { scratch, zones, increment, nodes, inverse_mass, corners } = self;
        add_subzonal_forces(scratch, zones, increment, nodes, inverse_mass, corners);
    }
}

/// Adds the forces of the quarters to the corner forces, their work to the artificial energy, and limits the time
/// increment. Does nothing without subzonal pressures. `damping` is the hourglass viscosity as a fraction of
/// critical damping.
pub(super) fn resist_patterns(
    scratch: &mut TaskWorkspace,
    increment: (f64, f64),
    nodes: &CornerNodes,
    inverse_mass: &[Lanes; 4],
    corners: &mut BlockCornerForces,
) {
    let Some(zones) = scratch.task.subzones.get(scratch.at).copied() else { return };
    let arch = scratch.arch;
    dispatch_outlined(arch, SubzonalUpdate { scratch, zones, increment, nodes, inverse_mass, corners });
}

/// Equation (7.12).
#[inline(always)]
fn add_subzonal_forces(
    scratch: &mut TaskWorkspace,
    mut zones: SubzonalPressures,
    (dt, damping): (f64, f64),
    nodes: &CornerNodes,
    inverse_mass: &[Lanes; 4],
    corners: &mut BlockCornerForces,
) {
    let inverse_mass = &by_corner(inverse_mass);
    let mut whole = [0.0; LANES];
    let mut answers = SubzonalForces { forces: [[[0.0; LANES]; 2]; 4], power: [0.0; LANES], stiff: [0.0; LANES] };
    // The trace of the stiffness of the quarters relative to that of the whole element bounds the square of their
    // highest frequency.
    for l in 0..LANES {
        let [r, z] = nodes.places(l);
        let VolumeGradient { volume, by_r, by_z } = volume_gradient(r, z);
        let light = |i: usize| (by_r[i] * by_r[i] + by_z[i] * by_z[i]) * inverse_mass[i][l];
        whole[l] = volume;
        answers.stiff[l] = -((light(0) + light(1)) + (light(2) + light(3))) / volume;
    }
    zones.add_quarter::<0>(scratch, (&whole, nodes), inverse_mass, &mut answers);
    zones.add_quarter::<1>(scratch, (&whole, nodes), inverse_mass, &mut answers);
    zones.add_quarter::<2>(scratch, (&whole, nodes), inverse_mass, &mut answers);
    zones.add_quarter::<3>(scratch, (&whole, nodes), inverse_mass, &mut answers);
    for (to, list) in corners.iter_mut().zip(&answers.forces) {
        for l in 0..LANES {
            to[0][l] += UNIT * list[0][l];
            to[1][l] += UNIT * list[1][l];
        }
    }
    let (block, damped) = (scratch.number(), damping + (1.0 + damping * damping).sqrt());
    for l in 0..LANES {
        scratch.sums.artificial[l] += dt * UNIT * scratch.weight[l] * answers.power[l];
        let square = UNIT * scratch.stress.bulk[l] * answers.stiff[l];
        let rate = scratch.weight[l] * (if square > 0.0 { square } else { 0.0 }).sqrt() * damped;
        let (best, limiting) = (scratch.sums.rate[l], scratch.sums.limiting[l]);
        let larger = is_larger(rate, best);
        scratch.sums.rate[l] = if larger { rate } else { best };
        scratch.sums.limiting[l] = if larger { block } else { limiting };
    }
    if let Some(place) = scratch.task.subzones.get_mut(scratch.at) {
        *place = zones;
    }
}

#[cfg(test)]
mod tests {
    use super::{limited, quarter};
    use crate::kernel::quad::{VolumeGradient, gradient};

    const R: [f64; 4] = [1.0, 3.2, 2.9, 0.8];
    const Z: [f64; 4] = [0.1, -0.2, 1.7, 2.0];

    #[test]
    fn quarter_volumes_and_derivatives_sum_to_the_element() {
        let quarters = [0, 1, 2, 3].map(|c| quarter(c, &R, &Z));
        let g = gradient(R, Z);
        let volume: f64 = quarters.iter().map(|q| q.volume).sum();
        assert!((volume / g.volume - 1.0).abs() < 1e-14);
        for i in 0..4 {
            let (by_r, by_z): (f64, f64) = quarters.iter().fold((0.0, 0.0), |s, q| (s.0 + q.by_r[i], s.1 + q.by_z[i]));
            assert!((by_r - g.r[i] - g.hoop[i]).abs() < 1e-13 && (by_z - g.z[i]).abs() < 1e-13);
        }
    }

    /// The tension of the element and that of its quarters, each below the limit 2, differ by the limited difference.
    #[test]
    fn quarters_have_the_tension_limit_of_the_element() {
        let limit = 2.0;
        for tension in [-3.0, 1.0, 2.0, 2.5, 9.0] {
            for difference in [-5.0, -0.5, 0.0, 0.4, 3.0, 20.0] {
                let expected = f64::min(tension, limit) - f64::min(tension - difference, limit);
                let limited_difference = limited(difference, tension - limit);
                assert!(
                    (limited_difference - expected).abs() < 1e-14,
                    "{tension} {difference}: {limited_difference} {expected}"
                );
                assert_eq!(limited(difference, f64::NEG_INFINITY).to_bits(), f64::to_bits(difference));
            }
        }
        assert!(limited(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn quarter_derivatives_match_finite_differences() {
        let step = 1e-6;
        for c in 0..4 {
            let VolumeGradient { by_r, by_z, .. } = quarter(c, &R, &Z);
            for i in 0..4 {
                let moved = |x: [f64; 4], by: f64| {
                    let mut x = x;
                    x[i] += by;
                    x
                };
                let along_r = quarter(c, &moved(R, step), &Z).volume - quarter(c, &moved(R, -step), &Z).volume;
                let along_z = quarter(c, &R, &moved(Z, step)).volume - quarter(c, &R, &moved(Z, -step)).volume;
                assert!((along_r / (2.0 * step) - by_r[i]).abs() < 1e-8);
                assert!((along_z / (2.0 * step) - by_z[i]).abs() < 1e-8);
            }
        }
    }
}
