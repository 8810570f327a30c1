//! Construction of models in Rust, without a deck. [`Model::check`] validates them.

use super::name::EntityName;
use super::steps::DEFAULT_ACCURACY;
use super::types::{
    Amplitude, AmplitudeDefinition, AmplitudeId, BoundaryCondition, CohesiveSection, Element, ElementKind,
    ElementSetId, ElementSide, IncrementControl, InitialCondition, InitialKind, Load, LoadKind, MaterialDefinition,
    MaterialId, MemberSet, Model, MotionKind, NodeSetId, OutputCard, OutputExpression, OutputInterval, OutputKind,
    OutputPosition, OutputRegion, OutputRequest, PointMass, RigidBody, SectionControls, ShellLayer, ShellSection,
    ShellThinning, SideSelection, SolidSection, Step,
};
use crate::deck::Span;
use crate::kernel::lists::sorted_unique;
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;

impl Model {
    /// Iterates over material and elements of all sections: solids, shells with their first layer, cohesive elements.
    pub fn material_regions(&self) -> impl Iterator<Item = (MaterialId, &[usize])> {
        let solids = self.sections.iter().map(|s| (s.material, &s.elements[..]));
        let cohesive = self.cohesive_sections.iter().map(|s| (s.material, &s.elements[..]));
        let shells = self.shell_sections.iter().map(|s| (s.layers[0].material, &s.elements[..]));
        solids.chain(shells).chain(cohesive)
    }

    /// Iterates over material and elements of all sections, with all layers of shells.
    pub fn layer_regions(&self) -> impl Iterator<Item = (MaterialId, &[usize])> {
        let upper = |s: &'_ ShellSection| -> Vec<MaterialId> { s.layers.iter().skip(1).map(|l| l.material).collect() };
        let further = self.shell_sections.iter().flat_map(move |s| upper(s).into_iter().map(|m| (m, &s.elements[..])));
        self.material_regions().chain(further)
    }

    /// Adds a node at `[r, z]` and returns its index. Its name is its number, counted from 1.
    pub fn node(&mut self, r: f64, z: f64) -> usize {
        self.mesh.points.push([r, z]);
        let number = self.mesh.points.len() as i64;
        self.mesh.node_names.push(EntityName::of_label("", number));
        self.mesh.points.len() - 1
    }

    /// Adds an element and returns its index. Its name is its number, counted from 1. Nodes of solids are given
    /// counter-clockwise in (r, z), in the order of ABAQUS.
    #[track_caller]
    pub fn element(&mut self, kind: ElementKind, nodes: &[usize]) -> usize {
        let name = EntityName::of_label("", self.mesh.elements.len() as i64 + 1);
        self.mesh.elements.push(Element { name, kind, nodes: kind.around(nodes), span: Span::composed() });
        self.mesh.elements.len() - 1
    }

    /// Defines a node set, for output requests; the name is converted to upper case.
    #[track_caller]
    pub fn node_set(&mut self, name: &str, members: &[usize]) -> NodeSetId {
        NodeSetId::new(self.node_sets.insert_full(name.to_uppercase(), MemberSet::new(members)).0)
    }

    /// Defines an element set, for output requests; the name is converted to upper case.
    #[track_caller]
    pub fn element_set(&mut self, name: &str, members: &[usize]) -> ElementSetId {
        ElementSetId::new(self.element_sets.insert_full(name.to_uppercase(), MemberSet::new(members)).0)
    }

    /// Adds a material and returns its handle.
    pub fn material(&mut self, material: MaterialDefinition) -> MaterialId {
        self.materials.push(material);
        MaterialId::new(self.materials.len() - 1)
    }

    /// Assigns a material to solid elements.
    #[track_caller]
    pub fn section(&mut self, elements: &[usize], material: MaterialId) {
        let elements = elements.to_vec();
        self.sections.push(SolidSection {
            elements,
            material,
            controls: SectionControls::default(),
            fibres: Vec::new(),
            span: Span::composed(),
        });
    }

    /// Assigns a material and a thickness to shell elements, with five section points.
    #[track_caller]
    pub fn shell_section(&mut self, elements: &[usize], material: MaterialId, thickness: f64) -> &mut ShellSection {
        self.shell_sections.push(ShellSection {
            elements: elements.to_vec(),
            layers: vec![ShellLayer { material, thickness, points: 5, angle: 0.0 }],
            offset: 0.0,
            per_area: 0.0,
            thinning: ShellThinning::Material,
            span: Span::composed(),
        });
        let last = self.shell_sections.len() - 1;
        &mut self.shell_sections[last]
    }

    /// Assigns a material to cohesive elements, with a constitutive thickness of 1: nominal strains are separations.
    #[track_caller]
    pub fn cohesive_section(&mut self, elements: &[usize], material: MaterialId) -> &mut CohesiveSection {
        self.cohesive_sections.push(CohesiveSection {
            elements: elements.to_vec(),
            material,
            thickness: Some(1.0),
            controls: SectionControls::default(),
            span: Span::composed(),
        });
        let last = self.cohesive_sections.len() - 1;
        &mut self.cohesive_sections[last]
    }

    /// Defines a rigid body. Its mass is given by [`RigidBody::density`] and thickness, or by [`Model::mass`].
    #[track_caller]
    pub fn rigid_body(&mut self, name: &str, reference: usize, elements: &[usize]) -> &mut RigidBody {
        self.rigid_bodies.push(RigidBody {
            name: name.to_uppercase(),
            reference,
            elements: elements.to_vec(),
            nodes: Vec::new(),
            thickness: 0.0,
            density: 0.0,
            span: Span::composed(),
        });
        let last = self.rigid_bodies.len() - 1;
        &mut self.rigid_bodies[last]
    }

    /// Adds a point mass to a node.
    #[track_caller]
    pub fn mass(&mut self, node: usize, mass: f64) {
        self.discrete.masses.push(PointMass { node, mass, span: Span::composed() });
    }

    /// Sets the initial velocity of nodes along a degree of freedom (1 = r, 2 = z).
    #[track_caller]
    pub fn initial_velocity(&mut self, nodes: &[usize], dof: u8, velocity: f64) {
        let kind = InitialKind::Velocity(dof, velocity);
        self.initial_conditions.push(InitialCondition {
            kind,
            members: sorted_unique(nodes.iter().copied()),
            span: Span::composed(),
        });
    }

    /// Adds a piecewise linear amplitude of step time, from points `[time, value]` with ascending times.
    #[track_caller]
    pub fn amplitude(&mut self, name: &str, points: &[[f64; 2]]) -> AmplitudeId {
        let definition = AmplitudeDefinition::Curve { points: points.to_vec(), smooth: false, total_time: false };
        let (name, span) = (name.to_uppercase(), Span::composed());
        self.amplitudes.push(Amplitude { name, definition, absolute: false, span });
        AmplitudeId::new(self.amplitudes.len() - 1)
    }
}

impl MemberSet {
    /// Creates a set from members in any order.
    #[track_caller]
    pub fn new(members: &[usize]) -> MemberSet {
        MemberSet { members: sorted_unique(members.iter().copied()), span: Span::composed() }
    }
}

impl MaterialDefinition {
    /// Creates a linear elastic material from density, Young's modulus and Poisson's ratio. Set its fields for other
    /// laws.
    #[track_caller]
    pub fn elastic(name: &str, density: f64, modulus: f64, ratio: f64) -> MaterialDefinition {
        MaterialDefinition {
            name: name.to_uppercase(),
            span: Span::composed(),
            density: Some(density),
            elastic: Some([modulus, ratio]),
            ..MaterialDefinition::default()
        }
    }
}

impl SideSelection {
    /// Creates a surface from faces `(element, side)`.
    pub fn new(name: &str, faces: &[(usize, ElementSide)]) -> SideSelection {
        SideSelection { name: name.into(), surface: true, faces: faces.to_vec(), free_face_elements: Vec::new() }
    }
}

impl Step {
    /// Creates a step of a duration, with automatic increments and nothing in force.
    #[track_caller]
    pub fn new(name: &str, duration: f64) -> Step {
        Step { name: name.into(), span: Span::composed(), duration, scale_factor: 1.0, ..Step::default() }
    }

    /// Adds a prescribed motion.
    #[must_use]
    pub fn with_boundary(mut self, boundary: BoundaryCondition) -> Step {
        self.boundaries.push(boundary);
        self
    }

    /// Adds a load that acts in the step.
    #[must_use]
    pub fn with_load(mut self, load: Load) -> Step {
        self.loads.push(load);
        self
    }

    /// Adds an output request.
    #[must_use]
    pub fn with_output(mut self, request: OutputRequest) -> Step {
        self.outputs.push(request);
        self
    }
}

impl Default for IncrementControl {
    fn default() -> Self {
        let accuracy = DEFAULT_ACCURACY;
        IncrementControl::Automatic { accuracy, element_by_element: false, largest: f64::INFINITY }
    }
}

impl BoundaryCondition {
    /// Fixes nodes along a degree of freedom (1 = r, 2 = z).
    #[track_caller]
    pub fn fixed(name: &str, nodes: &[usize], dof: u8) -> BoundaryCondition {
        BoundaryCondition::prescribed(name, nodes, dof, MotionKind::Displacement, 0.0)
    }

    /// Prescribes a motion of nodes. A displacement requires [`BoundaryCondition::amplitude`], because displacements cannot
    /// jump.
    #[track_caller]
    pub fn prescribed(name: &str, nodes: &[usize], dof: u8, kind: MotionKind, value: f64) -> BoundaryCondition {
        let (set, nodes, span) = (name.into(), nodes.to_vec(), Span::composed());
        BoundaryCondition { nodes, set, dof, kind, user: false, value, amplitude: None, span }
    }
}

impl Load {
    /// Creates a constant load.
    #[track_caller]
    pub fn new(kind: LoadKind, magnitude: f64) -> Load {
        Load { kind, magnitude, amplitude: None, span: Span::composed() }
    }

    /// Creates a pressure load; positive pressure acts against the outward normal.
    #[track_caller]
    pub fn pressure(sides: SideSelection, magnitude: f64) -> Load {
        Load::new(LoadKind::Pressure(sides), magnitude)
    }

    /// Creates a pressure load given by a user load ([`revolve_numerics::routines::Routines::with_load`]).
    #[track_caller]
    pub fn user(sides: SideSelection) -> Load {
        Load::new(LoadKind::User { sides, load_type: 0 }, 1.0)
    }

    /// Multiplies the load with an amplitude over time.
    #[must_use]
    pub fn with_amplitude(mut self, amplitude: AmplitudeId) -> Load {
        self.amplitude = Some(amplitude);
        self
    }
}

impl OutputRequest {
    /// Requests history columns `<VARIABLE>@<SET>` at the default interval.
    #[track_caller]
    pub fn history<A: Into<VariableRequest>>(
        region: OutputRegion,
        variables: impl IntoIterator<Item = A>,
    ) -> OutputRequest {
        OutputRequest::new(OutputKind::History, region, variables.into_iter().map(Into::into).collect())
    }

    /// Requests field output at the default interval.
    #[track_caller]
    pub fn field<A: Into<VariableRequest>>(variables: impl IntoIterator<Item = A>) -> OutputRequest {
        OutputRequest::new(OutputKind::Field, OutputRegion::Whole, variables.into_iter().map(Into::into).collect())
    }

    #[track_caller]
    fn new(kind: OutputKind, region: OutputRegion, variables: Vec<VariableRequest>) -> OutputRequest {
        let card = match region {
            OutputRegion::Whole => OutputCard::Output,
            OutputRegion::Nodes(_) => OutputCard::Node,
            OutputRegion::Elements(_) => OutputCard::Element,
            OutputRegion::Surface(..) => OutputCard::Integrated,
            OutputRegion::Pairs(_) => OutputCard::Contact,
        };
        let (interval, position, span) = (OutputInterval::Default, OutputPosition::Element, Span::composed());
        OutputRequest { kind, interval, card, variables, position, region, statistics: Vec::new(), sensor: None, span }
    }

    /// Requests statistics over the set instead of one column per member.
    #[must_use]
    pub fn with_statistics(mut self, statistics: &[Statistic]) -> OutputRequest {
        self.statistics = statistics.to_vec();
        self
    }

    /// Requests output at this interval instead of the default.
    #[must_use]
    pub fn every(mut self, interval: OutputInterval) -> OutputRequest {
        self.interval = interval;
        self
    }
}

impl OutputExpression {
    /// Creates a history column from an expression in other columns, for example `-1000*(U2@TOP - U2@FOOT)`.
    #[track_caller]
    pub fn new(name: &str, text: &str) -> OutputExpression {
        let span = Span::composed();
        OutputExpression { name: name.to_uppercase(), text: text.to_owned(), span, place: span }
    }
}
