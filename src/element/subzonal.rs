//! Subzonal pressures: the quarters of an element at its corners keep their masses, and one that is denser than the element
//! pushes back. They see the patterns that the mean over the element does not (Caramana and Shashkov 1998, J. Comput. Phys.
//! 142, 521), for what has an equation of state and no shear modulus.
//! Never here: pressures of elements, viscosity.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::{Nodes, Workspace, is_larger};
use crate::kernel::lanes::{Corners, InlineMap, LANES, Lanes, column, dispatch_outlined};
use crate::kernel::quad::{UNIT, at_corners, volume_gradient};
use crate::state::archive::persist_struct;
use crate::state::nodes::Node;

/// The least part of its share of the volume for which the pressure of a quarter still rises.
const LEAST: f64 = 0.01;

/// What a block keeps of its quarters.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Subzones {
    /// Mass of each quarter over that of the element.
    share: [Lanes; 4],
    /// Pressure of each quarter less that of the element.
    pressure: [Lanes; 4],
}

/// Volume of a quarter in the unit [`UNIT`], and its derivatives by r and z of the element's corners.
struct Quarter {
    volume: f64,
    by_r: [f64; 4],
    by_z: [f64; 4],
}

/// The quarter at a corner: its other corners lie in the middles of both sides and of the element.
#[inline(always)]
fn quarter(corner: usize, r: &[f64; 4], z: &[f64; 4]) -> Quarter {
    let (next, before) = ((corner + 1) % 4, (corner + 3) % 4);
    let corners = |x: &[f64; 4]| {
        let middle = 0.25 * ((x[0] + x[1]) + (x[2] + x[3]));
        [x[corner], 0.5 * (x[corner] + x[next]), middle, 0.5 * (x[before] + x[corner])]
    };
    let (by_r, by_z, volume) = volume_gradient(corners(r), corners(z));
    let spread = |d: [f64; 4]| {
        let mut all = [0.25 * d[2]; 4];
        all[corner] += d[0] + 0.5 * (d[1] + d[3]);
        all[next] += 0.5 * d[1];
        all[before] += 0.5 * d[3];
        all
    };
    Quarter { volume, by_r: spread(by_r), by_z: spread(by_z) }
}

/// One over the masses of the corners, by their sums.
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

impl Subzones {
    /// Of a block's elements at the start; lanes behind the last element repeat it.
    pub fn of(elements: &[[u32; 4]], nodes: &[Node]) -> Self {
        let mut zones = Subzones::default();
        for l in 0..LANES {
            let corners = elements[l.min(elements.len() - 1)].inline_map(|n| nodes[n as usize].place());
            let (r, z) = (corners.inline_map(|c| c[0]), corners.inline_map(|c| c[1]));
            let volumes = [0, 1, 2, 3].inline_map(|c| quarter(c, &r, &z).volume);
            let whole: f64 = volumes.iter().sum();
            (0..4).for_each(|c| zones.share[c][l] = volumes[c] / whole);
        }
        zones
    }
}

/// What the quarters of a block come to: forces as in [`Corners`] over [`UNIT`], power, and the trace that bounds the increment.
struct Answers {
    forces: [[[f64; 2]; LANES]; 4],
    power: Lanes,
    stiff: Lanes,
}

impl Workspace {
    /// Adds the forces of the block's quarters to those on its corners, books their work as artificial, and bounds the increment
    /// by them: nothing without subzonal pressures. `damping` is the fraction of critical damping that hourglass control has.
    pub(super) fn resist_patterns(
        &mut self,
        increment: (f64, f64),
        nodes: &Nodes,
        inverse_mass: &[Lanes; 4],
        corners: &mut Corners,
    ) {
        let Some(zones) = self.task.subzones.get(self.at).copied() else { return };
        dispatch_outlined(
            self.arch,
            #[inline(always)]
            || self.add_subzonal_forces(zones, increment, nodes, inverse_mass, corners),
        );
    }

    #[inline(always)]
    fn add_subzonal_forces(
        &mut self,
        mut zones: Subzones,
        (dt, damping): (f64, f64),
        nodes: &Nodes,
        inverse_mass: &[Lanes; 4],
        corners: &mut Corners,
    ) {
        let inverse_mass = &by_corner(inverse_mass);
        let mut whole = [0.0; LANES];
        let mut answers = Answers { forces: [[[0.0; 2]; LANES]; 4], power: [0.0; LANES], stiff: [0.0; LANES] };
        // The trace of what the quarters do beside the element as a whole is no smaller than the square of their highest
        // frequency.
        for l in 0..LANES {
            let (by_r, by_z, volume) = volume_gradient(nodes.of(l, 0), nodes.of(l, 1));
            let light = |i: usize| (by_r[i] * by_r[i] + by_z[i] * by_z[i]) * inverse_mass[i][l];
            whole[l] = volume;
            answers.stiff[l] = -((light(0) + light(1)) + (light(2) + light(3))) / volume;
        }
        self.add_quarter::<0>(&mut zones, (&whole, nodes), inverse_mass, &mut answers);
        self.add_quarter::<1>(&mut zones, (&whole, nodes), inverse_mass, &mut answers);
        self.add_quarter::<2>(&mut zones, (&whole, nodes), inverse_mass, &mut answers);
        self.add_quarter::<3>(&mut zones, (&whole, nodes), inverse_mass, &mut answers);
        for (to, list) in corners.0.iter_mut().zip(&answers.forces) {
            for l in 0..LANES {
                to[l] = [to[l][0] + UNIT * list[l][0], to[l][1] + UNIT * list[l][1]];
            }
        }
        let (block, damped) = (self.number(), damping + (1.0 + damping * damping).sqrt());
        for l in 0..LANES {
            self.sums.artificial[l] += dt * UNIT * self.weight[l] * answers.power[l];
            let square = UNIT * self.stress.bulk[l] * answers.stiff[l];
            let rate = self.weight[l] * (if square > 0.0 { square } else { 0.0 }).sqrt() * damped;
            let (best, limiting) = (self.sums.rate[l], self.sums.limiting[l]);
            let larger = is_larger(rate, best);
            self.sums.rate[l] = if larger { rate } else { best };
            self.sums.limiting[l] = if larger { block } else { limiting };
        }
        if let Some(place) = self.task.subzones.get_mut(self.at) {
            *place = zones;
        }
    }

    /// The pressures of the quarters at one corner.
    #[inline(always)]
    fn add_quarter<const CORNER: usize>(
        &self,
        zones: &mut Subzones,
        (whole, nodes): (&Lanes, &Nodes),
        inverse_mass: &[Lanes; 4],
        answers: &mut Answers,
    ) {
        for l in 0..LANES {
            let Quarter { volume, by_r, by_z } = quarter(CORNER, &nodes.of(l, 0), &nodes.of(l, 1));
            let (v_r, v_z) = (nodes.of(l, 2), nodes.of(l, 3));
            let due = zones.share[CORNER][l] * whole[l];
            let room = if volume > LEAST * due { volume } else { LEAST * due };
            let pressure = self.stress.bulk[l] * (due / room - 1.0);
            let mean = 0.5 * (zones.pressure[CORNER][l] + pressure);
            zones.pressure[CORNER][l] = pressure;
            let growth = |i: usize| by_r[i] * v_r[i] + by_z[i] * v_z[i];
            let light = |i: usize| (by_r[i] * by_r[i] + by_z[i] * by_z[i]) * inverse_mass[i][l];
            for i in 0..4 {
                let [r, z] = answers.forces[i][l];
                answers.forces[i][l] = [r + pressure * by_r[i], z + pressure * by_z[i]];
            }
            answers.power[l] -= mean * ((growth(0) + growth(1)) + (growth(2) + growth(3)));
            answers.stiff[l] += ((light(0) + light(1)) + (light(2) + light(3))) / room;
        }
    }
}

// The shares are those of the mesh.
persist_struct!(Subzones { pressure } derived { share });

#[cfg(test)]
mod tests {
    use super::{Quarter, quarter};
    use crate::kernel::quad::gradient;

    const R: [f64; 4] = [1.0, 3.2, 2.9, 0.8];
    const Z: [f64; 4] = [0.1, -0.2, 1.7, 2.0];

    #[test]
    fn quarters_fill_the_element_and_have_its_derivatives() {
        let quarters = [0, 1, 2, 3].map(|c| quarter(c, &R, &Z));
        let g = gradient(R, Z);
        let volume: f64 = quarters.iter().map(|q| q.volume).sum();
        assert!((volume / g.volume - 1.0).abs() < 1e-14);
        for i in 0..4 {
            let (by_r, by_z): (f64, f64) = quarters.iter().fold((0.0, 0.0), |s, q| (s.0 + q.by_r[i], s.1 + q.by_z[i]));
            assert!((by_r - g.r[i] - g.hoop[i]).abs() < 1e-13 && (by_z - g.z[i]).abs() < 1e-13);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_volume() {
        let step = 1e-6;
        for c in 0..4 {
            let Quarter { by_r, by_z, .. } = quarter(c, &R, &Z);
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
