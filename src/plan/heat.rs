//! Temperatures of nodes and thermal strains of the plan: what conducts, what is given and held, what expands.
//! Never here: arithmetic of heat.

use std::collections::{BTreeSet, HashSet};

use super::loads::kind_name;
use super::solid_material::heating;
use super::{Compiler, State};
use crate::deck::{Diagnostic, Span};
use crate::element::group::ElementGroup;
use crate::heat::Thermal;
use crate::heat::conductors::{Conductor, Conductors, Part, Properties};
use crate::heat::expansion::{Expanding, Expansion};
use crate::heat::field::{Conditions, Heat};
use crate::heat::sources::{Held, HeldNode, Kind, Source};
use crate::kernel::hardening::Table;
use crate::kernel::quad::corner_masses;
use crate::mesh::hidden::Hidden;
use crate::model::{Boundary, InitialKind, Load, LoadKind, Material, Motion, SolidSection, Step};
use crate::state::nodes::Nodes;

/// A section with the group of its elements.
type Sectioned<'m> = (&'m SolidSection, usize);

impl Compiler<'_> {
    /// What temperatures bring into the scene; `None` where they change nothing.
    pub(super) fn thermal(&mut self, state: &State) -> Option<Box<Thermal>> {
        let model = self.model;
        let coupled = model.steps.first().is_some_and(|s| s.coupled);
        if !coupled {
            self.tell_without_temperatures();
        }
        let groups = |s: &SolidSection| {
            let of_elements = s.elements.iter().filter_map(|e| self.places.elements.get(e)).map(|place| place.0);
            of_elements.collect::<BTreeSet<usize>>()
        };
        let with_groups = |s| groups(s).into_iter().map(move |group| (s, group));
        let sections: Vec<Sectioned> = model.sections.iter().flat_map(with_groups).collect();
        let heat = if coupled { self.heat(&sections, state) } else { None };
        let start = self.initial_temperatures(state);
        let mut expanding = Vec::new();
        for &(section, group) in &sections {
            let material = &model.materials[section.material];
            if let Some(own) = self.expanding(section, group, material, state) {
                let elements = &state.elements.groups[group];
                let held = |e: usize| {
                    let own = elements.value(e, crate::variables::Variable::Temperature.into());
                    own.filter(|_| heat.is_none()).unwrap_or_else(|| mean(&**elements, e, &start, &state.dofs.nodes))
                };
                expanding.push((own, (0..elements.len()).map(held).collect()));
            }
        }
        let expansion = (!expanding.is_empty()).then(|| Expansion::new(expanding));
        (heat.is_some() || expansion.is_some()).then(|| Box::new(Thermal { heat, expansion }))
    }

    /// What is read and acts on temperatures that nothing solves for.
    fn tell_without_temperatures(&mut self) {
        let model = self.model;
        for material in &model.materials {
            if let Some((_, span)) = &material.thermal.conductivity {
                self.unused(*span, "*CONDUCTIVITY", "nothing here conducts heat");
            }
        }
        let why = "no step solves for temperatures: *DYNAMIC TEMPERATURE-DISPLACEMENT does";
        for (keyword, span) in model.interactions.iter().flat_map(|i| &i.heat_cards) {
            self.unused(*span, format!("*{keyword}"), why);
        }
        for step in &model.steps {
            for boundary in step.boundaries.iter().filter(|b| b.kind == Motion::Temperature) {
                self.unused(boundary.span, format!("*BOUNDARY {}, 11", boundary.set), why);
            }
            for load in step.loads.iter().filter(|l| is_heat(&l.kind)) {
                self.unused(load.span, kind_name(&load.kind), why);
            }
        }
        if let Some(equation) = model.constraints.equations.iter().find(|e| e.is_thermal()) {
            self.unused(equation.span, "*EQUATION between temperatures", why);
        }
    }

    fn heat(&mut self, sections: &[Sectioned], state: &State) -> Option<Heat> {
        let model = self.model;
        let step = model.steps.first()?;
        let (mut parts, mut list, mut id) = (Vec::new(), Vec::new(), None);
        for &(section, group) in sections {
            if !self.conducts(section) {
                continue;
            }
            let material = &model.materials[section.material];
            let properties = self.properties(section, material)?;
            let density = material.density.unwrap_or(0.0);
            let elements = &state.elements.groups[group];
            let first = list.len();
            list.extend((0..elements.len()).flat_map(|e| elements.cells(e)).map(|nodes| {
                let places = nodes.map(|n| state.dofs.nodes[n as usize].place());
                Conductor { nodes, masses: corner_masses(places, density) }
            }));
            let rows = |table: &Table| match table.rows.as_slice() {
                [[value, _]] => format!("{value}"),
                rows => format!("{} rows", rows.len()),
            };
            let detail = format!(
                "material {}, conductivity {}, specific heat {}, lumped capacity, forward differences",
                material.name,
                rows(&properties.conductivity),
                rows(&properties.capacity)
            );
            let row = self.cause(section.span, "heat conduction", elements.len(), "elements", detail);
            id = id.or(Some(row));
            if !heating(material, 1.0).is_none() && (material.plastic.is_some() || material.user.material.is_some()) {
                let detail = "from elements to the temperatures of their nodes, at the end of each increment";
                self.cause(section.span, "plastic heat", elements.len(), "elements", detail.into());
            }
            parts.push(Part { group, first, end: list.len(), properties });
        }
        let Some(id) = id else {
            let message = "the step solves for temperatures, and no element has any";
            let finding = Diagnostic::error("P065", message).at(step.span, "this step");
            return self.diagnostics.refuse(finding.help("CAX4RT and CAX3T have; or write *DYNAMIC, EXPLICIT"));
        };
        let conductors = Conductors::new(parts, list, state.dofs.nodes.len());
        let conducting: HashSet<usize> = conductors.list.iter().flat_map(|c| c.nodes).map(|n| n as usize).collect();
        let start = self.initial_temperatures(state);
        let mut steps = Vec::with_capacity(model.steps.len());
        for (index, step) in model.steps.iter().enumerate() {
            let goes_on = index > 0 && has_same_heat(&model.steps[index - 1], step);
            steps.push((!goes_on).then(|| self.conditions(step, &conductors, &conducting)));
        }
        self.tie_temperatures(&mut steps, &conductors, &conducting, &start);
        let meets = model.steps.iter().any(Step::has_contact);
        Some(Heat::new(id, conductors, steps, start, meets))
    }

    /// What a section's material needs to conduct.
    fn properties(&mut self, section: &SolidSection, material: &Material) -> Option<Properties> {
        let mixed = section.elements.iter().find(|e| !self.model.mesh.elements[**e].kind.is_thermal());
        let missing = match (&material.thermal.conductivity, &material.thermal.specific_heat) {
            _ if mixed.is_some() => "has elements with temperatures at their nodes beside such without",
            _ if matches!(&material.eos, Some(eos) if matches!(eos.kind, crate::model::EosKind::IdealGas(_))) => {
                "has an ideal gas, whose temperature is that of its energy: it cannot conduct"
            }
            (None, _) => "solves for temperatures, and its material has no *CONDUCTIVITY",
            (_, None) => "solves for temperatures, and its material has no *SPECIFIC HEAT",
            (Some((conductivity, _)), Some(capacity)) => {
                let table = |rows: &[[f64; 2]]| Table { rows: rows.to_vec() };
                return Some(Properties { conductivity: table(conductivity), capacity: table(capacity) });
            }
        };
        let message = format!("this section (material `{}`) {missing}", material.name);
        self.diagnostics.refuse(Diagnostic::error("P066", message).at(section.span, "this section"))
    }

    /// Temperatures of nodes at the start, 0 where none is given.
    fn initial_temperatures(&self, state: &State) -> Vec<f64> {
        let mut temperatures = vec![0.0; state.dofs.nodes.len()];
        for condition in &self.model.initial_conditions {
            if let InitialKind::Temperature(value) = condition.kind {
                for place in condition.members.iter().filter_map(|n| self.places.nodes.get(n)) {
                    temperatures[*place] = value;
                }
            }
        }
        temperatures
    }

    fn conditions(&mut self, step: &Step, conductors: &Conductors, conducting: &HashSet<usize>) -> Conditions {
        let mut conditions = Conditions::default();
        let mut taken = HashSet::new();
        for boundary in step.boundaries.iter().filter(|b| b.kind == Motion::Temperature) {
            let places = boundary.nodes.iter().filter_map(|n| self.places.nodes.get(n).copied());
            let nodes: Vec<usize> = places.filter(|n| conducting.contains(n) && taken.insert(*n)).collect();
            if nodes.is_empty() {
                let what = format!("*BOUNDARY {}, 11", boundary.set);
                self.unused(boundary.span, what, "its nodes have no temperature");
                continue;
            }
            let detail = format!("{}: {}", boundary.set, boundary.value);
            let id = self.cause(boundary.span, "prescribed temperature", nodes.len(), "nodes", detail);
            let magnitude = self.magnitude(boundary.value, boundary.amplitude);
            let nodes = nodes.into_iter().map(HeldNode::new).collect();
            conditions.held.push(Held { id, magnitude, nodes });
        }
        let loads: Vec<&Load> = step.loads.iter().filter(|l| is_heat(&l.kind)).collect();
        for load in loads {
            conditions.sources.extend(self.source(load, conductors, conducting));
        }
        conditions
    }

    fn source(&mut self, load: &Load, conductors: &Conductors, conducting: &HashSet<usize>) -> Option<Source> {
        if !self.matters(load) {
            return None;
        }
        let (kind, effect, count, unit, set) = match &load.kind {
            LoadKind::NodalHeat { nodes, set } => {
                let places = nodes.iter().filter_map(|n| self.places.nodes.get(n).copied());
                let list: Vec<usize> = places.filter(|n| conducting.contains(n)).collect();
                let count = if list.len() == nodes.len() { list.len() } else { 0 };
                (Kind::Nodes(list), "heat into nodes", count, "nodes", set)
            }
            LoadKind::BodyHeat { elements, set } => {
                let index = |e: &usize| {
                    let (group, i) = *self.places.elements.get(e)?;
                    Some(conductors.parts.iter().find(|p| p.group == group)?.first + i)
                };
                let list: Vec<usize> = elements.iter().filter_map(index).collect();
                let count = list.len();
                (Kind::Volumes(list), "heat into volumes", count, "elements", set)
            }
            LoadKind::SurfaceHeat(sides) => {
                let surface = self.surface(sides, load.span);
                let count = surface.skin.faces.len();
                (Kind::Faces(surface.skin), "heat flux", count, "faces", &sides.name)
            }
            LoadKind::Film { sides, coefficient, amplitude } => {
                let skin = self.surface(sides, load.span).skin;
                let count = skin.faces.len();
                let coefficient = self.magnitude(*coefficient, *amplitude);
                (Kind::Film(skin, coefficient), "film", count, "faces", &sides.name)
            }
            _ => return None,
        };
        if count == 0 || !self.all_conduct(&kind, conducting) {
            let message = format!("`{set}` holds what has no temperature");
            let finding = Diagnostic::error("P063", message).at(load.span, "this source of heat");
            return self.diagnostics.refuse(finding.help("CAX4RT and CAX3T have temperatures at their nodes"));
        }
        let film = match &load.kind {
            LoadKind::Film { coefficient, .. } => format!("h = {coefficient}, T = "),
            _ => "q = ".into(),
        };
        let detail = format!("on {set}, {film}{}{}", load.magnitude, self.amplitude_name(load));
        let id = self.cause(load.span, effect, count, unit, detail);
        let magnitude = self.magnitude(load.magnitude, load.amplitude);
        Some(Source { id, kind, magnitude })
    }

    fn all_conduct(&self, kind: &Kind, conducting: &HashSet<usize>) -> bool {
        match kind {
            Kind::Faces(skin) | Kind::Film(skin, _) => skin
                .faces
                .iter()
                .chain(skin.hidden().map_or(&[][..], Hidden::faces))
                .flatten()
                .all(|n| conducting.contains(n)),
            Kind::Nodes(_) | Kind::Volumes(_) => true,
        }
    }

    /// How a section expands, where its temperatures change and its stress follows from a bulk modulus.
    fn expanding(
        &mut self,
        section: &SolidSection,
        group: usize,
        material: &Material,
        state: &State,
    ) -> Option<Expanding> {
        let expansion = material.thermal.expansion.as_ref()?;
        let (conducts, elements) = (self.conducts(section), &state.elements.groups[group]);
        let warms = self.adiabatic() && !heating(material, 1.0).is_none() && material.plastic.is_some();
        let idle = |coefficient: f64| coefficient == 0.0;
        let why = if elements.is_empty() || expansion.rows.iter().all(|r| idle(r[0])) {
            Some("its coefficient is zero")
        } else if !conducts && !warms {
            Some("temperatures do not change")
        } else if material.eos.is_some() {
            Some("the equation of state says how the material expands")
        } else {
            None
        };
        if let Some(why) = why {
            self.unused(expansion.span, "*EXPANSION", why);
            return None;
        }
        if material.hyperelastic.is_some() {
            self.refuse_expansion(expansion.span);
            return None;
        }
        let detail = match expansion.rows.as_slice() {
            [[value, _]] => format!("coefficient {value} from {}", expansion.zero),
            rows => format!("{} rows from {}", rows.len(), expansion.zero),
        };
        let id = self.cause(section.span, "thermal expansion", elements.len(), "elements", detail);
        let coefficient = Table { rows: expansion.rows.clone() };
        Some(Expanding { id, group, coefficient, reference: expansion.zero })
    }

    fn refuse_expansion(&mut self, span: Span) {
        let finding = Diagnostic::error("P064", "*EXPANSION with *HYPERELASTIC is not supported").at(span, "here");
        self.diagnostics.push(finding.help("leave one of them out"));
    }
}

/// Mean temperature of an element over its volume.
fn mean(group: &dyn ElementGroup, element: usize, nodal: &[f64], nodes: &Nodes) -> f64 {
    let conductor = |cell: [u32; 4]| {
        let masses = corner_masses(cell.map(|n| nodes[n as usize].place()), 1.0);
        Conductor { nodes: cell, masses }
    };
    let cells = || group.cells(element).map(conductor);
    let volume: f64 = cells().map(|c| c.mass()).sum();
    cells().map(|c| c.mean(nodal) * (c.mass() / volume)).sum()
}

/// Whether two steps give and hold the same heat.
fn has_same_heat(a: &Step, b: &Step) -> bool {
    let held = |b: &&Boundary| b.kind == Motion::Temperature;
    let gives = |l: &&Load| is_heat(&l.kind);
    a.boundaries.iter().filter(held).eq(b.boundaries.iter().filter(held))
        && a.loads.iter().filter(gives).eq(b.loads.iter().filter(gives))
}

fn is_heat(kind: &LoadKind) -> bool {
    use LoadKind::{BodyHeat, Film, NodalHeat, SurfaceHeat};
    matches!(kind, NodalHeat { .. } | SurfaceHeat(_) | BodyHeat { .. } | Film { .. })
}
