//! Thermal loads: `*CFLUX`, `*DFLUX`, `*DSFLUX`, `*FILM`, `*SFILM`.

use super::context::Context;
use super::families::StepReader;
use super::loads::{ReadLoad, label, read_lines, unknown_label};
use super::names::upper;
use super::types::{AmplitudeId, LoadKind, SideSelection};
use super::{amplitudes, surfaces};
use crate::deck::{Card, DataLine, Word};

pub fn read_heat_loads(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let Ok(amplitude) = amplitudes::amplitude_of(context, card, "AMPLITUDE") else { return };
    let Ok(of_film) = amplitudes::amplitude_of(context, card, "FILM AMPLITUDE") else { return };
    read_lines(context, steps, card, amplitude, |context, line| match card.keyword.name {
        "CFLUX" => nodal_heat(context, line),
        "DFLUX" => element_heat(context, line),
        "DSFLUX" => {
            let sides = surface_sides(context, line)?;
            Some((LoadKind::SurfaceHeat(sides), context.number(line, 2, "the heat flux per area")?))
        }
        family => film(context, line, family, of_film),
    });
}

fn nodal_heat(context: &mut Context<'_>, line: &DataLine) -> Option<ReadLoad> {
    let set = context.region(line)?;
    let nodes = context.original_nodes(set)?;
    Some((LoadKind::NodalHeat { nodes, set: set.text.clone() }, context.number(line, 2, "the heat flux")?))
}

fn element_heat(context: &mut Context<'_>, line: &DataLine) -> Option<ReadLoad> {
    if line.field(1).is_some_and(|label| label.is("BF")) {
        let set = context.region(line)?;
        let elements = context.element_members(set)?;
        let magnitude = context.number(line, 2, "the heat source per volume")?;
        return Some((LoadKind::BodyHeat { elements, set: set.text.clone() }, magnitude));
    }
    let sides = element_sides(context, line, 'S', "S1 to S4 and BF")?;
    Some((LoadKind::SurfaceHeat(sides), context.number(line, 2, "the heat flux per area")?))
}

fn film(context: &mut Context<'_>, line: &DataLine, family: &str, amplitude: Option<AmplitudeId>) -> Option<ReadLoad> {
    let sides =
        if family == "FILM" { element_sides(context, line, 'F', "F1 to F4")? } else { surface_sides(context, line)? };
    let fluid = context.number(line, 2, "the fluid temperature")?;
    let coefficient = context.number(line, 3, "the film coefficient")?;
    Some((LoadKind::Film { sides, coefficient: amplitudes::scaled(context, coefficient, amplitude), amplitude }, fluid))
}

/// Returns the element faces named by a load label: a letter and the face number.
fn element_sides(context: &mut Context<'_>, line: &DataLine, letter: char, known: &str) -> Option<SideSelection> {
    let set = context.region(line)?;
    let elements = context.element_members(set)?;
    let label = label(context, line, known)?;
    let number = upper(&label.text).strip_prefix(letter).and_then(|n| n.parse::<u8>().ok());
    let Some(number) = number.filter(|n| (1..=4).contains(n)) else {
        return unknown_label(context, label, known);
    };
    let word = Word { text: format!("S{number}"), ..label.clone() };
    let (name, faces) = (set.text.clone(), surfaces::sides(context, set, &elements, &word));
    Some(SideSelection { name, surface: false, faces, free_face_elements: Vec::new() })
}

fn surface_sides(context: &mut Context<'_>, line: &DataLine) -> Option<SideSelection> {
    let word = context.region(line)?;
    surfaces::loaded_sides(context, word)
}
