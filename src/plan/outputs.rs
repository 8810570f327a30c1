//! Output requests as history columns, frame variables and schedules.
//! Never here: files.

use super::Compiler;
use crate::deck::Span;
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
}

/// When to write.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Frames.
    pub field: Vec<Schedule>,
    /// History rows.
    pub history: Vec<Schedule>,
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
const SOLID_ENERGIES: [(&str, Quantity); 6] = [
    ("ALLIE", Quantity::Internal),
    ("ALLSE", Quantity::Strain),
    ("ALLPD", Quantity::Plastic),
    ("ALLVD", Quantity::Viscous),
    ("ALLAE", Quantity::Artificial),
    ("ALLCW", Quantity::Contact),
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
const ELEMENT_FIELDS: [(&str, FieldVariable); 5] = [
    ("S", FieldVariable::Stress),
    ("MISES", FieldVariable::Mises),
    ("PRESS", FieldVariable::Pressure),
    ("PEEQ", FieldVariable::PlasticStrain),
    ("TEMP", FieldVariable::Temperature),
];

/// Variables of the facets that every frame of a loaded surface shows.
const FACET_VARIABLES: [&str; 4] = ["P", "PRESSURE", "NORMAL_VELOCITY", "LAYER"];

impl Compiler<'_> {
    /// Columns and frame variables of all steps together: a file keeps its columns from step to step.
    pub(super) fn variables(&mut self) -> (Vec<Column>, Vec<FieldVariable>) {
        let (mut columns, mut fields) = (Vec::new(), Vec::new());
        let model = self.model;
        for step in &model.steps {
            for request in &step.outputs {
                match request.kind {
                    OutputKind::History => self.history_columns(request, &mut columns),
                    OutputKind::Field => self.field_variables(request, &mut fields),
                }
            }
            if step.outputs.is_empty() {
                columns.extend(self.energies().map(energy_column));
                fields.extend(self.preselected_fields());
            }
        }
        dedup(&mut columns);
        dedup(&mut fields);
        (columns, fields)
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
        outputs.field.dedup();
        outputs.history.dedup();
        outputs
    }

    fn history_columns(&mut self, request: &OutputRequest, columns: &mut Vec<Column>) {
        let first = columns.len();
        for variable in &request.variables {
            match &request.region {
                Region::Elements(set) => self.element_columns(variable, set, request.span, columns),
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

    fn field_variables(&mut self, request: &OutputRequest, fields: &mut Vec<FieldVariable>) {
        for variable in &request.variables {
            match variable.as_str() {
                "PRESELECT" | "ALL" => fields.extend(self.preselected_fields()),
                name if FACET_VARIABLES.contains(&name) => {}
                name => match self.fields_there_are().find(|f| f.0 == name) {
                    Some(field) => fields.push(field.1),
                    None => self.absent(variable, request.span),
                },
            }
        }
        let detail = request.variables.join(" ");
        self.cause(request.span, "field output", request.variables.len(), "variables", detail);
    }

    fn element_columns(&mut self, variable: &str, set: &str, span: Span, columns: &mut Vec<Column>) {
        let model = self.model;
        let Some(members) = model.element_sets.get(set).map(|s| &s.members) else { return };
        let before = columns.len();
        for &element in members {
            let Some(&(group, index)) = self.places.elements.get(&element) else { continue };
            let place = if members.len() == 1 { set.to_owned() } else { model.mesh.elements[element].name.clone() };
            for (name, variable) in element_quantities(variable) {
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

    fn fields_there_are(&self) -> impl Iterator<Item = (&'static str, FieldVariable)> + use<> {
        let solid = if self.deforms() { &ELEMENT_FIELDS[..] } else { &[] };
        FIELDS.iter().chain(solid).copied()
    }

    /// ABAQUS/Explicit preselects U, V, A, and S and PEEQ of what deforms.
    fn preselected_fields(&self) -> impl Iterator<Item = FieldVariable> + use<> {
        self.fields_there_are().map(|f| f.1).filter(|f| *f != FieldVariable::Temperature)
    }

    fn absent(&mut self, variable: &str, span: Span) {
        let why = format!("output variable {variable} has no value in this scene");
        self.unused(span, variable, why);
    }
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

/// The columns an element variable stands for.
fn element_quantities(variable: &str) -> Vec<(&'static str, ElementVariable)> {
    use ElementVariable::{Mises, PlasticStrain, Pressure, Stress, Temperature};
    let stresses = [("S11", Stress(0)), ("S22", Stress(1)), ("S33", Stress(2)), ("S12", Stress(3))];
    match variable {
        "S" => stresses.to_vec(),
        "MISES" => vec![("MISES", Mises)],
        "PRESS" => vec![("PRESS", Pressure)],
        "PEEQ" => vec![("PEEQ", PlasticStrain)],
        "TEMP" => vec![("TEMP", Temperature)],
        name => stresses.into_iter().filter(|s| s.0 == name).collect(),
    }
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
