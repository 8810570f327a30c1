//! Field variables of the plan: initial nodal values, `*FIELD` of each step, and material tables over field variables.

use std::sync::Arc;

use crate::deck::Diagnostic;
use crate::element::predefined::{NodalFieldValue, PredefinedFields, mean};
use crate::kernel::levels::NestedTable;
use crate::material::user::description::{FieldElasticity, MOST_DEPENDENCIES, YieldOverFields, YieldSource};
use crate::model::{InitialKind, MaterialDefinition, PlasticityModel, SolidSection};
use crate::plan::solids::solid_material::rate_factor;
use crate::plan::{Compiler, State};

/// Returns the number of field variables on which the tables of a material depend.
fn dependencies(material: &MaterialDefinition) -> usize {
    // The first three columns are two moduli, or yield stress and plastic strain, and the temperature.
    let of = |rows: &[Vec<f64>]| rows.first().map_or(0, |row| row.len().saturating_sub(3));
    let plastic = if let Some(PlasticityModel::OverFields(rows)) = &material.plastic { of(rows) } else { 0 };
    plastic.max(of(&material.elastic_table))
}

/// Returns the number of field variables that a material reads: all with user subroutines, else those of its tables.
fn fields_read(material: &MaterialDefinition) -> usize {
    let hardens = matches!(material.plastic, Some(PlasticityModel::User(_)));
    let calls_routines = material.user.material.is_some() || material.user.fields.is_some() || hardens;
    if calls_routines { usize::MAX } else { dependencies(material) }
}

impl Compiler<'_> {
    fn given_fields(&self) -> usize {
        let start = self.model.initial_conditions.iter().filter_map(|c| match c.kind {
            InitialKind::Field(variable, _) => Some(variable + 1),
            _ => None,
        });
        let prescribed = self.model.steps.iter().flat_map(|s| &s.fields).map(|f| f.variable + 1);
        start.chain(prescribed).max().unwrap_or(0)
    }

    /// Returns the number of field variables of a material: those of the deck or of its tables, and at least one with
    /// `*USER DEFINED FIELD`.
    pub(crate) fn field_variables(&self, material: &MaterialDefinition) -> usize {
        self.given_fields().max(dependencies(material)).max(usize::from(material.user.fields.is_some()))
    }

    /// Returns the initial nodal values of each field variable, 0 by default.
    fn fields_at_start(&self, nodes: usize) -> Vec<Vec<f64>> {
        let mut values = vec![vec![0.0; nodes]; self.given_fields()];
        for condition in &self.model.initial_conditions {
            if let InitialKind::Field(variable, value) = condition.kind {
                let places = condition.members.iter().filter_map(|n| self.places.nodes.get(n));
                places.for_each(|&place| values[variable][place] = value);
            }
        }
        values
    }

    pub(crate) fn start_fields(&self, state: &mut State) {
        if !self.model.initial_conditions.iter().any(|c| matches!(c.kind, InitialKind::Field(..))) {
            return;
        }
        let values = self.fields_at_start(state.dofs.nodes.len());
        for group in state.elements.groups.iter_mut().filter(|g| g.properties().fields > 0) {
            for e in 0..group.len() {
                let boundary = group.boundary(e);
                let Some(fields) = group.extensions().fields() else { continue };
                for (variable, nodal) in values.iter().enumerate() {
                    fields.set_field(e, variable, mean(&boundary, nodal));
                }
            }
        }
    }

    /// Creates the values of `*FIELD`; `None` if no material depends on field variables.
    pub(crate) fn predefined_fields(&mut self, state: &State) -> Option<Box<PredefinedFields>> {
        let model = self.model;
        let cards = || model.steps.iter().flat_map(|s| &s.fields);
        let groups = &state.elements.groups;
        let most_read = self.materials_present().map(fields_read).max().unwrap_or(0);
        if most_read == 0 {
            for field in cards() {
                let what = format!("*FIELD, VARIABLE={}", field.variable + 1);
                self.add_unused_card(field.span, what, "no material depends on field variables");
            }
            for condition in model.initial_conditions.iter().filter(|c| matches!(c.kind, InitialKind::Field(..))) {
                let what = "*INITIAL CONDITIONS, TYPE=FIELD";
                self.add_unused_card(condition.span, what, "no material depends on field variables");
            }
            return None;
        }
        self.note_unused_variables(most_read);
        let mut id = None;
        let mut steps: Vec<Arc<[NodalFieldValue]>> = Vec::new();
        for (index, step) in model.steps.iter().enumerate() {
            if index > 0 && model.steps[index - 1].fields == step.fields {
                steps.extend(steps.last().cloned());
                continue;
            }
            let mut list = Vec::new();
            for field in &step.fields {
                let nodes: Vec<usize> = field.nodes.iter().filter_map(|n| self.places.nodes.get(n).copied()).collect();
                let detail = format!("variable {} on {}: {}", field.variable + 1, field.set, field.value);
                let row = self.ledger_row(field.span, "predefined fields", nodes.len(), "nodes", detail);
                id = id.or(Some(row));
                let magnitude = self.magnitude(field.value, field.amplitude);
                list.push(NodalFieldValue { variable: field.variable, nodes, magnitude });
            }
            steps.push(list.into());
        }
        let start = self.fields_at_start(state.dofs.nodes.len());
        Some(Box::new(PredefinedFields::new(id?, start, steps, groups)))
    }

    /// Lists field variables from number `most` on, from 0, as unused.
    fn note_unused_variables(&mut self, most: usize) {
        let model = self.model;
        let why = |variable: usize| format!("no material depends on field variable {}", variable + 1);
        for field in model.steps.iter().flat_map(|s| &s.fields).filter(|field| field.variable >= most) {
            let what = format!("*FIELD, VARIABLE={}", field.variable + 1);
            self.add_unused_card(field.span, what, why(field.variable));
        }
        for condition in &model.initial_conditions {
            if let InitialKind::Field(variable, _) = condition.kind
                && variable >= most
            {
                self.add_unused_card(condition.span, "*INITIAL CONDITIONS, TYPE=FIELD", why(variable));
            }
        }
    }

    /// Returns tables of moduli over temperature and field variables; `None` if the moduli are constant.
    pub(crate) fn elasticity(
        &mut self,
        section: &SolidSection,
        material: &MaterialDefinition,
        count: usize,
    ) -> Option<Arc<FieldElasticity>> {
        let rows = &material.elastic_table;
        let of = |value: usize| {
            let rows: Vec<Vec<f64>> = rows.iter().map(|r| [&r[value..=value], &r[2..]].concat()).collect();
            NestedTable::new(&rows)
        };
        let (young, ratio) = (of(0)?, of(1)?);
        let fields = rows.first()?.len() - 3;
        let detail = format!("{} rows over temperature and {fields} field variables", rows.len());
        self.ledger_row(section.span, "moduli", count, "elements", detail);
        Some(Arc::new(FieldElasticity { young, ratio, fields }))
    }

    /// Returns the table of the yield stress over field variables; an invalid table is an error.
    pub(crate) fn yield_over_fields(
        &mut self,
        section: &SolidSection,
        material: &MaterialDefinition,
        rows: &[Vec<f64>],
    ) -> Option<YieldSource> {
        let fields = rows.first().map_or(0, |r| r.len().saturating_sub(3));
        let table = NestedTable::new(rows).filter(|_| fields <= MOST_DEPENDENCIES);
        let Some(table) = table else {
            let message =
                format!("material `{}`: the rows of its table over field variables are not in order", material.name);
            return self
                .diagnostics
                .refuse(Diagnostic::error("P014", message).at(section.span, "the material of this section"));
        };
        Some(YieldSource::OverFields(Arc::new(YieldOverFields {
            table,
            factor: rate_factor(material.rate.as_ref()),
            fields,
        })))
    }
}
