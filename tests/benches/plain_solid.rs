//! Copper Taylor bar in a plain scalar loop: an array of structs, one element after the other, forces added to the
//! nodes.
//!
//! The mathematics is that of the solver (CAX4R, von Mises with hardening, relaxing stiffness hourglass control, bulk
//! viscosity, all energies, stable increment), written corner by corner as in textbooks.

use std::f64::consts::PI;

use revolve::internals::quad::corner_masses;
use revolve::internals::rotation::rotated;

/// Factor of the integrals of [`gradient`].
const UNIT: f64 = PI / 3.0;

const DENSITY: f64 = 8930.0;
const SHEAR: f64 = 117e9 / 2.7;
const BULK: f64 = 117e9 / 0.9;
/// Yield stress at zero plastic strain and slope of each line; the smallest line applies.
const LINES: [[f64; 2]; 2] = [[400e6, 100e6], [900e6, 0.0]];
const HOURGLASS: f64 = 0.005;
const VISCOSITY: [f64; 2] = [0.06, 1.2];

#[derive(Clone, Copy, Default)]
struct Node {
    place: [f64; 2],
    velocity: [f64; 2],
    force: [f64; 2],
    mass: f64,
    held: bool,
}

struct Element {
    nodes: [usize; 4],
    stress: [f64; 4],
    hourglass: [f64; 2],
    viscous: f64,
    strain: f64,
    /// Ratio of yield stress to trial stress in the last return mapping.
    left: f64,
    inverse_mass: [f64; 4],
}

/// Bar that moves against a wall.
pub struct PlainBar {
    nodes: Vec<Node>,
    elements: Vec<Element>,
    /// Work of the stress, plastic, of the bulk viscosity and of the hourglass control.
    pub energies: [f64; 4],
    /// Kinetic energy.
    pub kinetic: f64,
    /// Largest frequency of an element.
    pub rate: f64,
}

/// Integrals of the gradient operators of an axisymmetric quadrilateral, in units of pi/3 (Flanagan and Belytschko
/// 1981, eqs. 13 to 21, extended to axisymmetry): along z the derivative of the volume, along r this derivative less
/// the integral of N_I/r.
struct Gradient {
    r: [f64; 4],
    z: [f64; 4],
    hoop: [f64; 4],
    volume: f64,
}

fn gradient(r: [f64; 4], z: [f64; 4]) -> Gradient {
    // Triangles at the corners: twice their areas, with T1 + T3 = T2 + T4 = 2 A.
    let (r21, z21) = (r[1] - r[0], z[1] - z[0]);
    let (r31, z31) = (r[2] - r[0], z[2] - z[0]);
    let (r41, z41) = (r[3] - r[0], z[3] - z[0]);
    let t1 = r21 * z41 - r41 * z21;
    let t2 = r21 * z31 - r31 * z21;
    let t4 = r31 * z41 - r41 * z31;
    let double = t2 + t4;
    // int N_I dA = (A + T_I)/6 with plane areas.
    let hoop = [double + t1, double + t2, double + double - t1, double + t4].map(|t| 0.5 * t);
    let (mut by_r, mut by_z, mut moment) = ([0.0; 4], [0.0; 4], 0.0);
    for i in 0..4 {
        let (j, p) = ((i + 1) % 4, (i + 3) % 4);
        let (next, before) = (r[i] + r[j], r[p] + r[i]);
        // dV/dr_I is pi/3 times 2 r_I (z_J - z_P) + r_J (z_J - z_I) + r_P (z_I - z_P).
        by_r[i] = (r[i] + next) * (z[j] - z[i]) + (r[i] + before) * (z[i] - z[p]);
        by_z[i] = r[p] * before - r[j] * next;
        moment += r[i] * by_r[i];
    }
    Gradient { r: [0, 1, 2, 3].map(|i: usize| by_r[i] - hoop[i]), z: by_z, hoop, volume: 0.5 * moment }
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

impl PlainBar {
    /// Creates a bar of `nr` by `nz` elements.
    pub fn new(nr: usize, nz: usize) -> PlainBar {
        let node = |n: usize| {
            let (i, j) = (n % (nr + 1), n / (nr + 1));
            let place = [3.2e-3 * i as f64 / nr as f64, 32.4e-3 * j as f64 / nz as f64];
            let velocity = [0.0, if j == 0 { 0.0 } else { -227.0 }];
            Node { place, velocity, held: j == 0, ..Node::default() }
        };
        let mut nodes: Vec<Node> = (0..(nr + 1) * (nz + 1)).map(node).collect();
        let mut elements = Vec::with_capacity(nr * nz);
        for e in 0..nr * nz {
            let first = e % nr + e / nr * (nr + 1);
            let corners = [first, first + 1, first + nr + 2, first + nr + 1];
            let masses = corner_masses(corners.map(|n| nodes[n].place), DENSITY);
            corners.iter().zip(masses).for_each(|(&n, mass)| nodes[n].mass += mass);
            elements.push(Element {
                nodes: corners,
                stress: [0.0; 4],
                hourglass: [0.0; 2],
                viscous: 0.0,
                strain: 0.0,
                left: 1.0,
                inverse_mass: masses.map(|m| 1.0 / m),
            });
        }
        PlainBar { nodes, elements, energies: [0.0; 4], kinetic: 0.0, rate: 0.0 }
    }

    /// Runs `increments` of central differences.
    pub fn run(&mut self, increments: usize, dt: f64) {
        self.forces(0.0);
        self.velocities(0.0, 0.5 * dt);
        for increment in 1..=increments {
            for node in &mut self.nodes {
                node.place = [0, 1].map(|i| node.place[i] + dt * node.velocity[i]);
            }
            self.forces(dt);
            let last = increment == increments;
            self.velocities(0.5 * dt, if last { 0.0 } else { 0.5 * dt });
        }
    }

    fn velocities(&mut self, previous: f64, next: f64) {
        self.kinetic = 0.0;
        for node in &mut self.nodes {
            let acceleration = [node.force[0] / node.mass, if node.held { 0.0 } else { node.force[1] / node.mass }];
            // Kinetic energy of central differences: product of the velocities half an increment before and after.
            let energy = |i: usize| node.velocity[i] * (node.velocity[i] + 2.0 * previous * acceleration[i]);
            self.kinetic += 0.5 * node.mass * (energy(0) + energy(1));
            node.velocity = [0, 1].map(|i| node.velocity[i] + (previous + next) * acceleration[i]);
            node.force = [0.0; 2];
        }
    }

    fn forces(&mut self, dt: f64) {
        self.rate = 0.0;
        for element in &mut self.elements {
            let nodes = element.nodes.map(|n| self.nodes[n]);
            let [r, z] = [0, 1].map(|i| nodes.map(|n| n.place[i]));
            let [v_r, v_z] = [0, 1].map(|i| nodes.map(|n| n.velocity[i]));
            let (strain, volume) = element.update_stress(dt, r, z, v_r, v_z, &mut self.energies);
            let (forces, rate) = element.corner_forces(dt, r, z, v_r, v_z, strain, volume, &mut self.energies);
            self.rate = self.rate.max(rate);
            for (&n, force) in element.nodes.iter().zip(forces) {
                self.nodes[n].force[0] -= force[0];
                self.nodes[n].force[1] -= force[1];
            }
        }
    }
}

impl Element {
    /// Returns the change of volume and the volume at the middle of the increment, and updates the stress to its end.
    fn update_stress(
        &mut self,
        dt: f64,
        r: [f64; 4],
        z: [f64; 4],
        v_r: [f64; 4],
        v_z: [f64; 4],
        energies: &mut [f64; 4],
    ) -> (f64, f64) {
        let middle = |x: [f64; 4], v: [f64; 4]| [0, 1, 2, 3].map(|i| x[i] - 0.5 * dt * v[i]);
        let g = gradient(middle(r, v_r), middle(z, v_z));
        let per = dt / g.volume;
        let (rz, zr) = (per * dot(g.z, v_r), per * dot(g.r, v_z));
        let d = [per * dot(g.r, v_r), per * dot(g.z, v_z), per * dot(g.hoop, v_r), 0.5 * (rz + zr)];
        let old = rotated(self.stress, 0.5 * (rz - zr));
        let dilation = d[0] + d[1] + d[2];
        let pressure = (old[0] + old[1] + old[2]) / 3.0;
        let base = pressure + 2.0 * SHEAR / 3.0 * dilation;
        let s = [0, 1, 2].map(|i| old[i] - base + 2.0 * SHEAR * d[i]);
        let s_rz = old[3] + 2.0 * SHEAR * d[3];
        let trial = (1.5_f64 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) + 3.0 * s_rz * s_rz).sqrt();
        let mut flow = 0.0_f64;
        for [start, slope] in LINES {
            flow = flow.max((trial - (start + slope * self.strain)) / (3.0 * SHEAR + slope));
        }
        let returned = trial - 3.0 * SHEAR * flow;
        let factor = if flow > 0.0 { returned / trial } else { 1.0 };
        (self.strain, self.left) = (self.strain + flow, factor);
        let mean = pressure + BULK * dilation;
        self.stress = [mean + factor * s[0], mean + factor * s[1], mean + factor * s[2], factor * s_rz];
        let volume = UNIT * g.volume;
        let double = |i: usize| d[i] * (old[i] + self.stress[i]);
        energies[0] += 0.5 * volume * (double(0) + double(1) + double(2) + 2.0 * double(3));
        energies[1] += volume * returned * flow;
        (dilation, volume)
    }

    /// Returns the corner forces and the frequency of the element.
    #[allow(clippy::too_many_arguments)]
    fn corner_forces(
        &mut self,
        dt: f64,
        r: [f64; 4],
        z: [f64; 4],
        v_r: [f64; 4],
        v_z: [f64; 4],
        dilation: f64,
        volume: f64,
        energies: &mut [f64; 4],
    ) -> ([[f64; 2]; 4], f64) {
        let g = gradient(r, z);
        let modulus = BULK + 4.0 / 3.0 * SHEAR;
        let per = 1.0 / g.volume;
        let corner = |i: usize| (g.r[i] * g.r[i] + g.z[i] * g.z[i] + g.hoop[i] * g.hoop[i]) * self.inverse_mass[i];
        let omega = (modulus * UNIT * (corner(0) + corner(1) + corner(2) + corner(3)) * per).sqrt();
        let dilation_rate = if dt > 0.0 { dilation / dt } else { 0.0 };
        let fraction = VISCOSITY[0] - VISCOSITY[1] * VISCOSITY[1] * 2.0 / omega * dilation_rate.min(0.0);
        let damping = 2.0 * modulus / omega * dilation_rate * fraction;
        energies[2] += volume * 0.5 * (self.viscous + damping) * dilation;
        self.viscous = damping;
        let (h_r, h_z) = (per * ((r[0] - r[1]) + (r[2] - r[3])), per * ((z[0] - z[1]) + (z[2] - z[3])));
        let shape = [0, 1, 2, 3].map(|i| [1.0, -1.0, 1.0, -1.0][i] - (h_r * g.r[i] + h_z * g.z[i]));
        let spring = dt * UNIT * HOURGLASS * SHEAR * (dot(g.r, g.r) + dot(g.z, g.z)) * per;
        let (q_r, q_z) = (dot(shape, v_r), dot(shape, v_z));
        let old = self.hourglass;
        self.hourglass = [self.left * (old[0] + spring * q_r), self.left * (old[1] + spring * q_z)];
        let [f_r, f_z] = self.hourglass;
        energies[3] += dt * 0.5 * (q_r * (old[0] + f_r) + q_z * (old[1] + f_z));
        let [rr, zz, hoop] = [0, 1, 2].map(|i| UNIT * (self.stress[i] + damping));
        let rz = UNIT * self.stress[3];
        let force = |i: usize| {
            [rr * g.r[i] + rz * g.z[i] + hoop * g.hoop[i] + f_r * shape[i], zz * g.z[i] + rz * g.r[i] + f_z * shape[i]]
        };
        ([0, 1, 2, 3].map(force), omega * (1.0 + fraction * (1.0 + 0.5 * fraction)))
    }
}
