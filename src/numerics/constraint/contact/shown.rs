//! Contact output: pressure, shear stress, opening and slip at points; forces and areas of pairs.

use super::area::contact_area;
use super::curve::PointCarrier;
use super::stations::StationContact;
use super::system::ContactSystem;
use super::{ContactConstraint, ContactPair};
use crate::constraint::PairForces;
use crate::kernel::lanes::InlineMap;
use crate::state::dofs::Dof;
use crate::variables::{Variable, VariableComponent};

/// Forces on a surface along r and z.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SurfaceForces {
    pub(super) pressure: [f64; 2],
    pub(super) friction: [f64; 2],
}

impl ContactConstraint {
    /// Returns the forces on the own surface of a pair.
    fn forces(&self, pair: &ContactPair) -> SurfaceForces {
        let (contact, mut sum) = (&self.system, SurfaceForces::default());
        if pair.analytical.is_some() {
            add_forces_of_rows(contact, pair, &mut sum);
        } else if pair.is_active {
            add_forces_of_facets(contact, pair, &mut sum);
            add_forces_of_rows(contact, pair, &mut sum);
            if let Some(cohesion) = &self.cohesion {
                cohesion.add_forces(contact, pair, &mut sum);
            }
        }
        sum
    }

    /// Returns the value at a point of a surface; `None` if the point belongs to no contact surface.
    pub fn value_at_point(&self, carrier: PointCarrier, part: VariableComponent) -> Option<f64> {
        let (contact, cohesion) = (&self.system, self.cohesion.as_deref());
        let point = contact.surfaces.point_on(carrier)?;
        let keys = contact.surfaces.own_pairs(point).flat_map(|index| {
            let pair = &contact.pairs[index];
            let own_points = &contact.surfaces.curves[pair.secondary].points;
            let key = own_points.binary_search(&point).ok().map(|index| pair.first_key as usize + index);
            let second = key.filter(|_| contact.surfaces.has_two_keys(pair)).map(|key| key + own_points.len());
            [key, second].into_iter().flatten()
        });
        let mut sum: Option<f64> = None;
        for key in keys {
            let ([pressure, shear], bond) =
                (stresses(contact, key), cohesion.map_or([0.0; 2], |cohesion| cohesion.stresses(contact, key)));
            let value = match part.variable {
                Variable::ContactPressure => sum.unwrap_or(0.0) + pressure + bond[0],
                Variable::ContactShear => sum.unwrap_or(0.0) + shear + bond[1],
                Variable::ContactOpening => contact.keys.opening[key].min(sum.unwrap_or(f64::NAN)),
                Variable::ContactSlip => sum.unwrap_or(0.0) + contact.keys.slip[key],
                variable => match cohesion.and_then(|cohesion| cohesion.value(contact, key, variable)) {
                    Some(value) => value.max(sum.unwrap_or(0.0)),
                    None => continue,
                },
            };
            sum = Some(value);
        }
        sum
    }

    /// Returns whether contact pressed on a point of a surface in the previous increment; `None` if the point belongs to no
    /// contact surface.
    pub fn is_pressed(&self, carrier: PointCarrier) -> Option<bool> {
        let dofs = self.system.dofs.of_points[self.system.surfaces.point_on(carrier)? as usize];
        Some(
            dofs.iter()
                .any(|dof| self.system.dofs.impulses.get(*dof as usize).is_some_and(|impulse| impulse[0] != 0.0)),
        )
    }

    /// Returns the pair that has absorbed the least energy.
    pub fn lowest_energy(&self) -> Option<&ContactPair> {
        self.system.pairs.iter().min_by(|a, b| a.absorbed.total_cmp(&b.absorbed))
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
    pub fn forces_of_pair(&self, number: usize) -> Option<PairForces> {
        if let Some(stations) = self.stations_of_number(number) {
            return Some(stations.forces(&self.system.dofs));
        }
        let pair = self.pair_of_number(number)?;
        // The forces on the two surfaces are opposite.
        let sign = if pair.first { 1.0 } else { -1.0 };
        let SurfaceForces { pressure, friction } = self.forces(pair);
        let forces = [pressure, friction].inline_map(|[r, z]| [sign * r, sign * z, 0.0]);
        Some(PairForces { forces, duration: self.system.dofs.half / self.system.dofs.output_share })
    }

    /// Returns the area in contact of a pair; `None` if the pair is not in force, NaN for hard contact of a rigid body with
    /// six degrees of freedom.
    pub fn area_of_pair(&self, number: usize) -> Option<f64> {
        if let Some(stations) = self.stations_of_number(number) {
            return Some(stations.area());
        }
        self.pair_of_number(number).map(|pair| contact_area(&self.system.surfaces, pair, &self.system.keys))
    }

    fn stations_of_number(&self, number: usize) -> Option<&StationContact> {
        self.stations.iter().find(|stations| stations.pair.number == number)
    }

    /// Returns the pair with a number among the pairs of all steps.
    fn pair_of_number(&self, number: usize) -> Option<&ContactPair> {
        self.system.surfaces.first_of_number(number).map(|index| &self.system.pairs[index])
    }
}

/// Adds the forces on the own surface of a pair from pressures on its facets.
fn add_forces_of_facets(contact: &ContactSystem, pair: &ContactPair, sum: &mut SurfaceForces) {
    let secondary = &contact.surfaces.curves[pair.secondary];
    for &k in &pair.search.close.facets {
        let (facet, gaps) = (&secondary.facets[k as usize], &pair.facet_gaps[k as usize]);
        if gaps.area == [0.0; 2] {
            continue;
        }
        for (end, point) in facet.iter().enumerate() {
            let Ok(index) = secondary.points.binary_search(point) else { continue };
            let [pressure, shear] = stresses(contact, pair.first_key as usize + index);
            if pressure == 0.0 && shear == 0.0 {
                continue;
            }
            for share in contact.measured.facets.shares_of(gaps).iter().filter(|s| facet.contains(&s.point)) {
                let derivatives = share.of[end];
                sum.pressure[0] += pressure * derivatives[0];
                sum.pressure[1] += pressure * derivatives[1];
                sum.friction[0] -= shear * derivatives[1];
                sum.friction[1] += shear * derivatives[0];
            }
        }
    }
}

/// Adds the forces on the own surface of a pair from its points in front of an analytical surface, or from single points of
/// the other surface.
fn add_forces_of_rows(contact: &ContactSystem, pair: &ContactPair, sum: &mut SurfaceForces) {
    let ContactSystem { surfaces, dofs, measured, .. } = contact;
    let (secondary, other) = surfaces.sides(pair);
    let (is_analytical, own_points) = (pair.analytical.is_some(), secondary.points.len());
    let mut keys = pair.keys();
    keys.start += if is_analytical { 0 } else { own_points };
    for row in measured.rows.rows.iter().filter(|row| keys.contains(&(row.key as usize)) && row.acts()) {
        let [force, shear] = stresses(contact, row.key as usize);
        let index = row.key as usize - keys.start;
        let point = if is_analytical { secondary.points[index % own_points] } else { other.points[index] };
        let point_dofs = dofs.of_points[point as usize];
        for term in measured.rows.terms_of(row).iter().filter(|t| point_dofs.contains(&t.dof) == is_analytical) {
            let axis = if let Dof::Node(_, axis) = dofs.list[term.dof as usize].0 { axis } else { 1 };
            sum.pressure[axis] += force * term.normal;
            sum.friction[axis] += shear * term.slip;
        }
    }
}

/// Returns pressure and shear stress of a key, damping included.
fn stresses(contact: &ContactSystem, key: usize) -> [f64; 2] {
    let [pressure, shear] = contact.keys.pressures[key];
    let damping = contact.keys.slip_damping.stress(key);
    [pressure, shear + damping].inline_map(|stress| stress * contact.dofs.output_share)
}
