//! Output requests as history columns, frame variables and schedules.
//! Never here: files.

use super::Compiler;
use crate::deck::{Diagnostic, Span};
use crate::element::body::Solid;
use crate::element::group::Group;
use crate::model::{Interval, OutputKind, OutputRequest, Region, Step};

/// What a history column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement of a body along z.
    Displacement(usize),
    /// Velocity along z.
    Velocity(usize),
    /// Acceleration along z.
    Acceleration(usize),
    /// Force needed for a prescribed motion along z.
    Reaction(usize),
    /// Current z of a node: its first coordinate and its body.
    Coordinate(usize, usize),
    /// Displacement of a deformable node along r (0) or z (1).
    NodeDisplacement(usize, usize),
    /// Velocity.
    NodeVelocity(usize, usize),
    /// Acceleration.
    NodeAcceleration(usize, usize),
    /// Force of what is prescribed there.
    NodeReaction(usize, usize),
    /// Current coordinate.
    NodeCoordinate(usize, usize),
    /// A number of an element: group, element of the group, what.
    Element(usize, usize, ElementVariable),
    /// `ALLIE`.
    Internal,
    /// `ALLSE`.
    Strain,
    /// `ALLPD`.
    Plastic,
    /// `ALLVD`.
    Viscous,
    /// `ALLCW`.
    Contact,
    /// `ALLAE`.
    Artificial,
    /// `ALLDC`.
    Distortion,
    /// Something that axial symmetry keeps at zero (`U1` of a rigid body).
    Zero,
    /// `ALLKE`.
    Kinetic,
    /// `ALLWK`.
    Work,
    /// `ALLFD`.
    Friction,
    /// `ALLCAV`.
    Cavity,
    /// `ETOTAL`.
    Total,
    /// `DT`.
    Increment,
}

/// A number of a deformable element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementVariable {
    /// A stress component: 0 rr (`S11`), 1 zz (`S22`), 2 hoop (`S33`), 3 rz (`S12`).
    Stress(usize),
    /// Von Mises stress.
    Mises,
    /// Pressure, positive in compression.
    Pressure,
    /// Equivalent plastic strain.
    PlasticStrain,
    /// Temperature.
    Temperature,
    /// A component of the logarithmic strain, in the order of stresses; shear is the engineering one (`LE12`).
    LogarithmicStrain(usize),
    /// A component of the plastic strain, likewise.
    PlasticComponent(usize),
    /// A component of the strain rate, likewise.
    StrainRate(usize),
    /// Recoverable strain energy a volume (`SENER`).
    StrainEnergy,
    /// Plastic dissipation a volume (`PENER`).
    PlasticEnergy,
    /// 1 where the element is there, 0 where it is deleted.
    Status,
    /// Volume.
    Volume,
    /// Mass a volume.
    Density,
    /// A variable that the user's material keeps, counted from 0 (`SDV1`).
    State(usize),
}

impl ElementVariable {
    /// Whether an element of a group has it. Nothing that is elastic has a plastic strain, and of a user's material only the
    /// routine would know one.
    pub fn is_of(self, group: &dyn Group, element: usize) -> bool {
        match self {
            ElementVariable::PlasticStrain | ElementVariable::PlasticComponent(_) => {
                group.plastic_strain(element).is_some()
            }
            ElementVariable::Temperature => group.temperature(element).is_some(),
            ElementVariable::State(i) => group.state_variable(element, i).is_some(),
            _ => true,
        }
    }

    /// Whether elements follow it only if an output asks.
    fn is_followed(self) -> bool {
        use ElementVariable::{LogarithmicStrain, PlasticComponent, PlasticEnergy, StrainEnergy, StrainRate};
        matches!(self, LogarithmicStrain(_) | PlasticComponent(_) | StrainRate(_) | StrainEnergy | PlasticEnergy)
    }
}

/// One history column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// `<VARIABLE>@<SET or node>`, or the variable alone for the whole model.
    pub name: String,
    /// What it holds.
    pub quantity: Quantity,
}

/// A variable on the nodes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldVariable {
    /// `U`.
    Displacement,
    /// `V`.
    Velocity,
    /// `A`.
    Acceleration,
    /// `S`, on elements.
    Stress,
    /// `MISES`.
    Mises,
    /// `PRESS`.
    Pressure,
    /// `PEEQ`.
    PlasticStrain,
    /// `TEMP`.
    Temperature,
    /// `RF`, on nodes.
    Reaction,
    /// `LE`.
    LogarithmicStrain,
    /// `PE`.
    PlasticComponents,
    /// `ER`.
    StrainRate,
    /// `SENER`.
    StrainEnergy,
    /// `PENER`.
    PlasticEnergy,
    /// `STATUS`.
    Status,
    /// `EVOL`.
    Volume,
    /// `DENSITY`.
    Density,
    /// `SDV1` and so on, counted from 0.
    State(usize),
}

impl FieldVariable {
    /// What it shows of elements, one entry a component; empty for a variable of nodes.
    pub fn parts(self) -> Vec<ElementVariable> {
        use ElementVariable as E;
        let four = |part: fn(usize) -> E| [0, 1, 2, 3].map(part).to_vec();
        match self {
            FieldVariable::Displacement
            | FieldVariable::Velocity
            | FieldVariable::Acceleration
            | FieldVariable::Reaction => Vec::new(),
            FieldVariable::Stress => four(E::Stress),
            FieldVariable::LogarithmicStrain => four(E::LogarithmicStrain),
            FieldVariable::PlasticComponents => four(E::PlasticComponent),
            FieldVariable::StrainRate => four(E::StrainRate),
            FieldVariable::Mises => vec![E::Mises],
            FieldVariable::Pressure => vec![E::Pressure],
            FieldVariable::PlasticStrain => vec![E::PlasticStrain],
            FieldVariable::Temperature => vec![E::Temperature],
            FieldVariable::StrainEnergy => vec![E::StrainEnergy],
            FieldVariable::PlasticEnergy => vec![E::PlasticEnergy],
            FieldVariable::Status => vec![E::Status],
            FieldVariable::Volume => vec![E::Volume],
            FieldVariable::Density => vec![E::Density],
            FieldVariable::State(i) => vec![E::State(i)],
        }
    }

    /// Its name in frames.
    pub fn name(self) -> String {
        let known = FIELDS.iter().chain(&ELEMENT_FIELDS).chain(&[REACTION]).find(|f| f.1 == self);
        match (self, known) {
            (FieldVariable::State(i), _) => format!("SDV{}", i + 1),
            (_, Some(known)) => known.0.into(),
            (_, None) => String::new(),
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Schedule {
    /// Every so much time.
    Time(f64),
    /// Every so many increments.
    Increments(u64),
}

impl Schedule {
    fn new(interval: Interval, duration: f64, default: u32) -> Schedule {
        match interval {
            Interval::Time(dt) => Schedule::Time(dt),
            Interval::Number(n) => Schedule::Time(duration / f64::from(n.max(1))),
            Interval::Increments(n) => Schedule::Increments(u64::from(n.max(1))),
            Interval::Default => Schedule::Time(duration / f64::from(default)),
        }
    }
}

/// Energies that exist only where something deforms.
const SOLID_ENERGIES: [(&str, Quantity); 7] = [
    ("ALLIE", Quantity::Internal),
    ("ALLSE", Quantity::Strain),
    ("ALLPD", Quantity::Plastic),
    ("ALLVD", Quantity::Viscous),
    ("ALLAE", Quantity::Artificial),
    ("ALLCW", Quantity::Contact),
    ("ALLDC", Quantity::Distortion),
];

const ENERGIES: [(&str, Quantity); 5] = [
    ("ALLKE", Quantity::Kinetic),
    ("ALLWK", Quantity::Work),
    ("ALLFD", Quantity::Friction),
    ("ALLCAV", Quantity::Cavity),
    ("ETOTAL", Quantity::Total),
];

const FIELDS: [(&str, FieldVariable); 3] =
    [("U", FieldVariable::Displacement), ("V", FieldVariable::Velocity), ("A", FieldVariable::Acceleration)];

/// Variables on elements of what deforms.
const ELEMENT_FIELDS: [(&str, FieldVariable); 13] = [
    ("S", FieldVariable::Stress),
    ("MISES", FieldVariable::Mises),
    ("PRESS", FieldVariable::Pressure),
    ("PEEQ", FieldVariable::PlasticStrain),
    ("TEMP", FieldVariable::Temperature),
    ("LE", FieldVariable::LogarithmicStrain),
    ("PE", FieldVariable::PlasticComponents),
    ("ER", FieldVariable::StrainRate),
    ("SENER", FieldVariable::StrainEnergy),
    ("PENER", FieldVariable::PlasticEnergy),
    ("STATUS", FieldVariable::Status),
    ("EVOL", FieldVariable::Volume),
    ("DENSITY", FieldVariable::Density),
];

/// On nodes of what deforms.
const REACTION: (&str, FieldVariable) = ("RF", FieldVariable::Reaction);

/// Variables of the facets that every frame of a loaded surface shows.
const FACET_VARIABLES: [&str; 4] = ["P", "PRESSURE", "NORMAL_VELOCITY", "LAYER"];

impl Compiler<'_> {
    /// Columns and frame variables of all steps together: a file keeps its columns from step to step.
    pub(super) fn variables(&mut self, solid: Option<&mut Solid>) -> (Vec<Column>, Vec<FieldVariable>) {
        let (mut columns, mut fields) = (Vec::new(), Vec::new());
        let model = self.model;
        for step in &model.steps {
            for request in &step.outputs {
                match request.kind {
                    OutputKind::History => self.history_columns(request, solid.as_deref(), &mut columns),
                    OutputKind::Field => self.field_variables(request, solid.as_deref(), &mut fields),
                }
            }
            if step.outputs.is_empty() {
                columns.extend(self.energies().map(energy_column));
                fields.extend(self.preselected_fields());
            }
        }
        fields.retain(|f| is_anywhere(*f, solid.as_deref()));
        dedup(&mut columns);
        dedup(&mut fields);
        let shown = fields.iter().flat_map(|f| f.parts());
        let told = columns.iter().filter_map(|c| match c.quantity {
            Quantity::Element(_, _, variable) => Some(variable),
            _ => None,
        });
        if let Some(solid) = solid.filter(|_| shown.chain(told).any(ElementVariable::is_followed)) {
            solid.groups.iter_mut().for_each(|g| g.follow());
            self.followed_row(solid);
        }
        (columns, fields)
    }

    /// The row of strains and energies that elements follow because an output asks for them.
    fn followed_row(&mut self, solid: &Solid) {
        let count = solid.groups.iter().map(|g| g.len()).sum();
        let asks = |r: &&OutputRequest| r.variables.iter().any(|v| v == "PRESELECT" || is_followed(v));
        let request = self.model.steps.iter().flat_map(|s| &s.outputs).find(asks);
        let Some(span) = request.map(|r| r.span).or_else(|| self.model.steps.first().map(|s| s.span)) else { return };
        self.cause(span, "strain history", count, "elements", "LE, PE, ER, SENER, PENER".into());
    }

    /// When this step writes; without any request what ABAQUS preselects.
    pub(super) fn outputs(&mut self, step: &Step) -> Outputs {
        let mut outputs = Outputs::default();
        for request in &step.outputs {
            match request.kind {
                OutputKind::Field => outputs.field.push(Schedule::new(request.interval, step.duration, 20)),
                OutputKind::History => outputs.history.push(Schedule::new(request.interval, step.duration, 200)),
            }
        }
        if step.outputs.is_empty() {
            outputs.field.push(Schedule::new(Interval::Default, step.duration, 20));
            outputs.history.push(Schedule::new(Interval::Default, step.duration, 200));
        }
        outputs.restart.extend(step.restart.map(|r| Schedule::new(r.interval, step.duration, 1)));
        if let Some(restart) = step.restart {
            let detail = format!("{:?}, written as <job>.checkpoint", outputs.restart[0]);
            self.cause(restart.span, "checkpoint", 1, "step", detail);
            if self.routines.any() {
                let message = "what the user's routines keep to themselves (SAVE, COMMON, open files) is not kept";
                self.diagnostics.push(Diagnostic::note("K102", message).at(restart.span, "asked here"));
            }
        }
        outputs.field.dedup();
        outputs.history.dedup();
        outputs
    }

    fn history_columns(&mut self, request: &OutputRequest, solid: Option<&Solid>, columns: &mut Vec<Column>) {
        let first = columns.len();
        for variable in &request.variables {
            match &request.region {
                Region::Elements(set) => self.element_columns(variable, (set, request.span), solid, columns),
                Region::Nodes(set) => self.node_columns(variable, set, request.span, columns),
                _ => self.model_columns(variable, request.span, columns),
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

    fn model_columns(&mut self, variable: &str, span: Span, columns: &mut Vec<Column>) {
        match variable {
            "PRESELECT" | "ALL" => columns.extend(self.energies().map(energy_column)),
            "DT" => columns.push(Column { name: "DT".into(), quantity: Quantity::Increment }),
            name => match self.energies().find(|e| e.0 == name) {
                Some(energy) => columns.push(energy_column(energy)),
                None => self.absent(variable, span),
            },
        }
    }

    fn node_columns(&mut self, variable: &str, set: &str, span: Span, columns: &mut Vec<Column>) {
        let model = self.model;
        let Some(members) = model.node_sets.get(set).map(|s| &s.members) else { return };
        let before = columns.len();
        for &node in members {
            let solid = self.places.free_node(node);
            let body = self.body_of_node.get(&node);
            let place = if members.len() == 1 { set.to_owned() } else { model.mesh.node_names[node].clone() };
            let quantities = match (solid, body) {
                (Some(node), _) => solid_quantities(variable, node),
                (_, Some(&body)) => node_quantities(variable, node, body),
                _ => Vec::new(),
            };
            columns
                .extend(quantities.into_iter().map(|(n, quantity)| Column { name: format!("{n}@{place}"), quantity }));
        }
        if columns.len() == before {
            self.absent(variable, span);
        }
    }

    fn field_variables(&mut self, request: &OutputRequest, solid: Option<&Solid>, fields: &mut Vec<FieldVariable>) {
        for variable in &request.variables {
            match variable.as_str() {
                "PRESELECT" => fields.extend(self.preselected_fields()),
                "ALL" => fields.extend(self.fields_there_are().iter().map(|f| f.1)),
                "ENER" if self.deforms() => fields.extend([FieldVariable::StrainEnergy, FieldVariable::PlasticEnergy]),
                "SDV" if self.state_variables() > 0 => {
                    fields.extend((0..self.state_variables()).map(FieldVariable::State));
                }
                name if FACET_VARIABLES.contains(&name) => {}
                name => match self.fields_there_are().into_iter().find(|f| f.0 == name) {
                    Some(field) if is_anywhere(field.1, solid) => fields.push(field.1),
                    _ => self.absent(variable, request.span),
                },
            }
        }
        let detail = request.variables.join(" ");
        self.cause(request.span, "field output", request.variables.len(), "variables", detail);
    }

    fn element_columns(
        &mut self,
        variable: &str,
        (set, span): (&str, Span),
        solid: Option<&Solid>,
        columns: &mut Vec<Column>,
    ) {
        let model = self.model;
        let Some(members) = model.element_sets.get(set).map(|s| &s.members) else { return };
        let before = columns.len();
        for &element in members {
            let Some(&(group, index)) = self.places.elements.get(&element) else { continue };
            let place = if members.len() == 1 { set.to_owned() } else { model.mesh.elements[element].name.clone() };
            for (name, variable) in self.element_quantities(variable) {
                if solid.is_some_and(|s| !variable.is_of(&*s.groups[group], index)) {
                    continue;
                }
                let quantity = Quantity::Element(group, index, variable);
                columns.push(Column { name: format!("{name}@{place}"), quantity });
            }
        }
        if columns.len() == before {
            self.absent(variable, span);
        }
    }

    fn deforms(&self) -> bool {
        !self.places.elements.is_empty()
    }

    /// Energies that this scene has.
    fn energies(&self) -> impl Iterator<Item = (&'static str, Quantity)> + use<> {
        let solid = if self.deforms() { &SOLID_ENERGIES[..] } else { &[] };
        ENERGIES[..4].iter().chain(solid).chain(&ENERGIES[4..]).copied()
    }

    fn fields_there_are(&self) -> Vec<(String, FieldVariable)> {
        let named = |f: &(&str, FieldVariable)| (f.0.to_owned(), f.1);
        let mut fields: Vec<_> = FIELDS.iter().map(named).collect();
        if self.deforms() {
            fields.extend([REACTION].iter().chain(&ELEMENT_FIELDS).map(named));
            fields.extend((0..self.state_variables()).map(|i| (format!("SDV{}", i + 1), FieldVariable::State(i))));
        }
        fields
    }

    /// ABAQUS/Explicit preselects U, V, A, and of what deforms RF, S, LE, PE and PEEQ, and STATUS where elements can be
    /// deleted; invariants of the stress, which its viewer computes, come along.
    fn preselected_fields(&self) -> Vec<FieldVariable> {
        use FieldVariable::{Density, PlasticEnergy, State, Status, StrainEnergy, StrainRate, Temperature, Volume};
        let deletes = self.deletes();
        let meant = |f: &FieldVariable| match f {
            Density | PlasticEnergy | State(_) | StrainEnergy | StrainRate | Temperature | Volume => false,
            Status => deletes,
            _ => true,
        };
        self.fields_there_are().into_iter().map(|f| f.1).filter(meant).collect()
    }

    /// The columns an element variable stands for.
    fn element_quantities(&self, variable: &str) -> Vec<(String, ElementVariable)> {
        let groups = ["ENER", "SDV"];
        let mut columns = Vec::new();
        for (name, field) in self.fields_there_are() {
            let parts = field.parts();
            let stem = name == variable || groups.contains(&variable) && family(field) == variable;
            for (i, &part) in parts.iter().enumerate() {
                let column = if parts.len() == 4 { format!("{name}{}", COMPONENTS[i]) } else { name.clone() };
                if stem || column == variable {
                    columns.push((column, part));
                }
            }
        }
        columns
    }

    fn absent(&mut self, variable: &str, span: Span) {
        let why = format!("output variable {variable} has no value in this scene");
        self.unused(span, variable, why);
    }
}

/// Whether a variable of nodes, or one that some element has: of those that do not, frames hold NaN.
fn is_anywhere(field: FieldVariable, solid: Option<&Solid>) -> bool {
    let (parts, groups) = (field.parts(), solid.map_or(&[][..], |s| &s.groups));
    let of = |part: &ElementVariable| groups.iter().any(|g| (0..g.len()).any(|e| part.is_of(&**g, e)));
    parts.is_empty() || solid.is_none() || parts.iter().any(of)
}

fn energy_column((name, quantity): (&str, Quantity)) -> Column {
    Column { name: name.into(), quantity }
}

/// The columns a node variable stands for on a node of a rigid body.
fn node_quantities(variable: &str, node: usize, body: usize) -> Vec<(&'static str, Quantity)> {
    use Quantity::{Acceleration, Coordinate, Displacement, Reaction, Velocity, Zero};
    match variable {
        "U" => vec![("U1", Zero), ("U2", Displacement(body))],
        "V" => vec![("V1", Zero), ("V2", Velocity(body))],
        "A" => vec![("A1", Zero), ("A2", Acceleration(body))],
        "RF" => vec![("RF1", Zero), ("RF2", Reaction(body))],
        "U1" => vec![("U1", Zero)],
        "V1" => vec![("V1", Zero)],
        "A1" => vec![("A1", Zero)],
        "RF1" => vec![("RF1", Zero)],
        "U2" => vec![("U2", Displacement(body))],
        "V2" => vec![("V2", Velocity(body))],
        "A2" => vec![("A2", Acceleration(body))],
        "RF2" => vec![("RF2", Reaction(body))],
        "COORD" | "COOR2" => vec![("COOR2", Coordinate(node, body))],
        _ => Vec::new(),
    }
}

/// The columns a node variable stands for on a deformable node.
fn solid_quantities(variable: &str, node: usize) -> Vec<(&'static str, Quantity)> {
    use Quantity::{NodeAcceleration, NodeCoordinate, NodeDisplacement, NodeReaction, NodeVelocity};
    let all: [(&'static str, &str, Quantity); 10] = [
        ("U1", "U", NodeDisplacement(node, 0)),
        ("U2", "U", NodeDisplacement(node, 1)),
        ("V1", "V", NodeVelocity(node, 0)),
        ("V2", "V", NodeVelocity(node, 1)),
        ("A1", "A", NodeAcceleration(node, 0)),
        ("A2", "A", NodeAcceleration(node, 1)),
        ("RF1", "RF", NodeReaction(node, 0)),
        ("RF2", "RF", NodeReaction(node, 1)),
        ("COOR1", "COORD", NodeCoordinate(node, 0)),
        ("COOR2", "COORD", NodeCoordinate(node, 1)),
    ];
    let meant = |(name, stem, _): &(&'static str, &str, Quantity)| variable == *name || variable == *stem;
    all.into_iter().filter(meant).map(|(name, _, quantity)| (name, quantity)).collect()
}

/// Numbers of the components of a symmetric tensor, in the order rr, zz, hoop, rz.
pub const COMPONENTS: [&str; 4] = ["11", "22", "33", "12"];

/// Variables that one name stands for together.
fn family(field: FieldVariable) -> &'static str {
    match field {
        FieldVariable::StrainEnergy | FieldVariable::PlasticEnergy => "ENER",
        FieldVariable::State(_) => "SDV",
        _ => "",
    }
}

/// Whether an output variable needs what elements follow only if asked.
fn is_followed(variable: &str) -> bool {
    let stem = variable.trim_end_matches(|c: char| c.is_ascii_digit());
    ["LE", "PE", "ER", "ENER", "SENER", "PENER", "ALL"].contains(&stem)
}

fn dedup<T: PartialEq + Clone>(items: &mut Vec<T>) {
    let mut kept: Vec<T> = Vec::new();
    for item in items.drain(..) {
        if !kept.contains(&item) {
            kept.push(item);
        }
    }
    *items = kept;
}
