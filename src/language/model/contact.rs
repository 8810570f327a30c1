//! Analytical surfaces and contact pairs: `*SURFACE, TYPE=SEGMENTS`, `*RIGID SURFACE`, `*CONTACT PAIR`.

use super::context::Context;
use super::families::{MeshReader, StepReader};
use super::names::{qualified, upper};
use super::refinement::listed;
use super::surface_contact;
use super::types::{
    AnalyticalSide, InteractionId, Model, ProfileSegment, RigidBody, RigidSurface, RigidSurfaceId, SideSelection,
    SurfaceProfile,
};
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::lists::sorted_unique;
use crate::platform::PortableMath as _;

/// Relative difference of the radii at both ends of an arc that is treated as rounding.
const ARC_ROUNDING: f64 = 1e-6;
/// Largest relative difference of the radii that is corrected; beyond it the arc is invalid.
const ARC_LIMIT: f64 = 1e-2;

/// Returns the point on the perpendicular bisector of `a` and `b` that is nearest to `centre`.
fn equidistant_centre(a: [f64; 2], b: [f64; 2], centre: [f64; 2]) -> [f64; 2] {
    let chord = [b[0] - a[0], b[1] - a[1]];
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let off = ((centre[0] - middle[0]) * chord[0] + (centre[1] - middle[1]) * chord[1])
        / (chord[0] * chord[0] + chord[1] * chord[1]);
    [centre[0] - off * chord[0], centre[1] - off * chord[1]]
}

/// Reads an analytical surface: START, then LINE and CIRCL (ABAQUS Keywords Reference Guide, *SURFACE,
/// TYPE=SEGMENTS).
pub fn analytical_surface(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card, name: &Word) {
    let Some((start, rest)) = card.lines.split_first() else {
        let message = "an analytical surface must start with `START, r, z`";
        return context.error("M102", message, card.span, "no data lines");
    };
    let Some(mut at) = surface_point(context, start, "START") else { return };
    let (mut segments, mut lines) = (Vec::new(), Vec::new());
    for line in rest {
        let Some(segment) = segment(context, line, at) else { return };
        at = segment.ends()[1];
        segments.push(segment);
        lines.push(line.span);
    }
    if segments.is_empty() {
        return context.out_of_range(start.span, "an analytical surface requires a LINE or CIRCL after START");
    }
    let mut profile = SurfaceProfile { segments };
    if let Some(word) = card.value("FILLET RADIUS") {
        let Some(radius) = word.number(&mut context.diagnostics) else { return };
        if radius.is_nan() || radius < 0.0 {
            return context.out_of_range(word.span, format!("FILLET RADIUS must not be negative, found {radius}"));
        }
        if radius > 0.0 {
            match profile.fillet(radius) {
                Ok(rounded) => profile = rounded,
                Err(k) => {
                    let message = format!("a fillet of radius {radius} does not fit at the start of this segment");
                    return context.out_of_range(lines[k], message);
                }
            }
        }
    }
    let profile = placed(mesh, profile);
    let surface = RigidSurface { profile, reference: None, span: card.span };
    let key = qualified(&context.scope, &name.text);
    let first = context.model.surfaces.analytical.get(&key);
    if let Some(first) = first.filter(|_| !context.missing.faulty.contains(&card.span)) {
        let message = format!("the surface {} is defined twice", name.text);
        let spans = [first.span, card.span];
        return context.refuse_second(message, spans);
    }
    context.model.surfaces.analytical.insert(key, surface);
}

/// Places a profile by the current instance. If the placement mirrors the plane, the profile is reversed, so that
/// its contact side is preserved.
fn placed(mesh: &MeshReader, profile: SurfaceProfile) -> SurfaceProfile {
    let Some(placement) = &mesh.placement else { return profile };
    let put = |p: [f64; 2]| placement.apply(p);
    let moved = |s: &ProfileSegment| match *s {
        ProfileSegment::Line(ends) => ProfileSegment::Line(ends.map(put)),
        ProfileSegment::Arc(ends, centre, ..) => ProfileSegment::arc(put(ends[0]), put(ends[1]), put(centre)),
    };
    let placed = SurfaceProfile { segments: profile.segments.iter().map(moved).collect() };
    let [o, r, z] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(put);
    let turned = (r[0] - o[0]) * (z[1] - o[1]) - (r[1] - o[1]) * (z[0] - o[0]) < 0.0;
    if turned { placed.reversed() } else { placed }
}

fn surface_point(context: &mut Context<'_>, line: &DataLine, word: &str) -> Option<[f64; 2]> {
    if !line.field(0).is_some_and(|w| w.is(word)) {
        return context.refuse_value(line.span, format!("an analytical surface must start with `{word}, r, z`"));
    }
    if let Some(surplus) = line.field(3).or(line.field(4)) {
        context.report_surplus(surplus, "START has two coordinates");
    }
    Some([context.number(line, 1, "r")?, context.number(line, 2, "z")?])
}

/// Reads the segment of a data line, which starts at the end of the previous one.
fn segment(context: &mut Context<'_>, line: &DataLine, from: [f64; 2]) -> Option<ProfileSegment> {
    let is = |what: &str| line.field(0).is_some_and(|w| w.is(what));
    if !is("LINE") && !is("CIRCL") {
        let help = "use LINE or CIRCL";
        return context.refuse_unsupported(line.span, "this segment of an analytical surface is not supported", help);
    }
    let end = [context.number(line, 1, "r")?, context.number(line, 2, "z")?];
    if from == end {
        return context.refuse_value(line.span, "this segment has zero length");
    }
    if is("LINE") {
        if let Some(surplus) = line.field(3).or(line.field(4)) {
            context.report_surplus(surplus, "LINE has two coordinates; CIRCL has a centre");
        }
        return Some(ProfileSegment::Line([from, end]));
    }
    let centre = [context.number(line, 3, "r of the centre")?, context.number(line, 4, "z of the centre")?];
    let centre = equidistant_centre(from, end, arc_centre(context, from, end, centre, line.span)?);
    let (u, v) = ([from[0] - centre[0], from[1] - centre[1]], [end[0] - centre[0], end[1] - centre[1]]);
    let sine = (u[0] * v[1] - u[1] * v[0]) / (u[0].portable_hypot(u[1]) * v[0].portable_hypot(v[1]));
    if sine.abs() < 1e-6 {
        return context.refuse_value(line.span, "an arc must be shorter than half a circle; split it into two arcs");
    }
    Some(ProfileSegment::arc(from, end, centre))
}

/// Returns the centre of an arc. If the distances to the ends differ by more than rounding, the centre is corrected
/// with a warning; if they differ by more than 1 % of the radius, an error is reported.
pub fn arc_centre(
    context: &mut Context<'_>,
    from: [f64; 2],
    to: [f64; 2],
    centre: [f64; 2],
    span: Span,
) -> Option<[f64; 2]> {
    let [a, b] = [from, to].map(|p| (p[0] - centre[0]).portable_hypot(p[1] - centre[1]));
    let off = (a - b).abs() / a.max(b);
    if off <= ARC_ROUNDING {
        return Some(centre);
    }
    let message = format!(
        "the ends of the arc have the distances {a} and {b} from the centre ({}, {}); relative difference {off:.1e}",
        centre[0], centre[1]
    );
    if off.is_nan() || off > ARC_LIMIT {
        let diagnostic = Diagnostic::error("M103", message).at(span, "no circle about this centre");
        return context.diagnostics.refuse(diagnostic.help("the relative difference may be 1e-2 at most"));
    }
    context.warning("M170", message, span, "the nearest valid centre is used", "give the centre with more digits");
    Some(equidistant_centre(from, to, centre))
}

/// Reads an analytical surface with its reference node in the older syntax (ABAQUS Keywords Reference Guide, *RIGID
/// SURFACE).
pub fn read_rigid_surface(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    if !card.value("TYPE").is_some_and(|w| w.is("SEGMENTS")) {
        let message = "*RIGID SURFACE supports TYPE=SEGMENTS only, a surface of revolution";
        return context.unsupported(card.span, message, "use TYPE=SEGMENTS");
    }
    let Some(name) = card.value("NAME").or(card.value("ELSET")) else {
        context.required(card, "NAME");
        return;
    };
    analytical_surface(context, mesh, card, name);
    let Some(word) = card.value("REF NODE") else { return };
    let Some(reference) = context.single_node(word, "REF NODE") else { return };
    if let Some(surface) = context.model.surfaces.analytical.get_mut(&qualified(&context.scope, &name.text)) {
        surface.reference = Some(reference);
    }
    if context.model.rigid_bodies.iter().any(|b| b.reference == reference) {
        return;
    }
    let (elements, nodes, name) = (Vec::new(), Vec::new(), upper(&name.text));
    let body = RigidBody { name, reference, elements, nodes, thickness: 0.0, density: 0.0, span: card.span };
    context.model.rigid_bodies.push(body);
}

/// Assigns an analytical surface to the rigid body with a reference node.
pub fn carry_surface(context: &mut Context<'_>, word: &Word, reference: usize) {
    match analytical_id(context, word) {
        Some(id) => context.model.surfaces.analytical[id].reference = Some(reference),
        None => context
            .unknown("M114", "analytical surface", word, |c| c.model.surfaces.analytical.keys().cloned().collect()),
    }
}

pub fn contact_note(context: &mut Context<'_>, card: &Card) {
    if !context.deck.cards.iter().any(|c| matches!(c.keyword.name, "CONTACT PAIR" | "CONTACT")) {
        context.inert(card, "it is used by contact only");
    }
}

pub fn read_contact_pair(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    if context.first_line(card).is_none() {
        return;
    }
    for line in &card.lines {
        let Some(first) = line.field(0) else {
            context.error("M102", "a contact pair requires two surfaces", line.span, "here");
            continue;
        };
        // A single surface defines self-contact.
        let second = line.field(1).unwrap_or(first);
        let (side, surface, other) = match (analytical_id(context, first), analytical_id(context, second)) {
            (Some(surface), None) => (0, surface, second),
            (None, Some(surface)) => (1, surface, first),
            _ if context.missing.explains("surface", first) || context.missing.explains("surface", second) => continue,
            (None, None) => {
                surface_contact::surface_pair(context, steps, card, line, [first, second]);
                continue;
            }
            _ => {
                let message = "both surfaces of this contact pair are analytical";
                context.unsupported(line.span, message, "one of the surfaces must have elements or nodes");
                continue;
            }
        };
        let Some((nodes, sides)) = nodes_and_faces(context, other) else { continue };
        let rigid = SideSelection::new(context.model.surfaces.analytical_name(surface), &[]);
        // Nodes of shells contact an analytical surface on either side.
        let sides = SideSelection { faces: sides.first_sides(), ..sides };
        let sides = if side == 0 { [rigid, sides] } else { [sides, rigid] };
        let analytical = AnalyticalSide { side, surface, nodes };
        surface_contact::add_pair(context, steps, card, line, sides, Some(analytical));
    }
}

/// Returns the analytical surface with a name.
pub fn analytical_id(context: &Context<'_>, word: &Word) -> Option<RigidSurfaceId> {
    let known = &context.model.surfaces.analytical;
    context.names_of(word).iter().find_map(|name| known.get_index_of(name)).map(RigidSurfaceId::new)
}

/// Copies the laws of interactions to the contacts after all cards are read; a pair may precede its interaction.
pub fn apply_interactions(context: &mut Context<'_>) {
    let names: Vec<String> = context.model.interactions.iter().map(|i| i.name.clone()).collect();
    let mut used = std::mem::take(&mut context.names.interactions_used);
    used.dedup_by_key(|word| word.span);
    for word in used.iter().filter(|word| !names.contains(&upper(&word.text))) {
        context.unknown("M114", "surface interaction", word, |_| names.clone());
    }
    let Model { interactions, steps, .. } = &mut context.model;
    let law = |id: Option<InteractionId>| {
        id.and_then(|id| interactions.get(id.index())).map(|i| i.law.clone()).unwrap_or_default()
    };
    for step in steps {
        step.surface_contacts.iter_mut().for_each(|contact| contact.law = law(contact.interaction));
        let assigned = step.general_contact.iter_mut().flat_map(|general| &mut general.assigned);
        assigned.for_each(|assigned| assigned.law = law(assigned.interaction));
    }
}

/// Returns the surface interaction with a name, which may be defined later.
pub fn interaction(context: &mut Context<'_>, word: &Word) -> Option<InteractionId> {
    context.names.interactions_used.push(word.clone());
    context.names.interactions.get(&upper(&word.text)).copied().map(InteractionId::new)
}

/// Returns the nodes of a surface, ascending, and its faces; a node-based surface has no faces.
pub fn nodes_and_faces(context: &mut Context<'_>, word: &Word) -> Option<(Vec<usize>, SideSelection)> {
    for name in context.names_of(word) {
        if let Some(nodes) = context.model.surfaces.nodes.get(&name) {
            return Some((nodes.clone(), SideSelection::new(&name, &[])));
        }
    }
    let id = context.surface_id(word)?;
    let (mesh, name) = (&context.model.mesh, context.model.surfaces.name(id).to_owned());
    let faces = context.model.surfaces.faces[id].faces.clone();
    let nodes: Vec<usize> = sorted_unique(faces.iter().filter_map(|&(e, side)| mesh.side_nodes(e, side)).flatten());
    Some((nodes, SideSelection { name, surface: true, faces, free_face_elements: Vec::new() }))
}

/// Defines a node-based surface from node sets and single nodes.
pub fn node_surface(context: &mut Context<'_>, card: &Card, name: &Word) {
    let words = card.lines.iter().filter_map(|l| l.field(0));
    let between = listed::between_labels(context, words.clone());
    if let Some(last) = card.lines.last().filter(|_| !between.is_empty()) {
        context.add_node_line(last.span, &between, "");
    }
    let nodes = words.filter_map(|w| context.node_members(w)).flatten();
    let nodes: Vec<usize> = sorted_unique(nodes.chain(between));
    context.model.surfaces.nodes.insert(qualified(&context.scope, &name.text), nodes);
    if !context.deck.cards.iter().any(|c| matches!(c.keyword.name, "COUPLING" | "TIE")) {
        contact_note(context, card);
    }
}
