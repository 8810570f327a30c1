//! Output values at an instant: bodies, nodes, elements, facets and the whole model.

use indexmap::IndexMap;

use super::adaptive_meshes::smallest_angle;
use super::body_surfaces::{SpatialPoint, SurfacePoint, on_cells, point_value, surfaces, value_in_space};
use super::energy::Energy;
use super::reaction_means::ReactionMeans;
use super::run_state::RunState;
use crate::constraint::contact::curve::PointCarrier;
use crate::constraint::{Constraint, ConstraintIndex, reaction};
use crate::element::parts::PartTotals;
use crate::element::values;
use crate::model::OutputPosition;
use crate::output::{CellList, FieldArray, OutputFrame};
use crate::plan::{ColumnSource, ElementCorner, FrameField, HistoryColumn, IntegratedSection, SolidPlaces};
use crate::remesh::interpolation::TracerPoint;
use crate::state::dofs::{Dof, Dofs};
use crate::variables::statistic::Statistic;
use crate::variables::{Variable, VariableComponent, VariablePlace};

/// Returns a value at a node of a deformable body; NaN if nodes do not have the variable.
pub fn node_value(dofs: &Dofs, constraints: &[Box<dyn Constraint>], node: usize, part: VariableComponent) -> f64 {
    let axis = part.component;
    let dof = Dof::Node(node, axis);
    match part.variable {
        // Rotations are degrees of freedom of separate nodes.
        Variable::Displacement | Variable::Rotation => dofs.displacement(dof),
        Variable::Velocity | Variable::RotationalVelocity => dofs.velocity(dof),
        Variable::Acceleration | Variable::RotationalAcceleration => dofs.acceleration(dof),
        Variable::Reaction | Variable::ReactionMoment => reaction(constraints, dofs, dof),
        Variable::Coordinate => dofs.nodes[node].place()[axis],
        _ => f64::NAN,
    }
}

/// Returns a value of the whole model; NaN if the model does not have the variable.
fn model_value(energy: &Energy, increment: f64, variable: Variable) -> f64 {
    let removed = energy.removed.unwrap_or_default();
    match variable {
        Variable::KineticEnergy => energy.kinetic,
        Variable::Work => energy.work,
        Variable::FrictionEnergy => energy.friction,
        Variable::CavityEnergy => energy.cavity,
        Variable::InternalEnergy => energy.internal,
        Variable::AllStrainEnergy => energy.strain,
        Variable::AllPlasticEnergy => energy.plastic,
        Variable::AllDamageEnergy => energy.damage.unwrap_or(0.0),
        Variable::ViscousEnergy => energy.viscous,
        Variable::ArtificialEnergy => energy.artificial,
        Variable::ConstraintWork => energy.contact,
        Variable::MassScalingWork => energy.mass_scaling.unwrap_or(0.0),
        Variable::AddedMass => energy.added_mass.unwrap_or(0.0),
        Variable::PenaltyWork => energy.penalty.unwrap_or(0.0),
        Variable::DistortionEnergy => energy.distortion,
        Variable::AdvectionEnergy => energy.advection.unwrap_or(0.0),
        Variable::FlowKineticEnergy => energy.flow.kinetic,
        Variable::MassIn => energy.flow.mass_in,
        Variable::MassOut => energy.flow.mass_out,
        Variable::FlowMomentum => energy.flow.momentum,
        Variable::ExternalHeat => energy.heat.unwrap_or(f64::NAN),
        Variable::InternalHeat => energy.internal_heat.unwrap_or(f64::NAN),
        Variable::RemovedMass => removed.mass,
        Variable::RemovedEnergy => removed.internal,
        Variable::PointMass => removed.points,
        Variable::PointKineticEnergy => removed.kinetic,
        Variable::PointMomentum => removed.momentum,
        Variable::TotalEnergy => energy.total,
        Variable::TimeIncrement => increment,
        _ => f64::NAN,
    }
}

/// Values of a history row that are not read from the state.
pub(super) struct RowSources<'a> {
    pub(super) energy: &'a Energy,
    pub(super) reactions: &'a ReactionMeans,
}

impl RunState<'_> {
    /// Returns the value of a history column; `before` are the values of the previous columns of the row.
    pub(super) fn column_value(&self, column: &HistoryColumn, row: &RowSources<'_>, before: &[f64]) -> f64 {
        match (column.source, column.part) {
            (ColumnSource::Expression(index), _) => self.plan.expressions[index].value(self.now.total_time, before),
            (source, Some(part)) => self.value(source, part, row),
            (_, None) => f64::NAN,
        }
    }

    /// Computes the current values of the sensors. Reactions are those of the last increment.
    pub(super) fn sensor_values(&self, values: &mut Vec<f64>) {
        let needs_energy = self.plan.sensors.iter().any(|sensor| sensor.source == ColumnSource::Model);
        let energy = if needs_energy { self.energy() } else { Energy::default() };
        let row = RowSources { energy: &energy, reactions: &ReactionMeans::default() };
        values.clear();
        values.extend(self.plan.sensors.iter().map(|sensor| self.column_value(sensor, &row, &[])));
    }

    fn value(&self, source: ColumnSource, part: VariableComponent, row: &RowSources<'_>) -> f64 {
        if let Some(mean) = row.reactions.value(source, part) {
            return mean;
        }
        match source {
            ColumnSource::Model => match part.variable {
                Variable::MeshChanges => self.state.adaptive.iter().map(|domain| domain.changes() as f64).sum(),
                Variable::SmallestAngle => smallest_angle(&self.state),
                variable => model_value(row.energy, self.last_increment, variable),
            },
            ColumnSource::Body { body, node } => self.body_value(body, node, part),
            ColumnSource::Node(node) => self.node_value(node, part),
            ColumnSource::Tracer(index) => self.tracer_value(&self.plan.tracers[index], part),
            ColumnSource::Element(group, e) => self.element_value((group, e), part),
            ColumnSource::Section(index) => self.section_value(&self.plan.sections[index], part),
            ColumnSource::Set(statistic, index) => self.statistic(statistic, &self.plan.sets[index], part, row),
            ColumnSource::Part(index) => self.part_value(&self.plan.sets[index], part.variable),
            ColumnSource::Expression(_) | ColumnSource::Pair(_) => f64::NAN,
        }
    }

    /// Returns a statistic over a set. Deleted elements are excluded except for STATUS, and so are members without a
    /// value.
    fn statistic(
        &self,
        statistic: Statistic,
        members: &[ColumnSource],
        part: VariableComponent,
        row: &RowSources<'_>,
    ) -> f64 {
        let of_points = statistic == Statistic::Mean && part.variable.place() == VariablePlace::Point;
        let number = |source: &ColumnSource| {
            let weight = match *source {
                ColumnSource::Element(g, e)
                    if part.variable != Variable::Status && self.state.elements.groups[g].is_deleted(e) =>
                {
                    return None;
                }
                ColumnSource::Element(..) if of_points => self.value(*source, Variable::Volume.into(), row),
                _ => 1.0,
            };
            Some((self.value(*source, part, row), weight)).filter(|(value, _)| !value.is_nan())
        };
        statistic.of(members.iter().filter_map(number))
    }

    /// Returns a value of a part: of the active elements and rigid bodies among its members.
    fn part_value(&self, members: &[ColumnSource], variable: Variable) -> f64 {
        let mut totals = PartTotals::default();
        for member in members {
            match *member {
                ColumnSource::Element(group, e) => {
                    totals.add(&self.state.elements, (group, e), &self.state.dofs.nodes);
                }
                ColumnSource::Body { body, .. } => {
                    let (state, velocity) = (&self.state.dofs.bodies[body], self.state.dofs.velocity(Dof::Body(body)));
                    totals.mass += state.mass;
                    totals.momentum += state.mass * velocity;
                    totals.kinetic += state.kinetic();
                }
                _ => {}
            }
        }
        match variable {
            Variable::PartMass => totals.mass,
            Variable::PartMomentum => totals.momentum,
            Variable::PartVelocity => totals.momentum / totals.mass,
            Variable::PartKineticEnergy => totals.kinetic,
            Variable::PartInternalEnergy => totals.internal,
            Variable::PartErodedMass => totals.eroded,
            _ => f64::NAN,
        }
    }

    /// Returns a value of a surface: the force that holds its elements against their internal forces, or its area.
    fn section_value(&self, section: &IntegratedSection, part: VariableComponent) -> f64 {
        let nodes = &self.state.dofs.nodes;
        match part.variable {
            Variable::SurfaceForce => {
                let elements = &self.state.elements;
                let force = |&ElementCorner { group, element, corner }: &ElementCorner| {
                    elements.assembly.corner_force(&elements.groups, (group, element), corner)[part.component]
                };
                -section.corners.iter().map(force).sum::<f64>()
            }
            Variable::SectionArea => {
                let area = |[a, b]: &[usize; 2]| {
                    let (a, b) = (nodes[*a], nodes[*b]);
                    std::f64::consts::PI * (a.r + b.r) * libm::hypot(b.r - a.r, b.z - a.z)
                };
                section.faces.iter().map(area).sum()
            }
            _ => f64::NAN,
        }
    }

    /// Returns a value at a point between nodes. Its displacement is that from its own place at the start.
    fn tracer_value(&self, point: &TracerPoint, part: VariableComponent) -> f64 {
        let axis = part.component;
        let place = || point.offset[axis] + point.value(|node| self.state.dofs.nodes[node].place()[axis]);
        match part.variable {
            Variable::Coordinate => place(),
            Variable::Displacement => place() - point.start[axis],
            _ => point.value(|node| self.node_value(node, part)),
        }
    }

    fn node_value(&self, node: usize, part: VariableComponent) -> f64 {
        match (part.variable, self.state.heat()) {
            (Variable::NodalTemperature, Some(heat)) => heat.temperature(node),
            (Variable::NodalTemperature, None) => {
                self.state.elements.fields.as_ref().and_then(|fields| fields.temperature(node)).unwrap_or(f64::NAN)
            }
            (Variable::ReactionFlux, Some(heat)) => heat.reaction(node),
            (v, _) if v.is_of_contact_nodes() => self.contact_value(PointCarrier::Node(node), part),
            _ => node_value(&self.state.dofs, &self.state.constraints, node, part),
        }
    }

    /// Returns a value at a point of a contact surface; without contact there is no gap, and pressure and slip are
    /// zero.
    fn contact_value(&self, carrier: PointCarrier, part: VariableComponent) -> f64 {
        let nowhere = if part.variable == Variable::ContactOpening { f64::NAN } else { 0.0 };
        self.contacts().find_map(|c| c.value_at_point(carrier, part)).unwrap_or(nowhere)
    }

    /// Returns a value of an element; NaN if its group does not have the variable. The temperature of an element with
    /// heat conduction or prescribed temperatures is that of its nodes.
    fn element_value(&self, (group, e): (usize, usize), part: VariableComponent) -> f64 {
        let thermal = self.state.heat().and_then(|heat| match part.variable {
            Variable::Temperature => heat.element_temperature(group, e),
            Variable::HeatFlux => Some(heat.flux(group, e, &self.state.dofs)?[part.component]),
            _ => None,
        });
        let prescribed = || self.state.elements.prescribed_temperature(group, e);
        let thermal = thermal.or_else(|| if part.variable == Variable::Temperature { prescribed() } else { None });
        if let Some(value) = thermal {
            return value;
        }
        if part.variable == Variable::MassScalingFactor {
            return self.state.elements.mass_scaling.factor(group, e).unwrap_or(f64::NAN);
        }
        values::value(&*self.state.elements.groups[group], self.state.dofs.nodes.as_slice(), e, part)
            .unwrap_or(f64::NAN)
    }

    /// Returns a value at a node of the mesh that belongs to a rigid body. Axial symmetry keeps the node at its radius.
    fn body_value(&self, body: usize, node: usize, part: VariableComponent) -> f64 {
        if let Some(value) = value_in_space(self, body, node, part) {
            return value;
        }
        let state = &self.state.dofs.bodies[body];
        match (part.variable, part.component) {
            (Variable::Coordinate, 0) => self.plan.mesh.points[node][0],
            (Variable::Coordinate, _) => self.plan.mesh.points[node][1] + state.displacement,
            (Variable::NodalTemperature | Variable::ReactionFlux, _) => f64::NAN,
            (v, _) if v.is_of_contact_nodes() => {
                self.contact_value(PointCarrier::Body(body, self.plan.mesh.points[node]), part)
            }
            (_, 0) => 0.0,
            (Variable::Displacement, _) => state.displacement,
            (Variable::Velocity, _) => self.state.dofs.velocity(Dof::Body(body)),
            (Variable::Acceleration, _) => self.state.dofs.acceleration(Dof::Body(body)),
            (Variable::Reaction, _) => state.reaction,
            _ => f64::NAN,
        }
    }
}

/// Returns the current frame: deformable bodies, and the facets of all rigid bodies at their current positions.
pub(super) fn frame(run: &RunState<'_>) -> OutputFrame {
    let mesh = &run.plan.mesh;
    let mut frame = OutputFrame { time: run.now.total_time, increment: run.now.increment, ..OutputFrame::default() };
    let places = &run.plan.places;
    let mut point_of_node = vec![u32::MAX; mesh.points.len()];
    let mut of_point = PointOwners::with_capacity(places.nodes.len());
    frame.points.reserve_exact(places.nodes.len());
    for (node, &place) in places.nodes.iter() {
        point_of_node[node] = frame.points.len() as u32;
        frame.points.push(run.state.dofs.nodes[place].place());
        of_point.push(node, None);
    }
    let mut elements: Vec<u32> = places.elements.keys().map(|e| e as u32).collect();
    for (b, body) in run.plan.bodies.iter().enumerate().filter(|(b, _)| run.state.dofs.bodies[*b].stations().is_none())
    {
        for &node in body.nodes.iter().filter(|n| !places.tied.contains_key(n)) {
            let [r, z] = mesh.points[node];
            point_of_node[node] = frame.points.len() as u32;
            frame.points.push([r, z + run.state.dofs.bodies[b].displacement]);
            of_point.push(node, Some(b));
        }
        let surface_elements = body.elements.iter().filter(|&&e| !mesh.elements[e].kind.is_discrete());
        elements.extend(surface_elements.map(|e| *e as u32));
    }
    frame.cells = CellList::with_capacity(elements.len());
    for &e in &elements {
        frame.cells.push(mesh.elements[e as usize].nodes.iter().map(|&n| point_of_node[n] as usize));
    }
    drop(point_of_node);
    add_surfaces(run, &mut frame, &mut elements, &mut of_point);
    let is_deleted_element = |&(group, e): &(usize, usize)| run.state.elements.groups[group].is_deleted(e);
    if places.elements.values().any(is_deleted_element) {
        frame.deleted = places.elements.values().map(is_deleted_element).collect();
        frame.deleted.resize(elements.len(), false);
    }
    for field in &run.plan.fields {
        let values = match (field.variable().place(), field.position) {
            (VariablePlace::Node, _) => of_nodes(run, field, &of_point),
            (_, OutputPosition::Element) => of_elements(run, field, elements.len()),
            (_, OutputPosition::Nodes) => averaged_at_nodes(run, field, &frame),
        };
        let list = if field.is_on_points() { &mut frame.point_fields } else { &mut frame.cell_fields };
        list.push(if in_space(run, field) {
            array_in_space(field, values, run, &of_point)
        } else {
            array(field, values)
        });
    }
    frame.cell_fields.extend(facet_fields(run, &elements));
    let start = of_point.in_plane.iter().map(|(node, _)| mesh.points[*node as usize]);
    frame.start = start.chain(std::mem::take(&mut frame.start)).collect();
    (frame.point_labels, frame.cell_labels) = run.plan.labels.of_frame(mesh, &of_point.nodes(), &elements);
    frame
}

/// Owner of the motion of a frame point.
#[derive(Clone, Copy)]
enum PointOwner {
    /// A rigid body, and the node of the mesh.
    Body(usize, usize),
    /// A node of a deformable body, and the node of its rotation, if it has one.
    Node(usize, Option<usize>),
    /// A body with six degrees of freedom.
    Space(SpatialPoint),
}

/// Owners of all points of a frame, in a form that needs little memory.
struct PointOwners {
    /// Mesh node of each point in the plane of the mesh, and its rigid body, if it is not a node of a deformable body.
    in_plane: Vec<(u32, Option<u32>)>,
    /// The points after these.
    on_surfaces: Vec<SpatialPoint>,
}

impl PointOwners {
    fn with_capacity(count: usize) -> PointOwners {
        PointOwners { in_plane: Vec::with_capacity(count), on_surfaces: Vec::new() }
    }

    fn push(&mut self, node: usize, body: Option<usize>) {
        self.in_plane.push((node as u32, body.map(|body| body as u32)));
    }

    fn iter(&self, places: &SolidPlaces) -> impl Iterator<Item = PointOwner> {
        let owner = |&(node, body): &(u32, Option<u32>)| match (node as usize, body) {
            (node, Some(body)) => PointOwner::Body(body as usize, node),
            (node, None) => PointOwner::Node(places.nodes[&node], places.rotations.get(&node).copied()),
        };
        self.in_plane.iter().map(owner).chain(self.on_surfaces.iter().map(|point| PointOwner::Space(*point)))
    }

    /// Returns the mesh nodes of all points.
    fn nodes(&self) -> Vec<u32> {
        self.in_plane
            .iter()
            .map(|(node, _)| *node)
            .chain(self.on_surfaces.iter().map(|point| point.node as u32))
            .collect()
    }
}

/// Adds the surfaces of bodies with six degrees of freedom, after all points and cells in the plane of the mesh.
fn add_surfaces(run: &RunState<'_>, frame: &mut OutputFrame, elements: &mut Vec<u32>, of_point: &mut PointOwners) {
    let (in_plane, surfaces) = (frame.points.len(), surfaces(run));
    if surfaces.points.is_empty() {
        return;
    }
    (frame.third, frame.third_at_start) = (vec![0.0; in_plane], vec![0.0; in_plane]);
    for SurfacePoint { point, place: [x, y, z], start } in surfaces.points {
        frame.points.push([x, y]);
        frame.third.push(z);
        frame.start.push([start[0], start[1]]);
        frame.third_at_start.push(start[2]);
        of_point.on_surfaces.push(point);
    }
    surfaces.cells.into_iter().for_each(|cell| frame.cells.push(cell.into_iter().map(|p| in_plane + p)));
    elements.extend(surfaces.elements.into_iter().map(|e| e as u32));
}

/// Returns the third component of a vector, used if a body has six degrees of freedom.
fn third(variable: Variable) -> Option<Variable> {
    match variable {
        Variable::Displacement => Some(Variable::ThirdDisplacement),
        Variable::Velocity => Some(Variable::ThirdVelocity),
        Variable::Acceleration => Some(Variable::ThirdAcceleration),
        _ => None,
    }
}

fn in_space(run: &RunState<'_>, field: &FrameField) -> bool {
    run.state.dofs.bodies.iter().any(|body| body.stations().is_some())
        && field.parts.len() == 2
        && third(field.variable()).is_some()
}

/// Returns an array of vectors over points, with the component along direction 3 added.
fn array_in_space(field: &FrameField, values: Vec<f64>, run: &RunState<'_>, of_point: &PointOwners) -> FieldArray {
    let flat = array(field, values);
    let more = |owner: PointOwner| match (owner, third(field.variable())) {
        (PointOwner::Space(point), Some(variable)) => point_value(run, &point, variable.into()),
        _ => 0.0,
    };
    let pairs = flat.values.chunks_exact(2).zip(of_point.iter(&run.plan.places));
    let values = pairs.flat_map(|(pair, owner)| [pair[0], pair[1], more(owner)]).collect();
    let component_names = flat.component_names.into_iter().chain([format!("{}3", field.name)]).collect();
    FieldArray { components: 3, component_names, values, ..flat }
}

fn array(field: &FrameField, values: Vec<f64>) -> FieldArray {
    let components = field.parts.len();
    let labels = if components > 1 { field.parts.iter().map(|p| p.label()).collect() } else { Vec::new() };
    FieldArray { name: field.name.clone(), components, component_names: labels, values }
}

/// Returns a nodal variable over points. The reaction force of a rigid body belongs to its reference node.
fn of_nodes(run: &RunState<'_>, field: &FrameField, of_point: &PointOwners) -> Vec<f64> {
    let is_reaction = matches!(field.variable(), Variable::Reaction | Variable::ReactionMoment);
    let reactions = is_reaction.then(|| ConstraintIndex::new(&run.state.constraints));
    let of_node = |node: usize, part: VariableComponent| match &reactions {
        Some(reactions) => reactions.reaction(&run.state.dofs, (node, part.component)),
        None => run.node_value(node, part),
    };
    let value = |owner: PointOwner, part: VariableComponent| match owner {
        PointOwner::Body(b, node) if part.variable == Variable::Reaction && node != run.plan.bodies[b].reference => 0.0,
        PointOwner::Body(b, node) => run.body_value(b, node, part),
        PointOwner::Node(_, rotation) if part.variable.is_of_rotations() => {
            rotation.map_or(f64::NAN, |n| of_node(n, part))
        }
        PointOwner::Node(n, _) => of_node(n, part),
        PointOwner::Space(point) => point_value(run, &point, part),
    };
    let mut values = Vec::with_capacity((of_point.in_plane.len() + of_point.on_surfaces.len()) * field.parts.len());
    for owner in of_point.iter(&run.plan.places) {
        values.extend(field.parts.iter().map(|part| value(owner, *part)));
    }
    values
}

/// Returns an element variable over cells; those of deformable elements come first. Cells without
/// the variable, such as those of rigid bodies, are NaN. ParaView excludes NaN from ranges and draws it in a separate
/// colour.
fn of_elements(run: &RunState<'_>, field: &FrameField, cells: usize) -> Vec<f64> {
    let mut values = Vec::with_capacity(cells * field.parts.len());
    for place in run.plan.places.elements.values() {
        values.extend(field.parts.iter().map(|part| run.element_value(*place, *part)));
    }
    values.resize(cells * field.parts.len(), f64::NAN);
    values
}

/// Returns a variable of integration points over points: the unweighted mean over the adjacent elements that have it
/// and are not deleted. An element has one integration point, whose value is used at all its corners.
fn averaged_at_nodes(run: &RunState<'_>, field: &FrameField, frame: &OutputFrame) -> Vec<f64> {
    let solid = &run.plan.places.elements;
    let of_elements = of_elements(run, field, solid.len());
    let width = field.parts.len();
    let (mut sums, mut counts) = (vec![0.0; width * frame.points.len()], vec![0_u32; frame.points.len()]);
    let is_there = |&(group, e): &(usize, usize)| !run.state.elements.groups[group].is_deleted(e);
    let elements = solid.values().zip(of_elements.chunks(width)).zip(frame.cells.iter());
    for ((_, values), corners) in elements.filter(|((e, v), _)| is_there(e) && v.iter().all(|x| !x.is_nan())) {
        for point in corners.iter().map(|point| *point as usize) {
            counts[point] += 1;
            sums[width * point..].iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }
    let mean = |(i, sum): (usize, f64)| match counts[i / width] {
        0 => f64::NAN,
        count => sum / f64::from(count),
    };
    sums.into_iter().enumerate().map(mean).collect()
}

/// Returns the output of loads on facets. Values of several loads on a facet are combined as the variable requires; for
/// the faces of one deformable element the mean is used.
fn facet_fields(run: &RunState<'_>, elements: &[u32]) -> Vec<FieldArray> {
    let load_fields: Vec<_> = run.state.loads.iter().filter_map(|load| load.fields(&run.state.dofs)).collect();
    if load_fields.is_empty() {
        return Vec::new();
    }
    // First cell of each element, and its number of cells: a body with six degrees of freedom has one for each station.
    let mut cells_of_element = vec![(usize::MAX, 0); run.plan.mesh.elements.len()];
    for (cell, &element) in elements.iter().enumerate() {
        let (first, count) = &mut cells_of_element[element as usize];
        (*first, *count) = ((*first).min(cell), *count + 1);
    }
    let facet_variables = Variable::ALL.iter().filter(|v| v.place() == VariablePlace::Facet);
    let field = |&variable: &Variable| {
        let mut values = vec![0.0; elements.len()];
        for fields in &load_fields {
            let mut element_values: IndexMap<usize, Vec<[f64; 2]>> = IndexMap::new();
            for (facet, element) in fields.elements.iter().enumerate() {
                let value = fields.value(facet, variable).unwrap_or_default();
                element_values.entry(*element).or_default().push([value, fields.weight[facet]]);
            }
            for (element, element_values) in element_values {
                let (first, count) = cells_of_element[element];
                for (cell, value) in (first..).zip(on_cells(&element_values, count)) {
                    values[cell] = (variable.row().combined)(values[cell], value);
                }
            }
        }
        FieldArray { name: variable.name().into(), components: 1, component_names: Vec::new(), values }
    };
    facet_variables.map(field).collect()
}
