//! What a pair of surfaces can hardly mean, or not do well: surfaces that face away from each other, rigid bodies lighter than what
//! they meet, rigid surfaces finer than what meets them. Warnings; the run does what the deck says.
//! Never here: contact, overlaps.

use super::{Compiler, State};
use crate::constraint::contact::curve::{Beyond, Carrier, Curve, Point, Shape};
use crate::deck::Diagnostic;
use crate::model::SurfaceContact;

/// Facets face each other where the cosine between their normals is below this, as in contact.
const FACING: f64 = -0.1;
/// Angle by which a rigid surface may turn within one facet of what meets it, beside its sharpest corner.
const TURN: f64 = 0.5;

/// Two curves in contact: the one that carries the pressures first.
#[derive(Clone, Copy)]
pub(super) struct Met<'a> {
    pub(super) curves: [&'a Curve; 2],
    pub(super) points: &'a [Point],
    pub(super) places: &'a [[f64; 2]],
    /// Mean length of the first one's facets.
    pub(super) length: f64,
}

impl Met<'_> {
    fn shape(&self, curve: &Curve, facet: u32) -> Shape {
        let [a, b] = curve.facets[facet as usize].map(|p| self.places[p as usize]);
        Shape::new(a, b)
    }

    /// Whether no facet of one has one of the other in front of it.
    fn faces_away(&self) -> bool {
        let [own, other] = self.curves;
        let behind = |a: &Shape, b: &Shape, depth: f64| {
            let way = [0, 1].map(|i| a.from[i] + 0.5 * a.along[i] - b.from[i] - 0.5 * b.along[i]);
            way[0] * b.normal[0] + way[1] * b.normal[1] < -depth
        };
        let meets = |i: u32, j: u32| {
            let (a, b) = (self.shape(own, i), self.shape(other, j));
            let cosine = a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1];
            let away = behind(&a, &b, other.depth[j as usize]) && behind(&b, &a, own.depth[i as usize]);
            cosine < FACING && !away
        };
        !own.bare.iter().any(|&i| other.bare.iter().any(|&j| meets(i, j)))
    }

    /// The rigid body that carries all of the second curve.
    fn body(&self) -> Option<usize> {
        let bodies = self.curves[1].own.iter().map(|&p| match self.points[p as usize].carrier {
            Carrier::Body(body, _) => Some(body),
            Carrier::Node(_) => None,
        });
        bodies.reduce(|a, b| if a == b { a } else { None }).flatten()
    }

    fn area(&self, curve: &Curve) -> f64 {
        let of = |&k: &u32| {
            let shape = self.shape(curve, k);
            std::f64::consts::PI * (2.0 * shape.from[0] + shape.along[0]) * shape.length
        };
        curve.bare.iter().map(of).sum()
    }

    /// Where the second curve turns within a facet of the first by more than one corner does.
    fn too_fine(&self) -> Option<[f64; 2]> {
        let other = self.curves[1];
        let turn = |j: u32, k: u32| {
            let (a, b) = (self.shape(other, j).normal, self.shape(other, k).normal);
            libm::atan2((a[0] * b[1] - a[1] * b[0]).abs(), a[0] * b[0] + a[1] * b[1])
        };
        let around = |from: u32| {
            let (mut at, mut way, mut sum, mut most) = (from, 0.0, 0.0, 0.0_f64);
            while let Beyond::Facet(next) = other.beyond[at as usize][1] {
                let angle = turn(at, next);
                (sum, most, way) = (sum + angle, most.max(angle), way + self.shape(other, next).length);
                if way > self.length || next == from {
                    break;
                }
                at = next;
            }
            sum - most
        };
        let found = other.bare.iter().copied().find(|&k| around(k) > TURN)?;
        Some(self.places[other.facets[found as usize][1] as usize])
    }
}

impl Compiler<'_> {
    /// Tells of a pair that begins in a step.
    pub(super) fn doubt_pair(&mut self, contact: &SurfaceContact, step: usize, met: Met<'_>, state: &State) {
        let known = |c: &SurfaceContact| c.span == contact.span && c.sides[0].name == contact.sides[0].name;
        if contact.is_of_one() || step > 0 && self.pairs[step - 1].iter().any(known) {
            return;
        }
        let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
        if !contact.general && met.faces_away() {
            let message = format!("`{a}` and `{b}` face away from each other: they will not meet");
            let finding = Diagnostic::warning("P110", message).at(contact.span, "this pair");
            self.diagnostics
                .push(finding.help("give the sides that lie in front of each other; of shells SPOS or SNEG"));
            return;
        }
        let Some(body) = met.body() else { return };
        self.light_body(contact, step, body, met, state);
        if let Some([r, z]) = met.too_fine() {
            let message = format!(
                "the rigid surface of `{a}` and `{b}` turns within less than {:.3e}, the length of the faces that meet it",
                met.length
            );
            let finding = Diagnostic::warning("P118", message).at(contact.span, format!("near ({r:.4e}, {z:.4e})"));
            self.diagnostics.push(finding.help("make the elements that meet it as small as its roundings"));
        }
    }

    /// A rigid body that moves freely and weighs less than the nodes that it meets.
    fn light_body(&mut self, contact: &SurfaceContact, step: usize, body: usize, met: Met<'_>, state: &State) {
        let reference = self.bodies[body].reference;
        let boundaries = &self.model.steps[step].boundaries;
        if boundaries.iter().any(|b| b.dof == 2 && b.nodes.contains(&reference)) {
            return;
        }
        let [own, other] = met.curves;
        let mass: f64 = own
            .own
            .iter()
            .map(|&p| match met.points[p as usize].carrier {
                Carrier::Node(n) => state.dofs.nodes.mass[n],
                Carrier::Body(..) => 0.0,
            })
            .sum();
        let (wide, narrow) = (met.area(own), met.area(other));
        let weighs = mass * (narrow / wide).min(1.0);
        let light = self.bodies[body].mass();
        if light < weighs {
            let message = format!(
                "the rigid body `{}` weighs {light:.3e}, less than the nodes that it meets, some {weighs:.3e}",
                self.bodies[body].name
            );
            let label = "where it hits them it takes on their velocity, and what it had is lost";
            let finding = Diagnostic::warning("P117", message).at(contact.span, label);
            self.diagnostics.push(finding.help("make the elements that it meets thinner"));
        }
    }
}
