//! Transport of mass and element variables through the edges of a domain whose nodes move while the material rests:
//! swept rings with linear reconstruction (van Leer 1979, J. Comput. Phys. 32, 101), limited by
//! [`limiter`](super::limiter).

use super::geometry::{centre, swept};
use super::limiter::{TransportWork, WeightFlux};
use super::topology::DomainTopology;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::heap_bytes;
use crate::kernel::quad;

/// Order of the transport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportOrder {
    /// The value of the donor.
    First,
    /// Linear reconstruction in the donor.
    Second,
}

/// Transport of the elements of a domain, and its work arrays.
#[derive(Clone, Debug)]
pub(super) struct ElementTransport {
    order: TransportOrder,
    /// Volumes before the motion and, from the rings that inner edges sweep, after it.
    volumes: [Vec<f64>; 2],
    centres: Vec<[f64; 2]>,
    /// Inverse of the sums of squared distances to the neighbours: rr, zz, rz.
    distances: Vec<[f64; 3]>,
    gradient: Vec<[f64; 2]>,
    /// Volumes, then masses, that move through each inner edge to its left.
    rings: Vec<WeightFlux>,
    masses: Vec<WeightFlux>,
    /// Centres of the swept rings.
    middles: Vec<[f64; 2]>,
    density: Vec<f64>,
    /// Masses after the motion.
    pub mass: Vec<f64>,
    work: TransportWork,
}

/// Relative increase of the sums of squares, which keeps them regular for neighbours in one line.
const REGULAR: f64 = 1e-9;

impl ElementTransport {
    pub fn new(domain: &DomainTopology, order: TransportOrder) -> ElementTransport {
        let (cells, edges) = (domain.corners.len(), domain.edges.len());
        let fluxes = || domain.edges.iter().map(|e| WeightFlux { cells: [e.left, e.right], weight: 0.0 }).collect();
        let list = || vec![0.0; cells];
        ElementTransport {
            order,
            volumes: [list(), list()],
            centres: vec![[0.0; 2]; cells],
            distances: vec![[0.0; 3]; cells],
            gradient: vec![[0.0; 2]; cells],
            rings: fluxes(),
            masses: fluxes(),
            middles: vec![[0.0; 2]; edges],
            density: list(),
            mass: list(),
            work: TransportWork::new(cells, edges),
        }
    }

    pub fn bytes(&self) -> usize {
        let fluxes = heap_bytes(&self.rings) + heap_bytes(&self.masses) + heap_bytes(&self.middles);
        let cells = heap_bytes(&self.centres) + heap_bytes(&self.distances) + heap_bytes(&self.gradient);
        fluxes + cells + 8 * 4 * self.mass.capacity() + self.work.bytes()
    }

    /// Measures the rings that edges sweep from the places `before` to `after`. Returns the largest share of its volume
    /// that an element loses.
    pub fn measure(&mut self, domain: &DomainTopology, before: &[[f64; 2]], after: &[[f64; 2]]) -> f64 {
        let at = |n: u32| [before[n as usize], after[n as usize]];
        for (e, corners) in domain.corners.iter().enumerate() {
            let corners = corners.inline_map(|n| before[n as usize]);
            (self.volumes[0][e], self.centres[e]) = (quad::volume(corners), centre(corners));
        }
        let (lost, [volumes, after]) = (&mut self.density, &mut self.volumes);
        lost.fill(0.0);
        after.copy_from_slice(volumes);
        for ((edge, ring), middle) in domain.edges.iter().zip(&mut self.rings).zip(&mut self.middles) {
            let ([a0, a1], [b0, b1]) = (at(edge.a), at(edge.b));
            (ring.weight, *middle) = swept([a0, b0], [a1, b1]);
            lost[ring.donor()] += ring.weight.abs();
            after[edge.left as usize] += ring.weight;
            after[edge.right as usize] -= ring.weight;
        }
        let shares = lost.iter().zip(&*volumes).map(|(lost, volume)| lost / volume);
        shares.fold(0.0, f64::max)
    }

    /// Moves masses, given before the motion, through the measured rings. The new masses are in `self.mass`.
    pub fn move_masses(&mut self, domain: &DomainTopology, mass: &[f64]) {
        self.measure_distances(domain);
        for ((density, mass), volume) in self.density.iter_mut().zip(mass).zip(&self.volumes[0]) {
            *density = mass / volume;
        }
        find_gradients(domain, &self.centres, &self.distances, &self.density, &mut self.gradient, self.order);
        let (density, gradient) = (&self.density, &self.gradient);
        let value = reconstruction(&self.rings, density, gradient, [&self.centres, &self.middles]);
        self.work.transport(density, &self.rings, &self.volumes[1], value);
        self.mass.copy_from_slice(mass);
        for ((flux, ring), correction) in self.masses.iter_mut().zip(&self.rings).zip(&self.work.correction) {
            flux.weight = ring.weight * density[ring.donor()] + correction;
            self.mass[flux.cells[0] as usize] += flux.weight;
            self.mass[flux.cells[1] as usize] -= flux.weight;
        }
    }

    /// Moves a variable, per mass, with the masses that [`Self::move_masses`] has moved.
    pub fn move_variable(&mut self, domain: &DomainTopology, values: &mut [f64]) {
        if values.iter().all(|value| *value == values[0]) {
            return;
        }
        find_gradients(domain, &self.centres, &self.distances, values, &mut self.gradient, self.order);
        let value = reconstruction(&self.masses, values, &self.gradient, [&self.centres, &self.middles]);
        self.work.transport(values, &self.masses, &self.mass, value);
        values.copy_from_slice(&self.work.value);
    }

    /// Returns the mass that moves through each inner edge to its left.
    pub fn mass_fluxes(&self) -> &[WeightFlux] {
        &self.masses
    }

    fn measure_distances(&mut self, domain: &DomainTopology) {
        self.distances.fill([0.0; 3]);
        for edge in &domain.edges {
            let [r, z] = distance(&self.centres, edge.left, edge.right);
            for e in [edge.left, edge.right] {
                let [rr, zz, rz] = &mut self.distances[e as usize];
                (*rr, *zz, *rz) = (*rr + r * r, *zz + z * z, *rz + r * z);
            }
        }
        for sums in &mut self.distances {
            let [rr, zz, rz] = *sums;
            let more = REGULAR * (rr + zz);
            let (rr, zz) = (rr + more, zz + more);
            let determinant = rr * zz - rz * rz;
            *sums = if determinant > 0.0 { [zz, rr, -rz].inline_map(|x| x / determinant) } else { [0.0; 3] };
        }
    }
}

fn distance(centres: &[[f64; 2]], from: u32, to: u32) -> [f64; 2] {
    let (from, to) = (centres[from as usize], centres[to as usize]);
    [to[0] - from[0], to[1] - from[1]]
}

/// Computes gradients by least squares over the neighbours.
fn find_gradients(
    domain: &DomainTopology,
    centres: &[[f64; 2]],
    distances: &[[f64; 3]],
    values: &[f64],
    gradients: &mut [[f64; 2]],
    order: TransportOrder,
) {
    gradients.fill([0.0; 2]);
    if order == TransportOrder::First {
        return;
    }
    for edge in &domain.edges {
        let ([r, z], (left, right)) =
            (distance(centres, edge.left, edge.right), (edge.left as usize, edge.right as usize));
        let step = values[right] - values[left];
        for e in [left, right] {
            gradients[e][0] += step * r;
            gradients[e][1] += step * z;
        }
    }
    for (gradient, [rr, zz, rz]) in gradients.iter_mut().zip(distances) {
        let [r, z] = *gradient;
        *gradient = [rr * r + rz * z, rz * r + zz * z];
    }
}

/// Returns the function that gives the value of the donor at the middle of each swept ring.
fn reconstruction<'a>(
    fluxes: &'a [WeightFlux],
    values: &'a [f64],
    gradient: &'a [[f64; 2]],
    [centres, middles]: [&'a [[f64; 2]]; 2],
) -> impl Fn(usize) -> f64 + 'a {
    move |i| {
        let donor = fluxes[i].donor();
        let ([r, z], [cr, cz], [along_r, along_z]) = (middles[i], centres[donor], gradient[donor]);
        values[donor] + (along_r * (r - cr) + along_z * (z - cz))
    }
}
