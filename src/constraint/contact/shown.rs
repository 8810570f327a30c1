//! What contact shows: pressure, shear, opening and slip at points, forces and areas of pairs.
//! Never here: what happens in contact.

use super::curve::{Carrier, Point};
use super::{Contact, Pair};
use crate::constraint::ContactResults;
use crate::kernel::lists::MemoryUse;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::persist_struct;
use crate::variables::{Part, Variable};

/// What is kept for those who look.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// Gap of each key; not a number where nothing is near.
    pub(super) opening: Vec<f64>,
    /// Slip of each key so far while in contact.
    slip: Vec<f64>,
    /// Points by what carries them: nodes first, ascending.
    by_node: Vec<(usize, u32)>,
    on_bodies: Vec<(Carrier, u32)>,
}

impl Shown {
    pub(super) fn new(keys: usize, points: &[Point]) -> Shown {
        let mut shown = Shown { opening: vec![f64::NAN; keys], slip: vec![0.0; keys], ..Shown::default() };
        for (index, point) in points.iter().enumerate() {
            match point.carrier {
                Carrier::Node(node) => shown.by_node.push((node, index as u32)),
                carrier => shown.on_bodies.push((carrier, index as u32)),
            }
        }
        shown.by_node.sort_unstable();
        shown
    }

    pub(super) fn clear(&mut self) {
        self.opening.fill(f64::NAN);
    }

    /// Goes on with what was shown of a key before.
    pub(super) fn take_over(&mut self, key: usize, previous: &Shown, other: usize) {
        self.opening[key] = previous.opening[other];
        self.slip[key] = previous.slip[other];
    }

    fn point(&self, carrier: Carrier) -> Option<u32> {
        match carrier {
            Carrier::Node(node) => self.by_node.binary_search_by_key(&node, |p| p.0).ok().map(|at| self.by_node[at].1),
            carrier => self.on_bodies.iter().find(|p| p.0 == carrier).map(|p| p.1),
        }
    }

    /// The points of an element's boundary; `None` where one is in no contact.
    pub(super) fn points(&self, boundary: &ElementNodes) -> Option<ElementNodes> {
        let mut points = *boundary;
        for point in points.iter_mut() {
            *point = self.point(Carrier::Node(*point as usize))?;
        }
        Some(points)
    }

    pub(super) fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.opening)
            + MemoryUse::of(&self.slip)
            + MemoryUse::of(&self.by_node)
            + MemoryUse::of(&self.on_bodies)
    }
}

impl Contact {
    /// Keeps the gaps that the increment begins with.
    pub(super) fn show_openings(&mut self) {
        let Contact { rows, shown, .. } = self;
        for row in rows.rows.iter().filter(|row| row.foot.is_none()) {
            shown.opening[row.key as usize] = row.gap / row.area;
        }
    }

    /// Keeps the slip of an increment of the length `dt`.
    pub(super) fn show(&mut self, dt: f64) {
        let Contact { rows, motion, shown, .. } = self;
        for row in rows.rows.iter().filter(|row| row.pressed > 0.0) {
            shown.slip[row.key as usize] += dt * motion.slip(rows.terms_of(row)) / row.area;
        }
    }

    /// Force of pressure and of friction on the own surface of a pair, along r and z, and the area where it is pressed.
    fn forces(&self, pair: &Pair) -> [f64; 5] {
        if pair.analytical.is_some() {
            return self.forces_of_rows(pair);
        }
        let (own, mut sum) = (&self.curves[pair.own], [0.0; 5]);
        for &k in &own.bare {
            let (facet, seen) = (&own.facets[k as usize], &pair.seen[k as usize]);
            if seen.area == [0.0; 2] {
                continue;
            }
            for (end, point) in facet.iter().enumerate() {
                let Ok(at) = own.own.binary_search(point) else { continue };
                let [pressure, shear] = self.pressures[pair.first_key as usize + at];
                if pressure == 0.0 {
                    continue;
                }
                sum[4] += seen.area[end];
                for share in self.gaps.shares_of(seen).iter().filter(|s| facet.contains(&s.point)) {
                    let of = share.of[end];
                    sum[0] += pressure * of[0];
                    sum[1] += pressure * of[1];
                    sum[2] -= shear * of[1];
                    sum[3] += shear * of[0];
                }
            }
        }
        sum
    }
}

impl ContactResults for Contact {
    fn value_at_point(&self, carrier: Carrier, part: Part) -> Option<f64> {
        let point = self.shown.point(carrier)?;
        let keys = self.pairs.iter().flat_map(|pair| {
            let own = &self.curves[pair.own].own;
            let at = own.binary_search(&point).ok().map(|at| pair.first_key as usize + at);
            // In corners of analytical surfaces it has two.
            let twice = pair.analytical.is_some() && self.keys_of(pair) as usize > own.len();
            [at, at.filter(|_| twice).map(|at| at + own.len())].into_iter().flatten()
        });
        let mut found: Option<f64> = None;
        for key in keys {
            let [pressure, shear] = self.pressures[key];
            let value = match part.variable {
                Variable::ContactPressure => found.unwrap_or(0.0) + pressure,
                Variable::ContactShear => found.unwrap_or(0.0) + shear,
                Variable::ContactOpening => self.shown.opening[key].min(found.unwrap_or(f64::NAN)),
                Variable::ContactSlip => found.unwrap_or(0.0) + self.shown.slip[key],
                _ => return None,
            };
            found = Some(value);
        }
        found
    }

    fn value_of_pair(&self, number: usize, part: Part) -> Option<f64> {
        let pair = self.pairs.iter().find(|p| p.number == number)?;
        // What acts on the other surface is the opposite.
        let sign = if pair.first { 1.0 } else { -1.0 };
        let forces = self.forces(pair);
        match part.variable {
            Variable::NormalContactForce => Some(sign * forces[part.component]),
            Variable::ShearContactForce => Some(sign * forces[2 + part.component]),
            Variable::ContactForce => Some(sign * (forces[part.component] + forces[2 + part.component])),
            Variable::NormalContactMagnitude => Some(libm::hypot(forces[0], forces[1])),
            Variable::ShearContactMagnitude => Some(libm::hypot(forces[2], forces[3])),
            Variable::ContactMagnitude => Some(libm::hypot(forces[0] + forces[2], forces[1] + forces[3])),
            Variable::ContactArea => Some(forces[4]),
            _ => None,
        }
    }
}

persist_struct!(Shown { opening: fixed, slip: fixed } derived { by_node, on_bodies });
