//! Parts, instances and the assembly. The cards of a part are read again for each instance, with its placement and
//! scope.

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use super::budget::BudgetedItem;
use super::builder::{ModelBuilder, OpenBlock};
use super::names::upper;
use crate::deck::{Card, Diagnostic};

/// Placement of an instance: a translation, then a rotation about an axis.
#[derive(Clone, Debug)]
pub struct InstancePlacement {
    translation: Vector3<f64>,
    rotation: Option<(Point3<f64>, Rotation3<f64>)>,
}

impl InstancePlacement {
    /// Transforms a point of the part to the assembly.
    pub fn apply(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let moved = Point3::new(r, z, 0.0) + self.translation;
        let placed = match &self.rotation {
            Some((centre, rotation)) => centre + rotation * (moved - centre),
            None => moved,
        };
        [placed.x, placed.y]
    }

    /// Transforms a point of the assembly to the part.
    pub fn undo(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let placed = Point3::new(r, z, 0.0);
        let moved = match &self.rotation {
            Some((centre, rotation)) => centre + rotation.inverse() * (placed - centre),
            None => placed,
        };
        let point = moved - self.translation;
        [point.x, point.y]
    }
}

impl<'a> ModelBuilder<'a> {
    /// Records the cards of an open part for its instances. Returns whether the card was recorded.
    pub(super) fn record(&mut self, card: &'a Card) -> bool {
        let Some(part) = self.recording.clone() else { return false };
        if card.keyword.name == "END PART" {
            return false;
        }
        if matches!(card.keyword.name, "PART" | "ASSEMBLY" | "STEP" | "INSTANCE") {
            self.recording = None;
            return false;
        }
        self.parts.entry(part).or_default().push(card);
        true
    }

    pub(super) fn block(&mut self, card: &'a Card) {
        match card.keyword.name {
            "PART" => self.begin_part(card),
            "INSTANCE" => self.begin_instance(card),
            "ASSEMBLY" => self.open("ASSEMBLY", card),
            "END PART" => {
                self.recording = None;
                self.close("PART", card);
            }
            "END INSTANCE" => {
                self.instance = None;
                self.scope.clear();
                self.close("INSTANCE", card);
            }
            _ => self.close("ASSEMBLY", card),
        }
    }

    fn begin_part(&mut self, card: &Card) {
        self.open("PART", card);
        if let Some(name) = self.required(card, "NAME") {
            let name = upper(&name.text);
            self.parts.insert(name.clone(), Vec::new());
            self.recording = Some(name);
        }
    }

    fn begin_instance(&mut self, card: &'a Card) {
        self.open("INSTANCE", card);
        let Some(name) = self.required(card, "NAME") else { return };
        self.instances.insert(upper(&name.text));
        let Some(part) = card.value("PART") else { return };
        let Some(cards) = self.parts.get(&upper(&part.text)).cloned() else {
            let mut names: Vec<String> = self.parts.keys().cloned().collect();
            names.sort();
            return self.unknown("M115", "part", part, |_| names.clone());
        };
        let lines = cards.iter().map(|inner| inner.line_count() as u128).sum();
        if !self.fits_budget(BudgetedItem::Elements, lines, card.span) {
            return;
        }
        self.scope = upper(&name.text);
        self.instance = self.placement(card);
        for inner in super::order::ordered(&cards, &self.deck.sources) {
            self.card(inner);
        }
        self.scope = upper(&name.text);
    }

    pub(super) fn placement(&mut self, card: &Card) -> Option<InstancePlacement> {
        card.lines.first()?;
        let [r, z]: [f64; 2] = card.read_lines();
        let rotation = match (card.lines.get(1), card.read_lines::<Vec<[f64; 7]>>().get(1)) {
            (Some(line), Some(n)) if n.iter().all(|number| number.is_finite()) => {
                let axis = Unit::try_new(Vector3::new(n[3] - n[0], n[4] - n[1], n[5] - n[2]), 0.0);
                let lies = n[2] == 0.0 && n[5] == 0.0 && (n[6] % 180.0).abs() < 1e-9;
                let Some(axis) = axis.filter(|a| a.x == 0.0 && a.y == 0.0 || lies) else {
                    let message = "an instance may be rotated about an axis normal to the r-z \
                                   plane, or by 180 degrees about an axis in it";
                    return self
                        .diagnostics
                        .refuse(Diagnostic::error("M126", message).at(line.span, "rotation out of the r-z plane"));
                };
                Some((Point3::new(n[0], n[1], n[2]), Rotation3::from_axis_angle(&axis, n[6].to_radians())))
            }
            (None, _) => None,
            _ => return None,
        };
        Some(InstancePlacement { translation: Vector3::new(r, z, 0.0), rotation })
    }

    pub(super) fn open(&mut self, kind: &'static str, card: &Card) {
        self.blocks.push(OpenBlock { kind, span: card.span });
    }

    pub(super) fn close(&mut self, kind: &'static str, card: &Card) {
        match self.blocks.last() {
            Some(block) if block.kind == kind => {
                self.blocks.pop();
            }
            // The missing *STEP has been reported at its procedure.
            None if kind == "STEP" && self.missing.has_card("DYNAMIC") => {}
            other => {
                let mut diagnostic = Diagnostic::error("M105", format!("*{} without *{kind}", card.keyword.name));
                diagnostic = diagnostic.at(card.span, "no such block is open");
                if let Some(block) = other {
                    diagnostic = diagnostic.at(block.span, format!("this *{} is open", block.kind));
                }
                self.diagnostics.push(diagnostic);
            }
        }
    }
}
