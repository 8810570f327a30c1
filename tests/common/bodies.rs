//! Decks of several bodies in contact, and the results of their runs.

use revolve::job::PreparedJob;
use revolve::output::OutputFrame;
use revolve::plan::State;
use revolve::solve::{self, Outcome};
use revolve::user::Routines;

use super::solid::grid;
use super::{RecordedOutput, prepared};

/// Returns a part of one body: a grid of elements with the material of the same name, followed by further cards.
pub fn part(name: &str, [n, m]: [usize; 2], place: impl Fn(usize, usize) -> [f64; 2], more: &str) -> String {
    let grid = grid(n, m, false, place);
    format!("*Part, name={name}\n{grid}*Solid Section, elset=SOLID, material={name}\n{more}*End Part\n")
}

/// Returns an assembly with one instance of each part at its original position, followed by further cards.
pub fn assembly(names: &[&str], more: &str) -> String {
    let each = names.iter().map(|n| format!("*Instance, name={n}, part={n}\n*End Instance\n"));
    format!("*Assembly, name=ALL\n{}{more}*End Assembly\n", each.collect::<String>())
}

/// Returns a part with a rigid body of line elements between corners. Its face SPOS is on the left of the direction of
/// travel; its reference node is the set REF.
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

pub fn elastic(name: &str, [modulus, ratio, density]: [f64; 3], more: &str) -> String {
    format!("*Material, name={name}\n*Density\n {density:e},\n*Elastic\n {modulus:e}, {ratio}\n{more}")
}

/// A finished run with its initial state.
pub struct DeckRun {
    pub prepared: PreparedJob,
    pub outcome: Outcome,
    pub memory: RecordedOutput,
    pub state: State,
}

/// Runs a deck to its end.
pub fn run(deck: &str) -> DeckRun {
    run_with(deck, &Routines::none())
}

/// Runs a deck with user subroutines to its end.
pub fn run_with(deck: &str, routines: &Routines) -> DeckRun {
    let prepared = prepared(deck, &[], routines);
    let mut memory = RecordedOutput::default();
    let (outcome, state) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    DeckRun { prepared, outcome, memory, state }
}

impl DeckRun {
    /// Returns the run after asserting that it was completed.
    pub fn whole(self) -> DeckRun {
        assert_eq!(self.outcome.halt, None, "{:?}", self.outcome.halt);
        self
    }

    /// Returns the nodes of an instance as pairs of mesh index and solver index.
    pub fn nodes(&self, instance: &str) -> Vec<[usize; 2]> {
        let prefix = format!("{instance}.");
        let names = &self.prepared.plan.mesh.node_names;
        let own = self.prepared.plan.places.nodes.iter().filter(|(node, _)| names[*node].starts_with(&prefix));
        own.map(|(node, &place)| [node, place]).collect()
    }

    /// Returns the final axial momentum of all deformable and rigid bodies.
    pub fn momentum(&self) -> f64 {
        let (nodes, bodies) = (&self.state.dofs.nodes, &self.state.dofs.bodies);
        let of_nodes: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
        of_nodes + bodies.iter().map(|b| b.mass * b.velocity_half).sum::<f64>()
    }

    /// Returns the axial momentum of an instance in a frame with the field V.
    pub fn momentum_of(&self, nodes: &[[usize; 2]], frame: &OutputFrame) -> f64 {
        let velocity = point_field(frame, "V");
        nodes.iter().map(|&[node, place]| self.state.dofs.nodes.mass[place] * velocity[2 * node + 1]).sum()
    }

    /// Returns time and value of each row of a column.
    pub fn column(&self, name: &str) -> Vec<[f64; 2]> {
        let at = self.prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
        self.memory.rows.iter().map(|row| [row.0, row.1[at]]).collect()
    }

    /// Returns the last frame.
    pub fn end(&self) -> &OutputFrame {
        self.memory.frames.last().expect("a frame")
    }
}

/// Returns the values of a nodal field.
pub fn point_field<'a>(frame: &'a OutputFrame, name: &str) -> &'a [f64] {
    &frame.point_fields.iter().find(|f| f.name == name).expect("a field").values
}

/// Returns the values of an element field.
pub fn cell_field<'a>(frame: &'a OutputFrame, name: &str) -> &'a [f64] {
    &frame.cell_fields.iter().find(|f| f.name == name).expect("a field").values
}

/// Formats numbers with two significant digits.
pub fn short(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.1e}")).collect::<Vec<_>>().join(" ")
}

/// Returns a generator of uniform random numbers between two bounds; a seed gives the same sequence in every run
/// (Marsaglia 2003, J. Stat. Softw. 8(14)).
pub fn between(seed: u64) -> impl FnMut(f64, f64) -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    move |low, high| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// External pressure on the ring of [`ring_on_shaft`].
pub const PRESSURE: f64 = 1e-4;
/// Pressure on the shaft over the external pressure, for a ring in plane stress with b = 2 a: 2 b^2/(a^2 + b^2 + nu
/// (b^2 - a^2)).
pub const LAME: f64 = 8.0 / 5.9;
/// Duration of the pressure ramp.
pub const RAMP: f64 = 60.0;
/// Deceleration of the ring for a friction coefficient of 1: it has a mass of 3 pi and a contact area of 2 pi.
pub const PER_COEFFICIENT: f64 = LAME * PRESSURE * 2.0 / 3.0;

/// Returns a straight rigid line of `facets` facets.
pub fn straight_line(name: &str, from: [f64; 2], to: [f64; 2], facets: usize) -> String {
    let part = |i: usize| i as f64 / facets as f64;
    let corners: Vec<_> = (0..=facets).map(|i| [0, 1].map(|k| from[k] + part(i) * (to[k] - from[k]))).collect();
    rigid_line(name, &corners, "")
}

pub fn rigid_body(name: &str) -> String {
    format!("*Rigid Body, ref node={name}.REF, elset={name}.E\n")
}

/// Returns the deck of a ring from radius 1 to 2 and of length 1, pressed on a rigid shaft by an external pressure, with an
/// initial axial velocity. `friction` are the cards of the interaction.
pub fn ring_on_shaft(cells: usize, friction: &str, speed: f64, time: f64) -> String {
    part("RING", [cells; 2], |i, j| [1.0 + i as f64 / cells as f64, j as f64 / cells as f64], "")
        + &straight_line("SHAFT", [1.0, 3.0], [1.0, -1.0], 4 * cells)
        + &assembly(&["RING", "SHAFT"], &rigid_body("SHAFT"))
        + &elastic("RING", [1.0, 0.3, 1.0], "")
        + &format!(
            "*Surface Interaction, name=DRY\n{friction}*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., {RAMP}, 1.\n"
        )
        + &format!(
            "*Initial Conditions, type=VELOCITY\n RING.ALL, 2, {speed:e}\n*Step\n*Dynamic, Explicit\n , {time}\n"
        )
        + &format!("*Boundary\n SHAFT.REF, 2, 2\n*Dsload, amplitude=RAMP\n RING.I1, P, {PRESSURE:e}\n")
        + "*Contact Pair, interaction=DRY\n RING.I0, SHAFT.SKIN\n*Output, field, number interval=100\n*Node Output\n V, U\n\
           *Output, history, number interval=100\n*Energy Output\n ALLKE, ALLFD, ALLCW\n*End Step\n"
}

/// Returns the mean axial velocity of the ring of [`ring_on_shaft`] over time.
pub fn mean_velocities(ran: &DeckRun) -> Vec<[f64; 2]> {
    let nodes = ran.nodes("RING");
    let mass: f64 = nodes.iter().map(|n| ran.state.dofs.nodes.mass[n[1]]).sum();
    ran.memory.frames.iter().map(|f| [f.time, ran.momentum_of(&nodes, f) / mass]).collect()
}

/// Returns two bodies with adaptive meshes in contact: a copper shell with a spherical end of the radius 5 hits an aluminium
/// block at 100 m/s (t, mm, s). `interaction` are the cards of the contact, `cards` those of the step, which may name the sets
/// PUNCH.SOLID and BLOCK.SOLID. Both bodies are free, and have `n` elements along the block.
pub fn punch_and_block(n: usize, time: f64, interaction: &str, cards: &str) -> String {
    let (radius, width, rows) = (5.0, 15.0, n.div_ceil(4));
    let quarter = std::f64::consts::FRAC_PI_2;
    let punch = part(
        "PUNCH",
        [n, rows],
        |i, j| {
            let (angle, from) = (quarter * i as f64 / n as f64, radius * (1.0 - 0.5 * j as f64 / rows as f64));
            // The axis is met to the last bit.
            [if i == 0 { 0.0 } else { from * angle.sin() }, radius - from * angle.cos()]
        },
        "*Surface, name=SKIN\n SOLID,\n",
    );
    let block = part(
        "BLOCK",
        [n, n],
        |i, j| [width * i as f64 / n as f64, width * (j as f64 / n as f64 - 1.0)],
        "*Surface, name=SKIN\n SOLID,\n",
    );
    let metal = |name, constants, [yields, strong]: [f64; 2]| {
        elastic(name, constants, &format!("*Plastic\n {yields}, 0.\n {strong}, 1.\n"))
    };
    punch
        + &block
        + &assembly(&["PUNCH", "BLOCK"], "")
        + &metal("PUNCH", [117e3, 0.3, 8.93e-9], [200.0, 400.0])
        + &metal("BLOCK", [70e3, 0.3, 2.7e-9], [100.0, 200.0])
        + &format!("*Surface Interaction, name=I\n{interaction}")
        + &format!(
            "*Initial Conditions, type=VELOCITY\n PUNCH.ALL, 2, -1e5\n*Step\n*Dynamic, Explicit\n , {time:e}\n{cards}"
        )
        + "*Contact Pair, interaction=I\n PUNCH.SKIN, BLOCK.SKIN\n*Output, field, number interval=2\n*Node Output\n U, V\n*Element \
           Output\n S, PEEQ\n*Contact Output\n CSTRESS, CDISP\n*Output, history, number interval=20\n*Contact \
           Output\n CFN2\n*Energy Output\n ALL\n*Incrementation Output\n DT, NADAPT, ADANGLE\n*End Step\n"
}

/// Cards of adaptive meshes of both bodies of [`punch_and_block`].
pub const BOTH_ADAPTIVE: &str =
    "*Adaptive Mesh, elset=PUNCH.SOLID, frequency=3\n*Adaptive Mesh, elset=BLOCK.SOLID, frequency=3\n";
