//! Mechanical loads: `*CLOAD`, `*DLOAD`, `*DSLOAD`.

use super::builder::ModelBuilder;
use super::names::upper;
use super::types::{BodyForce, ElementKind, ElementSide, Load, LoadKind, SideSelection, SurfaceTraction, TargetId};
use crate::deck::{Card, DataLine, Diagnostic, Word};
use crate::platform::PortableMath as _;

/// Supported load type labels.
const LABELS: &str = "GRAV, BR, BZ, BRNU, BZNU, CENTRIF, P, VP, TRVEC, TRSHR and PNU (on element faces P1 to P4, P1NU to P4NU, VP1 ..., \
                      TRVEC1 ..., TRSHR1 ...), CAVITY";

impl ModelBuilder<'_> {
    pub(super) fn load_card(&mut self, card: &Card) {
        let Ok(amplitude) = self.amplitude_of(card) else { return };
        let family = card.keyword.name;
        if self.operation(card, family) {
            self.state().history.loads.retain(|l| load_family(&l.kind) != family);
        }
        self.check_load_options(card);
        let first = self.state().loads.len();
        for line in &card.lines {
            let parsed = match family {
                "CLOAD" => self.concentrated(line),
                "DLOAD" => self.element_load(card, line),
                _ => self.surface_load(card, line),
            };
            if let Some((kind, magnitude)) = parsed {
                let magnitude = self.scaled(magnitude, amplitude);
                self.state().loads.push(Load { kind, magnitude, amplitude, span: line.span });
            }
        }
        self.region_of_loads(card, first);
    }

    /// Reports `TARGET` and `FRICTION` without a CAVITY load, and direction components without GRAV.
    fn check_load_options(&mut self, card: &Card) {
        let is = |line: &DataLine, label: &str| line.field(1).is_some_and(|w| w.is(label));
        if !card.lines.iter().any(|line| is(line, "CAVITY")) {
            for parameter in card.parameters.iter().filter(|p| matches!(p.name, "TARGET" | "FRICTION")) {
                let message = format!("{} requires a CAVITY load, and this card has none", parameter.name);
                self.unsupported(parameter.span, message, "remove it, or use the load type CAVITY");
            }
        }
        let begins = |line: &DataLine, label: &str| line.field(1).is_some_and(|w| upper(&w.text).starts_with(label));
        let directed = |line: &DataLine| ["GRAV", "TRVEC", "TRSHR", "CENTRIF"].iter().any(|label| begins(line, label));
        for line in card.lines.iter().filter(|l| card.keyword.name != "CLOAD" && !directed(l)) {
            if let Some(word) = (3..9).find_map(|k| line.field(k)) {
                let diagnostic = Diagnostic::error("M161", format!("too many values: `{}`", word.text));
                self.diagnostics
                    .push(diagnostic.at(word.span, "only GRAV, TRVEC, TRSHR and CENTRIF have direction components"));
            }
        }
        let uses = |label: &str| card.lines.iter().any(|line| begins(line, label));
        if let Some(parameter) = card.parameters.iter().find(|p| p.name == "REF NODE").filter(|_| !uses("VP")) {
            self.unsupported(parameter.span, "REF NODE requires a viscous pressure (VP)", "remove it");
        }
        let fixed = card.parameters.iter().find(|p| p.name == "FOLLOWER").filter(|_| !card.read::<bool>("FOLLOWER"));
        if let Some(parameter) = fixed.filter(|_| card.lines.iter().any(|line| !begins(line, "TRVEC"))) {
            self.unsupported(
                parameter.span,
                "FOLLOWER=NO applies only to TRVEC: other tractions follow their faces",
                "put the TRVEC loads on a separate card",
            );
        }
    }

    /// Reports a value that the line does not read.
    pub(super) fn report_surplus(&mut self, word: &Word, why: &str) {
        let diagnostic = Diagnostic::error("M161", format!("too many values: `{}`", word.text));
        self.diagnostics.push(diagnostic.at(word.span, why));
    }

    fn concentrated(&mut self, line: &DataLine) -> Option<(LoadKind, f64)> {
        let set = self.region(line)?;
        let nodes = self.original_nodes(set)?;
        let dof = self.integer(line, 1, "the degree of freedom")? as u8;
        let magnitude = self.number(line, 2, "the force")?;
        Some((LoadKind::Concentrated { nodes, dof, set: set.text.clone() }, magnitude))
    }

    pub(super) fn region<'l>(&mut self, line: &'l DataLine) -> Option<&'l Word> {
        let word = line.field(0);
        if word.is_none() {
            self.diagnostics
                .push(Diagnostic::error("M102", "the set or surface is missing").at(line.span, "first field"));
        }
        word
    }

    fn label<'l>(&mut self, line: &'l DataLine) -> Option<&'l Word> {
        let word = line.field(1);
        if word.is_none() {
            let diagnostic = Diagnostic::error("M102", "the load label is missing").at(line.span, "second field");
            self.diagnostics.push(diagnostic.help(format!("supported: {LABELS}")));
        }
        word
    }

    fn unknown_label(&mut self, label: &Word) {
        let message = format!("load type {} is not supported", label.text);
        let diagnostic = Diagnostic::error("M132", message).at(label.span, "this label");
        self.diagnostics.push(diagnostic.help(format!("supported: {LABELS}")));
    }

    fn element_load(&mut self, card: &Card, line: &DataLine) -> Option<(LoadKind, f64)> {
        let label = self.label(line)?;
        let name = upper(&label.text);
        if name == "GRAV" {
            return self.gravity(line);
        }
        let set = self.region(line)?;
        let elements = self.element_members(set)?;
        if let "BRNU" | "BZNU" = name.as_str() {
            let load_type = if name == "BRNU" { 1 } else { 2 };
            let kind = LoadKind::UserBody { elements, set: set.text.clone(), load_type };
            return Some((kind, self.number_or(line, 2, 1.0)?));
        }
        if let Some(law) = body_force(&name) {
            let magnitude = self.number(line, 2, "the body force")?;
            if law == BodyForce::Centrifugal {
                self.check_rotation_axis(line);
            }
            return Some((LoadKind::Body { elements, set: set.text.clone(), law }, magnitude));
        }
        if let Some((traction, face)) = traction(&name) {
            let side = Word { text: if face.is_empty() { "SPOS".into() } else { format!("S{face}") }, ..label.clone() };
            let faces = self.sides(set, &elements, &side);
            let sides = SideSelection { name: set.text.clone(), surface: false, faces, free_face_elements: Vec::new() };
            return self.traction(card, line, sides, traction);
        }
        let user = name.strip_suffix("NU");
        let number = user.unwrap_or(&name).strip_prefix('P');
        let faces = match (number, name.as_str()) {
            // P on RAX2: pressure on the positive side (ABAQUS Elements Guide, rigid element library).
            (Some(""), _) | (_, "CAVITY") => {
                let spos = Word { text: "SPOS".into(), ..label.clone() };
                let mut sides = self.sides(set, &elements, &spos);
                self.orient_shell_sides(&mut sides);
                sides
            }
            (Some(n), _) if n.parse::<u8>().is_ok_and(|n| (1..=4).contains(&n)) => {
                let word = Word { text: format!("S{n}"), ..label.clone() };
                self.sides(set, &elements, &word)
            }
            _ => {
                self.unknown_label(label);
                return None;
            }
        };
        let sides = SideSelection { name: set.text.clone(), surface: false, faces, free_face_elements: Vec::new() };
        // Load type codes of VDLOAD: 20 is PNU, 21 to 24 are P1NU to P4NU.
        let load_type = user.map(|_| 20 + number.and_then(|n| n.parse::<i32>().ok()).unwrap_or(0));
        self.distributed(card, line, sides, load_type, name == "CAVITY")
    }

    /// Selects the negative sides of shell elements: positive pressure on shell elements acts along their normals
    /// (ABAQUS Analysis User's Guide 29.6.1, "Shell elements: overview").
    fn orient_shell_sides(&self, sides: &mut [(usize, ElementSide)]) {
        for (element, side) in sides {
            if self.model.mesh.elements[*element].kind == ElementKind::Sax1 {
                *side = ElementSide::Negative;
            }
        }
    }

    fn surface_load(&mut self, card: &Card, line: &DataLine) -> Option<(LoadKind, f64)> {
        let word = self.region(line)?;
        let sides = self.loaded_sides(word)?;
        let label = self.label(line)?;
        let name = upper(&label.text);
        if let Some((traction, "")) = traction(&name) {
            return self.traction(card, line, sides, traction);
        }
        if !matches!(name.as_str(), "P" | "PNU" | "CAVITY") {
            self.unknown_label(label);
            return None;
        }
        self.distributed(card, line, sides, (name == "PNU").then_some(0), name == "CAVITY")
    }

    fn distributed(
        &mut self,
        card: &Card,
        line: &DataLine,
        sides: SideSelection,
        user: Option<i32>,
        cavity: bool,
    ) -> Option<(LoadKind, f64)> {
        if cavity {
            if let Some(word) = line.field(2).filter(|word| !word.text.parse().is_ok_and(|value: f64| value == 1.0)) {
                self.report_surplus(word, "CAVITY has no magnitude: the target determines the pressure");
            }
            return self.cavity(card, sides).map(|kind| (kind, 1.0));
        }
        if let Some(load_type) = user {
            return Some((LoadKind::User { sides, load_type }, self.number_or(line, 2, 1.0)?));
        }
        Some((LoadKind::Pressure(sides), self.number(line, 2, "the pressure")?))
    }

    fn traction(&mut self, card: &Card, line: &DataLine, sides: SideSelection, label: &str) -> Option<(LoadKind, f64)> {
        let magnitude = self.number(line, 2, "the traction")?;
        let law = match label {
            "VP" => {
                let reference = match card.value("REF NODE") {
                    Some(word) => Some(self.node_members(word)?.first().copied()?),
                    None => None,
                };
                SurfaceTraction::Viscous { reference }
            }
            _ => {
                let [r, z, third] = self.direction(line)?;
                let length = r.portable_hypot(z);
                if length == 0.0 || third != 0.0 {
                    let message =
                        format!("{label} requires a direction: magnitude, r, z; the third component must be 0");
                    return self.refuse_value(line.span, message);
                }
                let direction = [r / length, z / length];
                match label {
                    "TRSHR" => SurfaceTraction::Shear { direction },
                    _ => SurfaceTraction::Vector { direction, follows: card.read("FOLLOWER") },
                }
            }
        };
        Some((LoadKind::Traction { sides, law }, magnitude))
    }

    /// Returns the three components of the direction after the magnitude.
    fn direction(&mut self, line: &DataLine) -> Option<[f64; 3]> {
        let mut direction = [0.0; 3];
        for (i, component) in direction.iter_mut().enumerate() {
            *component = self.number_or(line, 3 + i, 0.0)?;
        }
        Some(direction)
    }

    /// Reports a centrifugal load about another axis than that of symmetry: its point must have r = 0, and its
    /// direction must be z.
    fn check_rotation_axis(&mut self, line: &DataLine) {
        let value = |k: usize| line.field(k).and_then(|word| Some((word, word.text.parse::<f64>().ok()?)));
        let off = [3, 5, 6, 8].into_iter().filter_map(value).find(|(_, given)| *given != 0.0);
        let along = value(7).filter(|(_, given)| *given == 0.0);
        if let Some((word, _)) = off.or(along) {
            let message =
                "CENTRIF rotates about the axis of symmetry: its point has r = 0 and its direction is 0, 1, 0";
            self.out_of_range(word.span, message);
        }
    }

    fn cavity(&mut self, card: &Card, sides: SideSelection) -> Option<LoadKind> {
        let word = self.required(card, "TARGET")?;
        let target = self.model.targets.iter().position(|t| t.name == upper(&word.text));
        if target.is_none() {
            let names: Vec<String> = self.model.targets.iter().map(|t| t.name.clone()).collect();
            self.unknown("M113", "target", word, |_| names.clone());
        }
        let friction = card.read("FRICTION");
        Some(LoadKind::Cavity { sides, target: TargetId::new(target?), friction })
    }

    fn gravity(&mut self, line: &DataLine) -> Option<(LoadKind, f64)> {
        let elements = match line.field(0) {
            Some(word) => Some(self.element_members(word)?),
            None => None,
        };
        let magnitude = self.number(line, 2, "the acceleration")?;
        let direction = self.direction(line)?;
        let [r, z, third] = direction;
        let length = r.portable_hypot(z).portable_hypot(third);
        if length == 0.0 {
            return self
                .refuse_value(line.span, "GRAV requires a direction: magnitude, r, z (in oblique impact: 1, 2, 3)");
        }
        if (r != 0.0 || third != 0.0) && magnitude != 0.0 && !self.has_oblique_impact() {
            let message = "gravity along r has no resultant on a body of revolution; only its z component acts";
            let diagnostic = Diagnostic::warning("M152", message).at(line.span, "direction with an r component");
            self.diagnostics.push(diagnostic.help("give the direction as 0., 1. or 0., -1."));
        }
        Some((LoadKind::Gravity { elements, direction: direction.map(|d| d / length) }, magnitude))
    }
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
    let found = ["TRVEC", "TRSHR", "VP"].into_iter().find_map(known);
    found.filter(|(_, face)| matches!(*face, "" | "1" | "2" | "3" | "4"))
}

pub(super) fn load_family(kind: &LoadKind) -> &'static str {
    match kind {
        LoadKind::Concentrated { .. } => "CLOAD",
        LoadKind::Gravity { .. } | LoadKind::UserBody { .. } | LoadKind::Body { .. } => "DLOAD",
        LoadKind::Blast { .. } => "INCIDENT WAVE INTERACTION",
        LoadKind::NodalHeat { .. } => "CFLUX",
        LoadKind::BodyHeat { .. } => "DFLUX",
        LoadKind::SurfaceHeat(s) => {
            if s.surface {
                "DSFLUX"
            } else {
                "DFLUX"
            }
        }
        LoadKind::Film { sides: s, .. } => {
            if s.surface {
                "SFILM"
            } else {
                "FILM"
            }
        }
        LoadKind::Pressure(s)
        | LoadKind::Traction { sides: s, .. }
        | LoadKind::User { sides: s, .. }
        | LoadKind::Cavity { sides: s, .. } => {
            if s.surface {
                "DSLOAD"
            } else {
                "DLOAD"
            }
        }
    }
}
