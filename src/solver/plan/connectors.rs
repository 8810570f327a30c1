//! Springs and dashpots of the plan.

use super::{Compiler, State};
use crate::deck::{Diagnostic, Span};
use crate::element::connector::{Connector, Connectors, SpringDashpotLaw};
use crate::model::{ConnectorLaw, ConnectorProperty, ElementKind};

impl Compiler<'_> {
    /// Creates all springs and dashpots. Ends that are not on nodes of deformable bodies are errors.
    pub(super) fn connectors(&mut self) -> Vec<Connector> {
        let model = self.model;
        let mut connectors = Vec::new();
        let mut with_property = Vec::new();
        for property in &model.discrete.connectors {
            let before = connectors.len();
            for &e in &property.elements {
                with_property.push(e);
                connectors.extend(self.connector(e, property));
            }
            let (effect, detail) = match &property.law {
                ConnectorLaw::Spring(k) => ("springs", format!("stiffness {k}")),
                ConnectorLaw::Table(rows) => ("springs", format!("table of {} rows", rows.len())),
                ConnectorLaw::Dashpot(c) => ("dashpots", format!("coefficient {c}")),
                ConnectorLaw::DashpotTable(rows) => ("dashpots", format!("table of {} rows", rows.len())),
            };
            self.ledger_row(property.span, effect, connectors.len() - before, "elements", detail);
        }
        with_property.sort_unstable();
        let mesh = &model.mesh;
        let bare = |e: &usize| mesh.elements[*e].kind.is_connector() && with_property.binary_search(e).is_err();
        if let Some(e) = (0..mesh.elements.len()).find(bare) {
            let kind = mesh.elements[e].kind;
            let card = if matches!(kind, ElementKind::SpringA | ElementKind::Spring1) { "*SPRING" } else { "*DASHPOT" };
            self.refuse_connector(mesh.elements[e].span, format!("{} element without {card}", kind.name()));
        }
        connectors
    }

    fn connector(&mut self, element: usize, property: &ConnectorProperty) -> Option<Connector> {
        let mesh = &self.model.mesh;
        let element = &mesh.elements[element];
        let ends: Vec<usize> = element.nodes.iter().filter_map(|n| self.places.nodes.get(n).copied()).collect();
        if ends.len() < element.nodes.len() {
            let message = format!("element {} has a node that belongs to no deformable element", element.name);
            self.refuse_connector(element.span, message);
            return None;
        }
        let places: Vec<[f64; 2]> = element.nodes.iter().map(|&n| mesh.points[n]).collect();
        if places.len() == 2 && places[0] == places[1] {
            self.refuse_connector(element.span, format!("the ends of element {} coincide", element.name));
            return None;
        }
        let law = match &property.law {
            ConnectorLaw::Spring(k) => SpringDashpotLaw::Spring(*k),
            ConnectorLaw::Table(rows) => SpringDashpotLaw::Table(rows.clone()),
            ConnectorLaw::Dashpot(c) => SpringDashpotLaw::Dashpot(*c),
            ConnectorLaw::DashpotTable(rows) => SpringDashpotLaw::DashpotTable(rows.clone()),
        };
        let axis = (ends.len() == 1).then_some(usize::from(property.dof) - 1);
        Some(Connector::new([ends.first().copied(), ends.get(1).copied()], axis, law))
    }

    fn refuse_connector(&mut self, span: Span, message: String) {
        self.diagnostics.push(Diagnostic::error("P020", message).at(span, "here"));
    }

    /// Adds the springs and dashpots to the elements of the state.
    pub(super) fn connect(&mut self, state: &mut State) {
        let list = self.connectors();
        let light = |n: &usize| state.dofs.nodes.mass[*n] == 0.0 && !self.ties.iter().any(|t| t.nodes.contains(n));
        if let Some(node) = list.iter().flat_map(|c| c.ends.into_iter().flatten()).find(light) {
            let found = self.places.nodes.iter().find(|n| *n.1 == node).map(|n| *n.0);
            let name = found.map_or("", |n| self.model.mesh.node_names[n].as_str());
            let message = format!("a spring or dashpot is attached to node {name}, which has no mass");
            let span = self.model.discrete.connectors.first().map(|c| c.span).unwrap_or_default();
            self.refuse_connector(span, message + ": add a *MASS, or attach it to a node with mass");
        }
        if !list.is_empty() && !state.elements.is_empty() {
            state.elements.connectors = Some(Box::new(Connectors::new(list, &state.dofs.nodes)));
        }
    }
}
