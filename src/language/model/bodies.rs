//! Reads rigid bodies and their masses and motion: `*RIGID BODY`, `*ATTITUDE`, `*MASS`, `*ROTARY INERTIA` and `*INITIAL
//! CONDITIONS`.

use super::builder::ModelBuilder;
use super::names::{qualified, upper};
use super::types::{
    ElementKind, InitialAttitude, InitialCondition, InitialKind, PointMass, RigidBody, RotaryInertia, SurfaceId,
};
use crate::deck::read::FromValue;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Diagnostic, Span, Word};

/// Indices of the values of `TYPE` in the keyword table.
const FIELD: usize = 5;
const SOLUTION: usize = 6;

impl ModelBuilder<'_> {
    pub(super) fn rigid_body(&mut self, card: &Card) {
        let Some(reference) = self.required(card, "REF NODE") else { return };
        let Some(nodes) = self.node_members(reference) else { return };
        let [reference] = nodes[..] else {
            return self
                .out_of_range(reference.span, format!("REF NODE must be one node, found a set of {}", nodes.len()));
        };
        if let Some(word) = card.value("ANALYTICAL SURFACE") {
            self.carry_surface(word, reference);
        }
        let elements = card.value("ELSET").and_then(|w| self.element_members(w)).unwrap_or_default();
        let mut tied = Vec::new();
        for name in ["PIN NSET", "TIE NSET"] {
            tied.extend(card.value(name).and_then(|w| self.node_members(w)).unwrap_or_default());
        }
        let density: f64 = card.read("DENSITY");
        let thickness = f64::from_value(card.given_field(0, 0));
        let is_facet = |e: &usize| self.model.mesh.elements[*e].kind == ElementKind::Rax2;
        if let Some(word) = card.value("DENSITY").filter(|_| density > 0.0 && thickness == 0.0)
            && elements.iter().any(is_facet)
        {
            let message = "DENSITY of RAX2 elements requires their thickness on the data line";
            self.diagnostics.push(Diagnostic::error("M102", message).at(word.span, "the mass would be zero"));
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

    /// Assigns a mass to the nodes of the MASS elements of a set.
    pub(super) fn mass(&mut self, card: &Card) {
        let Some(set) = self.required(card, "ELSET") else { return };
        let cards::Mass { mass: [mass] } = self.values(card);
        let elements = match self.point_elements(card, set, ElementKind::Mass) {
            Ok(elements) => elements,
            Err(diagnostic) => {
                let help = "define the point mass with *ELEMENT, TYPE=MASS in a separate \
                            ELSET; the mass of solids is given by *DENSITY";
                return self.diagnostics.push(diagnostic.help(help));
            }
        };
        self.assign_property("mass", &elements, card.span);
        for element in elements {
            let node = self.model.mesh.elements[element].nodes[0];
            self.model.discrete.masses.push(PointMass { node, mass, span: card.span });
        }
    }

    /// Returns the elements of a set, which must all be of the type that the card requires.
    fn point_elements(&mut self, card: &Card, set: &Word, kind: ElementKind) -> Result<Vec<usize>, Diagnostic> {
        let elements = self.element_members(set).unwrap_or_default();
        let mesh = &self.model.mesh;
        let Some(&other) = elements.iter().find(|&&e| mesh.elements[e].kind != kind) else { return Ok(elements) };
        let other = &mesh.elements[other];
        let message = format!(
            "`{}` contains element {} of type {}, but *{} requires elements of TYPE={}",
            set.text,
            other.name,
            other.kind.name(),
            card.keyword.name,
            kind.name()
        );
        Err(Diagnostic::error("M121", message).at(set.span, "this set"))
    }

    /// Reads the rotary inertia of ROTARYI elements. A body of revolution has no products of inertia.
    pub(super) fn rotary_inertia(&mut self, card: &Card) {
        let Some(set) = self.required(card, "ELSET") else { return };
        let cards::RotaryInertia { moments: [first, axial, third] } = self.values(card);
        let [axial, third] = [axial, third].map(|moment| if moment.is_nan() { first } else { moment });
        let elements = match self.point_elements(card, set, ElementKind::RotaryInertia) {
            Ok(elements) => elements,
            Err(diagnostic) => return self.diagnostics.push(diagnostic),
        };
        self.assign_property("rotary inertia", &elements, card.span);
        for element in elements {
            let node = self.model.mesh.elements[element].nodes[0];
            let moments = [first, axial, third];
            self.model.discrete.inertias.push(RotaryInertia { node, moments, span: card.span });
        }
    }

    pub(super) fn attitude(&mut self, card: &Card) {
        let Some(reference) = self.required(card, "REF NODE") else { return };
        let Some(nodes) = self.node_members(reference) else { return };
        let [reference] = nodes[..] else {
            return self
                .out_of_range(reference.span, format!("REF NODE must be one node, found a set of {}", nodes.len()));
        };
        let cards::Attitude { stations, inertia, angles } = self.values(card);
        let uniform = inertia.is_some();
        self.model.attitudes.push(InitialAttitude { reference, angles, stations, uniform, span: card.span });
    }

    /// Removes masses of zero. Several masses on one node add up.
    pub(super) fn apply_masses(&mut self) {
        self.model.discrete.masses.retain(|p| p.mass > 0.0);
    }

    pub(super) fn initial_conditions(&mut self, card: &Card) {
        let kind: usize = card.read("TYPE");
        if kind == SOLUTION {
            return self.initial_state(card);
        }
        if let Some(word) = card.value("VARIABLE").filter(|_| kind != FIELD) {
            return self.unsupported(word.span, "VARIABLE is allowed with TYPE=FIELD only", "remove it");
        }
        let from = self.model.initial_conditions.len();
        for (at, line) in card.lines.iter().enumerate() {
            let Some(set) = line.field(0) else { continue };
            let value = |field| f64::from_value(card.given_field(at, field));
            let kind = match kind {
                0 => InitialKind::Velocity(value(1) as u8, value(2)),
                1 => InitialKind::Temperature(value(1)),
                2 => InitialKind::Stress(
                    (1..line.fields.len()).map(|at| if line.field(at).is_some() { value(at) } else { 0.0 }).collect(),
                ),
                3 => InitialKind::Energy(value(1)),
                4 => InitialKind::Hardening(value(1)),
                _ => InitialKind::Field(card.read::<usize>("VARIABLE") - 1, value(1)),
            };
            let members = if kind.applies_to_elements() { self.element_members(set) } else { self.node_members(set) };
            if let Some(members) = members {
                self.warn_of_repeated_condition(&kind, &members, line.span);
                self.model.initial_conditions.push(InitialCondition { kind, members, span: line.span });
            }
        }
        self.complete_initial_conditions(from);
    }

    /// Warns if an earlier condition of the same kind has the same members: it has no effect.
    fn warn_of_repeated_condition(&mut self, kind: &InitialKind, members: &[usize], span: Span) {
        let same = |other: &InitialKind| match (kind, other) {
            (InitialKind::Velocity(dof, _), InitialKind::Velocity(other, _)) => dof == other,
            (InitialKind::Field(variable, _), InitialKind::Field(other, _)) => variable == other,
            _ => std::mem::discriminant(kind) == std::mem::discriminant(other),
        };
        // The number of conditions can be that of nodes, and each comparison of members is short if they differ.
        let first = self.repeated_conditions.entry((members.len(), members.first().copied())).or_default();
        let earlier = first.iter().map(|at| &self.model.initial_conditions[*at]);
        let repeated = earlier.filter(|c| same(&c.kind) && c.members == members).map(|c| c.span).next();
        first.push(self.model.initial_conditions.len());
        if let Some(earlier) = repeated {
            let message = "this initial condition replaces an earlier one of the same kind on the same members";
            let diagnostic = Diagnostic::warning("M160", message).at(span, "second definition");
            self.diagnostics.push(diagnostic.at(earlier, "has no effect").help("remove one definition"));
        }
    }

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
