//! Models composed in Rust: constructors of the pieces, and putting them together.
//! Never here: decks; whether the pieces fit, which `consistency` says.

use super::name::Name;
use super::steps::{BULK_VISCOSITY, DEFAULT_ACCURACY};
use super::types::{
    Amplitude, AmplitudeDefinition, AmplitudeId, Boundary, Element, ElementKind, ElementSetId, IncrementControl,
    InitialCondition, InitialKind, Interval, Load, LoadKind, LoadVelocity, Material, MaterialId, Model, Motion,
    NodeSetId, OutputCard, OutputExpression, OutputKind, OutputRequest, PointMass, Position, Region, RigidBody,
    SectionControls, Set, ShellSection, ShellThinning, Side, Sides, SolidSection, Step,
};
use crate::deck::Span;
use crate::kernel::lists::sorted_unique;
use crate::variables::request::VariableRequest;
use crate::variables::statistic::Statistic;
use crate::variables::{Part, Variable};

impl Model {
    /// What deforms is made of: material and elements of each section, solids before shells.
    pub fn made_of(&self) -> impl Iterator<Item = (MaterialId, &[usize])> {
        let solids = self.sections.iter().map(|s| (s.material, &s.elements[..]));
        solids.chain(self.shell_sections.iter().map(|s| (s.material, &s.elements[..])))
    }

    /// Adds a node at `[r, z]`, named by its number from 1 on, and returns its index.
    pub fn node(&mut self, r: f64, z: f64) -> usize {
        self.mesh.points.push([r, z]);
        let number = self.mesh.points.len() as i64;
        self.mesh.node_names.push(Name::of_label("", number));
        self.mesh.points.len() - 1
    }

    /// Adds an element, named by its number from 1 on, and returns its index. Nodes of solids run counter-clockwise in (r, z).
    #[track_caller]
    pub fn element(&mut self, kind: ElementKind, nodes: &[usize]) -> usize {
        let name = Name::of_label("", self.mesh.elements.len() as i64 + 1);
        self.mesh.elements.push(Element { name, kind, nodes: kind.around(nodes), span: Span::composed() });
        self.mesh.elements.len() - 1
    }

    /// Names some nodes, for output requests; names are kept in upper case.
    #[track_caller]
    pub fn node_set(&mut self, name: &str, members: &[usize]) -> NodeSetId {
        NodeSetId::new(self.node_sets.insert_full(name.to_uppercase(), Set::new(members)).0)
    }

    /// Names some elements, likewise.
    #[track_caller]
    pub fn element_set(&mut self, name: &str, members: &[usize]) -> ElementSetId {
        ElementSetId::new(self.element_sets.insert_full(name.to_uppercase(), Set::new(members)).0)
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId::new(self.materials.len() - 1)
    }

    /// Lets elements deform that are of a material.
    #[track_caller]
    pub fn section(&mut self, elements: &[usize], material: MaterialId) {
        let elements = elements.to_vec();
        self.sections.push(SolidSection {
            elements,
            material,
            controls: SectionControls::default(),
            span: Span::composed(),
        });
    }

    /// Lets shells deform that are of a material and of a thickness, with five points through it.
    #[track_caller]
    pub fn shell_section(&mut self, elements: &[usize], material: MaterialId, thickness: f64) -> &mut ShellSection {
        self.shell_sections.push(ShellSection {
            elements: elements.to_vec(),
            material,
            thickness,
            points: 5,
            per_area: 0.0,
            thinning: ShellThinning::Material,
            span: Span::composed(),
        });
        let last = self.shell_sections.len() - 1;
        &mut self.shell_sections[last]
    }

    /// Makes elements one rigid body with a reference node. Mass comes from [`RigidBody::density`] and thickness, or from
    /// [`Model::mass`].
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

    /// Puts a mass on a node.
    #[track_caller]
    pub fn mass(&mut self, node: usize, mass: f64) {
        self.discrete.masses.push(PointMass { node, mass, span: Span::composed() });
    }

    /// Lets nodes start with a velocity along a degree of freedom (1 = r, 2 = z).
    #[track_caller]
    pub fn initial_velocity(&mut self, nodes: &[usize], dof: u8, velocity: f64) {
        let kind = InitialKind::Velocity(dof, velocity);
        self.initial_conditions.push(InitialCondition {
            kind,
            members: sorted_unique(nodes.iter().copied()),
            span: Span::composed(),
        });
    }

    /// Adds a piecewise linear function of the time in a step, `[time, value]` with ascending times.
    #[track_caller]
    pub fn amplitude(&mut self, name: &str, points: &[[f64; 2]]) -> AmplitudeId {
        let definition = AmplitudeDefinition::Curve { points: points.to_vec(), smooth: false, total_time: false };
        let (name, span) = (name.to_uppercase(), Span::composed());
        self.amplitudes.push(Amplitude { name, definition, absolute: false, span });
        AmplitudeId::new(self.amplitudes.len() - 1)
    }
}

impl Set {
    /// A set of some members in any order.
    #[track_caller]
    pub fn new(members: &[usize]) -> Set {
        Set { members: sorted_unique(members.iter().copied()), span: Span::composed() }
    }
}

impl Material {
    /// A linear elastic material by density, Young's modulus and Poisson's ratio. Other laws go into its fields.
    #[track_caller]
    pub fn elastic(name: &str, density: f64, modulus: f64, ratio: f64) -> Material {
        Material {
            name: name.to_uppercase(),
            span: Span::composed(),
            density: Some(density),
            elastic: Some([modulus, ratio]),
            ..Material::default()
        }
    }
}

impl Sides {
    /// Sides of elements as a surface, `(element, side)`.
    pub fn new(name: &str, faces: &[(usize, Side)]) -> Sides {
        Sides { name: name.into(), surface: true, faces: faces.to_vec(), whole: Vec::new() }
    }
}

impl Step {
    /// A step of some length in time, with the increment that the mesh calls for and nothing in force.
    #[track_caller]
    pub fn new(name: &str, duration: f64) -> Step {
        Step {
            name: name.into(),
            span: Span::composed(),
            duration,
            increment: IncrementControl::default(),
            scale_factor: 1.0,
            load_velocity: LoadVelocity::Predicted,
            bulk_viscosity: BULK_VISCOSITY,
            adiabatic: false,
            coupled: false,
            boundaries: Vec::new(),
            loads: Vec::new(),
            fields: Vec::new(),
            surface_contacts: Vec::new(),
            general_contact: None,
            mass_scalings: Vec::new(),
            energy_limit: None,
            outputs: Vec::new(),
            restart: None,
        }
    }

    /// With a prescribed motion.
    #[must_use]
    pub fn with_boundary(mut self, boundary: Boundary) -> Step {
        self.boundaries.push(boundary);
        self
    }

    /// With a load.
    #[must_use]
    pub fn with_load(mut self, load: Load) -> Step {
        self.loads.push(load);
        self
    }

    /// With an output request.
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

impl Boundary {
    /// Holds nodes along a degree of freedom (1 = r, 2 = z).
    #[track_caller]
    pub fn held(name: &str, nodes: &[usize], dof: u8) -> Boundary {
        Boundary::moved(name, nodes, dof, Motion::Displacement, 0.0)
    }

    /// Moves nodes along a degree of freedom. A displacement needs an [`Boundary::amplitude`]: none jumps.
    #[track_caller]
    pub fn moved(name: &str, nodes: &[usize], dof: u8, kind: Motion, value: f64) -> Boundary {
        let (set, nodes, span) = (name.into(), nodes.to_vec(), Span::composed());
        Boundary { nodes, set, dof, kind, user: false, value, amplitude: None, span }
    }
}

impl Load {
    /// A load of a kind with a magnitude that stays.
    #[track_caller]
    pub fn new(kind: LoadKind, magnitude: f64) -> Load {
        Load { kind, magnitude, amplitude: None, span: Span::composed() }
    }

    /// A pressure, positive towards the surface.
    #[track_caller]
    pub fn pressure(sides: Sides, magnitude: f64) -> Load {
        Load::new(LoadKind::Pressure(sides), magnitude)
    }

    /// The pressure of a user load ([`crate::user::Routines::with_load`]).
    #[track_caller]
    pub fn user(sides: Sides) -> Load {
        Load::new(LoadKind::User { sides, load_type: 0 }, 1.0)
    }

    /// The same with an amplitude.
    #[must_use]
    pub fn with_amplitude(mut self, amplitude: AmplitudeId) -> Load {
        self.amplitude = Some(amplitude);
        self
    }
}

impl OutputRequest {
    /// History columns of variables, `<VARIABLE>@<SET>`, at the program's default interval.
    #[track_caller]
    pub fn history<A: Into<VariableRequest>>(region: Region, variables: impl IntoIterator<Item = A>) -> OutputRequest {
        OutputRequest::new(OutputKind::History, region, variables.into_iter().map(Into::into).collect())
    }

    /// Arrays of frames, at the program's default interval.
    #[track_caller]
    pub fn field<A: Into<VariableRequest>>(variables: impl IntoIterator<Item = A>) -> OutputRequest {
        OutputRequest::new(OutputKind::Field, Region::Whole, variables.into_iter().map(Into::into).collect())
    }

    #[track_caller]
    fn new(kind: OutputKind, region: Region, variables: Vec<VariableRequest>) -> OutputRequest {
        let card = match region {
            Region::Whole => OutputCard::Output,
            Region::Nodes(_) => OutputCard::Node,
            Region::Elements(_) => OutputCard::Element,
            Region::Surface(..) => OutputCard::Integrated,
            Region::Pairs(_) => OutputCard::Contact,
        };
        let (interval, position, span) = (Interval::Default, Position::Element, Span::composed());
        OutputRequest { kind, interval, card, variables, position, region, statistics: Vec::new(), sensor: None, span }
    }

    /// The same with statistics over the set in place of a column for each member.
    #[must_use]
    pub fn with_statistics(mut self, statistics: &[Statistic]) -> OutputRequest {
        self.statistics = statistics.to_vec();
        self
    }

    /// The same as often as told.
    #[must_use]
    pub fn every(mut self, interval: Interval) -> OutputRequest {
        self.interval = interval;
        self
    }
}

impl OutputExpression {
    /// A history column of that name, by an expression over others (`-1000*(U2@TOP - U2@FOOT)`).
    #[track_caller]
    pub fn new(name: &str, text: &str) -> OutputExpression {
        let span = Span::composed();
        OutputExpression { name: name.to_uppercase(), text: text.to_owned(), span, place: span }
    }
}

impl From<Variable> for VariableRequest {
    fn from(variable: Variable) -> VariableRequest {
        VariableRequest::Whole(variable)
    }
}

impl From<Part> for VariableRequest {
    fn from(part: Part) -> VariableRequest {
        VariableRequest::One(part)
    }
}
