//! Bonds of contact surfaces: points of the own curve of a pair that are bonded to the other surface by a
//! traction-separation law. [`super::bonding`] applies them.
//!
//! A bonded point is connected to its foot: the material point of the other surface that was closest to it when it was
//! bonded. The separations are the components of the vector from the foot to the point along the normal and the tangent of
//! the foot's facet, less their values at that time. The tractions act on the area of the point's hat function, and with the
//! opposite sign on both ends of the facet. They are evaluated at the start of an increment and act as impulses before those
//! of contact, so that contact also prevents overlaps of bonded surfaces; compression is left to contact. Unlike contact,
//! bonds limit the time increment.

use super::curve::FacetShape;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::traction_separation::DissipatedEnergy;
use crate::kernel::traction_separation::{InterfaceHistory, TractionSeparationLaw};
use crate::state::archive::Persist;
use crate::variables::Variable;

/// Cohesive behaviour of a contact pair.
#[derive(Clone, Debug, Default, Persist)]
#[persist(derived: pair, law, has_law_of_points, intact_law, bonds_later, bonds_again, criterion, first)]
pub struct CohesivePair {
    /// Index of the pair among those of the contact.
    pub pair: usize,
    /// Index of the traction-separation law; if each point has one, that of the first point of the own curve.
    pub law: usize,
    /// Whether each point has a law.
    pub has_law_of_points: bool,
    /// Contact law of points without damage, which have no friction: an index as [`super::ContactPair::law`].
    pub intact_law: usize,
    /// Whether points are bonded that come into contact later.
    pub bonds_later: bool,
    /// Whether points are bonded again after failure and separation.
    pub bonds_again: bool,
    /// Output variable of the initiation criterion; `None` without damage initiation.
    pub criterion: Option<Variable>,
    /// Index of the first point of the own curve among the points of all pairs; set when the contact is created.
    pub first: usize,
    /// Whether the points that are in contact at the start of the pair are known.
    pub has_begun: bool,
}

impl CohesivePair {
    /// Returns the index of the law of an own point.
    pub(super) fn law_of(&self, index: usize) -> usize {
        if self.has_law_of_points { self.law + index } else { self.law }
    }
}

/// Whether a point is bonded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Persist)]
pub(super) enum BondStatus {
    /// It has not been bonded yet.
    #[default]
    Free,
    Bonded,
    /// The bond has failed.
    Failed,
    /// The bond has failed, and the surfaces have separated since.
    Separated,
}

/// State of a point of a cohesive pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub(super) struct BondedPoint {
    pub(super) status: BondStatus,
    /// Facet of the foot, and its coordinate on the facet from 0 to 1.
    pub(super) facet: u32,
    pub(super) part: f64,
    /// Area of the hat function.
    pub(super) area: f64,
    /// Components along normal and tangent of the vector from the foot when the point was bonded.
    pub(super) reference: [f64; 2],
    pub(super) history: InterfaceHistory,
    /// Normal and shear separation.
    pub(super) separation: [f64; 2],
    pub(super) traction: [f64; 2],
}

/// The vector from a foot to its point, in the frame of the foot's facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootVector {
    normal: [f64; 2],
    tangent: [f64; 2],
    /// Length of the facet.
    length: f64,
    /// Components along normal and tangent.
    pub(super) components: [f64; 2],
}

impl FootVector {
    pub(super) fn new(shape: &FacetShape, part: f64, place: [f64; 2]) -> FootVector {
        let FacetShape { from, along, normal, length } = *shape;
        let tangent = along.inline_map(|x| x / length);
        let d = [0, 1].inline_map(|i: usize| place[i] - from[i] - part * along[i]);
        let components = [normal, tangent].inline_map(|axis| axis[0] * d[0] + axis[1] * d[1]);
        FootVector { normal, tangent, length, components }
    }

    /// Returns the forces on the point and on both ends of the facet, for normal and shear tractions times area. They are
    /// minus the gradient of the energy: as the frame turns with the facet, a couple on its ends balances the moment of
    /// tractions between distant surfaces. Equation (17.8).
    pub(super) fn forces(&self, part: f64, [normal, shear]: [f64; 2]) -> [[f64; 2]; 3] {
        let FootVector { normal: n, tangent: t, length, components: [apart, aside] } = *self;
        let couple = (shear * apart - normal * aside) / length;
        let force = [0, 1].inline_map(|i: usize| normal * n[i] + shear * t[i]);
        [
            force.inline_map(|f| -f),
            [0, 1].inline_map(|i: usize| (1.0 - part) * force[i] + couple * n[i]),
            [0, 1].inline_map(|i: usize| part * force[i] - couple * n[i]),
        ]
    }
}

/// Leverage below which turning facets are neglected in the bound of the frequency.
const SMALL_LEVERAGE: f64 = 0.01;

/// Bonds of all pairs of a contact constraint.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: pairs, points, impulses; derived: laws, sums)]
#[memory(flat: laws, pairs)]
pub(super) struct CohesiveSurfaces {
    pub(super) laws: Vec<TractionSeparationLaw>,
    /// Pairs, ascending by their index.
    pub(super) pairs: Vec<CohesivePair>,
    pub(super) points: Vec<BondedPoint>,
    /// Impulses of the bonds on degrees of freedom in the previous increment.
    pub(super) impulses: Vec<f64>,
    /// Work array: stiffness of the bonds at degrees of freedom.
    pub(super) sums: Vec<f64>,
    /// Bound of the square of the highest frequency of the bonds.
    pub(super) squared_frequency: f64,
}

impl BondedPoint {
    /// Returns the ratio of a displacement of the ends of the facet to the separation that it causes by turning the facet:
    /// the distance from the foot to the point over the length of the facet. 0 if it is small.
    pub(super) fn leverage(&self, length: f64) -> f64 {
        let distance = |i: usize| self.separation[i] + self.reference[i];
        let leverage = distance(0).abs().max(distance(1).abs()) / length;
        if leverage > SMALL_LEVERAGE { leverage } else { 0.0 }
    }

    /// Updates separations and tractions after the time `dt`; returns the dissipated energy.
    pub(super) fn separate(&mut self, law: &TractionSeparationLaw, foot: &FootVector, dt: f64) -> DissipatedEnergy {
        let separation = [0, 1].inline_map(|i: usize| foot.components[i] - self.reference[i]);
        let opened = [self.separation, separation].inline_map(opened);
        let response = law.advance(&mut self.history, opened, dt);
        (self.separation, self.traction) = (separation, response.traction);
        let mut dissipated = response.dissipated;
        if law.has_failed(&self.history) {
            // Damage with viscosity is not quite complete.
            dissipated.add(law.released(self.history.damage, opened[1]), 1.0);
            (self.status, self.traction, self.history.damage) = (BondStatus::Failed, [0.0; 2], 1.0);
        }
        dissipated.times(self.area)
    }
}

/// Returns the separations without compression, which contact resists.
pub(super) fn opened([normal, shear]: [f64; 2]) -> [f64; 2] {
    [normal.max(0.0), shear]
}

#[cfg(test)]
mod tests {
    use super::{FacetShape, FootVector};

    /// Coordinates of the point and of both ends of the facet; place of the foot.
    const PLACES: [[f64; 2]; 3] = [[1.4, 0.9], [2.0, 0.5], [1.0, 0.2]];
    const PART: f64 = 0.3;

    fn foot([place, a, b]: [[f64; 2]; 3]) -> FootVector {
        FootVector::new(&FacetShape::new(a, b), PART, place)
    }

    /// Energy of springs of both modes.
    fn energy(places: [[f64; 2]; 3]) -> f64 {
        let [apart, aside] = foot(places).components;
        1.5 * (apart - 0.1).powi(2) + 0.5 * (aside - 0.2).powi(2)
    }

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy() {
        let [apart, aside] = foot(PLACES).components;
        let forces = foot(PLACES).forces(PART, [3.0 * (apart - 0.1), aside - 0.2]);
        for point in 0..3 {
            for axis in 0..2 {
                let moved = |by: f64| {
                    let mut places = PLACES;
                    places[point][axis] += by;
                    energy(places)
                };
                let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((forces[point][axis] + slope).abs() < 1e-9, "{point} {axis}");
            }
        }
    }

    #[test]
    fn forces_and_moments_balance() {
        let forces = foot(PLACES).forces(PART, [3.0, -1.7]);
        let [r, z] = [0, 1].map(|axis| forces.iter().map(|force| force[axis]).sum::<f64>());
        let moment: f64 = PLACES.iter().zip(forces).map(|(at, force)| at[0] * force[1] - at[1] * force[0]).sum();
        assert!(r.abs() < 1e-14 && z.abs() < 1e-14 && moment.abs() < 1e-14, "{r} {z} {moment}");
    }
}
