//! Contact output: pressure, shear stress, opening and slip at points; forces and areas of pairs.

use super::curve::{PointCarrier, SurfacePoint};
use super::mesh_continuation::KeyPlace;
use super::{ContactConstraint, ContactPair};
use crate::constraint::PairForces;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::Persist;
use crate::state::dofs::{Dof, Dofs};
use crate::variables::{Variable, VariableComponent};

/// Values kept for output only.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: opening, slip; derived: by_node, on_bodies)]
pub(super) struct ContactOutput {
    /// Gap of each key; NaN if no surface is near.
    pub(super) opening: Vec<f64>,
    /// Accumulated slip of each key while in contact.
    slip: Vec<f64>,
    /// Nodes and their points, ascending by node.
    by_node: Vec<(usize, u32)>,
    on_bodies: Vec<(PointCarrier, u32)>,
}

impl ContactOutput {
    pub(super) fn new(keys: usize, points: &[SurfacePoint]) -> ContactOutput {
        let mut shown =
            ContactOutput { opening: vec![f64::NAN; keys], slip: vec![0.0; keys], ..ContactOutput::default() };
        for (index, point) in points.iter().enumerate() {
            match point.carrier {
                PointCarrier::Node(node) => shown.by_node.push((node, index as u32)),
                carrier => shown.on_bodies.push((carrier, index as u32)),
            }
        }
        shown.by_node.sort_unstable();
        shown
    }

    pub(super) fn clear(&mut self) {
        self.opening.fill(f64::NAN);
    }

    /// Takes the output of a key from the previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &ContactOutput, place: KeyPlace) {
        self.opening[key] = place.value(|other| previous.opening[other]);
        self.slip[key] = place.value(|other| previous.slip[other]);
    }

    /// Returns the accumulated slip of the keys.
    pub(super) fn slip_mut(&mut self) -> &mut [f64] {
        &mut self.slip
    }

    fn point(&self, carrier: PointCarrier) -> Option<u32> {
        match carrier {
            PointCarrier::Node(node) => {
                self.by_node.binary_search_by_key(&node, |p| p.0).ok().map(|at| self.by_node[at].1)
            }
            carrier => self.on_bodies.iter().find(|p| p.0 == carrier).map(|p| p.1),
        }
    }

    /// Returns the points of an element's nodes; `None` if one has no contact.
    pub(super) fn points(&self, boundary: &ElementNodes) -> Option<ElementNodes> {
        let mut points = *boundary;
        for point in points.iter_mut() {
            *point = self.point(PointCarrier::Node(*point as usize))?;
        }
        Some(points)
    }
}

impl ContactConstraint {
    /// Stores the gaps at the start of the increment.
    pub(super) fn show_openings(&mut self) {
        let ContactConstraint { rows, shown, .. } = self;
        for row in rows.rows.iter().filter(|row| row.closest_point.is_none()) {
            shown.opening[row.key as usize] = row.gap / row.area;
        }
    }

    /// Adds the slip of an increment of length `dt`.
    pub(super) fn show(&mut self, dt: f64) {
        let ContactConstraint { rows, motion, shown, .. } = self;
        for row in rows.rows.iter().filter(|row| row.normal_impulse > 0.0) {
            shown.slip[row.key as usize] += dt * motion.slip(rows.terms_of(row)) / row.area;
        }
    }

    /// Returns pressure and shear stress of a key, damping included.
    pub(super) fn stresses(&self, key: usize) -> [f64; 2] {
        let [pressure, shear] = self.pressures[key];
        [pressure, shear + self.slip_damping.stress(key)].inline_map(|stress| stress * self.output_share)
    }

    /// Returns the forces of pressure and of friction on the own surface of a pair, each along r and z.
    fn forces(&self, pair: &ContactPair) -> [f64; 4] {
        if pair.analytical.is_some() {
            return self.forces_of_rows(pair);
        }
        let (own, mut sum) = (&self.curves[pair.own], [0.0; 4]);
        for &k in &own.exposed {
            let (facet, seen) = (&own.facets[k as usize], &pair.facet_gaps[k as usize]);
            if seen.area == [0.0; 2] {
                continue;
            }
            for (end, point) in facet.iter().enumerate() {
                let Ok(at) = own.own.binary_search(point) else { continue };
                let [pressure, shear] = self.stresses(pair.first_key as usize + at);
                if pressure == 0.0 && shear == 0.0 {
                    continue;
                }
                for share in self.gaps.shares_of(seen).iter().filter(|s| facet.contains(&s.point)) {
                    let of = share.of[end];
                    sum[0] += pressure * of[0];
                    sum[1] += pressure * of[1];
                    sum[2] -= shear * of[1];
                    sum[3] += shear * of[0];
                }
            }
        }
        self.add_forces_of_points(pair, &mut sum);
        self.add_forces_of_bonds(pair, &mut sum);
        sum
    }

    /// Adds the forces on the own surface of a pair from single points of the other surface.
    fn add_forces_of_points(&self, pair: &ContactPair, sum: &mut [f64; 4]) {
        let own = &self.curves[pair.own].own;
        let keys = pair.first_key + own.len() as u32..pair.first_key + self.keys_of(pair);
        for row in self.rows.rows.iter().filter(|row| keys.contains(&row.key) && row.acts()) {
            let [force, shear] = self.stresses(row.key as usize);
            let point = self.curves[pair.other.unwrap_or(pair.own)].own[(row.key - keys.start) as usize];
            let of_point = self.dofs_of[point as usize];
            for term in self.rows.terms_of(row).iter().filter(|t| !of_point.contains(&t.dof)) {
                let axis = if let Dof::Node(_, axis) = self.dofs[term.dof as usize].0 { axis } else { 1 };
                sum[axis] += force * term.normal;
                sum[2 + axis] += shear * term.slip;
            }
        }
    }
}

impl ContactConstraint {
    /// Returns the value at a point of a surface; `None` if the point belongs to no contact surface.
    pub fn value_at_point(&self, carrier: PointCarrier, part: VariableComponent) -> Option<f64> {
        let point = self.shown.point(carrier)?;
        let keys = self.pairs.iter().flat_map(|pair| {
            let own = &self.curves[pair.own].own;
            let at = own.binary_search(&point).ok().map(|at| pair.first_key as usize + at);
            // In front of re-entrant corners of analytical surfaces a point has two keys.
            let twice = pair.analytical.is_some() && self.keys_of(pair) as usize > own.len();
            [at, at.filter(|_| twice).map(|at| at + own.len())].into_iter().flatten()
        });
        let mut found: Option<f64> = None;
        for key in keys {
            let ([pressure, shear], bond) = (self.stresses(key), self.bond_stresses(key));
            let value = match part.variable {
                Variable::ContactPressure => found.unwrap_or(0.0) + pressure + bond[0],
                Variable::ContactShear => found.unwrap_or(0.0) + shear + bond[1],
                Variable::ContactOpening => self.shown.opening[key].min(found.unwrap_or(f64::NAN)),
                Variable::ContactSlip => found.unwrap_or(0.0) + self.shown.slip[key],
                variable => match self.bond_value(key, variable) {
                    Some(value) => value.max(found.unwrap_or(0.0)),
                    None => continue,
                },
            };
            found = Some(value);
        }
        found
    }

    /// Returns whether contact pressed on a point of a surface in the previous increment; `None` if the point belongs to no
    /// contact surface.
    pub fn is_pressed(&self, carrier: PointCarrier) -> Option<bool> {
        let dofs = self.dofs_of[self.shown.point(carrier)? as usize];
        Some(dofs.iter().any(|dof| self.impulses.get(*dof as usize).is_some_and(|impulse| impulse[0] != 0.0)))
    }

    /// Returns whether the contact corrects the new place of a point whose mesh moves ([`Self::follow_meshes`]), after
    /// [`Self::begin_mesh_motion`].
    pub fn keeps_gaps(&self, carrier: PointCarrier) -> bool {
        self.shown.point(carrier).is_some_and(|point| self.keeps_gaps_of(point))
    }

    /// Returns the closest place to `place` on the analytical surface that a point is in contact with, at the start of the
    /// current increment; `None` if it has no such surface, or several.
    pub fn place_on_surface(&self, carrier: PointCarrier, place: [f64; 2], dofs: &Dofs) -> Option<[f64; 2]> {
        self.place_on_analytical(self.shown.point(carrier)?, place, dofs)
    }

    /// Returns the pair that has absorbed the least energy.
    pub fn lowest_energy(&self) -> Option<&ContactPair> {
        self.pairs.iter().min_by(|a, b| a.absorbed.total_cmp(&b.absorbed))
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
    pub fn forces_of_pair(&self, number: usize) -> Option<PairForces> {
        let pair = self.pairs.iter().find(|p| p.number == number)?;
        // The forces on the two surfaces are opposite.
        let sign = if pair.first { 1.0 } else { -1.0 };
        let [n_r, n_z, t_r, t_z] = self.forces(pair);
        let forces = [[sign * n_r, sign * n_z, 0.0], [sign * t_r, sign * t_z, 0.0]];
        Some(PairForces { forces, duration: self.half / self.output_share })
    }

    /// Returns the area in contact of a pair; `None` if the pair is not in force.
    pub fn area_of_pair(&self, number: usize) -> Option<f64> {
        self.pairs.iter().find(|p| p.number == number).map(|pair| self.contact_area(pair))
    }
}
