//! Validation of composed models: indices and value ranges, with the diagnostic codes of decks.

use std::fmt::Display;

use super::adaptive::check_size_limits;
use super::faults::{ValueCheck, is_non_negative, is_positive, require};
use super::fields::MOST_FIELDS;
use super::interactions::check_overclosure;
use super::shells::{check_offset, check_points};
use super::targets::no_resistance;
use super::types::{
    AdaptiveControls, AmplitudeId, AnalyticalSide, BoundaryCondition, ConnectorProperty, CoulombFriction, ElementKind,
    ElementSide, ErosionCriteria, IncrementControl, InitialKind, InteractionId, LinkKind, Load, LoadKind, LoadRegion,
    MaterialId, Model, OutputInterval, OutputRegion, OutputRequest, PredefinedVariable, PrescribedClearance, Remeshing,
    ShellSection, SideSelection, Step, SurfaceContact, SurfaceTraction, TargetLayer, TargetStack,
};
use crate::deck::keywords::InputRule;
use crate::deck::table::{adaptive, constraints, materials, steps};
use crate::deck::{Diagnostic, Diagnostics, Span};
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::platform::PortableMath as _;
use crate::variables::request::VariableRequest;

impl Model {
    /// Returns the errors that prevent a plan. A model read from a deck without errors has none.
    pub fn check(&self) -> Diagnostics {
        let mut check = ConsistencyCheck { model: self, found: Diagnostics::default() };
        check.mesh();
        // Further messages about an invalid mesh would be consequential errors.
        if !check.found.has_errors() {
            check.names();
            self.materials.iter().for_each(|m| check.material(m));
            check.bodies();
            self.amplitudes.iter().for_each(|a| check.accept("", a.span, a.definition.check()));
            self.erosions.iter().for_each(|e| check.erosion(e));
            self.remeshings.iter().for_each(|r| check.remeshing(r));
            self.targets.iter().for_each(|t| check.target(t));
            self.discrete.connectors.iter().for_each(|c| check.connector(c));
            check.conditions();
            self.steps.iter().for_each(|s| check.step(s));
        }
        check.found
    }
}

/// A keyword and the rules of some of its fields.
pub type FieldRules<const N: usize> = (&'static str, [&'static InputRule; N]);

/// Returns the rules of fields of a card. A name that the card does not have is an error of the compiler.
macro_rules! fields {
    ($card:ty: $($name:literal),+) => { (<$card>::ROW.name, const { [$(<$card>::ROW.field($name)),+] }) };
}
pub(super) use fields;

/// Validation state: the model and the diagnostics.
pub struct ConsistencyCheck<'a> {
    model: &'a Model,
    found: Diagnostics,
}

fn is_ascending(members: &[usize]) -> bool {
    members.windows(2).all(|w| w[0] < w[1])
}

impl ConsistencyCheck<'_> {
    fn error(&mut self, code: &'static str, span: Span, message: impl Into<String>) {
        self.found.push(Diagnostic::error(code, message).at(span, "here"));
    }

    /// Reports an invalid value unless `is_valid`.
    fn value(&mut self, is_valid: bool, span: Span, message: impl Display) {
        self.accept("", span, require(is_valid, message));
    }

    /// Reports the fault that a check has found; `owner` precedes the message.
    pub fn accept(&mut self, owner: &str, span: Span, check: ValueCheck) {
        check.unwrap_or_else(|fault| self.found.push(fault.at(owner, span)));
    }

    /// Reports values outside the ranges of their fields in the keyword table; `owner` precedes the message.
    pub fn ranges<const N: usize>(
        &mut self,
        span: Span,
        owner: &str,
        (keyword, rules): FieldRules<N>,
        values: [Option<f64>; N],
    ) {
        for (rule, value) in rules.into_iter().zip(values) {
            let Some(value) = value.filter(|value| !rule.value.allows(*value)) else { continue };
            let message = format!("{} of *{keyword} must be {}, found {value}", rule.name, rule.value.allowed());
            self.accept(owner, span, require(false, message));
        }
    }

    /// Reports values that are negative or not finite.
    fn not_negative<const N: usize>(&mut self, span: Span, values: [(&str, f64); N]) {
        for (name, value) in values {
            self.value(is_non_negative(value), span, format_args!("{name} must not be negative, found {value}"));
        }
    }

    fn ascending(&mut self, span: Span, members: &str, indices: &[usize]) {
        self.value(is_ascending(indices), span, format_args!("the {members} must be in ascending order"));
    }

    /// Reports the first index that is out of range.
    fn indices(&mut self, code: &'static str, span: Span, what: &str, indices: &[usize], count: usize) {
        if let Some(stray) = indices.iter().find(|i| **i >= count) {
            self.error(code, span, format!("{what} index {stray} is out of range: the model has {count}"));
        }
    }

    fn nodes(&mut self, span: Span, indices: &[usize]) {
        self.indices("M110", span, "node", indices, self.model.mesh.points.len());
    }

    fn elements(&mut self, span: Span, indices: &[usize]) {
        self.indices("M110", span, "element", indices, self.model.mesh.elements.len());
    }

    fn remeshing(&mut self, remeshing: &Remeshing) {
        let Remeshing { span, elements, angle, increment, frequency, thickness, size, limits, .. } = remeshing;
        self.elements(*span, elements);
        self.ascending(*span, "elements of a body", elements);
        let fields = fields!(adaptive::Remesh: "ANGLE", "INCREMENT", "FREQUENCY", "THICKNESS", "SIZE", "CURVATURE ANGLE", "STRAIN CHANGE", "MINIMUM SIZE");
        let (angle, curvature) = (Some(angle.to_degrees()), limits.curvature_angle.map(f64::to_degrees));
        let (increment, frequency) = (Some(*increment), Some(*frequency as f64));
        let values =
            [angle, increment, frequency, Some(*thickness), *size, curvature, limits.strain_change, limits.smallest];
        self.ranges(*span, "", fields, values);
        self.accept("", *span, check_size_limits(limits));
    }

    fn erosion(&mut self, erosion: &ErosionCriteria) {
        self.elements(erosion.span, erosion.elements.as_deref().unwrap_or_default());
        let fields = fields!(materials::Erosion: "DISTORTION", "PLASTIC STRAIN", "PRINCIPAL STRAIN", "INCREMENT");
        let limits = [erosion.distortion, erosion.plastic, erosion.strain, erosion.increment];
        self.ranges(erosion.span, "", fields, limits);
        self.accept("", erosion.span, erosion.check());
    }

    fn amplitude(&mut self, span: Span, id: Option<AmplitudeId>) {
        self.indices("M112", span, "amplitude", id.map(AmplitudeId::index).as_slice(), self.model.amplitudes.len());
    }

    fn degree(&mut self, span: Span, dof: u8, last: u8) {
        let message = format_args!("degree of freedom must be from 1 to {last} (1 = r, 2 = z), found {dof}");
        self.value((1..=last).contains(&dof), span, message);
    }

    fn mesh(&mut self) {
        let mesh = &self.model.mesh;
        let (points, names) = (mesh.points.len(), mesh.node_names.len());
        if points != names {
            self.found.push(Diagnostic::error("M110", format!("the mesh has {points} nodes but {names} node names")));
        }
        // Coordinates of unused nodes are not restricted; an example is the centre of an arc.
        let stray = mesh.points.iter().find(|[r, z]| !(r.is_finite() && z.is_finite()));
        if let Some([r, z]) = stray {
            let message = format!("node coordinates must be finite, found r = {r}, z = {z}");
            self.found.push(Diagnostic::error("M126", message));
        }
        for element in &mesh.elements {
            let (need, has) = (element.kind.node_count(), element.nodes.len());
            if need != has {
                let message =
                    format!("element {} of {} must have {need} nodes, found {has}", element.name, element.kind.name());
                self.error("M122", element.span, message);
            }
            self.indices("M122", element.span, "node", &element.nodes, points);
            // Rounding errors of rotated or generated nodes are tolerated.
            let largest = element
                .nodes
                .iter()
                .filter_map(|&n| mesh.points.get(n))
                .fold(0.0_f64, |m, p| m.max(p[0].abs()).max(p[1].abs()));
            if element.nodes.iter().filter_map(|&n| mesh.points.get(n)).any(|p| p[0] < -1e-9 * largest) {
                let message = format!("element {} has a node with negative r", element.name);
                self.error("M126", element.span, message);
            }
        }
    }

    fn names(&mut self) {
        let model = self.model;
        for (name, set) in model.node_sets.iter().chain(&model.element_sets) {
            self.ascending(set.span, &format!("members of set `{name}`"), &set.members);
        }
        model.node_sets.values().for_each(|set| self.nodes(set.span, &set.members));
        model.element_sets.values().for_each(|set| self.elements(set.span, &set.members));
        model.surfaces.faces.values().for_each(|s| self.faces(s.span, &s.faces));
        model.surfaces.nodes.values().for_each(|nodes| self.nodes(Span::default(), nodes));
    }

    /// Checks that the selected sides and elements exist.
    fn sides(&mut self, span: Span, sides: &SideSelection) {
        self.faces(span, &sides.faces);
        self.refuse_cohesive_faces(span, sides);
        self.elements(span, &sides.free_face_elements);
    }

    /// Reports loads and contact on faces of cohesive elements, which are inside of bodies.
    fn refuse_cohesive_faces(&mut self, span: Span, sides: &SideSelection) {
        let elements = &self.model.mesh.elements;
        let is_cohesive = |face: &&(usize, ElementSide)| elements.get(face.0).is_some_and(|e| e.kind.is_cohesive());
        if let Some((element, _)) = sides.faces.iter().find(is_cohesive) {
            let name = &elements[*element].name;
            let message = format!("surface `{}` has a face of the cohesive element {name}", sides.name);
            let help = "faces of cohesive elements can only be tied (*TIE): give the faces of the solid elements";
            self.found.push(Diagnostic::error("M131", message).at(span, "here").help(help));
        }
    }

    /// Checks the elements of a load per volume, which cohesive elements do not have.
    fn loaded_elements(&mut self, span: Span, list: &[usize]) {
        self.elements(span, list);
        let elements = &self.model.mesh.elements;
        let is_cohesive = |e: &&usize| elements.get(**e).is_some_and(|e| e.kind.is_cohesive());
        if let Some(element) = list.iter().find(is_cohesive) {
            let message = format!("element {} is cohesive: loads per volume do not act on it", elements[*element].name);
            let help = "give an ELSET without cohesive elements";
            self.found.push(Diagnostic::error("M131", message).at(span, "this load").help(help));
        }
    }

    fn faces(&mut self, span: Span, faces: &[(usize, ElementSide)]) {
        let mesh = &self.model.mesh;
        for &(index, side) in faces {
            let Some(element) = mesh.elements.get(index) else {
                self.elements(span, &[index]);
                return;
            };
            let has = match side {
                ElementSide::Positive | ElementSide::Negative => element.kind.is_line(),
                ElementSide::Face(n) if element.kind.is_cohesive() => n == 1 || n == 3,
                ElementSide::Face(n) => element.kind.is_solid() && (1..=element.nodes.len()).contains(&usize::from(n)),
            };
            if !has {
                let message = format!("element {} of {} has no side {side:?}", element.name, element.kind.name());
                self.error("M131", span, message);
                return;
            }
        }
    }

    fn section(&mut self, span: Span, elements: &[usize], material: MaterialId) {
        self.elements(span, elements);
        self.indices("M111", span, "material", &[material.index()], self.model.materials.len());
    }

    fn bodies(&mut self) {
        let model = self.model;
        model.sections.iter().for_each(|s| self.section(s.span, &s.elements, s.material));
        for section in &model.shell_sections {
            self.elements(section.span, &section.elements);
            self.shell_section(section);
        }
        for section in &model.cohesive_sections {
            self.section(section.span, &section.elements, section.material);
            self.ranges(section.span, "", fields!(materials::CohesiveSection: "thickness"), [section.thickness]);
        }
        for body in &model.rigid_bodies {
            self.nodes(body.span, &[body.reference]);
            self.nodes(body.span, &body.nodes);
            self.elements(body.span, &body.elements);
            self.not_negative(body.span, [("DENSITY", body.density), ("thickness", body.thickness)]);
        }
        for point in &model.discrete.masses {
            self.nodes(point.span, &[point.node]);
            self.ranges(point.span, "", fields!(constraints::Mass: "mass"), [Some(point.mass)]);
        }
        for attitude in &model.attitudes {
            self.nodes(attitude.span, &[attitude.reference]);
            let is_valid = attitude.angles.iter().all(|a| a.is_finite());
            self.value(is_valid, attitude.span, "the angles of an attitude must be finite");
            let stations = Some(attitude.stations as f64);
            self.ranges(attitude.span, "", fields!(constraints::Attitude: "STATIONS"), [stations]);
        }
        for inertia in &model.discrete.inertias {
            self.nodes(inertia.span, &[inertia.node]);
            for moment in inertia.moments {
                self.ranges(inertia.span, "", fields!(constraints::RotaryInertia: "I11"), [Some(moment)]);
            }
        }
        for surface in model.surfaces.analytical.values() {
            self.nodes(surface.span, surface.reference.as_slice());
            let segments = &surface.profile.segments;
            let finite = segments.iter().flat_map(|s| s.ends()).flatten().all(f64::is_finite);
            let message = "an analytical surface requires segments with finite coordinates";
            self.value(finite && !segments.is_empty(), surface.span, message);
        }
    }

    fn shell_section(&mut self, section: &ShellSection) {
        self.ranges(section.span, "", fields!(materials::ShellSection: "DENSITY"), [Some(section.per_area)]);
        self.value(!section.layers.is_empty(), section.span, "a shell section requires a layer");
        for (index, layer) in section.layers.iter().enumerate() {
            let values = [layer.thickness, layer.points as f64].map(Some);
            self.ranges(section.span, "", fields!(materials::ShellSection: "thickness", "points"), values);
            self.indices("M111", section.span, "material", &[layer.material.index()], self.model.materials.len());
            self.accept("", section.span, check_points(index, layer.points));
            self.value(layer.angle.is_finite(), section.span, "the angle of a layer must be finite");
        }
        self.accept("", section.span, check_offset(section.offset));
        self.accept("", section.span, section.thinning.check());
    }

    fn target(&mut self, target: &TargetStack) {
        let is_valid = target.front.is_finite() && target.direction.abs() == 1.0 && !target.layers.is_empty();
        self.value(is_valid, target.span, "a target requires a finite front, a direction of +1 or -1, and layers");
        let owner = format!("`{}`: ", target.name);
        self.ranges(target.span, &owner, fields!(constraints::Target: "OBLIQUITY"), [Some(target.obliquity)]);
        for layer in &target.layers {
            let TargetLayer { thickness, radius, .. } = *layer;
            let message = format!("thickness and radius of a layer must be positive, found {thickness} and {radius}");
            self.value(thickness > 0.0 && radius > 0.0, layer.span, message);
            let Some(index) = layer.material else { continue };
            self.indices("M111", layer.span, "material", &[index.index()], self.model.materials.len());
            let Some(material) = self.model.materials.get(index.index()) else { continue };
            if material.cavity.is_none() || material.density.is_none() {
                self.error("M101", layer.span, no_resistance(material));
            }
        }
    }

    fn connector(&mut self, property: &ConnectorProperty) {
        self.elements(property.span, &property.elements);
        let elements = property.elements.iter().filter_map(|&e| self.model.mesh.elements.get(e));
        let kinds: Vec<ElementKind> = elements.map(|e| e.kind).collect();
        let message = "a spring or dashpot property is assigned to elements of another type";
        self.value(kinds.iter().all(|k| k.is_connector()), property.span, message);
        if kinds.iter().any(|k| k.node_count() == 1) {
            self.degree(property.span, property.dof, 2);
        }
        self.accept("", property.span, property.law.check());
    }

    fn conditions(&mut self) {
        let model = self.model;
        for equation in &model.constraints.equations {
            let nodes: Vec<usize> = equation.terms.iter().map(|t| t.0).collect();
            self.nodes(equation.span, &nodes);
            if equation.is_thermal() {
                let are_thermal = equation.terms.iter().all(|t| t.1 == 11);
                self.value(
                    are_thermal,
                    equation.span,
                    "an equation cannot combine temperatures (11) and displacements",
                );
            } else {
                equation.terms.iter().for_each(|t| self.degree(equation.span, t.1, 2));
            }
            let is_valid = !nodes.is_empty() && equation.terms.iter().all(|t| t.2.is_finite() && t.2 != 0.0);
            self.value(is_valid, equation.span, "an equation requires terms with nonzero coefficients");
        }
        for link in &model.constraints.links {
            self.nodes(link.span, &[link.reference]);
            self.nodes(link.span, &link.nodes);
            if let LinkKind::Distributing(weights) = &link.kind {
                let sum: f64 = weights.iter().sum();
                let is_valid = weights.len() == link.nodes.len()
                    && weights.iter().all(|w| is_non_negative(*w))
                    && is_positive(sum);
                self.value(is_valid, link.span, "a coupling requires one weight per node, with a positive sum");
            }
        }
        for tie in &model.constraints.ties {
            self.nodes(tie.span, &tie.slaves);
            self.nodes(tie.span, tie.chosen.as_deref().unwrap_or_default());
            self.faces(tie.span, &tie.slave_faces);
            self.faces(tie.span, &tie.masters);
            self.not_negative(tie.span, [("POSITION TOLERANCE", tie.tolerance.unwrap_or(0.0))]);
        }
        for condition in &model.initial_conditions {
            let finite = match &condition.kind {
                InitialKind::Stress(values) | InitialKind::State(values) => values.iter().all(|v| v.is_finite()),
                InitialKind::Velocity(_, v)
                | InitialKind::Temperature(v)
                | InitialKind::Energy(v)
                | InitialKind::Hardening(v)
                | InitialKind::Field(_, v) => v.is_finite(),
            };
            self.value(finite, condition.span, "the values of an initial condition must be finite");
            self.ascending(condition.span, "members of an initial condition", &condition.members);
            if condition.kind.applies_to_elements() {
                self.elements(condition.span, &condition.members);
            } else {
                self.nodes(condition.span, &condition.members);
            }
            if let InitialKind::Velocity(dof, _) = condition.kind {
                self.degree(condition.span, dof, 6);
            }
        }
        self.value(model.settings.absolute_zero.is_finite(), Span::default(), "absolute zero must be finite");
    }

    fn step(&mut self, step: &Step) {
        let fields = fields!(steps::Dynamic: "length of the step", "SCALE FACTOR", "ACCURACY");
        let accuracy = match step.increment {
            IncrementControl::Automatic { accuracy, .. } => Some(accuracy),
            IncrementControl::Fixed(_) => None,
        };
        let owner = format!("step `{}`: ", step.name);
        self.ranges(step.span, &owner, fields, [Some(step.duration), Some(step.scale_factor), accuracy]);
        self.accept(&owner, step.span, step.increment.check(step.duration));
        let BulkViscosity { linear, quadratic, .. } = step.bulk_viscosity;
        self.not_negative(step.span, [("linear bulk viscosity", linear), ("quadratic bulk viscosity", quadratic)]);
        step.boundaries.iter().for_each(|b| self.boundary(b));
        step.loads.iter().for_each(|l| self.load(l));
        for field in &step.fields {
            self.nodes(field.span, &field.nodes);
            self.amplitude(field.span, field.amplitude);
            let is_known = !matches!(field.variable, PredefinedVariable::Field(variable) if variable >= MOST_FIELDS);
            let is_valid = field.value.is_finite() && is_known && is_ascending(&field.nodes);
            self.value(is_valid, field.span, "a field requires a finite value and nodes in ascending order");
        }
        step.outputs.iter().for_each(|o| self.output(o));
        if let Some(restart) = step.restart {
            self.interval(restart.span, restart.interval);
        }
        self.contacts_and_masses(step);
    }

    fn contacts_and_masses(&mut self, step: &Step) {
        for contact in &step.surface_contacts {
            for sides in &contact.sides {
                self.refuse_cohesive_faces(contact.span, sides);
                let elements: Vec<usize> = sides.faces.iter().map(|f| f.0).collect();
                self.elements(contact.span, &elements);
            }
            if let Some(analytical) = &contact.analytical {
                self.analytical_side(contact, analytical);
            }
            let interaction = contact.interaction.map(InteractionId::index);
            let count = self.model.interactions.len();
            self.indices("M114", contact.span, "surface interaction", interaction.as_slice(), count);
            let CoulombFriction { at_rest, sliding, decay, largest, damping } = contact.law.friction;
            let is_valid = [at_rest, sliding, decay, largest, damping].iter().all(|x| *x >= 0.0);
            self.value(is_valid, contact.span, "friction parameters must not be negative");
            self.accept("", contact.span, check_overclosure(&contact.law.overclosure));
            let is_valid = contact.law.damping.is_none_or(|damping| damping.value() >= 0.0);
            self.value(is_valid, contact.span, "contact damping must not be negative");
            if let Some(PrescribedClearance { gap, above, below }) = contact.clearance {
                let is_valid = [Some(gap), above, below].into_iter().flatten().all(|x| x >= 0.0);
                self.value(is_valid, contact.span, "a clearance and its search distances must not be negative");
            }
            let is_valid = contact.penalty.is_none_or(is_positive);
            self.value(is_valid, contact.span, "the scale factor of the penalty stiffness must be positive");
        }
        for scaling in &step.mass_scalings {
            self.elements(scaling.span, scaling.elements.as_deref().unwrap_or_default());
            let fields = fields!(steps::FixedMassScaling: "FACTOR", "DT", "BUDGET");
            self.ranges(scaling.span, "", fields, [Some(scaling.factor), scaling.target.map(|t| t.1), scaling.budget]);
        }
        for mesh in &step.adaptive {
            self.elements(mesh.span, &mesh.elements);
            let fields = fields!(adaptive::AdaptiveMesh: "FREQUENCY", "MESH SWEEPS");
            let values = [mesh.frequency.map(|count| count as f64), Some(mesh.sweeps as f64)];
            self.ranges(mesh.span, "", fields, values);
            let AdaptiveControls { weights, corner_angle, .. } = mesh.controls;
            let is_valid = weights.iter().all(|w| *w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-9;
            self.value(is_valid, mesh.span, "weights of smoothing must not be negative, and their sum must be 1");
            let fields = fields!(adaptive::AdaptiveMeshControls: "TRANSITION FEATURE ANGLE");
            self.ranges(mesh.span, "", fields, [Some(corner_angle.to_degrees())]);
        }
        step.adaptive_fixed.iter().for_each(|(span, nodes)| self.nodes(*span, nodes));
        step.adaptive_regions.iter().for_each(|region| self.nodes(region.span, &region.nodes));
        step.mesh_motions.iter().for_each(|motion| self.nodes(motion.span, &motion.nodes));
    }

    fn analytical_side(&mut self, contact: &SurfaceContact, analytical: &AnalyticalSide) {
        self.nodes(contact.span, &analytical.nodes);
        self.ascending(contact.span, "nodes of a contact surface", &analytical.nodes);
        let count = self.model.surfaces.analytical.len();
        self.indices("M114", contact.span, "analytical surface", &[analytical.surface.index()], count);
    }

    fn boundary(&mut self, boundary: &BoundaryCondition) {
        self.nodes(boundary.span, &boundary.nodes);
        if boundary.is_thermal() {
            self.value(boundary.dof == 11, boundary.span, "a temperature must be prescribed at degree of freedom 11");
        } else {
            self.degree(boundary.span, boundary.dof, 6);
        }
        self.amplitude(boundary.span, boundary.amplitude);
        self.value(boundary.value.is_finite(), boundary.span, "a prescribed motion must be finite");
    }

    fn load(&mut self, load: &Load) {
        self.amplitude(load.span, load.amplitude);
        self.value(load.magnitude.is_finite(), load.span, "the magnitude of a load must be finite");
        match (load.kind.region(), &load.kind) {
            (LoadRegion::Nodes(nodes), _) => self.nodes(load.span, nodes),
            (LoadRegion::Elements(elements), LoadKind::Gravity { .. }) => self.elements(load.span, elements),
            (LoadRegion::Elements(elements), _) => self.loaded_elements(load.span, elements),
            (LoadRegion::Sides(sides), _) => self.sides(load.span, sides),
            (LoadRegion::Whole, _) => {}
        }
        match &load.kind {
            LoadKind::Concentrated { dof, .. } => self.degree(load.span, *dof, 6),
            LoadKind::Gravity { direction, .. } => {
                let length = direction[0].portable_hypot(direction[1]).portable_hypot(direction[2]);
                self.value((length - 1.0).abs() < 1e-9, load.span, "the direction of GRAV must be a unit vector");
            }
            LoadKind::Traction { law, .. } => self.traction(load.span, law),
            LoadKind::Blast { charge, .. } => {
                let is_valid = charge.mass > 0.0 && charge.units.iter().all(|unit| *unit > 0.0);
                self.value(is_valid, load.span, "mass and units of a charge must be positive");
            }
            LoadKind::Film { coefficient, amplitude, .. } => {
                self.amplitude(load.span, *amplitude);
                self.not_negative(load.span, [("the film coefficient", *coefficient)]);
            }
            LoadKind::User { load_type, .. } => {
                self.load_type(load.span, *load_type, matches!(load_type, 0 | 20..=24));
            }
            LoadKind::UserBody { load_type, .. } => {
                self.load_type(load.span, *load_type, matches!(load_type, 1 | 2));
            }
            LoadKind::Cavity { target, friction, .. } => {
                self.indices("M113", load.span, "target", &[target.index()], self.model.targets.len());
                self.not_negative(load.span, [("FRICTION", *friction)]);
            }
            LoadKind::Pressure(_)
            | LoadKind::Body { .. }
            | LoadKind::NodalHeat { .. }
            | LoadKind::SurfaceHeat(_)
            | LoadKind::BodyHeat { .. } => {}
        }
    }

    fn traction(&mut self, span: Span, law: &SurfaceTraction) {
        match law {
            SurfaceTraction::Vector { direction: [r, z], .. } | SurfaceTraction::Shear { direction: [r, z] } => {
                let is_unit = (r.portable_hypot(*z) - 1.0).abs() < 1e-9;
                self.value(is_unit, span, "the direction of a traction must be a unit vector");
            }
            SurfaceTraction::Viscous { reference } => self.nodes(span, reference.as_slice()),
            SurfaceTraction::Absorbing { .. } => {}
        }
    }

    fn load_type(&mut self, span: Span, load_type: i32, known: bool) {
        if !known {
            self.error("M132", span, format!("{load_type} is not a VDLOAD load type for this load"));
        }
    }

    fn output(&mut self, request: &OutputRequest) {
        self.interval(request.span, request.interval);
        let model = self.model;
        for variable in &request.variables {
            let VariableRequest::One(part) = variable else { continue };
            if !part.variable.row().numbered && part.variable.parts().all(|p| p != *part) {
                let message = format!("{} has no component {}", part.variable.name(), part.component);
                self.error("M141", request.span, message);
            }
        }
        let (what, index, count) = match &request.region {
            OutputRegion::Nodes(set) => ("node set", set.index(), model.node_sets.len()),
            OutputRegion::Elements(set) => ("element set", set.index(), model.element_sets.len()),
            OutputRegion::Surface(surface, _) => ("surface", surface.index(), model.surfaces.faces.len()),
            OutputRegion::Whole | OutputRegion::Pairs(_) => return,
        };
        self.indices("M110", request.span, what, &[index], count);
    }

    fn interval(&mut self, span: Span, interval: OutputInterval) {
        if let OutputInterval::Time(time) = interval {
            self.value(time > 0.0, span, format_args!("an output interval must be positive, found {time}"));
        }
    }
}
