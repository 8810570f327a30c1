//! Contact output: pressure, shear stress, opening and slip at points; forces and areas of pairs.

use super::curve::PointCarrier;
use super::stations::StationContact;
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
    /// Returns pressure and shear stress of a key, damping included.
    pub(super) fn stresses(&self, key: usize) -> [f64; 2] {
        let [pressure, shear] = self.keys.pressures[key];
        let damping = self.keys.slip_damping.stress(key);
        [pressure, shear + damping].inline_map(|stress| stress * self.dofs.output_share)
    }

    /// Returns the forces on the own surface of a pair.
    fn forces(&self, pair: &ContactPair) -> SurfaceForces {
        let (secondary, mut sum) = (&self.surfaces.curves[pair.secondary], SurfaceForces::default());
        if pair.analytical.is_some() {
            self.add_forces_of_rows(pair, &mut sum);
            return sum;
        }
        if !pair.is_active {
            return sum;
        }
        for &k in &pair.search.close.facets {
            let (facet, gaps) = (&secondary.facets[k as usize], &pair.facet_gaps[k as usize]);
            if gaps.area == [0.0; 2] {
                continue;
            }
            for (end, point) in facet.iter().enumerate() {
                let Ok(index) = secondary.points.binary_search(point) else { continue };
                let [pressure, shear] = self.stresses(pair.first_key as usize + index);
                if pressure == 0.0 && shear == 0.0 {
                    continue;
                }
                for share in self.measured.facets.shares_of(gaps).iter().filter(|s| facet.contains(&s.point)) {
                    let derivatives = share.of[end];
                    sum.pressure[0] += pressure * derivatives[0];
                    sum.pressure[1] += pressure * derivatives[1];
                    sum.friction[0] -= shear * derivatives[1];
                    sum.friction[1] += shear * derivatives[0];
                }
            }
        }
        self.add_forces_of_points(pair, &mut sum);
        self.add_forces_of_bonds(pair, &mut sum);
        sum
    }

    /// Adds the forces on the own surface of a pair from single points of the other surface.
    fn add_forces_of_points(&self, pair: &ContactPair, sum: &mut SurfaceForces) {
        let ContactConstraint { surfaces, dofs, measured, .. } = self;
        let first = pair.first_key as usize + surfaces.curves[pair.secondary].points.len();
        let keys = first..pair.keys().end;
        let (_, other) = surfaces.sides(pair);
        for row in measured.rows.rows.iter().filter(|row| keys.contains(&(row.key as usize)) && row.acts()) {
            let [force, shear] = self.stresses(row.key as usize);
            let point = other.points[row.key as usize - first];
            let point_dofs = dofs.of_points[point as usize];
            for term in measured.rows.terms_of(row).iter().filter(|t| !point_dofs.contains(&t.dof)) {
                let axis = if let Dof::Node(_, axis) = dofs.list[term.dof as usize].0 { axis } else { 1 };
                sum.pressure[axis] += force * term.normal;
                sum.friction[axis] += shear * term.slip;
            }
        }
    }

    /// Returns the value at a point of a surface; `None` if the point belongs to no contact surface.
    pub fn value_at_point(&self, carrier: PointCarrier, part: VariableComponent) -> Option<f64> {
        let point = self.surfaces.point_on(carrier)?;
        let keys = self.surfaces.own_pairs(point).flat_map(|index| {
            let pair = &self.pairs[index];
            let own_points = &self.surfaces.curves[pair.secondary].points;
            let key = own_points.binary_search(&point).ok().map(|index| pair.first_key as usize + index);
            let second = key.filter(|_| self.surfaces.has_two_keys(pair)).map(|key| key + own_points.len());
            [key, second].into_iter().flatten()
        });
        let mut sum: Option<f64> = None;
        for key in keys {
            let ([pressure, shear], bond) = (self.stresses(key), self.bond_stresses(key));
            let value = match part.variable {
                Variable::ContactPressure => sum.unwrap_or(0.0) + pressure + bond[0],
                Variable::ContactShear => sum.unwrap_or(0.0) + shear + bond[1],
                Variable::ContactOpening => self.keys.opening[key].min(sum.unwrap_or(f64::NAN)),
                Variable::ContactSlip => sum.unwrap_or(0.0) + self.keys.slip[key],
                variable => match self.bond_value(key, variable) {
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
        let dofs = self.dofs.of_points[self.surfaces.point_on(carrier)? as usize];
        Some(dofs.iter().any(|dof| self.dofs.impulses.get(*dof as usize).is_some_and(|impulse| impulse[0] != 0.0)))
    }

    /// Returns the pair that has absorbed the least energy.
    pub fn lowest_energy(&self) -> Option<&ContactPair> {
        self.pairs.iter().min_by(|a, b| a.absorbed.total_cmp(&b.absorbed))
    }

    /// Returns the forces of a contact pair over the previous increment; `None` if the pair is not in force.
    pub fn forces_of_pair(&self, number: usize) -> Option<PairForces> {
        if let Some(stations) = self.stations_of_number(number) {
            return Some(stations.forces(&self.dofs));
        }
        let pair = self.pair_of_number(number)?;
        // The forces on the two surfaces are opposite.
        let sign = if pair.first { 1.0 } else { -1.0 };
        let SurfaceForces { pressure, friction } = self.forces(pair);
        let forces = [pressure, friction].inline_map(|[r, z]| [sign * r, sign * z, 0.0]);
        Some(PairForces { forces, duration: self.dofs.half / self.dofs.output_share })
    }

    /// Returns the area in contact of a pair; `None` if the pair is not in force, NaN for hard contact of a rigid body with
    /// six degrees of freedom.
    pub fn area_of_pair(&self, number: usize) -> Option<f64> {
        if let Some(stations) = self.stations_of_number(number) {
            return Some(stations.area());
        }
        self.pair_of_number(number).map(|pair| self.contact_area(pair))
    }

    fn stations_of_number(&self, number: usize) -> Option<&StationContact> {
        self.stations.iter().find(|stations| stations.pair.number == number)
    }

    /// Returns the pair with a number among the pairs of all steps.
    fn pair_of_number(&self, number: usize) -> Option<&ContactPair> {
        self.surfaces.first_of_number(number).map(|index| &self.pairs[index])
    }
}
