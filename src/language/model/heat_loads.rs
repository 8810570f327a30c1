//! Thermal loads: `*CFLUX`, `*DFLUX`, `*DSFLUX`, `*FILM`, `*SFILM`.

use super::builder::ModelBuilder;
use super::loads::load_family;
use super::names::upper;
use super::types::{AmplitudeId, Load, LoadKind, SideSelection};
use crate::deck::{Card, DataLine, Diagnostic, Word};

impl ModelBuilder<'_> {
    pub(super) fn heat_card(&mut self, card: &Card) {
        let Ok(amplitude) = self.amplitude_of(card) else { return };
        let Ok(of_film) = self.film_amplitude(card) else { return };
        let family = card.keyword.name;
        if self.operation(card, family) {
            self.state().history.loads.retain(|l| load_family(&l.kind) != family);
        }
        let first = self.state().loads.len();
        for line in &card.lines {
            let parsed = match family {
                "CFLUX" => self.nodal_heat(line),
                "DFLUX" => self.element_heat(line),
                "DSFLUX" => self.surface_sides(line).and_then(|sides| {
                    Some((LoadKind::SurfaceHeat(sides), self.number(line, 2, "the heat flux per area")?))
                }),
                _ => self.film(line, family, of_film),
            };
            if let Some((kind, magnitude)) = parsed {
                let magnitude = self.scaled(magnitude, amplitude);
                self.state().loads.push(Load { kind, magnitude, amplitude, span: line.span });
            }
        }
        self.region_of_loads(card, first);
    }

    fn nodal_heat(&mut self, line: &DataLine) -> Option<(LoadKind, f64)> {
        let set = self.region(line)?;
        let nodes = self.original_nodes(set)?;
        Some((LoadKind::NodalHeat { nodes, set: set.text.clone() }, self.number(line, 2, "the heat flux")?))
    }

    fn element_heat(&mut self, line: &DataLine) -> Option<(LoadKind, f64)> {
        if line.field(1).is_some_and(|label| label.is("BF")) {
            let set = self.region(line)?;
            let elements = self.element_members(set)?;
            let magnitude = self.number(line, 2, "the heat source per volume")?;
            return Some((LoadKind::BodyHeat { elements, set: set.text.clone() }, magnitude));
        }
        let sides = self.element_sides(line, 'S', "S1 to S4 and BF")?;
        Some((LoadKind::SurfaceHeat(sides), self.number(line, 2, "the heat flux per area")?))
    }

    fn film(&mut self, line: &DataLine, family: &str, amplitude: Option<AmplitudeId>) -> Option<(LoadKind, f64)> {
        let sides =
            if family == "FILM" { self.element_sides(line, 'F', "F1 to F4")? } else { self.surface_sides(line)? };
        let fluid = self.number(line, 2, "the fluid temperature")?;
        let coefficient = self.number(line, 3, "the film coefficient")?;
        Some((LoadKind::Film { sides, coefficient: self.scaled(coefficient, amplitude), amplitude }, fluid))
    }

    /// Returns the element faces named by a load label: a letter and the face number.
    fn element_sides(&mut self, line: &DataLine, letter: char, known: &str) -> Option<SideSelection> {
        let set = self.region(line)?;
        let elements = self.element_members(set)?;
        let Some(label) = line.field(1) else {
            let diagnostic = Diagnostic::error("M102", "the load label is missing").at(line.span, "second field");
            return self.diagnostics.refuse(diagnostic.help(format!("supported: {known}")));
        };
        let number = upper(&label.text).strip_prefix(letter).and_then(|n| n.parse::<u8>().ok());
        let Some(number) = number.filter(|n| (1..=4).contains(n)) else {
            let message = format!("load type {} is not supported", label.text);
            let diagnostic = Diagnostic::error("M132", message).at(label.span, "this label");
            return self.diagnostics.refuse(diagnostic.help(format!("supported: {known}")));
        };
        let word = Word { text: format!("S{number}"), ..label.clone() };
        Some(SideSelection {
            name: set.text.clone(),
            surface: false,
            faces: self.sides(set, &elements, &word),
            free_face_elements: Vec::new(),
        })
    }

    fn surface_sides(&mut self, line: &DataLine) -> Option<SideSelection> {
        let word = self.region(line)?;
        self.loaded_sides(word)
    }
}
