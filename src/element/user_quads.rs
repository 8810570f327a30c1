//! Elements whose stress the user's routine gives (`*USER MATERIAL`), or its yield stress, or fields: geometry, hourglass control and bulk viscosity as of
//! other elements, and between them a call for each chunk of material points. Threads share the chunks; the calls, whose
//! routine may keep state of its own, are made by one thread in the order of the chunks.
//! Never here: how the routine was made or loaded.

use rayon::prelude::*;

use super::group::{
    Deletion, ElementGroup, Extensions, Fields, GroupProperties, InitialState, PARALLEL, Pass, Settings, Stiffness,
    Temperatures, Totals, UserCalls, tell_deleted, totals,
};
use crate::element::constants::Constants;
use crate::element::lengths::user_number;
use crate::element::record::{Followed, Record};
use crate::element::user_chunk::{BLOCKS, Chunk, Common, ELEMENTS, Place, Scratch, Tally};
use crate::element::user_flow::Returning;
use crate::element::user_law::Description;
use crate::kernel::lanes::{Corners, LANES};
use crate::kernel::topology::{ElementNodes, PerNode, Topology};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::nodes::Node;
use crate::user::{AtPoints, LoadFailure};
use crate::variables::{Part, Variable};

/// Chunks between whose phases the routine is called for all of them, where threads share them.
const BATCH: usize = 16;

/// Quadrilaterals of a user material.
#[derive(Clone)]
pub struct UserQuads {
    description: Description,
    /// Moduli are those that the routine's answer at time zero has.
    constants: Constants,
    count: usize,
    names: Vec<String>,
    chunks: Vec<Chunk>,
    /// Scratch memory of a batch.
    scratch: Vec<Scratch>,
    /// Scratch memory of the calls.
    returning: Returning,
    tallies: [Tally; BLOCKS],
    now: Instant,
    failure: Option<Halt>,
    /// Elements whose deletion has been told.
    told: Vec<bool>,
    /// Whether elements may be deleted from outside.
    erodible: bool,
    /// Highest frequency that counts.
    cap: f64,
}

/// A failure with the chunk in which it was.
type Failed = (usize, LoadFailure);

impl UserQuads {
    /// Elements by their corner nodes, at their places now, with their names for messages. The moduli of the constants
    /// come from the routine ([`UserCalls::probe`]).
    pub fn new(
        description: Description,
        constants: Constants,
        elements: &[[u32; 4]],
        nodes: &[Node],
        names: Vec<String>,
    ) -> Self {
        let chunk = |(part, names): (&[[u32; 4]], &[String])| {
            Chunk::new(&description, part, nodes, names.iter().map(|n| user_number(n)).collect())
        };
        let chunks: Vec<Chunk> = elements.chunks(ELEMENTS).zip(names.chunks(ELEMENTS)).map(chunk).collect();
        // What no other thread shares is best done chunk by chunk.
        let batch = if elements.len() < PARALLEL { 1 } else { BATCH.min(chunks.len()) };
        let turns = |slot: usize| (chunks.len() - slot).div_ceil(batch);
        UserQuads {
            scratch: (0..batch).map(|slot| Scratch::new(&constants, turns(slot))).collect(),
            chunks,
            returning: Returning::new(&description),
            description,
            constants,
            count: elements.len(),
            names,
            tallies: [Tally::default(); BLOCKS],
            now: Instant::default(),
            failure: None,
            told: vec![false; elements.len()],
            erodible: false,
            cap: f64::INFINITY,
        }
    }

    /// Moduli from the routine's answer to fictitious strains at time zero, as ABAQUS/Explicit asks for it: the largest of
    /// all elements.
    fn moduli(&mut self, nodes: &[Node], mut user: AtPoints<'_>) -> Result<[f64; 2], Failed> {
        let UserQuads { description, constants, count, chunks, scratch, now, cap, .. } = self;
        let common = Common { description, constants, count: *count, nodes, dt: 0.0, cap: *cap };
        let mut largest = [0_f64; 2];
        for (index, chunk) in chunks.iter_mut().enumerate() {
            chunk.strain(&common, Place { chunk: index, turn: 0 }, &mut scratch[0]);
            let [bulk, shear] = chunk.probe(description, user.lend(), now).map_err(|failure| (index, failure))?;
            largest = [largest[0].max(bulk), largest[1].max(shear)];
        }
        Ok(largest)
    }

    fn pass(&mut self, pass: Pass<'_>) -> Result<(), Failed> {
        let Pass { nodes, dt, before: _, now, threads, mut user, mut corners, lacking: _ } = pass;
        let corners = corners.double();
        let UserQuads { description, constants, count, chunks, scratch, returning, tallies, cap, .. } = self;
        let common = &Common { description, constants, count: *count, nodes, dt, cap: *cap };
        let (threads, batch) = (threads && *count >= PARALLEL, scratch.len());
        *tallies = [Tally::default(); BLOCKS];
        let batches = chunks.chunks_mut(batch).zip(corners.chunks_mut(batch * BLOCKS));
        for (turn, (chunks, corners)) in batches.enumerate() {
            let place = |slot: usize| Place { chunk: turn * batch + slot, turn };
            spread(threads, (chunks, scratch, corners), |slot, chunk, scratch, _| {
                chunk.strain(common, place(slot), scratch);
            });
            for (slot, (chunk, scratch)) in chunks.iter_mut().zip(&*scratch).enumerate() {
                let called = chunk.call(description, user.lend(), (now, dt), (scratch, turn), returning);
                called.map_err(|failure| (place(slot).chunk, failure))?;
            }
            spread(threads, (chunks, scratch, corners), |slot, chunk, scratch, corners| {
                chunk.respond(common, place(slot), scratch, corners);
            });
            for (chunk, scratch) in chunks.iter().zip(&*scratch) {
                tallies.iter_mut().zip(&scratch.workspaces).take(chunk.blocks.len()).for_each(|(t, s)| t.add(s));
            }
        }
        Tally::share_deformation(tallies);
        Ok(())
    }

    #[cold]
    fn halt(&self, (chunk, failure): &Failed) -> Halt {
        let name = failure.point.and_then(|i| self.names.get(chunk * ELEMENTS + i));
        let place = name.map_or(String::new(), |n| format!(" at element {n}"));
        let what = format!("the user material `{}`{place}", self.description.name);
        failure.halt(&what, &self.now)
    }

    /// What is followed of an element; `None` if nothing is.
    fn followed(&self, element: usize) -> Option<Followed> {
        let (index, i) = (element / ELEMENTS, element % ELEMENTS);
        let (slot, turn) = (index % self.scratch.len(), index / self.scratch.len());
        let followed = self.scratch[slot].workspaces[i / LANES].task.records.get(turn)?.of(i % LANES);
        let chunk = &self.chunks[index];
        if self.description.flow.is_some() {
            return Some(followed);
        }
        let dissipated = chunk.mass[i] * chunk.points.inelastic(i);
        Some(Followed { energy: [followed.energy[0] - dissipated, dissipated], ..followed })
    }

    fn chunk(&self, element: usize) -> (&Chunk, usize) {
        (&self.chunks[element / ELEMENTS], element % ELEMENTS)
    }

    fn corners(&self, element: usize) -> [u32; 4] {
        let (chunk, i) = self.chunk(element);
        [0, 1, 2, 3].map(|c| chunk.blocks[i / LANES].nodes[c][i % LANES])
    }

    fn corner_masses(&self, element: usize) -> [f64; 4] {
        let (chunk, i) = self.chunk(element);
        chunk.blocks[i / LANES].corner_masses(i % LANES)
    }
}

/// Does a phase of each chunk of a batch, with its scratch memory and its corner forces.
fn spread(
    threads: bool,
    (chunks, scratch, corners): (&mut [Chunk], &mut [Scratch], &mut [Corners]),
    phase: impl Fn(usize, &mut Chunk, &mut Scratch, &mut [Corners]) + Sync,
) {
    if threads {
        let parts = chunks.par_iter_mut().zip(scratch).zip(corners.par_chunks_mut(BLOCKS)).enumerate();
        parts.for_each(|(slot, ((chunk, scratch), corners))| phase(slot, chunk, scratch, corners));
    } else {
        let parts = chunks.iter_mut().zip(scratch).zip(corners.chunks_mut(BLOCKS)).enumerate();
        parts.for_each(|(slot, ((chunk, scratch), corners))| phase(slot, chunk, scratch, corners));
    }
}

impl ElementGroup for UserQuads {
    fn len(&self) -> usize {
        self.count
    }

    fn properties(&self) -> GroupProperties {
        GroupProperties {
            topology: Topology::Quadrilateral,
            single: false,
            deletable: self.description.delete.is_some() || self.erodible,
            damped: self.constants.damps(),
            holds_pressure: false,
            fields: self.description.fields,
        }
    }

    fn nodes(&self, element: usize) -> ElementNodes {
        self.corners(element).into()
    }

    fn masses(&self, element: usize) -> PerNode<f64> {
        self.corner_masses(element).into()
    }

    fn update(&mut self, pass: Pass<'_>) -> Totals {
        self.now = *pass.now;
        let passed = self.pass(pass);
        self.failure = passed.err().map(|failed| self.halt(&failed));
        let totals = totals(self.tallies.iter().map(Tally::parts), |_| f64::INFINITY);
        let rate = self.constants.with_assumed(totals.rate, self.cap);
        Totals { rate: if self.failure.is_some() { f64::NAN } else { rate }, ..totals }
    }

    fn value(&self, element: usize, part: Part) -> Option<f64> {
        let (chunk, i) = self.chunk(element);
        let (block, lane) = (&chunk.blocks[i / LANES], i % LANES);
        match part.variable {
            Variable::Stress => Some(block.stress.get(part.component)?[lane]),
            Variable::Temperature => Some(chunk.points.temperature(i)),
            Variable::State => {
                let kept = part.component < self.description.variables;
                kept.then(|| chunk.points.state_before(i, part.component))
            }
            Variable::Mass => Some(block.mass[lane]),
            Variable::Status => Some(if chunk.deleted[i] { 0.0 } else { 1.0 }),
            Variable::PlasticStrain => chunk.points.plastic(i),
            // Only the routine would know it.
            Variable::PlasticComponents if self.description.flow.is_none() => None,
            _ => self.followed(element)?.value(part),
        }
    }

    fn stable_rate(&self, element: usize, masses: Option<&[f64]>, nodes: &[Node]) -> Option<f64> {
        let corners = self.corners(element).map(|n| nodes[n as usize].place());
        let masses = masses.map_or(Some(self.corner_masses(element)), |list| list.first_chunk().copied())?;
        Some(self.constants.own_rate(corners, &masses))
    }

    fn stiffness(&self, element: usize, nodes: &[Node]) -> Option<Stiffness> {
        let corners = self.corners(element).map(|n| nodes[n as usize].place());
        let (chunk, i) = self.chunk(element);
        Some(self.constants.stiffness(corners, chunk.deleted[i]).into())
    }

    fn bytes(&self) -> usize {
        let names: usize = self.names.iter().map(|n| size_of_val(n) + n.capacity()).sum();
        let chunks: usize = self.chunks.iter().map(Chunk::bytes).sum();
        let scratch: usize = self.scratch.iter().map(Scratch::bytes).sum();
        chunks + scratch + self.returning.bytes() + names + self.told.capacity()
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn extensions(&mut self) -> &mut dyn Extensions {
        self
    }
}

impl Extensions for UserQuads {
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }

    fn deletion(&mut self) -> &mut dyn Deletion {
        self
    }

    fn initial_state(&mut self) -> &mut dyn InitialState {
        self
    }

    fn temperatures(&mut self) -> Option<&mut dyn Temperatures> {
        Some(self)
    }

    fn fields(&mut self) -> Option<&mut dyn Fields> {
        Some(self)
    }

    fn user(&mut self) -> Option<&mut dyn UserCalls> {
        Some(self)
    }
}

impl Settings for UserQuads {
    fn set_masses(&mut self, element: usize, masses: &[f64]) {
        let Some(masses) = masses.first_chunk::<4>() else { return };
        let i = element % ELEMENTS;
        self.chunks[element / ELEMENTS].blocks[i / LANES].set_corner_masses(i % LANES, *masses);
    }

    fn follow(&mut self) {
        let (chunks, batch) = (self.chunks.len(), self.scratch.len());
        for (slot, scratch) in self.scratch.iter_mut().enumerate() {
            let turns = (chunks - slot).div_ceil(batch);
            scratch.workspaces.iter_mut().for_each(|s| s.task.records = vec![Record::default(); turns]);
        }
    }

    fn limit_frequency(&mut self, frequency: f64) {
        self.cap = self.constants.cap(frequency);
    }
}

impl Deletion for UserQuads {
    fn make_erodible(&mut self) {
        self.erodible = true;
    }

    fn erode(&mut self, element: usize, _volume: f64) {
        self.chunks[element / ELEMENTS].deleted[element % ELEMENTS] = true;
        self.told[element] = true;
    }

    fn newly_deleted(&mut self, deleted: &mut Vec<ElementNodes>) {
        if self.description.delete.is_none() {
            return;
        }
        let mut told = std::mem::take(&mut self.told);
        tell_deleted(self, &mut told, deleted);
        self.told = told;
    }
}

impl InitialState for UserQuads {
    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        self.chunks[element / ELEMENTS].set(element % ELEMENTS, stress, temperature);
    }

    fn set_state(&mut self, element: usize, variable: usize, value: f64) -> bool {
        self.chunks[element / ELEMENTS].points.start_state(element % ELEMENTS, variable, value)
    }

    fn set_plastic_strain(&mut self, element: usize, strain: f64) -> bool {
        self.chunks[element / ELEMENTS].points.harden(element % ELEMENTS, strain)
    }
}

impl Temperatures for UserQuads {
    fn set_temperatures(&mut self, temperatures: &[f64]) {
        for (chunk, temperatures) in self.chunks.iter_mut().zip(temperatures.chunks(ELEMENTS)) {
            chunk.points.warm(temperatures);
        }
    }

    fn temperatures(&self, out: &mut [f64]) {
        for (chunk, out) in self.chunks.iter().zip(out.chunks_mut(ELEMENTS)) {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = chunk.points.temperature(i));
        }
    }

    /// The routine is shown the strain without it.
    fn expand(&mut self, strains: &[f64], _nodes: &[Node], _dt: f64) -> f64 {
        for (chunk, strains) in self.chunks.iter_mut().zip(strains.chunks(ELEMENTS)) {
            chunk.expand(strains);
        }
        0.0
    }
}

impl Fields for UserQuads {
    fn set_field(&mut self, element: usize, variable: usize, value: f64) {
        self.chunks[element / ELEMENTS].points.start_field(element % ELEMENTS, variable, value);
    }

    fn set_fields(&mut self, variable: usize, values: &[f64]) {
        for (chunk, values) in self.chunks.iter_mut().zip(values.chunks(ELEMENTS)) {
            chunk.points.give_field(variable, values);
        }
    }
}

impl UserCalls for UserQuads {
    fn probe(&mut self, nodes: &[Node], now: &Instant, user: AtPoints<'_>) -> Result<(), Halt> {
        self.now = *now;
        if user.material.is_none() || self.description.flow.is_some() {
            return Ok(());
        }
        let [bulk, shear] = self.moduli(nodes, user).map_err(|failed| self.halt(&failed))?;
        (self.constants.bulk, self.constants.shear) = (bulk, shear);
        Ok(())
    }

    fn failure(&self) -> Option<Halt> {
        self.failure.clone()
    }
}

impl Persist for UserQuads {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserQuads {
            description: _,
            constants,
            count: _,
            names: _,
            chunks,
            scratch,
            returning: _,
            tallies: _,
            now: _,
            failure: _,
            told,
            erodible: _,
            cap,
        } = self;
        // The moduli are those of the routine's answer at time zero, which is not asked for again.
        let Constants { bulk, shear, hourglass: _, bulk_viscosity: _ } = constants;
        persist_fields!(archive; bulk, shear, cap);
        persist_fields!(archive; chunks.as_mut_slice(), scratch.as_mut_slice(), told.as_mut_slice());
    }
}
