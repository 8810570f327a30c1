//! Output requests as history columns, frame fields and schedules.
//! Never here: files, the table of variables.

use std::collections::HashSet;
use std::sync::Arc;

use indexmap::{IndexMap, IndexSet};

use super::general_contact::pair_name;
use super::{Compiler, State};
use crate::element::values;
use crate::kernel::lists::heap_bytes;
use crate::model::{
    ElementSetId, Interval, Model, NodeSetId, OutputCard, OutputKind, OutputRequest, Position, Region, Set, Step,
    SurfaceId, WhichPairs,
};
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;
use crate::variables::{Part, Place, Preselected, Variable};

/// Where a history column is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A node (of the mesh) that moves with a rigid body.
    Body {
        /// The body.
        body: usize,
        /// The node.
        node: usize,
    },
    /// A node of what deforms.
    Node(usize),
    /// A group, and an element of it.
    Element(usize, usize),
    /// A surface that integrals are taken over, of [`Plan::sections`](super::Plan::sections).
    Section(usize),
    /// Two surfaces in contact, by their number among those of all steps.
    Pair(usize),
    /// All of a set, of [`Plan::sets`](super::Plan::sets).
    Set(Statistic, usize),
    /// Other columns, by an expression of [`Plan::expressions`](super::Plan::expressions).
    Expression(usize),
    /// The whole model.
    Model,
}

/// Faces of what deforms, as integrals over them are taken.
#[derive(Clone, Debug)]
pub struct Section {
    surface: SurfaceId,
    /// Group, element of it and corner, for each corner of an element behind the surface that lies on it.
    pub corners: Vec<(usize, usize, usize)>,
    /// Ends of the faces.
    pub faces: Vec<[usize; 2]>,
}

/// One history column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// `<VARIABLE>@<SET or node>`, or the variable alone for the whole model.
    pub name: String,
    /// What it holds; `None` of an expression.
    pub part: Option<Part>,
    /// Of what.
    pub source: Source,
}

/// An array of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameField {
    /// Its name.
    pub name: String,
    /// Its components.
    pub parts: Vec<Part>,
    /// Where a variable of integration points is shown.
    pub position: Position,
}

impl FrameField {
    fn new(parts: Vec<Part>) -> FrameField {
        let name = if parts.len() == 1 { parts[0].label() } else { parts[0].variable.name().into() };
        FrameField { name, parts, position: Position::Element }
    }

    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        self.name.capacity() + heap_bytes(&self.parts)
    }

    /// The variable.
    pub fn variable(&self) -> Variable {
        self.parts[0].variable
    }

    /// Whether it is on points of frames, and not on their cells.
    pub fn is_on_points(&self) -> bool {
        self.variable().place() == Place::Node || self.position == Position::Nodes
    }

    /// The same at a position, which only variables of integration points have.
    fn at(self, position: Position) -> FrameField {
        let position = if self.variable().place() == Place::Point { position } else { Position::Element };
        FrameField { position, ..self }
    }

    fn is_meant(&self, asked: VariableRequest) -> bool {
        match asked {
            VariableRequest::One(part) => self.parts == [part],
            _ => asked.variables().contains(&self.variable()),
        }
    }
}

/// When to write.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Frames.
    pub field: Vec<Schedule>,
    /// History rows.
    pub history: Vec<Schedule>,
    /// States to go on from (`*RESTART, WRITE`).
    pub restart: Vec<Schedule>,
}

/// One rhythm, relative to the start of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Schedule {
    /// Every so much time.
    Time(f64),
    /// Every so many increments.
    Increments(u64),
    /// At these times, ascending.
    Points(Arc<[f64]>),
}

impl Schedule {
    /// `None` for never.
    fn new(interval: Interval, step: &Step, default: u32, model: &Model) -> Option<Schedule> {
        Some(match interval {
            Interval::Time(dt) => Schedule::Time(dt),
            Interval::Number(n) => Schedule::Time(step.duration / f64::from(n.max(1))),
            Interval::Increments(n) => Schedule::Increments(u64::from(n.max(1))),
            Interval::Points(points) => Schedule::Points(model.output.time_points[points].times.as_slice().into()),
            Interval::Never => return None,
            Interval::Default => Schedule::Time(step.duration / f64::from(default)),
        })
    }
}

impl Compiler<'_> {
    /// Columns and frame fields of all steps together: a file keeps its columns from step to step.
    pub(super) fn variables(&mut self, state: &mut State) -> (Vec<Column>, Vec<FrameField>) {
        let (mut columns, mut fields) = (Vec::new(), Vec::new());
        let model = self.model;
        let there = self.fields_there_are(state);
        for step in &model.steps {
            for request in step.outputs.iter().filter(|r| r.interval != Interval::Never) {
                match request.kind {
                    OutputKind::History => self.history_columns(request, state, &mut columns),
                    OutputKind::Field => self.frame_fields(request, &there, &mut fields),
                }
            }
            if step.outputs.is_empty() {
                let erodes = !model.erosions.is_empty();
                columns.extend(self.energies().filter(|v| erodes || !is_removed(*v)).map(model_column));
                fields.extend(there.iter().filter(|f| self.is_preselected(f)).cloned());
            }
        }
        dedup(&mut columns);
        dedup(&mut fields);
        self.expression_columns(&mut columns);
        let mut parts = fields.iter().flat_map(|f| &f.parts).chain(columns.iter().filter_map(|c| c.part.as_ref()));
        let follows = parts.any(|p| p.variable.row().followed);
        if follows && !state.elements.is_empty() {
            state.elements.groups.iter_mut().for_each(|g| g.extensions().settings().follow());
            self.followed_row(state.elements.count());
        }
        self.books_of_deletion(&columns, state);
        (columns, fields)
    }

    /// Books of what deletion takes away, where erosion or an output asks for them.
    fn books_of_deletion(&mut self, columns: &[Column], state: &mut State) {
        let asked = columns.iter().filter_map(|c| c.part).any(|p| is_removed(p.variable));
        if state.elements.removed.is_none() && !asked {
            return;
        }
        if state.elements.removed.is_none() {
            state.elements.count_deletions(state.dofs.nodes.len());
        }
        let erosion = self.model.erosions.first().map(|e| e.span);
        let asks = |r: &&OutputRequest| r.variables.iter().any(|a| a.variables().iter().any(|v| is_removed(*v)));
        let request = self.model.steps.iter().flat_map(|s| &s.outputs).find(asks).map(|r| r.span);
        if let Some(span) = request.or(erosion) {
            let count = state.elements.groups.iter().filter(|g| g.properties().deletable).map(|g| g.len()).sum();
            let detail = "mass, energy and points that deletion leaves";
            self.cause(span, "books of deletion", count, "elements", detail.into());
        }
    }

    /// The row of strains and energies that elements follow because an output asks for them.
    fn followed_row(&mut self, count: usize) {
        let follows = |asked: &VariableRequest| match asked {
            VariableRequest::Preselect | VariableRequest::All => true,
            _ => asked.variables().iter().any(|v| v.row().followed),
        };
        let asks = |r: &&OutputRequest| r.variables.iter().any(follows);
        let request = self.model.steps.iter().flat_map(|s| &s.outputs).find(asks);
        let Some(span) = request.map(|r| r.span).or_else(|| self.model.steps.first().map(|s| s.span)) else { return };
        self.cause(span, "strain history", count, "elements", "LE, PE, ER, SENER, PENER".into());
    }

    /// When this step writes; without any request what ABAQUS preselects.
    pub(super) fn outputs(&mut self, step: &Step) -> Outputs {
        let mut outputs = Outputs::default();
        for request in &step.outputs {
            match request.kind {
                OutputKind::Field => outputs.field.extend(Schedule::new(request.interval, step, 20, self.model)),
                OutputKind::History => outputs.history.extend(Schedule::new(request.interval, step, 200, self.model)),
            }
        }
        if step.outputs.is_empty() {
            outputs.field.extend(Schedule::new(Interval::Default, step, 20, self.model));
            outputs.history.extend(Schedule::new(Interval::Default, step, 200, self.model));
        }
        outputs.restart.extend(step.restart.and_then(|r| Schedule::new(r.interval, step, 1, self.model)));
        if let Some(restart) = step.restart {
            let detail = format!("{:?}, written as <job>.checkpoint", outputs.restart[0]);
            self.cause(restart.span, "checkpoint", 1, "step", detail);
        }
        outputs.field.dedup();
        outputs.history.dedup();
        outputs
    }

    fn history_columns(&mut self, request: &OutputRequest, state: &State, columns: &mut Vec<Column>) {
        let first = columns.len();
        for &asked in &request.variables {
            let before = columns.len();
            match &request.region {
                Region::Elements(set) => self.element_columns((asked, request), *set, state, columns),
                Region::Nodes(set) => self.node_columns((asked, request), *set, columns),
                Region::Surface(surface, name) => self.section_columns(asked, *surface, name, state, columns),
                Region::Whole if request.card == OutputCard::Contact => {
                    self.pair_columns(asked, &WhichPairs::default(), columns);
                }
                Region::Pairs(pairs) => self.pair_columns(asked, pairs, columns),
                Region::Whole => columns.extend(self.model_variables(asked, request.card).map(model_column)),
            }
            if columns.len() == before {
                self.absent(asked, request);
            }
        }
        let names: Vec<_> = columns[first..].iter().map(|c| c.name.as_str()).collect();
        let mut detail = names.iter().take(6).copied().collect::<Vec<_>>().join(" ");
        if names.len() > 6 {
            detail += " …";
        }
        let count = names.len();
        if count > 0 {
            self.cause(request.span, "history output", count, "columns", detail);
        }
    }

    /// Variables of the whole model that a word means on a card.
    fn model_variables(&self, asked: VariableRequest, card: OutputCard) -> impl Iterator<Item = Variable> + use<> {
        let by_default = match card {
            OutputCard::Output | OutputCard::Energy => Some(Place::Energy),
            OutputCard::Incrementation => Some(Place::Increment),
            OutputCard::Node | OutputCard::Element | OutputCard::Integrated | OutputCard::Contact => None,
        };
        let named = asked.variables();
        // Where materials alone delete, books are kept if they are asked for by name: elements must be followed for them.
        let erodes = !self.model.erosions.is_empty();
        let meant = move |v: &Variable| match asked {
            VariableRequest::Preselect | VariableRequest::All => {
                Some(v.place()) == by_default && (erodes || !is_removed(*v))
            }
            _ => named.contains(v),
        };
        self.energies().chain([Variable::TimeIncrement]).filter(meant)
    }

    fn node_columns(
        &mut self,
        (asked, request): (VariableRequest, &OutputRequest),
        set: NodeSetId,
        columns: &mut Vec<Column>,
    ) {
        let model = self.model;
        let (set, members) = named(&model.node_sets, set.index());
        let mut parts = self.parts(asked, Variable::is_of_nodes);
        parts.retain(|p| self.has_nodal(p.variable));
        let name = |node: usize| model.mesh.node_names[node].as_str();
        let mut found = Vec::new();
        for node in by_number(members, name) {
            if let Some(&rotation) = self.places.rotations.get(&node) {
                let turning = parts.iter().filter(|p| p.variable.is_of_rotations());
                found.extend(turning.map(|&part| (part, name(node), Source::Node(rotation))));
            }
            if let Some(&body) = self.body_of_node.get(&node).filter(|&&b| self.bodies[b].spatial) {
                let source = Source::Body { body, node };
                found.extend(in_space(asked, &parts).map(|part| (part, name(node), source)));
                continue;
            }
            let source = match (self.places.free_node(node), self.body_of_node.get(&node)) {
                (Some(node), _) => Source::Node(node),
                (_, Some(&body)) => Source::Body { body, node },
                _ => continue,
            };
            let moving = parts.iter().filter(|p| !p.variable.is_of_rotations() && !is_spatial(p.variable));
            found.extend(moving.map(|&part| (part, name(node), source)));
        }
        self.columns_of_set(set, members.len(), &found, &request.statistics, columns);
    }

    /// Columns of the members of a set, which has so many, or of the set as a whole.
    fn columns_of_set(
        &mut self,
        set: &str,
        members: usize,
        found: &[(Part, &str, Source)],
        statistics: &[Statistic],
        columns: &mut Vec<Column>,
    ) {
        if statistics.is_empty() {
            let place = |name| if members == 1 { set } else { name };
            columns.extend(found.iter().map(|&(part, name, source)| column(part, place(name), source)));
            return;
        }
        let mut parts: Vec<Part> = found.iter().map(|f| f.0).collect();
        dedup(&mut parts);
        for part in parts {
            let mut sources: Vec<Source> = found.iter().filter(|f| f.0 == part).map(|f| f.2).collect();
            if part.variable == Variable::Reaction {
                once_a_body(&mut sources);
            }
            let known = self.sets.iter().position(|s| *s == sources);
            let at = known.unwrap_or_else(|| {
                self.sets.push(sources);
                self.sets.len() - 1
            });
            columns.extend(statistics.iter().map(|statistic| Column {
                name: format!("{}_{}@{set}", part.label(), statistic.name()),
                part: Some(part),
                source: Source::Set(*statistic, at),
            }));
        }
    }

    /// Columns of each pair of surfaces that may meet, of those that are meant.
    fn pair_columns(&self, asked: VariableRequest, which: &WhichPairs, columns: &mut Vec<Column>) {
        let asked = if matches!(asked, VariableRequest::Preselect) { VariableRequest::All } else { asked };
        let parts = self.parts(asked, |v| v.place() == Place::Pair);
        let meant = |name: &str| {
            self.pairs.iter().flat_map(|pairs| pairs.iter()).any(|c| pair_name(c) == name && which.means(c))
        };
        for (index, name) in self.pair_names.iter().enumerate().filter(|n| meant(n.1)) {
            columns.extend(parts.iter().map(|&part| column(part, name, Source::Pair(index))));
        }
    }

    /// Whether nodes of this scene can have a variable of nodes.
    fn has_nodal(&self, variable: Variable) -> bool {
        match variable.row().preselected {
            Preselected::Conducting => self.solves_for_temperatures(),
            Preselected::Meeting => !self.pair_names.is_empty(),
            Preselected::Oblique => self.bodies.iter().any(|b| b.spatial),
            _ => true,
        }
    }

    fn element_columns(
        &mut self,
        (asked, request): (VariableRequest, &OutputRequest),
        set: ElementSetId,
        state: &State,
        columns: &mut Vec<Column>,
    ) {
        let model = self.model;
        let (set, members) = named(&model.element_sets, set.index());
        let parts = self.parts(asked, Variable::is_of_elements);
        let name = |element: usize| model.mesh.elements[element].name.as_str();
        let mut found = Vec::new();
        for element in by_number(members, name) {
            let Some(&(group, index)) = self.places.elements.get(&element) else { continue };
            let has = |part: &&Part| has(state, group, index, **part);
            let source = Source::Element(group, index);
            found.extend(parts.iter().filter(has).map(|&part| (part, name(element), source)));
        }
        self.columns_of_set(set, members.len(), &found, &request.statistics, columns);
    }

    fn section_columns(
        &mut self,
        asked: VariableRequest,
        surface: SurfaceId,
        name: &str,
        state: &State,
        columns: &mut Vec<Column>,
    ) {
        let asked = if matches!(asked, VariableRequest::Preselect) { VariableRequest::All } else { asked };
        let parts = self.parts(asked, |v| v.place() == Place::Section);
        let known = self.sections.iter().position(|s| s.surface == surface);
        let at = known.unwrap_or_else(|| {
            let section = self.section(surface, state);
            self.sections.push(section);
            self.sections.len() - 1
        });
        if !self.sections[at].faces.is_empty() {
            columns.extend(parts.iter().map(|&part| column(part, name, Source::Section(at))));
        }
    }

    /// The faces of a surface that deform, with the corners of the elements behind them.
    fn section(&self, surface: SurfaceId, state: &State) -> Section {
        let model = self.model;
        let sides = &model.surfaces.faces[surface].faces;
        let mut section = Section { surface, faces: Vec::new(), corners: Vec::new() };
        let deforming = sides.iter().filter_map(|&(e, side)| Some((self.places.elements.get(&e)?, e, side)));
        for (&(group, element), e, side) in deforming {
            let Some(ends) = model.mesh.ends(e, side).map(|ends| ends.map(|n| self.places.nodes[&n])) else { continue };
            section.faces.push(ends);
            let corners = state.elements.groups[group].boundary(element);
            let on = (0..corners.len()).filter(|&c| ends.contains(&(corners[c] as usize)));
            section.corners.extend(on.map(|c| (group, element, c)));
        }
        section.corners.sort_unstable();
        section.corners.dedup();
        section
    }

    /// The numbers that a word means among variables of nodes or of elements.
    fn parts(&self, asked: VariableRequest, of: impl Fn(Variable) -> bool) -> Vec<Part> {
        let variables = match asked {
            VariableRequest::One(part) => return Some(part).filter(|p| of(p.variable)).into_iter().collect(),
            VariableRequest::All => Variable::ALL.to_vec(),
            _ => asked.variables(),
        };
        variables.into_iter().filter(|v| of(*v)).flat_map(|v| self.parts_of(v)).collect()
    }

    /// Components of a variable, or as many numbers as materials of the scene keep.
    fn parts_of(&self, variable: Variable) -> Vec<Part> {
        if variable.row().numbered {
            return (0..self.state_variables()).map(|component| Part { variable, component }).collect();
        }
        variable.parts().collect()
    }

    fn frame_fields(&mut self, request: &OutputRequest, there: &[FrameField], fields: &mut Vec<FrameField>) {
        let places = request.card.places();
        for &asked in &request.variables {
            let meant = |f: &&FrameField| match asked {
                VariableRequest::Preselect => self.is_preselected(f) && places.contains(&f.variable().place()),
                VariableRequest::All => places.contains(&f.variable().place()),
                _ => f.is_meant(asked),
            };
            let meant: Vec<FrameField> = there.iter().filter(meant).cloned().map(|f| f.at(request.position)).collect();
            if meant.is_empty() && !is_in_every_frame(asked) {
                self.absent(asked, request);
            }
            fields.extend(meant);
        }
        let detail = request.variables.iter().map(|v| v.name()).collect::<Vec<_>>().join(" ");
        self.cause(request.span, "field output", request.variables.len(), "variables", detail);
    }

    fn solves_for_temperatures(&self) -> bool {
        self.model.steps.first().is_some_and(|s| s.coupled)
    }

    fn deforms(&self) -> bool {
        !self.places.elements.is_empty()
    }

    /// Energies that this scene has.
    fn energies(&self) -> impl Iterator<Item = Variable> + use<> {
        let deforms = self.deforms();
        let (conducts, deletes) = (self.solves_for_temperatures(), self.deletes());
        let springs = self.pairs.iter().flat_map(|pairs| pairs.iter()).any(|pair| pair.penalty.is_some());
        let walls = self.pairs.iter().flat_map(|pairs| pairs.iter()).any(|pair| self.spatial_side(pair).is_some());
        let is_there = move |v: &Variable| {
            let there = match v.row().preselected {
                Preselected::Conducting => conducts,
                Preselected::Springing => springs,
                Preselected::Deleting => deletes,
                _ => true,
            };
            let lost = walls && *v == Variable::ConstraintWork;
            v.place() == Place::Energy && (deforms || lost || !v.row().deforming) && there
        };
        Variable::ALL.iter().copied().filter(is_there)
    }

    /// What frames of this scene can show: of nodes, and what some element has. (Others would be NaN everywhere.)
    fn fields_there_are(&self, state: &State) -> Vec<FrameField> {
        let groups = &state.elements.groups;
        // What one element of a group has they all have.
        let somewhere =
            |part: &Part| groups.iter().enumerate().any(|(g, group)| !group.is_empty() && has(state, g, 0, *part));
        let mut fields = Vec::new();
        let turns = !self.places.rotations.is_empty();
        for &variable in Variable::ALL {
            if variable.is_of_rotations() && !turns {
                continue;
            }
            let parts = self.parts_of(variable);
            match variable.place() {
                Place::Node if !self.has_nodal(variable) || is_spatial(variable) => {}
                Place::Node if variable != Variable::Coordinate => fields.push(FrameField::new(parts)),
                Place::Point | Place::Element if variable.row().numbered => {
                    let field = |p: Part| {
                        let field = FrameField::new(vec![p]);
                        let name = self.state_name(p.component).map(|name| format!("SDV_{name}"));
                        FrameField { name: name.unwrap_or(field.name.clone()), ..field }
                    };
                    fields.extend(parts.into_iter().filter(somewhere).map(field));
                }
                Place::Point | Place::Element if parts.iter().any(somewhere) => fields.push(FrameField::new(parts)),
                _ => {}
            }
        }
        fields
    }

    /// Whether ABAQUS/Explicit preselects it in this scene; invariants of the stress, which its viewer computes, come along.
    fn is_preselected(&self, field: &FrameField) -> bool {
        match field.variable().row().preselected {
            Preselected::Never => false,
            Preselected::Always => true,
            Preselected::Deforming => self.deforms(),
            Preselected::Deleting => self.deletes(),
            Preselected::Conducting | Preselected::Meeting | Preselected::Springing => true,
            Preselected::Oblique => false,
        }
    }

    fn absent(&mut self, asked: VariableRequest, request: &OutputRequest) {
        let why = why_absent(asked, request);
        self.unused(request.span, asked.name(), why);
    }
}

/// Whether rigid bodies with six degrees of freedom alone have a variable.
fn is_spatial(variable: Variable) -> bool {
    variable.row().preselected == Preselected::Oblique
}

/// Parts of a word at a node of a body with six degrees of freedom: a variable named as a whole has components in space too.
fn in_space(asked: VariableRequest, parts: &[Part]) -> impl Iterator<Item = Part> {
    let more = |variable: Variable| match variable {
        Variable::Displacement => Some(Variable::ThirdDisplacement),
        Variable::Velocity => Some(Variable::ThirdVelocity),
        Variable::Acceleration => Some(Variable::ThirdAcceleration),
        Variable::Rotation => Some(Variable::OutwardRotation),
        Variable::RotationalVelocity => Some(Variable::OutwardRotationalVelocity),
        Variable::RotationalAcceleration => Some(Variable::OutwardRotationalAcceleration),
        _ => None,
    };
    let named = if let VariableRequest::Whole(variable) = asked { more(variable) } else { None };
    let mut all: Vec<Part> = parts.to_vec();
    if let Some(variable) = named {
        let at = if variable.row().labels.is_empty() { all.len() } else { 0 };
        all.splice(at..at, variable.parts());
    }
    all.into_iter()
}

/// Whether it is of the books of what deletion took away.
fn is_removed(variable: Variable) -> bool {
    let row = variable.row();
    row.place == Place::Energy && row.preselected == Preselected::Deleting
}

/// Whether an element has a variable, or will have it once it is followed.
fn has(state: &State, group: usize, element: usize, part: Part) -> bool {
    let heat = state.thermal.as_ref().and_then(|t| t.heat.as_ref());
    if matches!(part.variable, Variable::Temperature | Variable::HeatFlux)
        && heat.is_some_and(|h| h.of_element(group, element).is_some())
    {
        return true;
    }
    values::has(&*state.elements.groups[group], state.dofs.nodes.as_slice(), element, part)
}

/// Why a word of a request comes to nothing.
fn why_absent(asked: VariableRequest, request: &OutputRequest) -> String {
    let history = request.kind == OutputKind::History;
    let name = asked.name();
    let place = match asked {
        VariableRequest::NotSimulated(known) => return format!("{name} ({}) is not simulated", known.words),
        VariableRequest::Preselect if history => return "of histories ABAQUS preselects energies alone".into(),
        VariableRequest::One(part) if !history && part.variable.parts().count() > 1 => {
            return format!("frames show {} with all its components", part.variable.name());
        }
        _ => asked.variables().first().map(|v| v.place()),
    };
    match (place, &request.region) {
        (Some(Place::Node), Region::Whole | Region::Elements(_)) if history => {
            format!("{name} lives at nodes; a history of it needs *NODE OUTPUT, NSET=")
        }
        (Some(Place::Point | Place::Element), Region::Whole | Region::Nodes(_)) if history => {
            format!("{name} lives in elements; a history of it needs *ELEMENT OUTPUT, ELSET=")
        }
        (Some(Place::Pair), Region::Pairs(_)) if history => {
            format!("{name}: no pair of surfaces is one of those meant")
        }
        (Some(Place::Pair), _) if !history => format!("{name} is one of pairs of surfaces: a history, *CONTACT OUTPUT"),
        (Some(Place::Pair), _) => {
            format!("{name} is one of pairs of surfaces of elements: *CONTACT OUTPUT without NSET")
        }
        (Some(Place::Section), _) => format!("{name} is one of surfaces that deform: *INTEGRATED OUTPUT, SURFACE="),
        (Some(Place::Facet), _) if history => format!("{name} is shown on facets in frames, not in histories"),
        (Some(Place::Energy), _) if !history => format!("{name} is an energy of the whole model: *OUTPUT, HISTORY"),
        (Some(Place::Increment), _) if !history => format!("{name} is one of increments: *OUTPUT, HISTORY"),
        (Some(Place::Energy), Region::Nodes(_) | Region::Elements(_)) => {
            format!("{name} is an energy of the whole model, not of a set")
        }
        _ => format!("output variable {name} has no value in this scene"),
    }
}

/// Whether frames have it without a field of its own: what loads show of facets, and coordinates, which are their points.
fn is_in_every_frame(asked: VariableRequest) -> bool {
    let implied = |v: &Variable| v.place() == Place::Facet || *v == Variable::Coordinate;
    let named = asked.variables();
    !named.is_empty() && named.iter().all(implied)
}

fn named(sets: &IndexMap<String, Set>, index: usize) -> (&str, &[usize]) {
    sets.get_index(index).map_or(("", &[]), |(name, set)| (name, &set.members))
}

fn model_column(variable: Variable) -> Column {
    Column { name: variable.name().into(), part: Some(variable.into()), source: Source::Model }
}

fn column(part: Part, place: &str, source: Source) -> Column {
    Column { name: format!("{}@{place}", part.label()), part: Some(part), source }
}

/// Members of a set in the order of their numbers, instance by instance.
fn by_number<'a>(members: &[usize], name: impl Fn(usize) -> &'a str) -> Vec<usize> {
    let mut instances: IndexSet<&str> = IndexSet::new();
    let mut key = |member: &usize| {
        let (instance, number) = name(*member).rsplit_once('.').unwrap_or(("", name(*member)));
        (instances.insert_full(instance).0, number.parse().unwrap_or(u64::MAX))
    };
    let mut keyed: Vec<_> = members.iter().map(|member| (key(member), *member)).collect();
    keyed.sort();
    keyed.into_iter().map(|(_, member)| member).collect()
}

/// Leaves of the nodes of each rigid body the first alone: they all show the reaction of the body.
fn once_a_body(sources: &mut Vec<Source>) {
    let mut seen = HashSet::new();
    sources.retain(|source| match source {
        Source::Body { body, .. } => seen.insert(*body),
        _ => true,
    });
}

/// Leaves of what is alike the first.
fn dedup<T: PartialEq + Clone>(items: &mut Vec<T>) {
    let mut kept: Vec<T> = Vec::new();
    for item in items.drain(..) {
        if !kept.contains(&item) {
            kept.push(item);
        }
    }
    *items = kept;
}
