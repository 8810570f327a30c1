//! `*BOUNDARY`.
//! Never here: what becomes of boundaries over the steps.

use super::builder::Builder;
use super::degrees::Rotational;
use super::names::upper;
use super::types::{AmplitudeId, Boundary, Motion};
use crate::deck::{Card, DataLine, Diagnostic, Word};

/// What a line of `*BOUNDARY` names.
struct Degrees {
    /// First and last degree of freedom.
    range: [u8; 2],
    /// The rotation besides, of a named symmetry.
    rotation: Option<u8>,
}

impl Degrees {
    fn range(first: u8, last: u8) -> Degrees {
        Degrees { range: [first, last], rotation: None }
    }
}

impl Builder<'_> {
    pub(super) fn boundary(&mut self, card: &Card) {
        let kinds = [Motion::Displacement, Motion::Velocity, Motion::Acceleration];
        let kind = match card.read::<Option<usize>>("TYPE") {
            None if card.has("TYPE") => return,
            kind => kinds[kind.unwrap_or(0)],
        };
        let user = card.has("USER");
        let ramp = self.step.as_ref().is_some_and(|s| s.ramp);
        let Ok(amplitude) = self.amplitude_of(card) else { return };
        self.boundary_operation(card);
        for line in &card.lines {
            let Some(set) = line.field(0) else { continue };
            let Some(nodes) = self.node_members(set) else { continue };
            let Some((degrees, value)) = self.boundary_dofs(line) else { continue };
            let ([first, last], rotation) = (degrees.range, degrees.rotation);
            let value = self.scaled(value, amplitude);
            if first == 11 {
                let line = (line, set.text.clone(), nodes, value);
                self.held_temperature(card, line, amplitude);
                continue;
            }
            if self.step.is_none() && (value != 0.0 || user) {
                self.before_steps(line);
                continue;
            }
            if kind == Motion::Displacement && value != 0.0 && amplitude.is_none() && !user && !ramp {
                let message = format!(
                    "the displacement {value} has no AMPLITUDE and would be a jump: it is ignored, the motion is held"
                );
                let finding = Diagnostic::warning("M140", message).at(line.span, "as ABAQUS/Explicit does");
                self.diagnostics.push(finding.help("give AMPLITUDE=, or prescribe a velocity"));
            }
            if first > 2 {
                let (span, set, nodes) = (line.span, set.text.clone(), nodes.clone());
                self.rotational.push(Rotational { span, set, dofs: [first, last], nodes, lost: "is held", value });
            }
            for dof in (first..=last).chain(rotation) {
                let boundary = Boundary {
                    nodes: nodes.clone(),
                    set: set.text.clone(),
                    dof,
                    kind,
                    user,
                    value,
                    amplitude,
                    span: line.span,
                };
                self.state().boundaries.push(boundary);
            }
        }
    }

    /// Degree of freedom 11: a value without amplitude is there at once (ABAQUS Analysis User's Guide 34.1.2, "Amplitude
    /// curves").
    fn held_temperature(
        &mut self,
        card: &Card,
        (line, set, nodes, value): (&DataLine, String, Vec<usize>, f64),
        amplitude: Option<AmplitudeId>,
    ) {
        let refusal = if card.has("USER") || card.value("TYPE").is_some_and(|w| !w.is("DISPLACEMENT")) {
            Some(("USER and TYPE of a prescribed temperature are not supported", "give a value, with AMPLITUDE="))
        } else if self.step.is_none() {
            Some(("a temperature before the first step is not prescribed", "give it inside a *STEP"))
        } else if self.step.as_ref().is_some_and(|s| s.ramp) && amplitude.is_none() {
            Some(("*STEP, AMPLITUDE=RAMP with a prescribed temperature is not supported", "give AMPLITUDE="))
        } else {
            None
        };
        if let Some((message, help)) = refusal {
            return self.unsupported(line.span, message, help);
        }
        let (span, kind) = (line.span, Motion::Temperature);
        self.state().boundaries.push(Boundary { nodes, set, dof: 11, kind, user: false, value, amplitude, span });
    }

    /// Before the first step boundaries hold, and move nothing (ABAQUS Analysis User's Guide 34.3.1, "Prescribing boundary
    /// conditions as model data").
    fn before_steps(&mut self, line: &DataLine) {
        let message = "a boundary before the first step holds degrees of freedom: it cannot move them";
        let finding = Diagnostic::error("M105", message).at(line.span, "a value that is not zero");
        self.diagnostics.push(finding.help("give it inside a *STEP"));
    }

    /// With OP=NEW the boundaries of earlier steps end. OP must be the same on all `*BOUNDARY` cards of a step (ABAQUS
    /// Keywords Reference Guide, *BOUNDARY).
    fn boundary_operation(&mut self, card: &Card) {
        let new = self.is_new(card);
        let Some(step) = &mut self.step else { return };
        if step.new_boundaries.is_some_and(|other| other != new) {
            let message =
                "OP must be the same on every *BOUNDARY of a step: NEW removes all of earlier steps, MOD keeps them";
            return self.out_of_range(card.span, message);
        }
        step.new_boundaries = Some(new);
        if new {
            step.history.boundaries.clear();
        }
    }

    /// First and last degree of freedom, and the value.
    fn boundary_dofs(&mut self, line: &DataLine) -> Option<(Degrees, f64)> {
        let word: &Word = match line.field(1) {
            Some(word) => word,
            None => {
                let finding = Diagnostic::error("M102", "a degree of freedom is missing").at(line.span, "here");
                return self.diagnostics.refuse(finding);
            }
        };
        match upper(&word.text).as_str() {
            "ENCASTRE" => return Some((Degrees::range(1, 6), 0.0)),
            "PINNED" => return Some((Degrees::range(1, 3), 0.0)),
            // Symmetry about a plane holds the rotations in it as well: 5 and 6, 4 and 6, 4 and 5 (ABAQUS Analysis User's
            // Guide 34.3.1, "Boundary conditions").
            "XSYMM" => return Some((Degrees { rotation: self.shell_rotation(), ..Degrees::range(1, 1) }, 0.0)),
            "YSYMM" => return Some((Degrees { rotation: self.shell_rotation(), ..Degrees::range(2, 2) }, 0.0)),
            "ZSYMM" => return Some((Degrees::range(3, 3), 0.0)),
            other @ ("XASYMM" | "YASYMM" | "ZASYMM") => {
                let message =
                    format!("antisymmetry ({other}) is not supported: ABAQUS has it in implicit analyses alone");
                return self.refuse_unsupported(word.span, message, "name the degrees of freedom: 1 is r, 2 is z");
            }
            _ => {}
        }
        let first = word.integer(&mut self.diagnostics)?;
        let last = line.field(2).map_or(Some(first), |w| w.integer(&mut self.diagnostics))?;
        let value = self.number_or(line, 3, 0.0)?;
        if [first, last] != [11; 2] && (!(1..=6).contains(&first) || !(first..=6).contains(&last)) {
            return self.refuse_value(
                line.span,
                format!("degrees of freedom {first} to {last}: 1 is r, 2 is z, 6 the rotation, 11 the temperature"),
            );
        }
        Some((Degrees::range(first as u8, last as u8), value))
    }

    /// The rotation, where some nodes of the deck have one.
    fn shell_rotation(&self) -> Option<u8> {
        let shells = |c: &&Card| c.keyword.name == "ELEMENT" && c.value("TYPE").is_some_and(|w| w.is("SAX1"));
        self.deck.cards.iter().find(shells).map(|_| 6)
    }
}
