//! Output requests as history columns, frame fields and schedules.

pub mod expressions;

use std::collections::HashSet;
use std::sync::Arc;

use indexmap::{IndexMap, IndexSet};

use crate::deck::Diagnostic;
use crate::element::elements::Elements;
use crate::element::group::GroupSetting;
use crate::element::values;
use crate::kernel::lists::Memory;
use crate::model::remesh::name_in_deck;
use crate::model::{
    AmplitudeDefinition, ContactPairFilter, ElementSetId, MaterialDefinition, MemberSet, Model, NodeSetId, OutputCard,
    OutputInterval, OutputKind, OutputPosition, OutputRegion, OutputRequest, RegionType, Step, SurfaceId,
};
use crate::plan::contact::cohesion::{cohesive_behaviors, has_cohesive_variable};
use crate::plan::contact::general::pair_name;
use crate::plan::contact::walls::spatial_side;
use crate::plan::output::expressions::expression_columns;
use crate::plan::solids::cohesive::damaged_interfaces;
use crate::plan::solids::erosion::ErodingState;
use crate::plan::solids::user_material::{deletes, materials_present, state_name, state_variables};
use crate::plan::{Pairs, Report, RowExpression, Scene, State};
use crate::remesh::interpolation::TracerPoint;
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;
use crate::variables::{PreselectRule, Variable, VariableComponent, VariablePlace};

/// Source of the values of a history column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColumnSource {
    /// A mesh node of a rigid body.
    Body {
        /// Index of the rigid body.
        body: usize,
        /// Index of the mesh node.
        node: usize,
    },
    /// A node of a deformable body, by its solver index.
    Node(usize),
    /// A point between nodes, by index in [`Plan::tracers`](crate::plan::Plan::tracers).
    Tracer(usize),
    /// An element: group, index in the group.
    Element(usize, usize),
    /// A surface integral, by index in [`Plan::sections`](crate::plan::Plan::sections).
    Section(usize),
    /// A contact pair, by its index among the pairs of all steps.
    Pair(usize),
    /// A part: elements and rigid bodies, by index in [`Plan::sets`](crate::plan::Plan::sets).
    Part(usize),
    /// A statistic over a set, by index in [`Plan::sets`](crate::plan::Plan::sets).
    Set(Statistic, usize),
    /// An expression of other columns, by index in [`Plan::expressions`](crate::plan::Plan::expressions).
    Expression(usize),
    /// The whole model, for energies and increment data.
    Model,
}

impl ColumnSource {
    /// Returns the index of the contact pair among the pairs of all steps; `None` for another source.
    pub fn pair(self) -> Option<usize> {
        if let ColumnSource::Pair(index) = self { Some(index) } else { None }
    }
}

/// A corner of an element of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ElementCorner {
    /// Index of the group.
    pub group: usize,
    /// Index in the group.
    pub element: usize,
    /// Index of the corner.
    pub corner: usize,
}

/// Deformable faces of a surface over which forces are integrated.
#[derive(Clone, Debug)]
pub struct IntegratedSection {
    surface: SurfaceId,
    /// Element corners on the surface.
    pub corners: Vec<ElementCorner>,
    /// Solver nodes at the ends of the faces.
    pub faces: Vec<[usize; 2]>,
}

/// A column of the history file, with the source of its values.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct HistoryColumn {
    /// `<VARIABLE>@<SET or node>`, or only the variable for the whole model.
    pub name: String,
    /// Variable and component; `None` for an expression.
    pub part: Option<VariableComponent>,
    /// Node, element, surface, set or expression that gives the values.
    pub source: ColumnSource,
}

/// An output array of frames.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Memory)]
#[memory(flat: parts; uncounted: position)]
pub struct FrameField {
    /// Name of the array in the result files.
    pub name: String,
    /// Components that the array contains, all of one variable.
    pub parts: Vec<VariableComponent>,
    /// Position at which a variable of integration points is shown.
    pub position: OutputPosition,
}

impl FrameField {
    fn new(parts: Vec<VariableComponent>) -> FrameField {
        let name = if parts.len() == 1 { parts[0].label() } else { parts[0].variable.name().into() };
        FrameField { name, parts, position: OutputPosition::Element }
    }

    /// Returns the variable of all components of the array.
    pub fn variable(&self) -> Variable {
        self.parts[0].variable
    }

    /// Returns whether the array is on points of frames, not on cells.
    pub fn is_on_points(&self) -> bool {
        self.variable().place() == VariablePlace::Node || self.position == OutputPosition::Nodes
    }

    /// Sets the position. It applies only to variables of integration points.
    fn at(self, position: OutputPosition) -> FrameField {
        let position = if self.variable().place() == VariablePlace::Point { position } else { OutputPosition::Element };
        FrameField { position, ..self }
    }

    fn matches_request(&self, selection: VariableRequest) -> bool {
        match selection {
            VariableRequest::One(part) => self.parts == [part],
            _ => selection.variables().contains(&self.variable()),
        }
    }
}

/// Times at which a step writes frames, history rows and restart files.
#[derive(Clone, Debug, Default)]
pub struct StepOutputs {
    /// Schedules of the frames.
    pub field: Vec<WriteSchedule>,
    /// Schedules of the history rows.
    pub history: Vec<WriteSchedule>,
    /// Restart files (`*RESTART, WRITE`).
    pub restart: Vec<WriteSchedule>,
}

/// Schedule of an output, relative to the start of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum WriteSchedule {
    /// At multiples of this time.
    Time(f64),
    /// After each time this number of increments is completed.
    Increments(u64),
    /// At these times, ascending.
    Points(Arc<[f64]>),
}

impl WriteSchedule {
    /// Converts the interval of a request; `None` if nothing is written.
    fn new(interval: OutputInterval, step: &Step, default: u32, model: &Model) -> Option<WriteSchedule> {
        Some(match interval {
            OutputInterval::Time(dt) => WriteSchedule::Time(dt),
            OutputInterval::Number(n) => WriteSchedule::Time(step.duration / f64::from(n.max(1))),
            OutputInterval::Increments(n) => WriteSchedule::Increments(u64::from(n.max(1))),
            OutputInterval::Points(points) => {
                WriteSchedule::Points(model.output.time_points[points].times.as_slice().into())
            }
            OutputInterval::Never => return None,
            OutputInterval::Default => WriteSchedule::Time(step.duration / f64::from(default)),
        })
    }
}

/// History columns and frame fields of a plan.
#[derive(Default)]
pub struct Columns {
    pub list: Vec<HistoryColumn>,
    pub fields: Vec<FrameField>,
    /// Surfaces over which history columns are integrated.
    pub sections: Vec<IntegratedSection>,
    /// Points between solver nodes.
    pub tracers: Vec<TracerPoint>,
    /// Members of the sets over which history columns are statistics.
    pub sets: IndexSet<Vec<ColumnSource>>,
    pub expressions: Vec<RowExpression>,
    /// Columns that user amplitudes read, by the names of sensors, in the order of the requests.
    pub sensors: IndexMap<String, HistoryColumn>,
}

impl Columns {
    /// Returns the columns that histories and user amplitudes read.
    fn read(&self) -> impl Iterator<Item = &HistoryColumn> {
        self.list.iter().chain(self.sensors.values())
    }

    /// Adds the sensor of a request, of which `first` is the index of the first column. The first request of a name counts.
    fn add_sensor(&mut self, request: &OutputRequest, first: usize, model: &Model, report: &mut Report) {
        let Some(name) = request.sensor.as_ref().filter(|name| !self.sensors.contains_key(*name)) else { return };
        match &self.list[first..] {
            [column] if column.source.pair().is_none() => drop(self.sensors.insert(name.clone(), column.clone())),
            columns if model.amplitudes.iter().any(|a| matches!(a.definition, AmplitudeDefinition::User { .. })) => {
                let message = format!("sensor `{name}` must be one history column, found {}", columns.len());
                let help = "request one component at one node or element, or one variable of the whole model";
                report.push(Diagnostic::error("P010", message).at(request.span, "this sensor").help(help));
            }
            _ => {}
        }
    }
}

/// The products on which history columns depend.
#[derive(Clone, Copy)]
struct OutputInput<'a> {
    scene: Scene<'a>,
    pairs: &'a Pairs,
    state: &'a State,
    /// Variables of the whole model that histories can show.
    model_variables: &'a [Variable],
}

/// The state before its effects are known, whose elements record what the output shows. Effects depend on it.
pub struct RecordingState(State);

impl RecordingState {
    pub fn into_state(self) -> State {
        self.0
    }
}

/// Returns history columns and frame fields of all steps: the columns of a file do not change between steps.
pub fn plan(scene: Scene, pairs: &Pairs, state: ErodingState, report: &mut Report) -> (Columns, RecordingState) {
    let (mut columns, mut fields, mut state) = (Columns::default(), Vec::new(), state.into_state());
    let model = scene.model;
    let model_variables = &find_model_variables(scene, pairs)[..];
    let input = OutputInput { scene, pairs, state: &state, model_variables };
    let available = available_fields(input);
    for step in &model.steps {
        for request in &step.outputs {
            let is_written = request.interval != OutputInterval::Never;
            match request.kind {
                OutputKind::History if is_written || request.sensor.is_some() => {
                    let first = columns.list.len();
                    add_history_columns(input, request, &mut columns, report);
                    columns.add_sensor(request, first, model, report);
                    if is_written {
                        history_row(request, &columns.list[first..], report);
                    } else {
                        columns.list.truncate(first);
                    }
                }
                OutputKind::History => {}
                OutputKind::Field if !is_written => {}
                OutputKind::Field => frame_fields(scene, request, &available, &mut fields, report),
            }
        }
        if step.outputs.is_empty() {
            let erodes = !model.erosions.is_empty();
            let energies = model_variables.iter().copied().filter(|v| v.place() == VariablePlace::Energy);
            columns.list.extend(energies.filter(|v| erodes || !is_deletion_total(*v)).map(model_column));
            fields.extend(available.iter().filter(|f| is_preselected(scene, f)).cloned());
        }
    }
    dedup(&mut columns.list);
    dedup(&mut fields);
    expression_columns(scene.model, &mut columns, report);
    let is_followed = |part: &VariableComponent| part.variable.row().followed;
    let follows = fields.iter().flat_map(|f| &f.parts).any(is_followed)
        || columns.read().filter_map(|c| c.part.as_ref()).any(is_followed);
    if follows && !state.elements.is_empty() {
        state.elements.groups.iter_mut().for_each(|g| g.configure(GroupSetting::Records));
        followed_row(scene.model, state.elements.count(), report);
    }
    track_deletion(scene.model, &columns, &mut state, report);
    (columns.fields, columns.tracers) = (fields, tracers(scene));
    (columns, RecordingState(state))
}

/// Enables the sums of deleted mass and energy if `*EROSION` or an output request needs them.
fn track_deletion(model: &Model, columns: &Columns, state: &mut State, report: &mut Report) {
    let requested = columns.read().filter_map(|c| c.part).any(|p| is_deletion_total(p.variable));
    if state.elements.deletions.record.is_none() && !requested {
        return;
    }
    if state.elements.deletions.record.is_none() {
        let Elements { groups, deletions, .. } = &mut state.elements;
        deletions.start_record(groups, state.dofs.nodes.len());
    }
    let erosion = model.erosions.first().map(|e| e.span);
    let asks = |r: &&OutputRequest| r.variables.iter().any(|a| a.variables().iter().any(|v| is_deletion_total(*v)));
    let request = model.steps.iter().flat_map(|s| &s.outputs).find(asks).map(|r| r.span);
    if let Some(span) = request.or(erosion) {
        let count = state.elements.groups.iter().filter(|g| g.properties().deletable).map(|g| g.len()).sum();
        let detail = "eroded mass and energy, and nodes of deleted elements";
        report.ledger_row(span, "record of deleted elements", count, "elements", detail.into());
    }
}

/// Creates the ledger row of strains and energies that elements integrate only for output.
fn followed_row(model: &Model, count: usize, report: &mut Report) {
    let follows = |selection: &VariableRequest| match selection {
        VariableRequest::Preselect | VariableRequest::All => true,
        _ => selection.variables().iter().any(|v| v.row().followed),
    };
    let asks = |r: &&OutputRequest| r.variables.iter().any(follows);
    let request = model.steps.iter().flat_map(|s| &s.outputs).find(asks);
    let Some(span) = request.map(|r| r.span).or_else(|| model.steps.first().map(|s| s.span)) else { return };
    report.ledger_row(span, "strain history", count, "elements", "LE, PE, ER, SENER, PENER".into());
}

/// Returns the output schedules of a step; without requests the defaults of ABAQUS.
pub fn output_schedules(model: &Model, step: &Step, report: &mut Report) -> StepOutputs {
    let mut outputs = StepOutputs::default();
    for request in &step.outputs {
        match request.kind {
            OutputKind::Field => outputs.field.extend(WriteSchedule::new(request.interval, step, 20, model)),
            OutputKind::History => outputs.history.extend(WriteSchedule::new(request.interval, step, 200, model)),
        }
    }
    if step.outputs.is_empty() {
        outputs.field.extend(WriteSchedule::new(OutputInterval::Default, step, 20, model));
        outputs.history.extend(WriteSchedule::new(OutputInterval::Default, step, 200, model));
    }
    outputs.restart.extend(step.restart.and_then(|r| WriteSchedule::new(r.interval, step, 1, model)));
    if let Some(restart) = step.restart {
        let detail = format!("{:?}, written as <job>.checkpoint", outputs.restart[0]);
        report.ledger_row(restart.span, "checkpoint", 1, "step", detail);
    }
    outputs.field.dedup();
    outputs.history.dedup();
    outputs
}

fn add_history_columns(input: OutputInput, request: &OutputRequest, columns: &mut Columns, report: &mut Report) {
    for &selection in &request.variables {
        let previous_count = columns.list.len();
        match &request.region {
            OutputRegion::Elements(set) if request.card == OutputCard::Energy => {
                part_columns(input.scene, selection, *set, columns);
            }
            OutputRegion::Elements(set) => element_columns(input, selection, request, *set, columns),
            OutputRegion::Nodes(set) => node_columns(input, selection, request, *set, columns),
            OutputRegion::Surface(surface, name) => section_columns(input, selection, *surface, name, columns),
            OutputRegion::Whole if request.card == OutputCard::Contact => {
                pair_columns(input, selection, &ContactPairFilter::default(), columns);
            }
            OutputRegion::Pairs(filter) => pair_columns(input, selection, filter, columns),
            OutputRegion::Whole => {
                columns.list.extend(select_model_variables(input, selection, request.card).map(model_column));
            }
        }
        if columns.list.len() == previous_count {
            report.add_unused_card(request.span, selection.name(), why_absent(selection, request));
        }
    }
}

/// Creates the ledger row of the history columns of a request.
fn history_row(request: &OutputRequest, columns: &[HistoryColumn], report: &mut Report) {
    let names: Vec<_> = columns.iter().map(|c| c.name.as_str()).collect();
    let mut detail = names.iter().take(6).copied().collect::<Vec<_>>().join(" ");
    if names.len() > 6 {
        detail += " …";
    }
    let count = names.len();
    if count > 0 {
        report.ledger_row(request.span, "history output", count, "columns", detail);
    }
}

/// Returns the variables of the whole model that a name on an output card selects.
fn select_model_variables(
    input: OutputInput<'_>,
    selection: VariableRequest,
    card: OutputCard,
) -> impl Iterator<Item = Variable> {
    let by_default = match card {
        OutputCard::Output | OutputCard::Energy => Some(VariablePlace::Energy),
        OutputCard::Incrementation => Some(VariablePlace::Increment),
        OutputCard::Node | OutputCard::Element | OutputCard::Integrated | OutputCard::Contact => None,
    };
    let named = selection.variables();
    // Without *EROSION, deletion sums are computed only if they are requested by name, because they need extra data
    // per element.
    let erodes = !input.scene.model.erosions.is_empty();
    let meant = move |v: &Variable| match selection {
        VariableRequest::Preselect | VariableRequest::All => {
            Some(v.place()) == by_default && (erodes || !is_deletion_total(*v))
        }
        _ => named.contains(v),
    };
    input.model_variables.iter().copied().filter(meant)
}

fn node_columns(
    input: OutputInput,
    selection: VariableRequest,
    request: &OutputRequest,
    set: NodeSetId,
    columns: &mut Columns,
) {
    let Scene { model, bodies, places } = input.scene;
    let (set, members) = named(&model.node_sets, set.index());
    let set = name_in_deck(set);
    let mut parts = selected_parts(input.scene, selection, Variable::is_of_nodes);
    parts.retain(|p| nodes_have(input, p.variable));
    let name = |node: usize| model.mesh.node_names[node].as_str();
    let mut sources_of_members = Vec::new();
    for node in by_number(members, name) {
        if let Some(&rotation) = places.rotations.get(&node) {
            let turning = parts.iter().filter(|p| p.variable.is_of_rotations());
            let source = ColumnSource::Node(rotation);
            sources_of_members.extend(turning.map(|&part| MemberSource { part, name: name(node), source }));
        }
        if let Some(&body) = bodies.of_node.get(&node).filter(|&&b| bodies.list[b].spatial) {
            let source = ColumnSource::Body { body, node };
            let parts = in_space(selection, &parts);
            sources_of_members.extend(parts.map(|part| MemberSource { part, name: name(node), source }));
            continue;
        }
        let tracer = TracerPoint::index_in(&model.output.tracers, node);
        let source = match (places.free_node(node), tracer, bodies.of_node.get(&node)) {
            (Some(node), ..) => ColumnSource::Node(node),
            (_, Some(index), _) => ColumnSource::Tracer(index),
            (.., Some(&body)) => ColumnSource::Body { body, node },
            _ => continue,
        };
        let moving = parts.iter().filter(|p| !p.variable.is_of_rotations() && !is_spatial(p.variable));
        sources_of_members.extend(moving.map(|&part| MemberSource { part, name: name(node), source }));
    }
    columns_of_set(set, members.len(), &sources_of_members, &request.statistics, columns);
}

/// Returns the points of histories with their solver nodes.
fn tracers(scene: Scene) -> Vec<TracerPoint> {
    let solver_node = |node: usize| scene.places.nodes.get(&node).copied().unwrap_or_default();
    let points = scene.model.output.tracers.iter();
    points.map(|point| point.renumbered(point.node, solver_node)).collect()
}

/// Source of a variable of a member of a set, which has a name.
struct MemberSource<'a> {
    part: VariableComponent,
    name: &'a str,
    source: ColumnSource,
}

/// Adds a column for each member of a set, or for each statistic of the set. `members` is the size of the set.
fn columns_of_set(
    set: &str,
    members: usize,
    sources_of_members: &[MemberSource<'_>],
    statistics: &[Statistic],
    columns: &mut Columns,
) {
    if statistics.is_empty() {
        let place_name = |name| if members == 1 { set } else { name };
        columns.list.extend(sources_of_members.iter().map(|m| column(m.part, place_name(m.name), m.source)));
        return;
    }
    let mut parts: Vec<VariableComponent> = sources_of_members.iter().map(|m| m.part).collect();
    dedup(&mut parts);
    for part in parts {
        let mut sources: Vec<ColumnSource> =
            sources_of_members.iter().filter(|m| m.part == part).map(|m| m.source).collect();
        if part.variable == Variable::Reaction {
            once_a_body(&mut sources);
        }
        let index = columns.sets.insert_full(sources).0;
        columns.list.extend(statistics.iter().map(|statistic| HistoryColumn {
            name: format!("{}_{}@{set}", part.label(), statistic.name()),
            part: Some(part),
            source: ColumnSource::Set(*statistic, index),
        }));
    }
}

/// Adds columns of a part. A rigid body belongs to it with all its mass if one of its elements does.
fn part_columns(scene: Scene, selection: VariableRequest, set: ElementSetId, columns: &mut Columns) {
    let parts = all_parts(scene, selection, VariablePlace::Part);
    let model = scene.model;
    let (name, members) = named(&model.element_sets, set.index());
    let source = |element: &usize| match scene.places.elements.get(element) {
        Some(&(group, index)) => Some(ColumnSource::Element(group, index)),
        None => {
            let body = *scene.bodies.of_element.get(element)?;
            Some(ColumnSource::Body { body, node: model.rigid_bodies[body].reference })
        }
    };
    let mut sources: Vec<ColumnSource> = members.iter().filter_map(source).collect();
    once_a_body(&mut sources);
    if !sources.is_empty() && !parts.is_empty() {
        let index = columns.sets.insert_full(sources).0;
        columns.list.extend(parts.into_iter().map(|part| column(part, name, ColumnSource::Part(index))));
    }
}

/// Adds columns of the selected contact pairs.
fn pair_columns(input: OutputInput, selection: VariableRequest, which: &ContactPairFilter, columns: &mut Columns) {
    let OutputInput { scene, pairs, .. } = input;
    let parts = all_parts(scene, selection, VariablePlace::Pair);
    let meant = |name: &str| {
        pairs.by_step.iter().flat_map(|pairs| pairs.iter()).any(|c| pair_name(c) == name && which.matches(c))
    };
    for (index, name) in pairs.names.iter().enumerate().filter(|n| meant(n.1)) {
        columns.list.extend(parts.iter().map(|&part| column(part, name, ColumnSource::Pair(index))));
    }
}

/// Returns whether nodes of this model have a nodal variable.
fn nodes_have(input: OutputInput, variable: Variable) -> bool {
    let OutputInput { scene, pairs, state, .. } = input;
    match variable.row().preselected {
        PreselectRule::HeatConduction => {
            let prescribed = state.elements.fields.as_ref().is_some_and(|fields| fields.prescribes_temperatures());
            scene.model.solves_for_temperatures() || (prescribed && variable == Variable::NodalTemperature)
        }
        PreselectRule::SurfaceContact => !pairs.names.is_empty(),
        PreselectRule::CohesiveContact => has_cohesive_variable(scene.model, pairs, variable),
        PreselectRule::SixDofBody => scene.bodies.list.iter().any(|b| b.spatial),
        _ => true,
    }
}

fn element_columns(
    input: OutputInput,
    selection: VariableRequest,
    request: &OutputRequest,
    set: ElementSetId,
    columns: &mut Columns,
) {
    let Scene { model, places, .. } = input.scene;
    let (set, members) = named(&model.element_sets, set.index());
    let parts = selected_parts(input.scene, selection, Variable::is_of_elements);
    let name = |element: usize| model.mesh.elements[element].name.as_str();
    let mut sources_of_members = Vec::new();
    for element in by_number(members, name) {
        let Some(&(group, index)) = places.elements.get(&element) else { continue };
        let has = |part: &&VariableComponent| element_has(input, (group, index), **part);
        let source = ColumnSource::Element(group, index);
        let parts = parts.iter().filter(has);
        sources_of_members.extend(parts.map(|&part| MemberSource { part, name: name(element), source }));
    }
    columns_of_set(set, members.len(), &sources_of_members, &request.statistics, columns);
}

fn section_columns(
    input: OutputInput,
    selection: VariableRequest,
    surface: SurfaceId,
    name: &str,
    columns: &mut Columns,
) {
    let parts = all_parts(input.scene, selection, VariablePlace::Section);
    let known = columns.sections.iter().position(|s| s.surface == surface);
    let index = known.unwrap_or_else(|| {
        columns.sections.push(integrated_section(input, surface));
        columns.sections.len() - 1
    });
    if !columns.sections[index].faces.is_empty() {
        columns.list.extend(parts.iter().map(|&part| column(part, name, ColumnSource::Section(index))));
    }
}

/// Returns the deformable faces of a surface, with the corners of their elements.
fn integrated_section(input: OutputInput, surface: SurfaceId) -> IntegratedSection {
    let Scene { model, places, .. } = input.scene;
    let sides = &model.surfaces.faces[surface].faces;
    let mut section = IntegratedSection { surface, faces: Vec::new(), corners: Vec::new() };
    let deforming = sides.iter().filter_map(|&(e, side)| Some((places.elements.get(&e)?, e, side)));
    for (&(group, element), e, side) in deforming {
        let Some(ends) = model.mesh.side_nodes(e, side).map(|ends| ends.map(|n| places.nodes[&n])) else {
            continue;
        };
        section.faces.push(ends);
        let corners = input.state.elements.groups[group].boundary(element);
        let on = (0..corners.len()).filter(|&c| ends.contains(&(corners[c] as usize)));
        section.corners.extend(on.map(|corner| ElementCorner { group, element, corner }));
    }
    section.corners.sort_unstable();
    section.corners.dedup();
    section
}

/// Returns the components that a name selects among nodal or element variables.
fn selected_parts(scene: Scene, selection: VariableRequest, of: impl Fn(Variable) -> bool) -> Vec<VariableComponent> {
    let variables = match selection {
        VariableRequest::One(part) => return Some(part).filter(|p| of(p.variable)).into_iter().collect(),
        VariableRequest::All => Variable::ALL.to_vec(),
        _ => selection.variables(),
    };
    variables.into_iter().filter(|v| of(*v)).flat_map(|v| components_of(scene, v)).collect()
}

/// Returns the components that a name selects among the variables of a place; PRESELECT selects all.
fn all_parts(scene: Scene, selection: VariableRequest, place: VariablePlace) -> Vec<VariableComponent> {
    let is_preselection = matches!(selection, VariableRequest::Preselect);
    let selection = if is_preselection { VariableRequest::All } else { selection };
    selected_parts(scene, selection, |variable| variable.place() == place)
}

/// Returns the components of a variable; for state variables as many as the materials of the model have.
fn components_of(scene: Scene, variable: Variable) -> Vec<VariableComponent> {
    if variable.row().numbered {
        return (0..state_variables(scene)).map(|component| VariableComponent { variable, component }).collect();
    }
    variable.parts().collect()
}

fn frame_fields(
    scene: Scene,
    request: &OutputRequest,
    available: &[FrameField],
    fields: &mut Vec<FrameField>,
    report: &mut Report,
) {
    let places = request.card.places();
    for &selection in &request.variables {
        let meant = |f: &&FrameField| match selection {
            VariableRequest::Preselect => is_preselected(scene, f) && places.contains(&f.variable().place()),
            VariableRequest::All => places.contains(&f.variable().place()),
            _ => f.matches_request(selection),
        };
        let meant: Vec<FrameField> = available.iter().filter(meant).cloned().map(|f| f.at(request.position)).collect();
        if meant.is_empty() && !is_in_every_frame(selection) {
            report.add_unused_card(request.span, selection.name(), why_absent(selection, request));
        }
        fields.extend(meant);
    }
    let detail = request.variables.iter().map(|v| v.name()).collect::<Vec<_>>().join(" ");
    report.ledger_row(request.span, "field output", request.variables.len(), "variables", detail);
}

/// Returns the variables that this model has as a whole: energies, the time increment and the added mass.
fn find_model_variables(scene: Scene, pairs: &Pairs) -> Vec<Variable> {
    let has_nodes = !scene.places.nodes.is_empty();
    let (conducts, deletes) = (scene.model.solves_for_temperatures(), deletes(scene));
    let damages = materials_present(scene).any(MaterialDefinition::loses_elastic_energy)
        || damaged_interfaces(scene.model).next().is_some()
        || cohesive_behaviors(scene.model, pairs).any(|cohesion| cohesion.evolution.is_some());
    let (scales, smooths) =
        (!scene.places.elements.is_empty() && scene.model.scales_masses(), scene.model.has_adaptive_mesh());
    let eulerian = |step: &Step| step.adaptive_regions.iter().any(|region| region.kind == RegionType::Eulerian);
    let flows = smooths && scene.model.steps.iter().any(eulerian);
    let adapts = smooths || scene.model.remeshings.iter().any(|card| !card.automatic);
    let added = scales.then_some(Variable::AddedMass);
    let springs = pairs.by_step.iter().flat_map(|pairs| pairs.iter()).any(|pair| pair.penalty.is_some());
    let walls =
        pairs.by_step.iter().flat_map(|pairs| pairs.iter()).any(|pair| spatial_side(scene.bodies, pair).is_some());
    let is_there = move |v: &Variable| {
        let available = match v.row().preselected {
            PreselectRule::HeatConduction => conducts,
            PreselectRule::PenaltyContact => springs,
            PreselectRule::ElementDeletion => deletes,
            PreselectRule::Damage => damages,
            PreselectRule::MassScaling => scales,
            PreselectRule::AdaptiveMesh => adapts,
            PreselectRule::EulerianBoundary => flows,
            _ => true,
        };
        let lost = walls && matches!(v, Variable::ConstraintWork | Variable::PenaltyWork);
        v.place() == VariablePlace::Energy && (has_nodes || lost || !v.row().deforming) && available
    };
    let meshes = [Variable::MeshChanges, Variable::SmallestAngle].into_iter().filter(|_| smooths);
    let increments = [Variable::TimeIncrement].into_iter().chain(added).chain(meshes);
    Variable::ALL.iter().copied().filter(is_there).chain(increments).collect()
}

/// Returns the fields that frames can show: nodal variables, and variables of at least one element group.
fn available_fields(input: OutputInput) -> Vec<FrameField> {
    let OutputInput { scene, state, .. } = input;
    let groups = &state.elements.groups;
    // All elements of a group have the same variables.
    let somewhere = |part: &VariableComponent| {
        groups.iter().enumerate().any(|(g, group)| !group.is_empty() && element_has(input, (g, 0), *part))
    };
    let mut fields = Vec::new();
    let turns = !scene.places.rotations.is_empty();
    for &variable in Variable::ALL {
        if variable.is_of_rotations() && !turns {
            continue;
        }
        let parts = components_of(scene, variable);
        match variable.place() {
            VariablePlace::Node if !nodes_have(input, variable) || is_spatial(variable) => {}
            VariablePlace::Node if variable != Variable::Coordinate => fields.push(FrameField::new(parts)),
            VariablePlace::Point | VariablePlace::Element if variable.row().numbered => {
                let field = |p: VariableComponent| {
                    let field = FrameField::new(vec![p]);
                    let name = state_name(scene, p.component).map(|name| format!("SDV_{name}"));
                    FrameField { name: name.unwrap_or(field.name.clone()), ..field }
                };
                fields.extend(parts.into_iter().filter(somewhere).map(field));
            }
            VariablePlace::Point | VariablePlace::Element if parts.iter().any(somewhere) => {
                fields.push(FrameField::new(parts))
            }
            _ => {}
        }
    }
    fields
}

/// Returns whether a field is in the preselected output of ABAQUS/Explicit. Stress invariants, which ABAQUS/Viewer
/// computes, are included.
fn is_preselected(scene: Scene, field: &FrameField) -> bool {
    match field.variable().row().preselected {
        PreselectRule::Never => false,
        PreselectRule::Always => true,
        PreselectRule::Deformable => !scene.places.nodes.is_empty(),
        PreselectRule::ElementDeletion => deletes(scene),
        PreselectRule::HeatConduction
        | PreselectRule::SurfaceContact
        | PreselectRule::CohesiveContact
        | PreselectRule::PenaltyContact
        | PreselectRule::MassScaling
        | PreselectRule::AdaptiveMesh
        | PreselectRule::EulerianBoundary
        | PreselectRule::Damage => true,
        PreselectRule::SixDofBody => false,
    }
}

/// Returns whether an element has a variable, also if the variable is integrated only on request.
fn element_has(input: OutputInput, (group, element): (usize, usize), part: VariableComponent) -> bool {
    let OutputInput { state, model_variables, .. } = input;
    let heat = state.heat();
    match part.variable {
        Variable::MassScalingFactor => model_variables.contains(&Variable::AddedMass),
        Variable::Temperature | Variable::HeatFlux
            if heat.is_some_and(|h| h.element_temperature(group, element).is_some()) =>
        {
            true
        }
        Variable::Temperature if state.elements.prescribed_temperature(group, element).is_some() => true,
        _ => values::has(&*state.elements.groups[group], state.dofs.nodes.as_slice(), element, part),
    }
}

/// Returns whether only rigid bodies with six degrees of freedom have a variable.
fn is_spatial(variable: Variable) -> bool {
    variable.row().preselected == PreselectRule::SixDofBody
}

/// Returns the components of a requested variable at a node of a body with six degrees of freedom, including
/// out-of-plane ones if the whole variable is requested.
fn in_space(selection: VariableRequest, parts: &[VariableComponent]) -> impl Iterator<Item = VariableComponent> {
    let more = |variable: Variable| match variable {
        Variable::Displacement => Some(Variable::ThirdDisplacement),
        Variable::Velocity => Some(Variable::ThirdVelocity),
        Variable::Acceleration => Some(Variable::ThirdAcceleration),
        Variable::Rotation => Some(Variable::OutwardRotation),
        Variable::RotationalVelocity => Some(Variable::OutwardRotationalVelocity),
        Variable::RotationalAcceleration => Some(Variable::OutwardRotationalAcceleration),
        _ => None,
    };
    let named = if let VariableRequest::Whole(variable) = selection { more(variable) } else { None };
    let mut components: Vec<VariableComponent> = parts.to_vec();
    if let Some(variable) = named {
        let position = if variable.row().labels.is_empty() { components.len() } else { 0 };
        components.splice(position..position, variable.parts());
    }
    components.into_iter()
}

/// Returns whether a variable is a sum of deleted mass or energy.
fn is_deletion_total(variable: Variable) -> bool {
    let row = variable.row();
    row.place == VariablePlace::Energy && row.preselected == PreselectRule::ElementDeletion
}

/// Returns the reason why a requested variable gives no output.
fn why_absent(selection: VariableRequest, request: &OutputRequest) -> String {
    let history = request.kind == OutputKind::History;
    let name = selection.name();
    let variable_place = match selection {
        VariableRequest::NotSimulated(known) => return format!("{name} ({}) is not simulated", known.words),
        VariableRequest::Preselect if history => {
            return "the preselected history output consists of energies only".into();
        }
        VariableRequest::One(part) if !history && part.variable.parts().count() > 1 => {
            return format!("frames show {} with all components", part.variable.name());
        }
        _ if selection.variables().contains(&Variable::NominalStrain) => {
            return format!("{name} is the nominal strain of cohesive elements; the strain of solids is LE");
        }
        _ => selection.variables().first().map(|v| v.place()),
    };
    let reason = match (variable_place, &request.region) {
        (Some(VariablePlace::Node), OutputRegion::Whole | OutputRegion::Elements(_)) if history => {
            "is a nodal variable; request its history with *NODE OUTPUT, NSET="
        }
        (Some(VariablePlace::Point | VariablePlace::Element), OutputRegion::Whole | OutputRegion::Nodes(_))
            if history =>
        {
            "is an element variable; request its history with *ELEMENT OUTPUT, ELSET="
        }
        (Some(VariablePlace::Pair), OutputRegion::Pairs(_)) if history => {
            return format!("{name}: no contact pair is selected");
        }
        (Some(VariablePlace::Pair), _) if !history => {
            "is a history variable of contact pairs: use *OUTPUT, HISTORY with *CONTACT OUTPUT"
        }
        (Some(VariablePlace::Pair), _) => "is a variable of contact pairs: use *CONTACT OUTPUT without NSET",
        (Some(VariablePlace::Section), _) => "is a variable of deformable surfaces: use *INTEGRATED OUTPUT, SURFACE=",
        (Some(VariablePlace::Part), _) => {
            "is a history variable of parts: use *OUTPUT, HISTORY with *ENERGY OUTPUT, ELSET="
        }
        (Some(VariablePlace::Facet), _) if history => "is a facet variable of frames and has no history",
        (Some(VariablePlace::Energy), _) if !history => "is an energy of the whole model: use *OUTPUT, HISTORY",
        (Some(VariablePlace::Increment), _) if !history => "is a variable of increments: use *OUTPUT, HISTORY",
        (Some(VariablePlace::Energy), OutputRegion::Nodes(_) | OutputRegion::Elements(_)) => {
            "is an energy of the whole model; sets have PARTKE and PARTIE"
        }
        _ => return format!("output variable {name} has no value in this model"),
    };
    format!("{name} {reason}")
}

/// Returns whether every frame contains a variable: facet variables of loads, and coordinates.
fn is_in_every_frame(selection: VariableRequest) -> bool {
    let implied = |v: &Variable| v.place() == VariablePlace::Facet || *v == Variable::Coordinate;
    let named = selection.variables();
    !named.is_empty() && named.iter().all(implied)
}

fn named(sets: &IndexMap<String, MemberSet>, index: usize) -> (&str, &[usize]) {
    sets.get_index(index).map_or(("", &[]), |(name, set)| (name, &set.members))
}

fn model_column(variable: Variable) -> HistoryColumn {
    HistoryColumn { name: variable.name().into(), part: Some(variable.into()), source: ColumnSource::Model }
}

fn column(part: VariableComponent, place: &str, source: ColumnSource) -> HistoryColumn {
    HistoryColumn { name: format!("{}@{place}", part.label()), part: Some(part), source }
}

/// Sorts the members of a set by instance and number.
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

/// Keeps only the first node of each rigid body, because all show the reaction of the body.
fn once_a_body(sources: &mut Vec<ColumnSource>) {
    let mut seen = HashSet::new();
    sources.retain(|source| match source {
        ColumnSource::Body { body, .. } => seen.insert(*body),
        _ => true,
    });
}

/// Removes duplicates; the first item remains.
fn dedup<T: Eq + std::hash::Hash>(items: &mut Vec<T>) {
    let unique: IndexSet<T> = items.drain(..).collect();
    *items = unique.into_iter().collect();
}
