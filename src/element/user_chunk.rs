//! The elements of a user material that one call of its routine shows: what is done with them before the call and behind it.
//! Chunks know nothing of each other, so that several threads take them; the call between is that of one thread.
//! Never here: the order of chunks, moduli, output.

use pulp::Arch;

use super::group::block;
use crate::element::block::{ElementBlock, Nodes, Sums, Workspace, larger};
use crate::element::constants::Constants;
use crate::element::control::{Seen, Spring};
use crate::element::middle::Middle;
use crate::element::points::{Points, Tells};
use crate::element::record::{Followed, spin, spins};
use crate::element::user_flow::{Returning, Under};
use crate::element::user_law::Description;
use crate::kernel::lanes::{Corners, LANES, Lanes, column, dot};
use crate::kernel::quad::{Gradient, gradient};
use crate::kernel::rotation::{of_spin, turned};
use crate::kernel::stress::mises;
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::material::{BlockStart, Material, PlasticFlow};
use crate::state::Instant;
use crate::state::archive::persist_struct;
use crate::state::nodes::Node;
use crate::user::{AtPoints, LoadFailure, MAX_MATERIAL_BLOCK};
use crate::variables::{Part, Variable};

/// Blocks of elements that one call shows, and its elements.
pub(super) const BLOCKS: usize = MAX_MATERIAL_BLOCK / LANES;
pub(super) const ELEMENTS: usize = BLOCKS * LANES;

/// The stress of a user subroutine, which is called for all elements of a chunk between two phases.
struct Routine;

impl Material for Routine {
    type State = ();
    const FLOW: PlasticFlow = PlasticFlow::Unknown;

    fn initial_state(&self, _start: &BlockStart) {}

    fn update(&self, (): &mut (), _: &mut [Lanes; 4], _: &StrainIncrement, _: &mut StressUpdate) {}
}

/// The elements of one call.
#[derive(Clone)]
pub(super) struct Chunk {
    pub blocks: Vec<ElementBlock<()>>,
    pub points: Points,
    /// Masses by density, which no mass scaling changes: the routine's density and energies a mass are those of its material.
    pub mass: Vec<f64>,
    /// Geometry at the start.
    start: Vec<Gradient>,
    /// Cosine and sine of the angle by which the stress's frame has turned.
    turn: Vec<[f64; 2]>,
    pub deleted: Vec<bool>,
    /// Thermal strain that the next increment takes off; empty before anything expands.
    thermal: Vec<f64>,
}

/// Scratch memory of a chunk between its phases. Chunks take turns with it.
#[derive(Clone)]
pub(super) struct Scratch {
    /// One for each block.
    pub workspaces: Vec<Workspace>,
    nodes: Vec<Nodes>,
}

impl Scratch {
    /// For so many chunks one after the other.
    pub fn new(constants: &Constants, turns: usize) -> Self {
        Scratch {
            workspaces: vec![Workspace::new(constants, 1.0, turns); BLOCKS],
            nodes: vec![Nodes::default(); BLOCKS],
        }
    }

    /// Bytes of it.
    pub fn bytes(&self) -> usize {
        size_of_val(self)
            + size_of_val(&*self.workspaces)
            + size_of_val(&*self.nodes)
            + self.workspaces.iter().map(Workspace::bytes).sum::<usize>()
    }
}

/// What all chunks of one pass share.
pub(super) struct Common<'a> {
    pub description: &'a Description,
    pub constants: &'a Constants,
    /// Elements of the group.
    pub count: usize,
    pub nodes: &'a [Node],
    pub dt: f64,
    /// Highest frequency that counts.
    pub cap: f64,
}

/// Where a chunk stands: in the group, and among those that share its scratch memory.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub chunk: usize,
    pub turn: usize,
}

impl Chunk {
    /// Elements by their corner nodes, at their places now, with the user's numbers.
    pub fn new(description: &Description, elements: &[[u32; 4]], nodes: &[Node], numbers: Vec<i32>) -> Self {
        let fresh = |part: &[[u32; 4]]| block((), (description.density, 1.0), part, nodes);
        let blocks: Vec<_> = elements.chunks(LANES).map(fresh).collect();
        Chunk {
            points: Points::new(description, elements, numbers),
            mass: (0..elements.len()).map(|i| blocks[i / LANES].mass[i % LANES]).collect(),
            start: elements.iter().map(|e| start(*e, nodes)).collect(),
            turn: vec![[1.0, 0.0]; elements.len()],
            deleted: vec![false; elements.len()],
            thermal: Vec::new(),
            blocks,
        }
    }

    /// Strain increments, in the frame that turns with the material.
    pub fn strain(&mut self, common: &Common<'_>, place: Place, scratch: &mut Scratch) {
        let first = place.chunk * BLOCKS;
        for (s, block) in self.blocks.iter_mut().enumerate() {
            let (workspace, corners) = (&mut scratch.workspaces[s], &mut scratch.nodes[s]);
            workspace.begin(common.cap, common.dt);
            workspace.prepare(first + s, place.turn, common.count - (first + s) * LANES);
            corners.collect(common.nodes, &block.nodes, 0.0);
            for l in 0..LANES {
                if self.deleted.get(s * LANES + l).copied().unwrap_or(true) {
                    corners.mask(l, 1.0, 1.0);
                    workspace.mask(l);
                }
            }
            block.strain::<Routine, false>(common.constants, common.dt, corners, workspace);
            if workspace.cap < f64::INFINITY {
                workspace.measure();
            }
        }
        (0..self.deleted.len()).for_each(|i| self.show(i, common.dt, scratch));
    }

    /// Puts before the routine what a point has gone through.
    fn show(&mut self, i: usize, dt: f64, scratch: &Scratch) {
        let (workspace, corners, l) = (&scratch.workspaces[i / LANES], &scratch.nodes[i / LANES], i % LANES);
        self.turn[i] = spun(self.turn[i], spin(corners, l, dt));
        let mut increment = [0, 1, 2, 3].map(|k| workspace.strain.strain[k][l]);
        if let Some(thermal) = self.thermal.get_mut(i) {
            let thermal = std::mem::take(thermal);
            increment[..3].iter_mut().for_each(|strain| *strain -= thermal);
        }
        let [cosine, sine] = self.turn[i];
        self.points.set_strain(i, components(increment, [cosine, -sine]));
        if !self.deleted[i] {
            let (r, z) = (corners.of(l, 0), corners.of(l, 1));
            self.points.set_place(i, r, z, self.mass[i] / workspace.strain.volume[l]);
            self.points.set_gradient(i, deformation(&self.start[i], r, z));
        }
    }

    /// Takes thermal strains off the next increment.
    pub fn expand(&mut self, strains: &[f64]) {
        self.thermal.resize(self.deleted.len(), 0.0);
        self.thermal.iter_mut().zip(strains).for_each(|(thermal, strain)| *thermal += strain);
    }

    /// Calls the routines. An increment of no length leaves all as it is.
    ///
    /// # Errors
    /// Those of [`Points::call_lengths`], [`Points::call_fields`], [`Points::call`] and [`Points::flow`].
    pub fn call(
        &mut self,
        description: &Description,
        user: AtPoints<'_>,
        (now, dt): (&Instant, f64),
        (scratch, turn): (&Scratch, usize),
        returning: &mut Returning,
    ) -> Result<(), LoadFailure> {
        if dt == 0.0 {
            self.points.keep();
            return Ok(());
        }
        self.points.carry_fields();
        if let (Some(properties), Some(routine)) = (&description.asks_lengths, user.lengths) {
            self.points.call_lengths(description, properties, routine, (now, dt))?;
        }
        if let (Some(properties), Some(routine)) = (&description.asks_fields, user.fields) {
            let tells = &Told { blocks: &self.blocks, workspaces: &scratch.workspaces, turn };
            self.points.call_fields(description, properties, routine, tells, (now, dt))?;
        }
        if let Some(flow) = &description.flow {
            let under = Under { material: description, flow, heating: &description.heating, now, dt };
            return self.points.flow(under, user.hardening, returning);
        }
        let Some(routine) = user.material else { return Ok(()) };
        self.points.carry_temperature();
        self.points.call(description, routine, now, dt)?;
        if !description.heating.is_none() {
            self.points.heat(&description.heating);
        }
        Ok(())
    }

    /// Bulk and shear modulus that the routine's answer to fictitious strains has, the largest of all points.
    ///
    /// # Errors
    /// Those of [`Points::call`] and [`Points::moduli`].
    pub fn probe(
        &mut self,
        description: &Description,
        user: AtPoints<'_>,
        now: &Instant,
    ) -> Result<[f64; 2], LoadFailure> {
        if let (Some(properties), Some(routine)) = (&description.asks_lengths, user.lengths) {
            self.points.call_lengths(description, properties, routine, (now, 0.0))?;
        }
        let Some(routine) = user.material else { return Ok([0.0; 2]) };
        self.points.show_fictitious();
        self.points.call(description, routine, now, 1.0)?;
        self.points.moduli()
    }

    /// The routine's stresses, the work done on the way to them, and the corner forces that follow.
    pub fn respond(&mut self, common: &Common<'_>, place: Place, scratch: &mut Scratch, corners: &mut [Corners]) {
        (0..self.deleted.len()).for_each(|i| self.take_stress(i, common.description.delete, scratch));
        let flow = common.description.flow.as_ref();
        let flows = flow.is_some();
        if flow.is_some_and(|f| f.elasticity.is_some()) {
            (0..self.deleted.len()).for_each(|i| self.take_direction(i, scratch));
        }
        if flows {
            (0..self.deleted.len()).for_each(|i| self.take_flow(i, scratch));
        }
        self.points.swap();
        for (s, (block, forces)) in self.blocks.iter_mut().zip(corners).enumerate() {
            let workspace = &mut scratch.workspaces[s];
            let mut kept = workspace.kept();
            if common.constants.hourglass.relaxes {
                workspace.stress.returned = std::array::from_fn(|l| workspace.returned(column(&block.stress, l), l));
            }
            let increment = (common.constants, common.dt);
            if workspace.task.enhanced.is_empty() {
                block.forces::<Routine, _, false>(increment, &mut kept, workspace, forces, &mut Spring);
            } else {
                workspace.stress.trial = std::array::from_fn(|l| mises(column(&workspace.stress.deviator, l)));
                let mut seen = Seen::default();
                block.forces::<Routine, _, false>(increment, &mut kept, workspace, forces, &mut seen);
                let (factor, middle) = (common.constants.hourglass.enhanced, Middle::of(common.constants, workspace));
                let seen = (&seen, &middle, &scratch.nodes[s]);
                block.resist::<Routine, false>((factor, common.dt), seen, workspace, forces);
            }
            workspace.keep(kept);
            for l in (0..LANES).filter(|l| self.deleted.get(s * LANES + l).copied().unwrap_or(true)) {
                forces.clear(l);
                if let Some(hourglass) = workspace.task.hourglass.get_mut(place.turn) {
                    hourglass.iter_mut().for_each(|list| list[l] = 0.0);
                }
                if let Some(assumed) = workspace.task.enhanced.get_mut(place.turn) {
                    assumed.clear(l);
                }
            }
            if !workspace.task.records.is_empty() {
                let flows = if flows { PlasticFlow::Deviatoric } else { PlasticFlow::None };
                let increment = (spins(&scratch.nodes[s], common.dt), common.dt);
                workspace.follow(Arch::new(), place.turn, &block.stress, flows, increment);
            }
        }
    }

    fn take_stress(&mut self, i: usize, delete: Option<usize>, scratch: &mut Scratch) {
        let (block, workspace, l) = (&mut self.blocks[i / LANES], &mut scratch.workspaces[i / LANES], i % LANES);
        if delete.is_some_and(|v| self.points.state(i, v) == 0.0) || self.deleted[i] {
            self.deleted[i] = true;
            self.points.delete(i, delete);
        }
        let stress = components(self.points.stress(i), self.turn[i]);
        let double = |k: usize| workspace.strain.strain[k][l] * (workspace.strain.carried[k][l] + stress[k]);
        let work = 0.5 * workspace.strain.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
        if workspace.weighs(l) {
            workspace.stress.internal[l] += work;
            workspace.stress.dissipated[l] += self.mass[i] * self.points.dissipated(i);
        }
        for (list, value) in block.stress.iter_mut().zip(stress) {
            list[l] = value;
        }
    }

    /// The direction of plastic flow where moduli change: that of the stress, not of what the largest moduli would try.
    fn take_direction(&self, i: usize, scratch: &mut Scratch) {
        let (block, workspace, l) = (&self.blocks[i / LANES], &mut scratch.workspaces[i / LANES], i % LANES);
        let stress = [0, 1, 2, 3].map(|k| block.stress[k][l]);
        let mean = (stress[0] + stress[1] + stress[2]) * (1.0 / 3.0);
        for (k, (list, stress)) in workspace.stress.deviator.iter_mut().zip(stress).enumerate() {
            list[l] = if k < 3 { stress - mean } else { stress };
        }
    }

    /// The plastic strain of the increment and the trial that it came from, for what outputs follow.
    fn take_flow(&self, i: usize, scratch: &mut Scratch) {
        let (workspace, l) = (&mut scratch.workspaces[i / LANES], i % LANES);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| workspace.stress.deviator[k][l] * workspace.stress.deviator[k][l]);
        workspace.stress.trial[l] = (1.5 * (a + b + c) + 3.0 * d).sqrt();
        workspace.stress.flow[l] = if self.deleted[i] { 0.0 } else { self.points.flowed(i) };
    }

    /// Stress and temperature of an element at the start.
    pub fn set(&mut self, i: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        self.points.start(i, stress, temperature);
        for (list, value) in self.blocks[i / LANES].stress.iter_mut().zip(stress.into_iter().flatten()) {
            list[i % LANES] = value;
        }
    }

    /// Bytes of it.
    pub fn bytes(&self) -> usize {
        size_of_val(self)
            + size_of_val(&*self.blocks)
            + self.points.bytes()
            + size_of_val(&*self.mass)
            + size_of_val(&*self.start)
            + size_of_val(&*self.turn)
            + size_of_val(&*self.deleted)
            + size_of::<f64>() * self.thermal.capacity()
    }
}

/// What elements of a chunk know of their points: stresses, and what outputs follow.
struct Told<'a> {
    blocks: &'a [ElementBlock<()>],
    workspaces: &'a [Workspace],
    /// Place of the chunk among those that share the workspaces.
    turn: usize,
}

impl Told<'_> {
    fn followed(&self, point: usize) -> Option<Followed> {
        Some(self.workspaces[point / LANES].task.records.get(self.turn)?.of(point % LANES))
    }
}

impl Tells for Told<'_> {
    fn component(&self, point: usize, part: Part) -> Option<f64> {
        match part.variable {
            Variable::Stress => Some(self.blocks[point / LANES].stress[part.component][point % LANES]),
            _ => self.followed(point)?.value(part),
        }
    }
}

/// What the chunks of a pass came to, block by block of a chunk: folded in the order of the chunks, whoever took them.
#[derive(Clone, Copy, Default)]
pub(super) struct Tally {
    sums: Sums,
    deformed: [Lanes; 2],
}

impl Tally {
    /// Adds what a block of the next chunk came to.
    pub fn add(&mut self, work: &Workspace) {
        let (sums, deformed) = work.parts();
        self.sums.add(&sums);
        for (most, list) in self.deformed.iter_mut().zip(&deformed) {
            most.iter_mut().zip(list).for_each(|(most, x)| *most = larger(*x, *most));
        }
    }

    /// Brings what deformed most in any block to the first: strain and dilation of a whole group bound a frequency together, as
    /// those of a task of other groups do.
    pub fn share_deformation(tallies: &mut [Tally]) {
        let [first, others @ ..] = tallies else { return };
        for other in others {
            for (most, list) in first.deformed.iter_mut().zip(&other.deformed) {
                most.iter_mut().zip(list).for_each(|(most, x)| *most = larger(*x, *most));
            }
        }
    }

    /// As [`Workspace::parts`].
    pub fn parts(&self) -> (Sums, [Lanes; 2]) {
        (self.sums, self.deformed)
    }
}

fn start(element: [u32; 4], nodes: &[Node]) -> Gradient {
    let corners = element.map(|n| nodes[n as usize].place());
    gradient(corners.map(|c| c[0]), corners.map(|c| c[1]))
}

/// The frame turned by a spin increment, as the stress is.
fn spun([cosine, sine]: [f64; 2], spin: f64) -> [f64; 2] {
    let [c, s] = of_spin(spin);
    [cosine * c - sine * s, sine * c + cosine * s]
}

/// Components of a tensor in a frame turned by an angle of this cosine and sine. Without a sine nothing turns, whatever sign its
/// zero has: zeros among the components keep theirs.
fn components(tensor: [f64; 4], [cosine, sine]: [f64; 2]) -> [f64; 4] {
    turned(tensor, if sine == 0.0 { [1.0, 0.0] } else { [cosine, sine] })
}

/// Mean deformation gradient: rr, zz, hoop, rz, zr.
fn deformation(start: &Gradient, r: [f64; 4], z: [f64; 4]) -> [f64; 5] {
    let per = 1.0 / start.volume;
    [dot(start.r, r), dot(start.z, z), dot(start.hoop, r), dot(start.z, r), dot(start.r, z)].map(|x| per * x)
}

persist_struct!(Chunk { blocks: fixed, points, turn: fixed, deleted: fixed, thermal } derived { mass, start });

// The rest of it is of one pass.
persist_struct!(Scratch { workspaces: fixed } derived { nodes });
