//! Mechanical loads: `*CLOAD`, `*DLOAD`, `*DSLOAD`.

use super::context::Context;
use super::families::StepReader;
use super::names::upper;
use super::types::{AmplitudeId, BodyForce, ElementSide, Load, LoadKind, SideSelection, SurfaceTraction, TargetId};
use super::{adaptive, amplitudes, completion, surfaces};
use crate::deck::{Card, DataLine, Diagnostic, Word};
use crate::platform::PortableMath as _;

/// Supported load type labels.
const LABELS: &str = "GRAV, BR, BZ, BRNU, BZNU, CENTRIF, P, VP, TRVEC, TRSHR and PNU (on element faces P1 to P4, P1NU to P4NU, VP1 ..., \
                      TRVEC1 ..., TRSHR1 ...), CAVITY";

/// Kind and magnitude of the load of a data line.
pub type ReadLoad = (LoadKind, f64);

pub fn read_loads(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Ok(amplitude) = amplitudes::amplitude_of(context, card, "AMPLITUDE") else { return };
    check_load_options(context, card);
    read_lines(context, steps, card, amplitude, |context, line| match card.keyword.name {
        "CLOAD" => concentrated(context, line),
        "DLOAD" => element_load(context, card, line),
        _ => surface_load(context, card, line),
    });
}

/// Reads the loads of a card line by line. OP=NEW removes the loads of its family from earlier steps.
pub fn read_lines(
    context: &mut Context<'_>,
    steps: &mut StepReader,
    card: &Card,
    amplitude: Option<AmplitudeId>,
    read: impl Fn(&mut Context<'_>, &DataLine) -> Option<ReadLoad>,
) {
    let family = card.keyword.name;
    if steps.operation(card, family) {
        steps.state().history.loads.retain(|l| load_family(&l.kind) != family);
    }
    let first = steps.state().loads.len();
    for line in &card.lines {
        if let Some((kind, magnitude)) = read(context, line) {
            let magnitude = amplitudes::scaled(context, magnitude, amplitude);
            steps.state().loads.push(Load { kind, magnitude, amplitude, span: line.span });
        }
    }
    adaptive::region_of_loads(steps, card, first);
}

/// Reports `TARGET` and `FRICTION` without a CAVITY load, and direction components without GRAV.
fn check_load_options(context: &mut Context<'_>, card: &Card) {
    let is = |line: &DataLine, label: &str| line.field(1).is_some_and(|w| w.is(label));
    if !card.lines.iter().any(|line| is(line, "CAVITY")) {
        for parameter in card.parameters.iter().filter(|p| matches!(p.name, "TARGET" | "FRICTION")) {
            let message = format!("{} requires a CAVITY load, and this card has none", parameter.name);
            context.unsupported(parameter.span, message, "remove it, or use the load type CAVITY");
        }
    }
    let begins = |line: &DataLine, label: &str| line.field(1).is_some_and(|w| upper(&w.text).starts_with(label));
    let directed = |line: &DataLine| ["GRAV", "TRVEC", "TRSHR", "CENTRIF"].iter().any(|label| begins(line, label));
    for line in card.lines.iter().filter(|l| card.keyword.name != "CLOAD" && !directed(l)) {
        if let Some(word) = (3..9).find_map(|k| line.field(k)) {
            context.report_surplus(word, "only GRAV, TRVEC, TRSHR and CENTRIF have direction components");
        }
    }
    let uses = |label: &str| card.lines.iter().any(|line| begins(line, label));
    if let Some(parameter) = card.parameters.iter().find(|p| p.name == "REF NODE").filter(|_| !uses("VP")) {
        context.unsupported(parameter.span, "REF NODE requires a viscous pressure (VP)", "remove it");
    }
    let fixed = card.parameters.iter().find(|p| p.name == "FOLLOWER").filter(|_| !card.read::<bool>("FOLLOWER"));
    if let Some(parameter) = fixed.filter(|_| card.lines.iter().any(|line| !begins(line, "TRVEC"))) {
        let help = "put the TRVEC loads on a separate card";
        let message = "FOLLOWER=NO applies only to TRVEC: other tractions follow their faces";
        context.unsupported(parameter.span, message, help);
    }
}

fn concentrated(context: &mut Context<'_>, line: &DataLine) -> Option<ReadLoad> {
    let set = context.region(line)?;
    let nodes = context.original_nodes(set)?;
    let dof = context.integer(line, 1, "the degree of freedom")? as u8;
    let magnitude = context.number(line, 2, "the force")?;
    Some((LoadKind::Concentrated { nodes, dof, set: set.text.clone() }, magnitude))
}

/// Returns the load label of a line, or reports that it is missing.
pub fn label<'l>(context: &mut Context<'_>, line: &'l DataLine, supported: &str) -> Option<&'l Word> {
    let word = line.field(1);
    if word.is_none() {
        let diagnostic = Diagnostic::error("M102", "the load label is missing").at(line.span, "second field");
        context.diagnostics.push(diagnostic.help(format!("supported: {supported}")));
    }
    word
}

/// Reports an unsupported load label.
pub fn unknown_label<T>(context: &mut Context<'_>, label: &Word, supported: &str) -> Option<T> {
    let message = format!("load type {} is not supported", label.text);
    let diagnostic = Diagnostic::error("M132", message).at(label.span, "this label");
    context.diagnostics.refuse(diagnostic.help(format!("supported: {supported}")))
}

fn element_load(context: &mut Context<'_>, card: &Card, line: &DataLine) -> Option<ReadLoad> {
    let label = label(context, line, LABELS)?;
    let name = upper(&label.text);
    if name == "GRAV" {
        return gravity(context, line);
    }
    let set = context.region(line)?;
    let elements = context.element_members(set)?;
    if let "BRNU" | "BZNU" = name.as_str() {
        let load_type = if name == "BRNU" { 1 } else { 2 };
        let kind = LoadKind::UserBody { elements, set: set.text.clone(), load_type };
        return Some((kind, context.number_or(line, 2, 1.0)?));
    }
    if let Some(law) = body_force(&name) {
        let magnitude = context.number(line, 2, "the body force")?;
        if law == BodyForce::Centrifugal {
            check_rotation_axis(context, line);
        }
        return Some((LoadKind::Body { elements, set: set.text.clone(), law }, magnitude));
    }
    if let Some((traction, face)) = traction(&name) {
        let side = Word { text: if face.is_empty() { "SPOS".into() } else { format!("S{face}") }, ..label.clone() };
        let faces = surfaces::sides(context, set, &elements, &side);
        let sides = SideSelection { name: set.text.clone(), surface: false, faces, free_face_elements: Vec::new() };
        return traction_load(context, card, line, sides, traction);
    }
    let user = name.strip_suffix("NU");
    let number = user.unwrap_or(&name).strip_prefix('P');
    let side = match (number, name.as_str()) {
        // P on RAX2: pressure on the positive side (ABAQUS Elements Guide, rigid element library).
        (Some(""), _) | (_, "CAVITY") => "SPOS".to_owned(),
        (Some(n), _) if n.parse::<u8>().is_ok_and(|n| (1..=4).contains(&n)) => format!("S{n}"),
        _ => return unknown_label(context, label, LABELS),
    };
    let is_positive = side == "SPOS";
    let mut faces = surfaces::sides(context, set, &elements, &Word { text: side, ..label.clone() });
    if is_positive {
        orient_shell_sides(context, &mut faces);
    }
    let sides = SideSelection { name: set.text.clone(), surface: false, faces, free_face_elements: Vec::new() };
    // Load type codes of VDLOAD: 20 is PNU, 21 to 24 are P1NU to P4NU.
    let load_type = user.map(|_| 20 + number.and_then(|n| n.parse::<i32>().ok()).unwrap_or(0));
    if name == "CAVITY" {
        return cavity_load(context, card, line, sides);
    }
    pressure(context, line, sides, load_type)
}

/// Selects the negative sides of shell elements: positive pressure on shell elements acts along their normals
/// (ABAQUS Analysis User's Guide 29.6.1, "Shell elements: overview").
fn orient_shell_sides(context: &Context<'_>, sides: &mut [(usize, ElementSide)]) {
    for (element, side) in sides {
        if context.model.mesh.elements[*element].kind.is_shell() {
            *side = ElementSide::Negative;
        }
    }
}

fn surface_load(context: &mut Context<'_>, card: &Card, line: &DataLine) -> Option<ReadLoad> {
    let word = context.region(line)?;
    let sides = surfaces::loaded_sides(context, word)?;
    let label = label(context, line, LABELS)?;
    let name = upper(&label.text);
    if let Some((traction, "")) = traction(&name) {
        return traction_load(context, card, line, sides, traction);
    }
    if !matches!(name.as_str(), "P" | "PNU" | "CAVITY") {
        return unknown_label(context, label, LABELS);
    }
    if name == "CAVITY" {
        return cavity_load(context, card, line, sides);
    }
    pressure(context, line, sides, (name == "PNU").then_some(0))
}

fn pressure(context: &mut Context<'_>, line: &DataLine, sides: SideSelection, user: Option<i32>) -> Option<ReadLoad> {
    if let Some(load_type) = user {
        return Some((LoadKind::User { sides, load_type }, context.number_or(line, 2, 1.0)?));
    }
    Some((LoadKind::Pressure(sides), context.number(line, 2, "the pressure")?))
}

fn traction_load(
    context: &mut Context<'_>,
    card: &Card,
    line: &DataLine,
    sides: SideSelection,
    label: &str,
) -> Option<ReadLoad> {
    let magnitude = context.number(line, 2, "the traction")?;
    if label == "VP" {
        let first_node = |context: &mut Context<'_>, word: &Word| context.node_members(word)?.first().copied();
        let reference = context.optional(card.value("REF NODE"), first_node)?;
        return Some((LoadKind::Traction { sides, law: SurfaceTraction::Viscous { reference } }, magnitude));
    }
    let [r, z, third] = context.numbers_or(line, DIRECTION, 0.0)?;
    let length = r.portable_hypot(z);
    if length == 0.0 || third != 0.0 {
        let message = format!("{label} requires a direction: magnitude, r, z; the third component must be 0");
        return context.refuse_value(line.span, message);
    }
    let direction = [r / length, z / length];
    let law = match label {
        "TRSHR" => SurfaceTraction::Shear { direction },
        _ => SurfaceTraction::Vector { direction, follows: card.read("FOLLOWER") },
    };
    Some((LoadKind::Traction { sides, law }, magnitude))
}

/// First field of the three components of the direction, after the magnitude.
const DIRECTION: usize = 3;

/// Reports a centrifugal load about another axis than that of symmetry: its point must have r = 0, and its
/// direction must be z.
fn check_rotation_axis(context: &mut Context<'_>, line: &DataLine) {
    let value = |k: usize| line.field(k).and_then(|word| Some((word, word.text.parse::<f64>().ok()?)));
    let off = [3, 5, 6, 8].into_iter().filter_map(value).find(|(_, given)| *given != 0.0);
    let along = value(7).filter(|(_, given)| *given == 0.0);
    if let Some((word, _)) = off.or(along) {
        let message = "CENTRIF rotates about the axis of symmetry: its point has r = 0 and its direction is 0, 1, 0";
        context.out_of_range(word.span, message);
    }
}

fn cavity_load(context: &mut Context<'_>, card: &Card, line: &DataLine, sides: SideSelection) -> Option<ReadLoad> {
    if let Some(word) = line.field(2).filter(|word| !word.text.parse().is_ok_and(|value: f64| value == 1.0)) {
        context.report_surplus(word, "CAVITY has no magnitude: the target determines the pressure");
    }
    let word = context.required(card, "TARGET")?;
    let target = context.model.targets.iter().position(|t| t.name == upper(&word.text));
    if target.is_none() {
        let names: Vec<String> = context.model.targets.iter().map(|t| t.name.clone()).collect();
        context.unknown("M113", "target", word, |_| names.clone());
    }
    let friction = card.read("FRICTION");
    Some((LoadKind::Cavity { sides, target: TargetId::new(target?), friction }, 1.0))
}

fn gravity(context: &mut Context<'_>, line: &DataLine) -> Option<ReadLoad> {
    let elements = context.optional(line.field(0), Context::element_members)?;
    let magnitude = context.number(line, 2, "the acceleration")?;
    let direction @ [r, z, third] = context.numbers_or(line, DIRECTION, 0.0)?;
    let length = r.portable_hypot(z).portable_hypot(third);
    if length == 0.0 {
        return context
            .refuse_value(line.span, "GRAV requires a direction: magnitude, r, z (in oblique impact: 1, 2, 3)");
    }
    if (r != 0.0 || third != 0.0) && magnitude != 0.0 && !completion::has_oblique_impact(context) {
        let message = "gravity along r has no resultant on a body of revolution; only its z component acts";
        let help = "give the direction as 0., 1. or 0., -1.";
        context.warning("M152", message, line.span, "direction with an r component", help);
    }
    Some((LoadKind::Gravity { elements, direction: direction.map(|d| d / length) }, magnitude))
}

fn body_force(label: &str) -> Option<BodyForce> {
    match label {
        "BR" => Some(BodyForce::Radial),
        "BZ" => Some(BodyForce::Axial),
        "CENTRIF" => Some(BodyForce::Centrifugal),
        _ => None,
    }
}

/// Returns the name of a traction label and the number of the element face after it, which may be empty.
fn traction(label: &str) -> Option<(&'static str, &str)> {
    let known = |name: &'static str| Some((name, label.strip_prefix(name)?));
    let named = ["TRVEC", "TRSHR", "VP"].into_iter().find_map(known);
    named.filter(|(_, face)| matches!(*face, "" | "1" | "2" | "3" | "4"))
}

/// Returns the keyword of the cards that define a load of this kind.
fn load_family(kind: &LoadKind) -> &'static str {
    let is_on_surface = kind.sides().is_some_and(|sides| sides.surface);
    match kind {
        LoadKind::Concentrated { .. } => "CLOAD",
        LoadKind::Blast { .. } => "INCIDENT WAVE INTERACTION",
        LoadKind::NodalHeat { .. } => "CFLUX",
        LoadKind::SurfaceHeat(_) if is_on_surface => "DSFLUX",
        LoadKind::SurfaceHeat(_) | LoadKind::BodyHeat { .. } => "DFLUX",
        LoadKind::Film { .. } if is_on_surface => "SFILM",
        LoadKind::Film { .. } => "FILM",
        _ if is_on_surface => "DSLOAD",
        _ => "DLOAD",
    }
}
