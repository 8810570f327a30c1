//! Choice of the surface that carries the contact pressures, and warnings for questionable contact pairs: surfaces that
//! face away from each other, rigid bodies lighter than the contact nodes, rigid surfaces finer than the deformable mesh.

use crate::constraint::contact::curve::{FacetCurve, FacetNeighbor, FacetShape, PointCarrier, SurfacePoint};
use crate::constraint::overlaps::distance;
use crate::deck::Diagnostic;
use crate::kernel::lists::sorted_unique;
use crate::kernel::sorted_boxes::SortedBoxes;
use crate::model::{Model, SurfaceContact};
use crate::plan::contact::curves::ContactGeometry;
use crate::plan::contact::penalty::modulus_of;
use crate::plan::{Report, StepInput};
use crate::variables::Variable;

/// Facets face each other if the cosine of the angle between their normals is below this value, as in contact.
const FACING: f64 = -0.1;
/// Number of sectors of directions by which facets are compared.
const SECTORS: usize = 32;
/// Accepted change of direction of a rigid surface within one deformable facet, in addition to its sharpest corner,
/// radians.
const TURN: f64 = 0.5;

/// Ratios of facet lengths and of moduli above which a finer and stiffer surface must not carry the pressures: the
/// coarse facets cannot follow its hat functions.
const FINER: f64 = 2.0;
const STIFFER: f64 = 1.5;

/// Difference of distances, in facet lengths, up to which facets count as the closest ones.
const CLOSE: f64 = 0.05;

/// Two curves in contact. The first one carries the contact pressures.
#[derive(Clone, Copy)]
pub struct ContactingCurves<'a> {
    pub curves: [&'a FacetCurve; 2],
    pub points: &'a [SurfacePoint],
    pub places: &'a [[f64; 2]],
    /// Mean facet length of the first curve.
    pub length: f64,
    /// Whether the first curve is the first surface of the pair in the deck.
    pub first_carries: bool,
}

impl ContactingCurves<'_> {
    fn shape(&self, curve: &FacetCurve, facet: u32) -> FacetShape {
        let [a, b] = curve.facets[facet as usize].map(|p| self.places[p as usize]);
        FacetShape::new(a, b)
    }

    /// Returns whether no facet of one curve is in front of a facet of the other.
    fn faces_away(&self) -> bool {
        let [own, other] = self.curves;
        let shapes = |curve: &FacetCurve| -> Vec<(FacetShape, f64)> {
            curve.exposed.iter().map(|&k| (self.shape(curve, k), curve.depth[k as usize][1])).collect()
        };
        let is_beyond = |a: &FacetShape, b: &FacetShape, depth: f64| {
            let way = [0, 1].map(|i| a.from[i] + 0.5 * a.along[i] - b.from[i] - 0.5 * b.along[i]);
            way[0] * b.normal[0] + way[1] * b.normal[1] < -depth
        };
        let meets = |(a, own): &(FacetShape, f64), (b, other): &(FacetShape, f64)| {
            let cosine = a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1];
            let away = is_beyond(a, b, *other) && is_beyond(b, a, *own);
            cosine < FACING && !away
        };
        // Facets of one curve whose normals are in the same sector are skipped together.
        let mut sectors: Vec<Vec<(FacetShape, f64)>> = vec![Vec::new(); SECTORS];
        shapes(other).into_iter().for_each(|facet| sectors[sector(facet.0.normal)].push(facet));
        let half = std::f64::consts::PI / SECTORS as f64;
        let may_face = |normal: [f64; 2], index: usize| {
            let (sine, cosine) = libm::sincos((2 * index + 1) as f64 * half);
            libm::acos((normal[0] * cosine + normal[1] * sine).clamp(-1.0, 1.0)) + half > libm::acos(FACING)
        };
        !shapes(own).iter().any(|facet| {
            let facing = (0..SECTORS).filter(|&index| !sectors[index].is_empty() && may_face(facet.0.normal, index));
            facing.flat_map(|index| &sectors[index]).any(|opposite| meets(facet, opposite))
        })
    }

    /// Returns the mean facet lengths of both curves where they are closest: of facing facets whose distance exceeds the
    /// smallest one by less than [`CLOSE`] facet lengths; of all exposed facets if none are near each other.
    fn closest_lengths(&self) -> [f64; 2] {
        let shapes = self.curves.map(|curve| curve.exposed.iter().map(|&k| self.shape(curve, k)).collect::<Vec<_>>());
        let mean = |lengths: &[f64]| lengths.iter().sum::<f64>() / lengths.len() as f64;
        let mean_lengths =
            shapes.each_ref().map(|shapes| mean(&shapes.iter().map(|shape| shape.length).collect::<Vec<_>>()));
        let mut boxes = SortedBoxes::default();
        boxes.sort(shapes[1].iter().map(FacetShape::bounds).zip(0..));
        let mut near: Vec<([usize; 2], f64)> = Vec::new();
        for (k, a) in shapes[0].iter().enumerate() {
            boxes.near(a.bounds(), mean_lengths[0].min(mean_lengths[1]), |j| {
                let b = &shapes[1][j as usize];
                if a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1] < FACING {
                    near.push(([k, j as usize], gap_between(a, b)));
                }
            });
        }
        let least = near.iter().map(|pair| pair.1).fold(f64::INFINITY, f64::min);
        let shorter = |[k, j]: [usize; 2]| shapes[0][k].length.min(shapes[1][j].length);
        let close = near.iter().filter(|pair| pair.1 <= least + CLOSE * shorter(pair.0));
        let close: Vec<[usize; 2]> = close.map(|pair| pair.0).collect();
        let lengths = |side: usize| {
            let facets = sorted_unique(close.iter().map(|pair| pair[side]));
            facets.into_iter().map(|facet| shapes[side][facet].length).collect::<Vec<_>>()
        };
        if close.is_empty() { mean_lengths } else { [0, 1].map(|side| mean(&lengths(side))) }
    }

    /// Returns the rigid body of the second curve; `None` if its points do not all belong to one rigid body.
    fn body(&self) -> Option<usize> {
        let bodies = self.curves[1].points.iter().map(|&p| match self.points[p as usize].carrier {
            PointCarrier::Body(body, _) => Some(body),
            PointCarrier::Node(_) => None,
        });
        bodies.reduce(|a, b| if a == b { a } else { None }).flatten()
    }

    fn area(&self, curve: &FacetCurve) -> f64 {
        let facet_area = |&k: &u32| {
            let shape = self.shape(curve, k);
            std::f64::consts::PI * (2.0 * shape.from[0] + shape.along[0]) * shape.length
        };
        curve.exposed.iter().map(facet_area).sum()
    }

    /// Returns a point at which the second curve changes its direction, within the length of a facet of the first
    /// curve, by more than its sharpest corner and [`TURN`].
    fn find_sharp_turn(&self) -> Option<[f64; 2]> {
        let other = self.curves[1];
        let turn = |j: u32, k: u32| {
            let (a, b) = (self.shape(other, j).normal, self.shape(other, k).normal);
            libm::atan2((a[0] * b[1] - a[1] * b[0]).abs(), a[0] * b[0] + a[1] * b[1])
        };
        let around = |from: u32| {
            let (mut current, mut way, mut sum, mut largest) = (from, 0.0, 0.0, 0.0_f64);
            while let FacetNeighbor::Facet(next) = other.neighbors[current as usize][1] {
                let angle = turn(current, next);
                (sum, largest, way) = (sum + angle, largest.max(angle), way + self.shape(other, next).length);
                if way > self.length || next == from {
                    break;
                }
                current = next;
            }
            sum - largest
        };
        let facet = other.exposed.iter().copied().find(|&k| around(k) > TURN)?;
        Some(self.places[other.facets[facet as usize][1] as usize])
    }
}

/// Returns the smaller one of the distances of the middle of each facet from the other facet.
fn gap_between(a: &FacetShape, b: &FacetShape) -> f64 {
    let ends = |shape: &FacetShape| [shape.from, [0, 1].map(|i| shape.from[i] + shape.along[i])];
    let middle = |shape: &FacetShape| [0, 1].map(|i: usize| shape.from[i] + 0.5 * shape.along[i]);
    distance(middle(a), ends(b)).0.min(distance(middle(b), ends(a)).0)
}

/// Returns the sector of directions that contains a normal.
fn sector([r, z]: [f64; 2]) -> usize {
    let turns = libm::atan2(z, r) / std::f64::consts::TAU;
    ((turns.rem_euclid(1.0) * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// Checks a pair in the step in which it begins.
pub fn check_pair(input: StepInput, contact: &SurfaceContact, curves: ContactingCurves, report: &mut Report) {
    let StepInput { scene, pairs, index: step, .. } = input;
    let known = |c: &SurfaceContact| c.span == contact.span && c.sides[0].name == contact.sides[0].name;
    if contact.is_self_contact() || step > 0 && pairs.by_step[step - 1].iter().any(known) {
        return;
    }
    let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
    if !contact.general && curves.faces_away() {
        let message = format!("`{a}` and `{b}` face away from each other: there will be no contact");
        let finding = Diagnostic::warning("P110", message).at(contact.span, "this pair");
        report.push(finding.help("give the sides that face each other; for shells SPOS or SNEG"));
        return;
    }
    let Some(body) = curves.body() else {
        return check_facet_sizes(scene.model, contact, curves, report);
    };
    check_mass(input, contact, body, curves, report);
    if let Some([r, z]) = curves.find_sharp_turn() {
        let message = format!(
            "the rigid surface of `{a}` and `{b}` has a rounding within {:.3e}, the length of the deformable faces in contact",
            curves.length
        );
        let finding = Diagnostic::warning("P118", message).at(contact.span, format!("near ({r:.4e}, {z:.4e})"));
        report.push(finding.help("use deformable elements as small as the roundings"));
    }
}

/// Warns if contact pressures are requested and the facets of two deformable surfaces differ too much in size where the
/// surfaces are closest.
fn check_facet_sizes(model: &Model, contact: &SurfaceContact, curves: ContactingCurves<'_>, report: &mut Report) {
    let mut requests = model.steps.iter().flat_map(|step| &step.outputs).flat_map(|output| &output.variables);
    if !requests.any(|request| request.variables().contains(&Variable::ContactPressure)) {
        return;
    }
    let [own, other] = curves.closest_lengths();
    let ratio = (own / other).max(other / own);
    // Meshes with exactly this ratio differ by rounding.
    if ratio < FINER * (1.0 + 1e-3) {
        return;
    }
    let [carrier, opposite] = if curves.first_carries { [0, 1] } else { [1, 0] };
    let coarser = &contact.sides[if own > other { carrier } else { opposite }].name;
    let message = format!(
        "the facets of `{}` and `{}` differ by a factor of {ratio:.1} where the surfaces are closest",
        contact.sides[0].name, contact.sides[1].name
    );
    let label = "contact pressures of curved surfaces are inaccurate, in particular on the axis";
    let finding = Diagnostic::warning("P124", message).at(contact.span, label);
    report.push(finding.help(format!(
            "use smaller facets on `{coarser}`, at most twice as long as those of the other surface, and at least five over the \
             contact radius"
        )));
}

/// Orders two curves: the first one carries the contact pressures. It is the secondary surface that the deck gives,
/// else the finer one of two deformable curves unless it is also stiffer, never a rigid one.
pub fn order_curves(
    model: &Model,
    contact: &SurfaceContact,
    [first, second]: [usize; 2],
    geometry: &ContactGeometry,
    report: &mut Report,
) -> [usize; 2] {
    let by_size = [first, second].map(|curve| geometry.lengths[curve][1]);
    let (finer, coarser) = if by_size[1] < by_size[0] { ([second, first], 0) } else { ([first, second], 1) };
    match (geometry.deforms[first], geometry.deforms[second]) {
        (true, false) => return [first, second],
        (false, _) => return [second, first],
        _ => {}
    }
    let unsuited = size_and_stiffness(model, finer, geometry);
    match (contact.secondary, unsuited) {
        (None, None) => finer,
        (None, Some(_)) => [finer[1], finer[0]],
        (Some(secondary), unsuited) => {
            if let Some(ratios) = unsuited.filter(|_| secondary != coarser) {
                warn_of_sizes(contact, coarser, ratios, report);
            }
            if secondary == 0 { [first, second] } else { [second, first] }
        }
    }
}

/// Returns how many times finer and stiffer the first curve is, if it is too fine and too stiff to carry the
/// pressures.
fn size_and_stiffness(model: &Model, [own, other]: [usize; 2], geometry: &ContactGeometry) -> Option<[f64; 2]> {
    let mean = |curve: usize| {
        let moduli = geometry.facet_elements[curve].iter().map(|&(element, _)| modulus_of(model, element));
        let (sum, count) = moduli.flatten().fold((0.0, 0), |(sum, count), m| (sum + m, count + 1));
        sum / f64::from(count.max(1))
    };
    let finer = geometry.lengths[other][1] / geometry.lengths[own][1];
    if own == other || finer <= FINER {
        return None;
    }
    let stiffer = mean(own) / mean(other);
    (stiffer > STIFFER).then_some([finer, stiffer])
}

/// Warns that the deck lets a finer and stiffer surface carry the pressures; `coarser` is the index of the other
/// surface.
fn warn_of_sizes(contact: &SurfaceContact, coarser: usize, [finer, stiffer]: [f64; 2], report: &mut Report) {
    let [a, b] = [1 - coarser, coarser].map(|side| &contact.sides[side].name);
    let message = format!(
        "`{a}` carries the contact pressures; it is {finer:.1} times finer and {stiffer:.1} times stiffer than `{b}`"
    );
    let finding = Diagnostic::warning("P121", message).at(contact.span, "pressures will oscillate from node to node");
    let cure = match contact.general {
        true => {
            format!("remove *CONTACT FORMULATION, so that `{b}` carries the pressures, or use smaller facets on `{b}`")
        }
        false => format!("remove WEIGHT, so that `{b}` carries the pressures, or use smaller facets on `{b}`"),
    };
    report.push(finding.help(cure));
}

/// Warns if a free rigid body is lighter than the contact nodes.
fn check_mass(input: StepInput, contact: &SurfaceContact, body: usize, curves: ContactingCurves, report: &mut Report) {
    let StepInput { scene, state, index: step, .. } = input;
    let reference = scene.bodies.list[body].reference;
    let boundaries = &scene.model.steps[step].boundaries;
    if boundaries.iter().any(|b| b.dof == 2 && b.nodes.contains(&reference)) {
        return;
    }
    let [own, other] = curves.curves;
    let mass: f64 = own
        .points
        .iter()
        .map(|&p| match curves.points[p as usize].carrier {
            PointCarrier::Node(n) => state.dofs.nodes.mass[n],
            PointCarrier::Body(..) => 0.0,
        })
        .sum();
    let (wide, narrow) = (curves.area(own), curves.area(other));
    let weighs = mass * (narrow / wide).min(1.0);
    let light = scene.bodies.list[body].mass();
    if light < weighs {
        let message = format!(
            "the mass {light:.3e} of rigid body `{}` is less than the mass of the contact nodes, about {weighs:.3e}",
            scene.bodies.list[body].name
        );
        let label = "at impact it takes the velocity of the contact nodes and loses its kinetic energy";
        let finding = Diagnostic::warning("P117", message).at(contact.span, label);
        report.push(finding.help("use thinner elements at the contact surface"));
    }
}
