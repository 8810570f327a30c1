//! Transfer of masses, element variables and velocities to a new mesh: linear fields in the old elements, limited to the
//! range of their neighbours, are integrated over the common parts of old and new elements.

use super::BodyMesh;
use super::interpolation::interpolated;
use super::overlap::CommonPart;
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::kernel::quad;
use crate::kernel::shape::middle;

/// Masses and velocities of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyMotion {
    /// Masses of the elements at their corners.
    pub masses: Vec<[f64; 4]>,
    /// Velocities of the nodes.
    pub velocities: Vec<[f64; 2]>,
}

impl BodyMotion {
    /// Returns the sum of the masses at each node.
    pub fn node_masses(&self, mesh: &BodyMesh) -> Vec<f64> {
        let mut sums = vec![0.0; mesh.points.len()];
        for (quad, masses) in mesh.quads.iter().zip(&self.masses) {
            quad.iter().zip(masses).for_each(|(n, mass)| sums[*n as usize] += mass);
        }
        sums
    }

    /// Returns the momentum along r and z.
    pub fn momentum(&self, mesh: &BodyMesh) -> [f64; 2] {
        let nodes = self.node_masses(mesh).into_iter().zip(&self.velocities);
        nodes.fold([0.0; 2], |[r, z], (mass, v)| [r + mass * v[0], z + mass * v[1]])
    }

    /// Returns the kinetic energy.
    pub fn kinetic(&self, mesh: &BodyMesh) -> f64 {
        let nodes = self.node_masses(mesh).into_iter().zip(&self.velocities);
        nodes.map(|(mass, v)| 0.5 * mass * (v[0] * v[0] + v[1] * v[1])).sum()
    }
}

/// Old and new mesh of a body, and their common parts.
pub struct MeshTransfer<'a> {
    old: &'a BodyMesh,
    new: &'a BodyMesh,
    parts: Vec<CommonPart>,
    /// First part of each old element, and the number of all parts.
    first: Vec<usize>,
    /// Masses of the old elements, and of the parts.
    mass: Vec<f64>,
    part_mass: Vec<f64>,
    /// Centres of mass of the old elements.
    centres: Vec<[f64; 2]>,
    /// Elements with a common side.
    beside: Vec<Vec<u32>>,
}

impl<'a> MeshTransfer<'a> {
    /// Prepares a transfer from the masses of the old elements.
    pub fn new([old, new]: [&'a BodyMesh; 2], parts: Vec<CommonPart>, masses: &[[f64; 4]]) -> MeshTransfer<'a> {
        let mass: Vec<f64> = masses.iter().map(|m| (m[0] + m[1]) + (m[2] + m[3])).collect();
        let first: Vec<usize> =
            (0..=old.quads.len()).map(|e| parts.partition_point(|part| (part.old as usize) < e)).collect();
        let part_mass: Vec<f64> = parts.iter().map(|part| part.share * mass[part.old as usize]).collect();
        let centre = |e: usize| {
            let own_parts = &parts[first[e]..first[e + 1]];
            own_parts
                .iter()
                .fold([0.0; 2], |sum, part| [0, 1].inline_map(|i: usize| sum[i] + part.share * part.centre[i]))
        };
        let centres = (0..old.quads.len()).map(centre).collect();
        MeshTransfer { old, new, part_mass, centres, beside: neighbours(old), parts, first, mass }
    }

    /// Returns the transfer with other masses of the old elements.
    #[must_use]
    pub fn with_masses(self, masses: &[[f64; 4]]) -> MeshTransfer<'a> {
        MeshTransfer::new([self.old, self.new], self.parts, masses)
    }

    /// Returns the old mesh.
    pub fn old_mesh(&self) -> &'a BodyMesh {
        self.old
    }

    /// Returns the new mesh.
    pub fn new_mesh(&self) -> &'a BodyMesh {
        self.new
    }

    /// Returns the means of values of the old elements over the parts of each new element, weighted with their masses.
    pub fn means<const N: usize>(&self, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let (mut sums, mut total) = (vec![[0.0; N]; self.new.quads.len()], vec![0.0; self.new.quads.len()]);
        for (part, mass) in self.parts.iter().zip(&self.part_mass) {
            let value = &values[part.old as usize];
            sums[part.new as usize].iter_mut().zip(value).for_each(|(sum, value)| *sum += mass * value);
            total[part.new as usize] += mass;
        }
        sums.iter_mut().zip(total).for_each(|(sum, mass)| sum.iter_mut().for_each(|x| *x /= mass));
        sums
    }

    /// Returns the sums over the parts of each new element of a quantity that the old elements contain.
    pub fn content(&self, of_old: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.new.quads.len()];
        for part in &self.parts {
            sums[part.new as usize] += part.share * of_old[part.old as usize];
        }
        sums
    }

    /// Returns the masses of the new elements at their corners.
    pub fn masses(&self) -> Vec<[f64; 4]> {
        let mut sums = vec![0.0; self.new.quads.len()];
        for (part, mass) in self.parts.iter().zip(&self.part_mass) {
            sums[part.new as usize] += mass;
        }
        let corners = |(quad, mass): (&[u32; 4], f64)| {
            let shares = quad::corner_masses(self.new.corners(quad), 1.0);
            let sum = (shares[0] + shares[1]) + (shares[2] + shares[3]);
            shares.inline_map(|share| mass * share / sum)
        };
        self.new.quads.iter().zip(sums).map(corners).collect()
    }

    /// Returns the values per mass of the new elements; those of an element without mass are zero. Equation (18.10).
    pub fn values(&self, values: &[Pack]) -> Vec<Pack> {
        let mut sums = vec![Pack::default(); self.new.quads.len()];
        let mut total = vec![0.0; sums.len()];
        for (e, own) in values.iter().enumerate() {
            let gradient = self.gradient(e, values);
            for at in self.first[e]..self.first[e + 1] {
                let (part, mass) = (&self.parts[at], self.part_mass[at]);
                let [r, z] = [0, 1].inline_map(|i: usize| part.centre[i] - self.centres[e][i]);
                let sum = &mut sums[part.new as usize].0;
                for l in 0..PACK {
                    sum[l] += mass * (own.0[l] + (gradient[0][l] * r + gradient[1][l] * z));
                }
                total[part.new as usize] += mass;
            }
        }
        for (sum, mass) in sums.iter_mut().zip(total).filter(|(_, mass)| *mass > 0.0) {
            sum.0.iter_mut().for_each(|x| *x /= mass);
        }
        sums
    }

    /// Returns the gradients of an element by least squares over its neighbours, multiplied by the largest share up to 1
    /// for which the field in all parts stays in the range of the element and its neighbours (Barth and Jespersen 1989).
    fn gradient(&self, e: usize, values: &[Pack]) -> [[f64; PACK]; 2] {
        let own_values = &values[e].0;
        let (mut low, mut high, mut sums) = (*own_values, *own_values, [[0.0; PACK]; 2]);
        let [mut rr, mut zz, mut rz] = [0.0; 3];
        for other in self.beside[e].iter().map(|other| *other as usize) {
            let [r, z] = [0, 1].inline_map(|i: usize| self.centres[other][i] - self.centres[e][i]);
            (rr, zz, rz) = (rr + r * r, zz + z * z, rz + r * z);
            for l in 0..PACK {
                let value = values[other].0[l];
                (low[l], high[l]) = (low[l].min(value), high[l].max(value));
                let difference = value - own_values[l];
                (sums[0][l], sums[1][l]) = (sums[0][l] + r * difference, sums[1][l] + z * difference);
            }
        }
        let mut gradient = [[0.0; PACK]; 2];
        for l in 0..PACK {
            let along = fitted([rr, zz, rz], [sums[0][l], sums[1][l]]);
            let share = self.share(e, along, [low[l] - own_values[l], high[l] - own_values[l]]);
            (gradient[0][l], gradient[1][l]) = (share * along[0], share * along[1]);
        }
        gradient
    }

    /// Returns the largest share of a gradient that keeps the changes in all parts of an element within bounds.
    fn share(&self, e: usize, along: [f64; 2], [low, high]: [f64; 2]) -> f64 {
        let mut share: f64 = 1.0;
        for part in &self.parts[self.first[e]..self.first[e + 1]] {
            let change =
                along[0] * (part.centre[0] - self.centres[e][0]) + along[1] * (part.centre[1] - self.centres[e][1]);
            if change > high {
                share = share.min(high / change);
            } else if change < low {
                share = share.min(low / change);
            }
        }
        share
    }

    /// Returns the velocities of the new nodes: those of the old mesh at their places, corrected in each new element, after the
    /// first ones of the number `unchanged`, so that it has the momentum of its parts. Components that are `held` are not
    /// corrected. Equation (18.11).
    pub fn velocities(
        &self,
        motion: &BodyMotion,
        (masses, unchanged): (&[[f64; 4]], usize),
        held: &[[bool; 2]],
    ) -> Vec<[f64; 2]> {
        let momentum = self.momentum_of_elements(motion);
        let mut velocities = interpolated(self.old, &motion.velocities, &self.new.points);
        let mut node_mass = vec![0.0; velocities.len()];
        let mut added = vec![[0.0; 2]; velocities.len()];
        for (e, ((quad, masses), momentum)) in self.new.quads.iter().zip(masses).zip(&momentum).enumerate() {
            for axis in (0..2).filter(|_| e >= unchanged) {
                let corners = || quad.iter().zip(masses);
                let own_momentum: f64 = corners().map(|(n, mass)| mass * velocities[*n as usize][axis]).sum();
                let free = |n: &u32| !held[*n as usize][axis];
                let able: f64 = corners().filter(|c| free(c.0)).map(|c| c.1).sum();
                for (n, mass) in corners().filter(|c| free(c.0)) {
                    added[*n as usize][axis] += mass * (momentum[axis] - own_momentum) / able;
                }
            }
            quad.iter().zip(masses).for_each(|(n, mass)| node_mass[*n as usize] += mass);
        }
        for ((velocity, added), mass) in velocities.iter_mut().zip(added).zip(node_mass) {
            *velocity = [0, 1].inline_map(|i: usize| velocity[i] + added[i] / mass);
        }
        velocities
    }

    /// Returns the momentum of the new elements, from fields of the velocity that are linear in each old element.
    fn momentum_of_elements(&self, motion: &BodyMotion) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0; 2]; self.new.quads.len()];
        for (e, quad) in self.old.quads.iter().enumerate() {
            let (places, masses) = (self.old.corners(quad), &motion.masses[e]);
            let corners = quad.inline_map(|n| motion.velocities[n as usize]);
            for axis in 0..2 {
                let component = corners.inline_map(|v| v[axis]);
                let mean = (0..4).map(|i| masses[i] * component[i]).sum::<f64>() / self.mass[e];
                let along = slope(places, component);
                let bounds =
                    [component.iter().copied().fold(mean, f64::min), component.iter().copied().fold(mean, f64::max)];
                let share = self.share(e, along, bounds.inline_map(|bound| bound - mean));
                for k in self.first[e]..self.first[e + 1] {
                    let part = &self.parts[k];
                    let [r, z] = [0, 1].inline_map(|i: usize| part.centre[i] - self.centres[e][i]);
                    sums[part.new as usize][axis] += self.part_mass[k] * (mean + share * (along[0] * r + along[1] * z));
                }
            }
        }
        sums
    }
}

/// Returns the gradient of a linear field by least squares over the corners of an element.
fn slope(at: [[f64; 2]; 4], of: [f64; 4]) -> [f64; 2] {
    let (middle, value) = (middle(at), 0.25 * ((of[0] + of[1]) + (of[2] + of[3])));
    fitted_gradient(at.iter().zip(of).map(|(place, of)| ([place[0] - middle[0], place[1] - middle[1]], of - value)))
}

/// Returns the gradient by least squares over distances and differences of a value.
pub(super) fn fitted_gradient(differences: impl Iterator<Item = ([f64; 2], f64)>) -> [f64; 2] {
    let [mut rr, mut zz, mut rz, mut first, mut second] = [0.0; 5];
    for ([r, z], d) in differences {
        (rr, zz, rz, first, second) = (rr + r * r, zz + z * z, rz + r * z, first + r * d, second + z * d);
    }
    fitted([rr, zz, rz], [first, second])
}

/// Returns the gradient that solves the normal equations of least squares; zero if all places are on one line.
fn fitted([rr, zz, rz]: [f64; 3], [r, z]: [f64; 2]) -> [f64; 2] {
    let determinant = rr * zz - rz * rz;
    if determinant <= 1e-9 * (rr + zz) * (rr + zz) {
        return [0.0; 2];
    }
    [(zz * r - rz * z) / determinant, (rr * z - rz * r) / determinant]
}

/// Returns the elements with a common side.
pub(super) fn neighbours(mesh: &BodyMesh) -> Vec<Vec<u32>> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::new();
    for (e, quad) in (0..).zip(&mesh.quads) {
        for i in 0..4 {
            let (a, b) = (quad[i], quad[(i + 1) % 4]);
            if a != b {
                sides.push(([a.min(b), a.max(b)], e));
            }
        }
    }
    sides.sort_unstable();
    let mut beside = vec![Vec::new(); mesh.quads.len()];
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        beside[pair[0].1 as usize].push(pair[1].1);
        beside[pair[1].1 as usize].push(pair[0].1);
    }
    beside
}

#[cfg(test)]
mod tests {
    use super::{BodyMotion, MeshTransfer, slope};
    use crate::kernel::lanes::{PACK, Pack};
    use crate::kernel::quad;
    use crate::remesh::BodyMesh;
    use crate::remesh::mesher::{OutlineRules, new_mesh};
    use crate::remesh::overlap::{common_parts, ring};

    #[test]
    fn slope_of_a_linear_field_is_exact() {
        let corners = [[1.0, 2.0], [3.0, 2.5], [2.8, 4.0], [0.9, 3.5]];
        let [along_r, along_z] = slope(corners, corners.map(|[r, z]| 2.0 * r - 3.0 * z + 5.0));
        assert!((along_r - 2.0).abs() < 1e-13 && (along_z + 3.0).abs() < 1e-13, "{along_r} {along_z}");
    }

    /// Returns a block on the axis with distorted elements, and the mesh that replaces it.
    fn meshes(n: u32) -> [BodyMesh; 2] {
        let mut mesh = BodyMesh::default();
        for j in 0..=2 * n {
            for i in 0..=n {
                let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let bend = x * (1.0 - x) * y * (2.0 - y);
                mesh.points.push([x + 0.6 * bend, y - 0.8 * bend]);
            }
        }
        for j in 0..2 * n {
            for i in 0..n {
                let a = i + j * (n + 1);
                mesh.quads.push([a, a + 1, a + n + 2, a + n + 1]);
                mesh.sizes.push(1.0 / f64::from(n));
            }
        }
        let kept_nodes = vec![false; mesh.points.len()];
        let rules = OutlineRules { kept: &kept_nodes, fixed: &[], place: &|_, _| None };
        let new = new_mesh(&mesh, &rules, None).expect("a mesh");
        [mesh, new.mesh]
    }

    fn field([r, z]: [f64; 2]) -> f64 {
        2.0 + (1.7 * r).sin() * (0.9 * z).cos()
    }

    fn velocity([r, z]: [f64; 2]) -> [f64; 2] {
        [r * (1.0 + 0.3 * z), 3.0 - 0.7 * z + 0.2 * r * r]
    }

    /// Returns mean values of the field per mass, masses and velocities of a mesh with the density 5.
    fn state(mesh: &BodyMesh) -> (Vec<Pack>, BodyMotion) {
        let corners = |quad: &[u32; 4]| quad.map(|n| mesh.points[n as usize]);
        let value = |quad: &[u32; 4]| Pack([field(ring(&corners(quad)).1); PACK]);
        let masses = |quad: &[u32; 4]| quad::corner_masses(corners(quad), 5.0);
        let motion = BodyMotion {
            masses: mesh.quads.iter().map(masses).collect(),
            velocities: mesh.points.iter().map(|p| velocity(*p)).collect(),
        };
        (mesh.quads.iter().map(value).collect(), motion)
    }

    /// Mass, momentum and the sum of mass and value are conserved to rounding; errors of values and velocities fall with
    /// the square of the element size; no value leaves the range of the old ones.
    #[test]
    fn transfer_conserves_and_is_of_second_order() {
        let mut errors = Vec::new();
        for n in [8, 16, 32] {
            let [old, new] = meshes(n);
            let (values, motion) = state(&old);
            let transfer = MeshTransfer::new([&old, &new], common_parts(&old, &new, &[]), &motion.masses);
            let masses = transfer.masses();
            let held_axes: Vec<[bool; 2]> = new.points.iter().map(|p| [p[0] == 0.0, false]).collect();
            let velocities = transfer.velocities(&motion, (&masses, 0), &held_axes);
            let moved = transfer.values(&values);
            let whole = |m: &[f64; 4]| m.iter().sum::<f64>();
            let sum = |masses: &[[f64; 4]], values: &[Pack]| {
                masses.iter().zip(values).map(|(m, v)| whole(m) * v.0[0]).sum::<f64>()
            };
            let mass = |masses: &[[f64; 4]]| masses.iter().map(whole).sum::<f64>();
            assert!((mass(&masses) / mass(&motion.masses) - 1.0).abs() < 1e-13);
            assert!((sum(&masses, &moved) / sum(&motion.masses, &values) - 1.0).abs() < 1e-12);
            let arrived = BodyMotion { masses, velocities };
            let (momentum_before, after) = (motion.momentum(&old), arrived.momentum(&new));
            for axis in 0..2 {
                assert!((after[axis] / momentum_before[axis] - 1.0).abs() < 1e-12, "{momentum_before:?} {after:?}");
            }
            let kinetic = [motion.kinetic(&old), arrived.kinetic(&new)];
            let (mut error, mut fastest) = (0.0, 0.0);
            for (quad, (value, m)) in new.quads.iter().zip(moved.iter().zip(&arrived.masses)) {
                let exact = field(ring(&quad.map(|k| new.points[k as usize])).1);
                error += whole(m) * (value.0[0] - exact).abs();
                assert!((1.0..3.0).contains(&value.0[0]));
            }
            for ((place, v), m) in new.points.iter().zip(&arrived.velocities).zip(arrived.node_masses(&new)) {
                let exact = velocity(*place);
                fastest += m * (v[0] - exact[0]).hypot(v[1] - exact[1]);
            }
            let per = mass(&arrived.masses);
            errors.push([error / per, fastest / per, (kinetic[1] / kinetic[0] - 1.0).abs()]);
        }
        let order = |i: usize| [0, 1].map(|k: usize| (errors[k][i] / errors[k + 1][i]).log2());
        assert!(order(0).iter().sum::<f64>() > 3.4, "{errors:?}");
        assert!(order(1).iter().sum::<f64>() > 3.4, "{errors:?}");
        assert!(errors[2][2] < 1e-4, "{errors:?}");
    }
}
