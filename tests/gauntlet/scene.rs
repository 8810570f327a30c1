//! Runs of the decks in `input/gauntlet/` in memory, and access to their results.

use revolve::internals::quad;
use revolve::job::{self, PreparedJob};
use revolve::solve::{self, Outcome};
use revolve::user::Routines;

use crate::common::{self, RecordedOutput};

pub struct GauntletRun {
    pub prepared: PreparedJob,
    pub outcome: Outcome,
    pub memory: RecordedOutput,
}

/// Runs a deck of `input/gauntlet/` with `--set` pairs.
pub fn deck(name: &str, settings: &[(&str, &str)]) -> GauntletRun {
    with(name, settings, &Routines::none())
}

/// Runs a deck of `input/gauntlet/` with user subroutines.
pub fn with(name: &str, settings: &[(&str, &str)], routines: &Routines) -> GauntletRun {
    let path = common::project("input/gauntlet").join(name);
    run(job::prepare(&path, &common::pairs(settings), routines))
}

/// Runs a deck text.
pub fn text(text: &str, routines: &Routines) -> GauntletRun {
    run(job::prepare_text("gauntlet.inp", text, &[], routines))
}

fn run(prepared: PreparedJob) -> GauntletRun {
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    let mut memory = RecordedOutput::default();
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    for warning in &outcome.warnings {
        let code = warning.split(':').next().unwrap_or_default();
        assert!(revolve::explain::codes().any(|known| known.code == code), "warning without a known code: {warning}");
    }
    GauntletRun { prepared, outcome, memory }
}

/// Returns the text of a deck of `input/gauntlet/`.
pub fn read(name: &str) -> String {
    std::fs::read_to_string(common::project("input/gauntlet").join(name)).expect("a deck")
}

impl GauntletRun {
    /// Returns whether the run was completed with an energy drift below this.
    pub fn completed(&self, drift: f64) -> bool {
        println!("drift {:.2e}", self.outcome.energy.drift);
        if let Some(halt) = &self.outcome.halt {
            println!("halted: {halt:?}");
        }
        self.outcome.halt.is_none() && self.outcome.energy.drift < drift
    }

    /// Returns time and value of each row of a history column.
    pub fn column(&self, name: &str) -> Vec<(f64, f64)> {
        let at = self.prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
        self.memory.rows.iter().map(|row| (row.0, row.1[at])).collect()
    }

    /// Returns the last value of a history column.
    pub fn last(&self, name: &str) -> f64 {
        self.column(name).last().expect("a row").1
    }

    /// Returns a nodal or element field of the last frame.
    pub fn field(&self, name: &str) -> Vec<f64> {
        let frame = self.memory.frames.last().expect("a frame");
        let all = frame.point_fields.iter().chain(&frame.cell_fields);
        all.into_iter().find(|f| f.name == name).expect("a field").values.clone()
    }

    /// Returns a field `[r, z]` of the last frame by solver node.
    pub fn at_nodes(&self, name: &str) -> Vec<[f64; 2]> {
        common::at_nodes(&self.prepared, &self.field(name))
    }

    /// Returns the coordinates of the nodes in the last frame.
    pub fn places(&self) -> Vec<[f64; 2]> {
        let start = &self.prepared.state.dofs.nodes.start;
        start.iter().zip(self.at_nodes("U")).map(|(s, u)| [s[0] + u[0], s[1] + u[1]]).collect()
    }

    /// Returns the solver node of a label.
    pub fn node(&self, label: usize) -> usize {
        let names = &self.prepared.plan.mesh.node_names;
        let at = names.iter().position(|n| *n == label.to_string()).expect("a node");
        self.prepared.plan.places.nodes[&at]
    }

    /// Returns the elements of all groups in the last frame: centre, density relative to the start, mean stress.
    pub fn cells(&self) -> Vec<ElementValues> {
        let start = &self.prepared.state.dofs.nodes.start;
        let (places, stress) = (self.places(), self.field("S"));
        let mut cells = Vec::new();
        for group in &self.prepared.state.elements.groups {
            for cell in (0..group.len()).flat_map(|e| group.cells(e)) {
                let corners = cell.map(|n| n as usize);
                let now = corners.map(|n| places[n]);
                let ratio = quad::volume(corners.map(|n| start[n])) / quad::volume(now);
                let s = &stress[4 * cells.len()..4 * cells.len() + 4];
                let place = [0, 1].map(|axis| now.iter().map(|c| c[axis]).sum::<f64>() / 4.0);
                cells.push(ElementValues { place, density: ratio, mean: (s[0] + s[1] + s[2]) / 3.0, axial: s[1] });
            }
        }
        cells
    }
}

pub struct ElementValues {
    pub place: [f64; 2],
    pub density: f64,
    pub mean: f64,
    pub axial: f64,
}

/// Returns the mean, and the largest relative deviation from it.
pub fn spread(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    assert!(!values.is_empty(), "no values");
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|v| (v / mean - 1.0).abs()).fold(0.0, f64::max))
}

/// Returns the relative error of a value.
pub fn off(value: f64, exact: f64) -> f64 {
    (value / exact - 1.0).abs()
}
