//! Decks of several bodies that meet, and what they answer.

use revolve::job::PreparedJob;
use revolve::output::OutputFrame;
use revolve::plan::State;
use revolve::solve::{self, Outcome};
use revolve::user::Routines;

use super::solid::grid;
use super::{Memory, prepared};

/// A body of its own: a part that is a grid, of the material of the same name, with more cards of the part behind it.
pub fn part(name: &str, [n, m]: [usize; 2], place: impl Fn(usize, usize) -> [f64; 2], more: &str) -> String {
    let grid = grid(n, m, false, place);
    format!("*Part, name={name}\n{grid}*Solid Section, elset=SOLID, material={name}\n{more}*End Part\n")
}

/// Each part once, where it was made; cards of the assembly behind them.
pub fn assembly(names: &[&str], more: &str) -> String {
    let each = names.iter().map(|n| format!("*Instance, name={n}, part={n}\n*End Instance\n"));
    format!("*Assembly, name=ALL\n{}{more}*End Assembly\n", each.collect::<String>())
}

/// A rigid body of lines between corners, its side SPOS to the left of the way, its reference node the set REF.
pub fn rigid_line(name: &str, corners: &[[f64; 2]], more: &str) -> String {
    let mut text = format!("*Part, name={name}\n*Node, nset=REF\n 1000, 0., 0.\n*Node\n");
    for (i, [r, z]) in corners.iter().enumerate() {
        text += &format!(" {}, {r:e}, {z:e}\n", i + 1);
    }
    text += "*Element, type=RAX2, elset=E\n";
    for i in 1..corners.len() {
        text += &format!(" {i}, {i}, {}\n", i + 1);
    }
    text + &format!("*Surface, name=SKIN\n E, SPOS\n{more}*End Part\n")
}

/// An elastic material.
pub fn elastic(name: &str, [modulus, ratio, density]: [f64; 3], more: &str) -> String {
    format!("*Material, name={name}\n*Density\n {density:e},\n*Elastic\n {modulus:e}, {ratio}\n{more}")
}

/// A run and where it began.
pub struct Ran {
    pub prepared: PreparedJob,
    pub outcome: Outcome,
    pub memory: Memory,
    pub state: State,
}

/// Runs a deck to its end.
pub fn run(deck: &str) -> Ran {
    let prepared = prepared(deck, &[], &Routines::none());
    let mut memory = Memory::default();
    let (outcome, state) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    Ran { prepared, outcome, memory, state }
}

impl Ran {
    /// The same, of a run that must come to its end.
    pub fn whole(self) -> Ran {
        assert_eq!(self.outcome.halt, None, "{:?}", self.outcome.halt);
        self
    }

    /// Nodes of an instance: in the mesh and in the solver.
    pub fn nodes(&self, instance: &str) -> Vec<[usize; 2]> {
        let prefix = format!("{instance}.");
        let names = &self.prepared.plan.mesh.node_names;
        let own = self.prepared.plan.places.nodes.iter().filter(|(node, _)| names[**node].starts_with(&prefix));
        own.map(|(&node, &place)| [node, place]).collect()
    }

    /// Axial momentum of all that deforms, and of rigid bodies, at the end.
    pub fn momentum(&self) -> f64 {
        let (nodes, bodies) = (&self.state.dofs.nodes, &self.state.dofs.bodies);
        let of_nodes: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
        of_nodes + bodies.iter().map(|b| b.mass * b.velocity_half).sum::<f64>()
    }

    /// Axial momentum of an instance in a frame that shows V.
    pub fn momentum_of(&self, nodes: &[[usize; 2]], frame: &OutputFrame) -> f64 {
        let velocity = point_field(frame, "V");
        nodes.iter().map(|&[node, place]| self.state.dofs.nodes.mass[place] * velocity[2 * node + 1]).sum()
    }

    /// Values of a column over time.
    pub fn column(&self, name: &str) -> Vec<[f64; 2]> {
        let at = self.prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
        self.memory.rows.iter().map(|row| [row.0, row.1[at]]).collect()
    }

    /// The frame at the end.
    pub fn end(&self) -> &OutputFrame {
        self.memory.frames.last().expect("a frame")
    }
}

/// A field of nodes.
pub fn point_field<'a>(frame: &'a OutputFrame, name: &str) -> &'a [f64] {
    &frame.point_fields.iter().find(|f| f.name == name).expect("a field").values
}

/// A field of elements.
pub fn cell_field<'a>(frame: &'a OutputFrame, name: &str) -> &'a [f64] {
    &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values
}

/// Numbers in two figures.
pub fn short(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(" ")
}

/// Numbers between two bounds without order, the same for a seed in every run (Marsaglia 2003, J. Stat. Softw. 8(14)).
pub fn between(seed: u64) -> impl FnMut(f64, f64) -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    move |low, high| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    }
}
