//! Bodies: `*RIGID BODY`, `*MASS`, `*TARGET`, `*INITIAL CONDITIONS`.
//! Never here: mass matrices.

use super::builder::Builder;
use super::names::{qualified, upper};
use super::types::{
    Attitude, ElementKind, InitialCondition, InitialKind, PointMass, RigidBody, RotaryInertia, STATIONS, SurfaceId,
};
use crate::deck::{Card, Diagnostic, Word};

impl Builder<'_> {
    pub(super) fn rigid_body(&mut self, card: &Card) {
        let Some(reference) = self.required(card, "REF NODE") else { return };
        let Some(nodes) = self.node_members(reference) else { return };
        let [reference] = nodes[..] else {
            self.out_of_range(reference.span, format!("REF NODE must be one node; this set has {}", nodes.len()));
            return;
        };
        if let Some(word) = card.value("ANALYTICAL SURFACE") {
            self.carry_surface(word, reference);
        }
        let elements = card.value("ELSET").and_then(|w| self.element_members(w)).unwrap_or_default();
        let mut tied = Vec::new();
        for name in ["PIN NSET", "TIE NSET"] {
            tied.extend(card.value(name).and_then(|w| self.node_members(w)).unwrap_or_default());
        }
        let density = card.value("DENSITY").map_or(Some(0.0), |w| w.number(&mut self.diagnostics)).unwrap_or(0.0);
        let thickness = card.lines.first().and_then(|l| self.number_or(l, 0, 0.0)).unwrap_or(0.0);
        if density < 0.0 || thickness < 0.0 {
            self.out_of_range(card.span, "density and thickness of a rigid body must not be below zero");
        }
        let name = card.value("ELSET").map_or_else(|| "RIGID BODY".into(), |w| upper(&w.text));
        self.model.rigid_bodies.push(RigidBody {
            name,
            reference,
            elements,
            nodes: tied,
            thickness,
            density,
            span: card.span,
        });
    }

    /// The mass is kept with its set and given to nodes at the end: MASS elements may follow.
    pub(super) fn mass(&mut self, card: &Card) {
        let Some(set) = self.required(card, "ELSET") else { return };
        let Some(line) = self.first_line(card) else { return };
        let Some(mass) = self.number(line, 0, "the mass") else { return };
        if mass < 0.0 {
            self.out_of_range(line.span, format!("a mass must not be below zero, not {mass}"));
            return;
        }
        let elements = match self.point_elements(card, set, ElementKind::Mass) {
            Ok(elements) => elements,
            Err(finding) => {
                let help = "*Element, type=MASS with an ELSET of its own puts a mass on a node; solids have *DENSITY";
                return self.diagnostics.push(finding.help(help));
            }
        };
        self.claim("mass", &elements, card.span);
        for element in elements {
            let node = self.model.mesh.elements[element].nodes[0];
            self.model.discrete.masses.push(PointMass { node, mass, span: card.span });
        }
    }

    /// Elements of a set that a card is for, which are all of one kind.
    fn point_elements(&mut self, card: &Card, set: &Word, kind: ElementKind) -> Result<Vec<usize>, Diagnostic> {
        let elements = self.element_members(set).unwrap_or_default();
        let mesh = &self.model.mesh;
        let Some(&other) = elements.iter().find(|&&e| mesh.elements[e].kind != kind) else { return Ok(elements) };
        let other = &mesh.elements[other];
        let message = format!(
            "`{}` holds element {} of the type {}: *{} is for elements of TYPE={}",
            set.text,
            other.name,
            other.kind.name(),
            card.keyword.name,
            kind.name()
        );
        Err(Diagnostic::error("M121", message).at(set.span, "this set"))
    }

    /// Rotary inertia of ROTARYI elements: a body of revolution is as heavy to turn about 1 as about 3, and has no products.
    pub(super) fn rotary_inertia(&mut self, card: &Card) {
        let Some(set) = self.required(card, "ELSET") else { return };
        let Some(line) = self.first_line(card) else { return };
        let Some(first) = self.number(line, 0, "the moment of inertia I11") else { return };
        let (Some(axial), Some(third)) = (self.number_or(line, 1, first), self.number_or(line, 2, first)) else {
            return;
        };
        if first < 0.0 || axial < 0.0 || first != third {
            let message = format!(
                "I11 and I33 of a body of revolution are equal, and none is below zero, not {first}, {axial}, {third}"
            );
            self.out_of_range(line.span, message);
            return;
        }
        let elements = match self.point_elements(card, set, ElementKind::RotaryInertia) {
            Ok(elements) => elements,
            Err(finding) => return self.diagnostics.push(finding),
        };
        self.claim("rotary inertia", &elements, card.span);
        for element in elements {
            let node = self.model.mesh.elements[element].nodes[0];
            let axial_transverse = [axial, first];
            self.model.discrete.inertias.push(RotaryInertia { node, axial_transverse, span: card.span });
        }
    }

    pub(super) fn attitude(&mut self, card: &Card) {
        let Some(reference) = self.required(card, "REF NODE") else { return };
        let Some(nodes) = self.node_members(reference) else { return };
        let [reference] = nodes[..] else {
            self.out_of_range(reference.span, format!("REF NODE must be one node; this set has {}", nodes.len()));
            return;
        };
        let stations = card.value("STATIONS").map_or(Some(STATIONS as f64), |w| w.number(&mut self.diagnostics));
        let uniform = card.value("INERTIA");
        if let Some(word) = uniform.filter(|w| upper(&w.text) != "UNIFORM") {
            self.unsupported(word.span, format!("INERTIA={} is not known", word.text), "UNIFORM is");
            return;
        }
        let uniform = uniform.is_some();
        let line = card.lines.first();
        let angle = |builder: &mut Self, at| line.map_or(Some(0.0), |line| builder.number_or(line, at, 0.0));
        let (Some(stations), Some(first), Some(second)) = (stations, angle(self, 0), angle(self, 1)) else { return };
        if stations.fract() != 0.0 || !(4.0..=4096.0).contains(&stations) {
            self.out_of_range(card.span, format!("STATIONS is a whole number from 4 to 4096, not {stations}"));
            return;
        }
        let (angles, stations) = ([first, second], stations as usize);
        self.model.attitudes.push(Attitude { reference, angles, stations, uniform, span: card.span });
    }

    /// Several masses on one node add up; MASS elements without *MASS are left without.
    pub(super) fn apply_masses(&mut self) {
        self.model.discrete.masses.retain(|p| p.mass > 0.0);
    }

    pub(super) fn initial_conditions(&mut self, card: &Card) {
        let Some(kind) = self.required(card, "TYPE") else { return };
        let name = upper(&kind.text);
        if name == "SOLUTION" {
            self.initial_state(card);
            return;
        }
        let Some(variable) = self.field_variable(card, &name) else { return };
        for line in &card.lines {
            let Some(set) = line.field(0) else { continue };
            let found = match name.as_str() {
                "VELOCITY" => {
                    let (Some(dof), Some(v)) =
                        (self.integer(line, 1, "the degree of freedom"), self.number_or(line, 2, 0.0))
                    else {
                        continue;
                    };
                    if !(1..=6).contains(&dof) {
                        self.out_of_range(line.span, format!("degree of freedom {dof}: 1 is r, 2 is z"));
                        continue;
                    }
                    self.node_members(set).map(|m| (InitialKind::Velocity(dof as u8, v), m))
                }
                "TEMPERATURE" => {
                    let Some(value) = self.number(line, 1, "the temperature") else { continue };
                    self.node_members(set).map(|m| (InitialKind::Temperature(value), m))
                }
                "STRESS" => {
                    let values: Vec<f64> =
                        (1..line.fields.len()).filter_map(|i| self.number_or(line, i, 0.0)).collect();
                    self.element_members(set).map(|m| (InitialKind::Stress(values), m))
                }
                "SPECIFIC ENERGY" => {
                    let Some(value) = self.number(line, 1, "the energy a mass") else { continue };
                    self.element_members(set).map(|m| (InitialKind::Energy(value), m))
                }
                "HARDENING" => {
                    let Some(value) = self.number(line, 1, "the equivalent plastic strain") else { continue };
                    if value < 0.0 {
                        self.out_of_range(line.span, format!("a plastic strain of {value} lies below zero"));
                        continue;
                    }
                    self.element_members(set).map(|m| (InitialKind::Hardening(value), m))
                }
                "FIELD" => {
                    let Some(value) = self.number(line, 1, "the value of the field") else { continue };
                    self.node_members(set).map(|m| (InitialKind::Field(variable, value), m))
                }
                other => {
                    let help = "VELOCITY, TEMPERATURE, STRESS, SPECIFIC ENERGY, HARDENING, SOLUTION and FIELD are";
                    self.unsupported(kind.span, format!("TYPE={other} is not supported"), help);
                    return;
                }
            };
            if let Some((kind, members)) = found {
                self.model.initial_conditions.push(InitialCondition { kind, members, span: line.span });
            }
        }
    }

    /// VARIABLE of `*INITIAL CONDITIONS, TYPE=FIELD`, counted from 0; the first without it.
    fn field_variable(&mut self, card: &Card, kind: &str) -> Option<usize> {
        let Some(word) = card.value("VARIABLE") else { return Some(0) };
        if kind != "FIELD" {
            self.unsupported(word.span, "VARIABLE is one of TYPE=FIELD", "take it away");
            return None;
        }
        self.numbered_field(card)
    }

    /// Surface index by name.
    pub(super) fn surface_id(&mut self, word: &Word) -> Option<SurfaceId> {
        for name in [qualified(&self.scope, &word.text), upper(&word.text)] {
            if let Some(index) = self.model.surfaces.faces.get_index_of(&name) {
                return Some(SurfaceId::new(index));
            }
        }
        self.unknown("M114", "surface", word, |b| b.model.surfaces.faces.keys().cloned().collect());
        None
    }
}
