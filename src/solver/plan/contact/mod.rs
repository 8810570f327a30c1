//! Contact of a step: its pairs, their interaction laws, penalty stiffness, initial clearances and warnings for initial
//! overlaps.

pub mod analytical;
pub mod cohesion;
pub mod curves;
pub mod general;
pub mod penalty;
pub mod tied_faces;
pub mod walls;

use std::cell::OnceCell;
use std::collections::HashSet;

use rustc_hash::FxHashMap;

use crate::constraint::Constraint;
use crate::constraint::contact::{AdjustedGap, ContactConstraint, ContactPair, InitialClearance, SurfaceOverlap};
use crate::deck::Diagnostic;
use crate::kernel::interaction::{GapHeat, InteractionLaw, PressureOverclosure};
use crate::model::{AnalyticalFront, AnalyticalSide, GeneralContact, Model, SideSelection, SurfaceContact};
use crate::plan::checks::contact_pairs::{ContactingCurves, check_pair, order_curves};
use crate::plan::contact::analytical::{analytical_contact, friction_of};
use crate::plan::contact::cohesion::{CohesionList, CohesionOrigin, add_cohesion, report_cohesion};
use crate::plan::contact::curves::{ContactGeometry, CurveContext, add_curve, solid_skin};
use crate::plan::contact::general::{general_row, pair_name};
use crate::plan::contact::penalty::{PENALTY_FACTOR, spring_laws};
use crate::plan::contact::tied_faces::tied_faces;
use crate::plan::contact::walls::{spatial_side, station_contact};
use crate::plan::queries::{heated_references, largest_distances, number_of_node};
use crate::plan::{Pairs, Report, Scene, StepInput};

/// Initial overlaps up to this fraction of a facet are accepted without a warning: meshes of matching curved surfaces
/// overlap.
const FIT: f64 = 0.05;
/// Default search distance of clearances, as a fraction of the facet length (ABAQUS Keywords Reference Guide, *CONTACT
/// CLEARANCE: approximately one-tenth of the element size).
const SEARCHED: f64 = 0.1;

/// Creates the contact constraint of a step. Returns it with the fronts of its analytical surfaces.
pub fn contact_constraint(
    input: StepInput,
    prescribed: &HashSet<(usize, usize)>,
    report: &mut Report,
) -> Option<(Box<dyn Constraint>, Vec<AnalyticalFront>)> {
    let StepInput { scene, links, state, index: step, .. } = input;
    let (mut geometry, mut pairs, mut laws) = (ContactGeometry::default(), Vec::new(), Vec::new());
    let (mut spans, mut cohesion, mut stations) = (Vec::new(), CohesionList::default(), Vec::new());
    let all_pairs = &input.pairs.by_step[step];
    let surface_pairs: Vec<&SurfaceContact> = all_pairs.iter().filter(|pair| !is_lost(scene.model, pair)).collect();
    if surface_pairs.is_empty() {
        return None;
    }
    let (equal_motions, mut prescribed_dofs) = links.equal_motions(prescribed);
    prescribed_dofs.extend(prescribed);
    let context = CurveContext {
        input,
        prescribed: &prescribed_dofs,
        in_equations: &links.dofs_of_equations(),
        tied_faces: &tied_faces(scene, links),
        skin: &solid_skin(scene.model),
        general: scene.model.steps[step].general_contact.as_ref(),
        pairs: all_pairs,
        general_row: OnceCell::new(),
    };
    for contact in surface_pairs {
        if let Some(oblique) = spatial_side(scene.bodies, contact) {
            stations.extend(station_contact(input, contact, oblique, &mut geometry, report));
            continue;
        }
        let pair = match &contact.analytical {
            Some(side) => analytical_pair(contact, side, &context, &mut geometry, report),
            None => pair_of_curves(contact, &context, &mut geometry, report),
        };
        let Some((mut pair, length)) = pair else { continue };
        if contact.law.friction_routine.is_some() {
            report.require_routine(contact.span, "pair", "*FRICTION, USER calls vfriction", "vfriction")?;
        }
        let Some([law, of_points]) = law_indices(input, contact, &pair, &mut laws, &geometry, report) else { continue };
        (pair.law, pair.of_points, pair.springs) = (law, of_points, has_springs(contact));
        let origin = CohesionOrigin { contact, index: pairs.len(), pair: &pair };
        if add_cohesion(input, origin, &mut laws, &geometry, &mut cohesion, report).is_none() {
            continue;
        }
        pair.initial_clearance = initial_clearance(contact, length);
        pair.name = input.pairs.names[pair.number].clone();
        if state.thermal.as_ref().is_some_and(|t| t.heat.is_some()) {
            heat_row(scene, contact, report);
        }
        pairs.push(pair);
        check_damping(contact, report);
        spans.push((contact, length));
    }
    if pairs.is_empty() && stations.is_empty() {
        return None;
    }
    let ContactGeometry { points, places, point_of_node, curves, analyticals, fronts, .. } = geometry;
    let mut contact = ContactConstraint::new(points, curves, analyticals, pairs, laws)
        .with_stations(stations)
        .with_equal_motions(equal_motions);
    if let Some(heat) = state.heat() {
        if contact.has_equal_motions() {
            let message = "heat conduction through contact of nodes with equal motion is not supported";
            let finding =
                Diagnostic::error("P021", message).at(all_pairs[0].span, "these nodes follow a reference node");
            return report.refuse(finding.help("make the body rigid, or remove these nodes from the surface"));
        }
        let of_body = |body: usize| {
            let node = *scene.places.nodes.get(&scene.bodies.list[body].reference)?;
            heat.temperature(node).is_finite().then_some(node)
        };
        contact = contact.with_heat(|node| heat.temperature(node).is_finite(), of_body);
    }
    contact = cohesion.add_to(contact);
    let gaps = contact.start(&places);
    let nodes_of_points: FxHashMap<_, _> = point_of_node.into_iter().map(|(node, point)| (point, node)).collect();
    contact = contact.with_node_numbers(|point| {
        let node = nodes_of_points.get(&point).map(|node| number_of_node(scene.model, *node));
        node.unwrap_or_default()
    });
    report_cohesion(&cohesion, &contact, step, report);
    for ((contact, length), gaps) in spans.into_iter().zip(gaps) {
        note_adjusted_gaps(scene.model, contact, &gaps.adjusted, &nodes_of_points, report);
        // Pairs with analytical surfaces have been checked when they were created.
        if contact.analytical.is_none() {
            warn_of_overlap(contact, length, gaps.overlap, report);
        }
    }
    Some((Box::new(contact), fronts))
}

/// Creates the pair of two curves, or of one curve with itself. Returns it with its facet length; the laws are set
/// later.
fn pair_of_curves(
    contact: &SurfaceContact,
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<(ContactPair, f64)> {
    let StepInput { scene, pairs, .. } = context.input;
    let curves = [0, 1].map(|i| add_curve(contact, i, context, geometry, report));
    let [Some(first), Some(second)] = curves else { return None };
    if !geometry.deforms[first] && !geometry.deforms[second] {
        let message = "both surfaces of this contact pair are rigid";
        let finding = Diagnostic::error("P021", message).at(contact.span, "no deformable surface");
        return report.refuse(finding.help("at least one surface must belong to a deformable body"));
    }
    let general = context.general.filter(|_| contact.general);
    if general.is_some_and(GeneralContact::excludes_detached_nodes) {
        [first, second].into_iter().for_each(|curve| geometry.curves[curve].drops_orphans = true);
    }
    let curves = order_curves(scene.model, contact, [first, second], geometry, report);
    let length = geometry.lengths[first][0].min(geometry.lengths[second][0]);
    let id = match general {
        Some(general) => general_row(general, context, report),
        None => contact_row(contact, geometry, curves[0], report),
    };
    let contacting = ContactingCurves {
        curves: curves.map(|c| &geometry.curves[c]),
        points: &geometry.points,
        places: &geometry.places,
        length: geometry.lengths[curves[0]][1],
        first_carries: curves[0] == first,
    };
    check_pair(context.input, contact, contacting, report);
    let mut pair = ContactPair::new(id, pair_number(pairs, contact), curves, length);
    pair.first = curves[0] == first;
    // Faces of one body meet again and again where it folds or erodes; their impacts do not limit the increment.
    if !contact.is_self_contact() {
        let thickness = curves.map(|curve| geometry.thicknesses[curve]);
        pair.thickness = thickness[0].min(thickness[1]);
    }
    Some((pair, length))
}

/// Returns whether a surface of a pair has no element on a new mesh, because all its elements have been deleted.
fn is_lost(model: &Model, pair: &SurfaceContact) -> bool {
    let has_members = match &pair.analytical {
        Some(side) => !side.nodes.is_empty(),
        None => pair.sides.iter().all(|side| !side.faces.is_empty()),
    };
    model.surfaces.fronts.is_some() && !has_members
}

/// Creates the pair of a curve with an analytical surface.
fn analytical_pair(
    contact: &SurfaceContact,
    side: &AnalyticalSide,
    context: &CurveContext,
    geometry: &mut ContactGeometry,
    report: &mut Report,
) -> Option<(ContactPair, f64)> {
    let pairs = context.input.pairs;
    let ([curve, analytical], id) = analytical_contact((contact, side), context, geometry, report)?;
    if context.general.is_some_and(|g| contact.general && g.excludes_detached_nodes()) {
        geometry.curves[curve].drops_orphans = true;
    }
    let length = geometry.lengths[curve][0];
    let mut pair = ContactPair::in_front_of(id, pair_number(pairs, contact), curve, analytical, length);
    pair.first = side.side == 1;
    pair.thickness = geometry.thicknesses[curve];
    Some((pair, length))
}

/// Returns the indices of the law of a pair, or of its first penalty spring, and of the law for single points.
fn law_indices(
    input: StepInput,
    contact: &SurfaceContact,
    pair: &ContactPair,
    laws: &mut Vec<InteractionLaw>,
    geometry: &ContactGeometry,
    report: &mut Report,
) -> Option<[usize; 2]> {
    let law = match contact.penalty.filter(|_| has_springs(contact)) {
        None => place_of(laws, contact.law.clone()),
        Some(factor) => {
            laws.extend(spring_laws(input, contact, PENALTY_FACTOR * factor, pair, geometry, report)?);
            laws.len() - geometry.curves[pair.secondary].points.len()
        }
    };
    // Contact of single points has no area for a pressure, so that it is hard contact.
    let hard = InteractionLaw { overclosure: PressureOverclosure::Hard, ..contact.law.clone() };
    Some([law, place_of(laws, hard)])
}

fn pair_number(pairs: &Pairs, contact: &SurfaceContact) -> usize {
    let name = pair_name(contact);
    pairs.names.get_index_of(&name).unwrap_or_default()
}

fn contact_row(contact: &SurfaceContact, geometry: &ContactGeometry, own: usize, report: &mut Report) -> usize {
    let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
    let between = if contact.is_self_contact() { format!("{a} with itself") } else { format!("{a} and {b}") };
    let kind = kind_of(contact);
    let friction = friction_of(contact);
    let count = geometry.curves[own].facets.len();
    let clearance = match contact.clearance {
        Some(clearance) if clearance.gap > 0.0 => format!(", clearance {:e}", clearance.gap),
        _ => String::new(),
    };
    report.ledger_row(contact.span, "contact", count, "facets", format!("{between}, {kind}{friction}{clearance}"))
}

/// Describes the normal behaviour of a pair. A pressure-overclosure relationship replaces penalty springs.
fn kind_of(contact: &SurfaceContact) -> String {
    match (&contact.law.overclosure, contact.penalty) {
        (PressureOverclosure::Hard, Some(factor)) => {
            format!("penalty, {} times the element stiffness", PENALTY_FACTOR * factor)
        }
        (PressureOverclosure::Hard, None) => "hard".into(),
        (PressureOverclosure::Linear(_) | PressureOverclosure::Spring(_), _) => "linear".into(),
        (PressureOverclosure::Exponential(_), _) => "exponential".into(),
        (PressureOverclosure::Table(_), _) => "tabular".into(),
    }
}

/// Returns whether one of the surfaces belongs to a rigid body without temperature.
fn has_cold_side(scene: Scene, contact: &SurfaceContact) -> bool {
    let of_side = |side: &SideSelection| side.faces.iter().find_map(|(e, _)| scene.bodies.of_element.get(e)).copied();
    let reference = |side: &AnalyticalSide| scene.model.surfaces.analytical[side.surface].reference;
    let of_surface =
        contact.analytical.as_ref().and_then(reference).and_then(|n| scene.bodies.of_node.get(&n)).copied();
    let heated = heated_references(scene.model);
    let cold = |body: usize| !heated.contains(&scene.bodies.list[body].reference);
    contact.sides.iter().filter_map(of_side).chain(of_surface).any(cold)
}

/// Creates the ledger row of heat transfer between two surfaces.
fn heat_row(scene: Scene, contact: &SurfaceContact, report: &mut Report) {
    let [a, b] = [0, 1].map(|i| contact.sides[i].name.as_str());
    let GapHeat { over_clearance, over_pressure, fraction, to_first } = &contact.law.heat;
    let mut parts = Vec::new();
    if contact.law.friction.is_active() {
        parts.push(format!("{fraction} of the frictional work, {to_first} of this heat to {a}"));
    }
    for (rows, over) in [(over_clearance, "clearance"), (over_pressure, "pressure")] {
        if !rows.is_empty() {
            parts.push(format!("conductance table of {} rows over {over}", rows.len()));
        }
    }
    let conducts = !over_clearance.is_empty() || !over_pressure.is_empty();
    if conducts && has_cold_side(scene, contact) {
        let message = "no heat flows through this contact: one of the surfaces is rigid and has no temperature";
        report.push(Diagnostic::warning("P067", message).at(contact.span, "this pair"));
    } else if !parts.is_empty() {
        report.ledger_row(contact.span, "contact heat", 1, "pair", format!("{a} and {b}: {}", parts.join(", ")));
    }
}

/// Warns of contact damping that has no effect.
fn check_damping(contact: &SurfaceContact, report: &mut Report) {
    let is_hard = !contact.law.is_soft() && contact.penalty.is_none();
    if contact.law.damping.is_none() || !is_hard {
        return;
    }
    let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
    let message = format!("*CONTACT DAMPING has no effect on the hard contact of `{a}` and `{b}`");
    let finding = Diagnostic::warning("P122", message).at(contact.span, "no overlap, so that there is nothing to damp");
    report.push(finding.help("remove the card, or use PENALTY or a pressure-overclosure relationship"));
}

/// Lists the initial gaps and overlaps that are set to the clearance of a pair.
fn note_adjusted_gaps(
    model: &Model,
    contact: &SurfaceContact,
    adjusted: &[AdjustedGap],
    nodes_of_points: &FxHashMap<u32, usize>,
    report: &mut Report,
) {
    let Some(clearance) = contact.clearance.map(|clearance| clearance.gap) else { return };
    let change = |adjusted: &AdjustedGap| Some((*nodes_of_points.get(&adjusted.point)?, adjusted.gap - clearance));
    let changes = adjusted.iter().filter_map(change).collect();
    let Some(list) = largest_distances(model, changes) else { return };
    let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
    let message = format!(
        "initial gaps and overlaps of `{a}` and `{b}` are set to the clearance {clearance} without strain, at {} nodes",
        list.count
    );
    let label = format!("change of the gap, negative for overlaps: {}", list.text);
    report.push(Diagnostic::note("P125", message).at(contact.span, label));
}

/// Warns of an initial overlap of the surfaces of a pair.
fn warn_of_overlap(contact: &SurfaceContact, length: f64, overlap: Option<SurfaceOverlap>, report: &mut Report) {
    let Some(SurfaceOverlap { depth, place: [r, z] }) = overlap.filter(|o| o.depth > FIT * length) else { return };
    let [a, b] = [0, 1].map(|i| &contact.sides[i].name);
    let message = format!("`{a}` and `{b}` overlap at the start by up to {depth:.3e}");
    let effect = match !contact.law.is_soft() && contact.penalty.is_none() {
        true => "the overlap is kept and does not grow",
        false => "its pressure acts from the start",
    };
    let label = format!("largest near ({r:.4e}, {z:.4e}); {effect}");
    let finding = Diagnostic::warning("P111", message).at(contact.span, label);
    report.push(finding.help("move the bodies apart, or use *CONTACT CLEARANCE or *CONTACT INITIALIZATION DATA"));
}

/// Returns whether a pair has penalty springs, which a pressure-overclosure relationship replaces.
fn has_springs(contact: &SurfaceContact) -> bool {
    contact.penalty.is_some() && !contact.law.is_soft()
}

/// Returns the initial clearance of a pair and the range of gaps to which it applies.
fn initial_clearance(contact: &SurfaceContact, length: f64) -> Option<InitialClearance> {
    contact.clearance.map(|clearance| {
        let searched = SEARCHED * length;
        let range = [-clearance.below.unwrap_or(searched), clearance.above.unwrap_or(searched)];
        InitialClearance { gap: clearance.gap, range }
    })
}

/// Returns the index of a law in the list, to which it is added if it is new.
pub fn place_of(laws: &mut Vec<InteractionLaw>, law: InteractionLaw) -> usize {
    laws.iter().position(|l| *l == law).unwrap_or_else(|| {
        laws.push(law);
        laws.len() - 1
    })
}
