//! Blast waves: `*INCIDENT WAVE INTERACTION PROPERTY`, `*CONWEP CHARGE PROPERTY`, `*INCIDENT WAVE INTERACTION`.

use super::context::Context;
use super::families::{ConditionReader, StepReader};
use super::names::upper;
use super::surfaces;
use super::types::{BlastCharge, BlastProperty, Load, LoadKind};
use crate::deck::Card;
use crate::kernel::blast_wave::BurstShape;

pub fn read_blast_property(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    let Some(name) = context.required(card, "NAME").map(|word| upper(&word.text)) else { return };
    let is_surface_burst: usize = card.read("TYPE");
    let shape = [BurstShape::Spherical, BurstShape::Hemispherical][is_surface_burst];
    let charge = BlastCharge { shape, mass: 0.0, units: [1.0; 3] };
    conditions.blasts.push(BlastProperty { name, charge, has_charge: false });
}

/// Reads mass and units of a charge. The first line has the mass and its factor to kilograms, the second line, which
/// may be missing, the factors from the units of the model to metres, seconds and pascals.
pub fn read_blast_charge(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    let Some(line) = context.first_line(card) else { return };
    let (Some(mass), Some(factor)) = (context.number(line, 0, "the mass of TNT"), context.number_or(line, 1, 1.0))
    else {
        return;
    };
    let Some(units) = card.lines.get(1).map_or(Some([1.0; 3]), |line| context.numbers_or(line, 0, 1.0)) else {
        return;
    };
    if let Some(property) = conditions.blasts.last_mut() {
        property.charge = BlastCharge { mass: mass * factor, units, ..property.charge };
        property.has_charge = true;
    }
}

pub fn read_incident_wave(
    context: &mut Context<'_>,
    conditions: &mut ConditionReader,
    steps: &mut StepReader,
    card: &Card,
) {
    if !card.has("CONWEP") {
        let help = "give the pressure history as *DSLOAD, P with *AMPLITUDE, or as PNU with a VDLOAD user subroutine";
        return context.unsupported(card.span, "only waves of *CONWEP CHARGE PROPERTY (CONWEP) are supported", help);
    }
    let Some(word) = context.required(card, "PROPERTY") else { return };
    let Some(property) = conditions.blasts.iter().find(|property| property.name == upper(&word.text)) else {
        let names: Vec<String> = conditions.blasts.iter().map(|property| property.name.clone()).collect();
        return context.unknown("M113", "incident wave interaction property", word, |_| names.clone());
    };
    let charge = property.charge;
    if !property.has_charge {
        let message = format!("{} has no *CONWEP CHARGE PROPERTY", word.text);
        return context.error("M102", message, word.span, "this property");
    }
    for line in &card.lines {
        let Some(sides) = context.region(line).and_then(|set| surfaces::loaded_sides(context, set)) else { continue };
        let Some(word) = line.field(1) else {
            context.error("M102", "the source node is missing", line.span, "second field");
            continue;
        };
        let Some(source) = context.single_node(word, "the source") else { continue };
        let position = context.model.mesh.points[source];
        if position[0] != 0.0 {
            let message = format!("the source must be on the axis of symmetry, found r = {}", position[0]);
            context.out_of_range(word.span, message);
        }
        let (Some(detonation), Some(magnitude)) = (context.number_or(line, 2, 0.0), context.number_or(line, 3, 1.0))
        else {
            continue;
        };
        let kind = LoadKind::Blast { sides, charge, height: position[1], detonation };
        steps.state().loads.push(Load { kind, magnitude, amplitude: None, span: line.span });
    }
}
