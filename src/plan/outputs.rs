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

const ENERGIES: [(&str, Quantity); 5] = [
    ("ALLKE", Quantity::Kinetic),
    ("ALLWK", Quantity::Work),
    ("ALLFD", Quantity::Friction),
    ("ALLCAV", Quantity::Cavity),
    ("ETOTAL", Quantity::Total),
];

const FIELDS: [(&str, FieldVariable); 3] =
    [("U", FieldVariable::Displacement), ("V", FieldVariable::Velocity), ("A", FieldVariable::Acceleration)];

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
                columns.extend(ENERGIES.map(energy_column));
                fields.extend(FIELDS.map(|f| f.1));
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
            "PRESELECT" | "ALL" => columns.extend(ENERGIES.map(energy_column)),
            "DT" => columns.push(Column { name: "DT".into(), quantity: Quantity::Increment }),
            name => match ENERGIES.iter().find(|e| e.0 == name) {
                Some(&energy) => columns.push(energy_column(energy)),
                None => self.absent(variable, span),
            },
        }
    }

    fn node_columns(&mut self, variable: &str, set: &str, span: Span, columns: &mut Vec<Column>) {
        let model = self.model;
        let Some(members) = model.node_sets.get(set).map(|s| &s.members) else { return };
        let before = columns.len();
        for &node in members {
            let Some(&body) = self.body_of_node.get(&node) else { continue };
            let place = if members.len() == 1 { set.to_owned() } else { model.mesh.node_names[node].clone() };
            for (name, quantity) in node_quantities(variable, node, body) {
                columns.push(Column { name: format!("{name}@{place}"), quantity });
            }
        }
        if columns.len() == before {
            self.absent(variable, span);
        }
    }

    fn field_variables(&mut self, request: &OutputRequest, fields: &mut Vec<FieldVariable>) {
        for variable in &request.variables {
            match variable.as_str() {
                "PRESELECT" | "ALL" => fields.extend(FIELDS.map(|f| f.1)),
                name if FACET_VARIABLES.contains(&name) => {}
                name => match FIELDS.iter().find(|f| f.0 == name) {
                    Some(field) => fields.push(field.1),
                    None => self.absent(variable, request.span),
                },
            }
        }
        let detail = request.variables.join(" ");
        self.cause(request.span, "field output", request.variables.len(), "variables", detail);
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

fn dedup<T: PartialEq + Clone>(items: &mut Vec<T>) {
    let mut kept: Vec<T> = Vec::new();
    for item in items.drain(..) {
        if !kept.contains(&item) {
            kept.push(item);
        }
    }
    *items = kept;
}
