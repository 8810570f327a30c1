//! Elements whose stress the user's routine gives (`*USER MATERIAL`): geometry, hourglass control and bulk viscosity as of
//! other elements, and between them a call for each block of material points.
//! Never here: how the routine was made or loaded.

use super::group::{ElementGroup, Pass, Totals, block, tell_deleted, totals};
use crate::element::block::{Block, Nodes, Stage, Sums, dot};
use crate::element::constants::Constants;
use crate::element::points::Points;
use crate::element::record::{Followed, Record, spin};
use crate::kernel::lanes::Corners;
use crate::kernel::lanes::LANES;
use crate::kernel::quad::{Gradient, gradient};
use crate::kernel::rotation::rotated;
use crate::material::plasticity::Elastic;
use crate::material::volumetric::Linear;
use crate::output::variables::{Part, Variable};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::state::nodes::Node;
use crate::user::{LoadFailure, MAX_MATERIAL_BLOCK, UserMaterial};

/// Blocks of elements that one call shows.
const BLOCKS: usize = MAX_MATERIAL_BLOCK / LANES;

/// What a deck says of a user material.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name, upper case (`cmname`).
    pub name: String,
    /// Constants.
    pub properties: Vec<f64>,
    /// Variables that each element keeps.
    pub variables: usize,
    /// The one of them, counted from 0, that deletes an element when it becomes zero.
    pub delete: Option<usize>,
}

/// Quadrilaterals of a user material.
#[derive(Clone)]
pub struct UserQuads {
    description: Description,
    /// Moduli are those that the routine's answer at time zero has.
    constants: Constants,
    count: usize,
    names: Vec<String>,
    blocks: Vec<Block<(), (), ()>>,
    chunks: Vec<Chunk>,
    /// One for each block of a call.
    stages: Vec<Stage>,
    nodes: Vec<Nodes>,
    now: Instant,
    failure: Option<Halt>,
    /// Elements whose deletion has been told.
    told: Vec<bool>,
}

/// The elements of one call.
#[derive(Clone)]
struct Chunk {
    points: Points,
    /// Geometry at the start.
    start: Vec<Gradient>,
    /// Cosine and sine of the angle by which the stress's frame has turned.
    turn: Vec<[f64; 2]>,
    deleted: Vec<bool>,
}

impl UserQuads {
    /// Elements by their corner nodes, at their places now, with their names for messages. The moduli of the constants
    /// come from the routine's first call.
    pub fn new(
        description: Description,
        constants: Constants,
        density: f64,
        elements: &[[u32; 4]],
        nodes: &[Node],
        names: Vec<String>,
    ) -> Self {
        let blocks: Vec<_> = elements.chunks(LANES).map(|part| block(((), (), ()), density, part, nodes)).collect();
        let chunk = |part: &[[u32; 4]]| Chunk {
            points: Points::new(part.len(), description.variables, description.delete),
            start: part.iter().map(|e| start(*e, nodes)).collect(),
            turn: vec![[1.0, 0.0]; part.len()],
            deleted: vec![false; part.len()],
        };
        UserQuads {
            chunks: elements.chunks(BLOCKS * LANES).map(chunk).collect(),
            description,
            constants,
            count: elements.len(),
            names,
            blocks,
            stages: vec![Stage::new(&constants, elements.len().div_ceil(BLOCKS * LANES)); BLOCKS],
            nodes: vec![Nodes::default(); BLOCKS],
            now: Instant::default(),
            failure: None,
            told: vec![false; elements.len()],
        }
    }

    /// Moduli from the routine's answer to fictitious strains at time zero, as ABAQUS/Explicit asks for it: the largest of
    /// all elements.
    fn probe(&mut self, nodes: &[Node], routine: &mut dyn UserMaterial) -> Result<(), Halt> {
        let (mut bulk, mut shear) = (0_f64, 0_f64);
        for c in 0..self.chunks.len() {
            self.strain(c, nodes, 0.0);
            let points = &mut self.chunks[c].points;
            points.show_fictitious();
            let called = points.call(&self.description, routine, &self.now, 1.0).and_then(|()| points.moduli());
            let [k, g] = called.map_err(|failure| self.halt(c, &failure))?;
            (bulk, shear) = (bulk.max(k), shear.max(g));
        }
        (self.constants.bulk, self.constants.shear) = (bulk, shear);
        Ok(())
    }

    /// Strain increments of one call's elements, in the frame that turns with the material.
    fn strain(&mut self, c: usize, nodes: &[Node], dt: f64) {
        let first = c * BLOCKS;
        let chunk = &mut self.chunks[c];
        let blocks = self.blocks[first..].iter_mut().take(BLOCKS);
        for (s, ((block, stage), corners)) in blocks.zip(&mut self.stages).zip(&mut self.nodes).enumerate() {
            stage.prepare(first + s, c, self.count - (first + s) * LANES);
            corners.collect(nodes, &block.nodes);
            for l in 0..LANES {
                if chunk.deleted.get(s * LANES + l).copied().unwrap_or(true) {
                    park(corners, l);
                    stage.park(l);
                }
            }
            block.strain::<Elastic, Linear, false>(&self.constants, dt, corners, stage);
        }
        for i in 0..chunk.deleted.len() {
            let (s, l) = (i / LANES, i % LANES);
            let (stage, corners, mass) = (&self.stages[s], &self.nodes[s], self.blocks[first + s].mass[l]);
            chunk.turn[i] = turned(chunk.turn[i], spin(corners, l, dt));
            let increment = [0, 1, 2, 3].map(|k| stage.strain[k][l]);
            let [cosine, sine] = chunk.turn[i];
            chunk.points.set_strain(i, components(increment, [cosine, -sine]));
            if !chunk.deleted[i] {
                let (r, z) = (corners.of(l, 0), corners.of(l, 1));
                chunk.points.set_place(i, r, z, mass / stage.volume[l]);
                chunk.points.set_gradient(i, deformation(&chunk.start[i], r, z));
            }
        }
    }

    /// The routine's stresses of one call, and the work done on the way to them.
    fn stress(&mut self, c: usize, dt: f64, routine: &mut dyn UserMaterial) -> Result<(), Halt> {
        let chunk = &mut self.chunks[c];
        if dt > 0.0 {
            let called = chunk.points.call(&self.description, routine, &self.now, dt);
            if let Err(failure) = called {
                return Err(self.halt(c, &failure));
            }
        } else {
            chunk.points.keep();
        }
        let delete = self.description.delete;
        for i in 0..chunk.deleted.len() {
            let (block, stage, l) = (&mut self.blocks[c * BLOCKS + i / LANES], &mut self.stages[i / LANES], i % LANES);
            if delete.is_some_and(|v| chunk.points.state(i, v) == 0.0) || chunk.deleted[i] {
                chunk.deleted[i] = true;
                chunk.points.delete(i, delete);
            }
            let stress = components(chunk.points.stress(i), chunk.turn[i]);
            let double = |k: usize| stage.strain[k][l] * (stage.carried[k][l] + stress[k]);
            let work = 0.5 * stage.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            if stage.weighs(l) {
                stage.sums.internal[l] += work;
                stage.sums.plastic[l] += block.mass[l] * chunk.points.dissipated(i);
            }
            for (list, value) in block.stress.iter_mut().zip(stress) {
                list[l] = value;
            }
        }
        chunk.points.swap();
        Ok(())
    }

    /// Corner forces of one call's elements.
    fn forces(&mut self, c: usize, dt: f64, corners: &mut [Corners]) {
        let first = c * BLOCKS;
        let deleted = &self.chunks[c].deleted;
        let blocks = self.blocks[first..].iter_mut().zip(&mut corners[first..]).take(BLOCKS);
        for (s, ((block, forces), (stage, nodes))) in blocks.zip(self.stages.iter_mut().zip(&self.nodes)).enumerate() {
            block.forces::<Linear, false>(&self.constants, dt, stage, forces);
            for l in (0..LANES).filter(|l| deleted.get(s * LANES + l).copied().unwrap_or(true)) {
                forces.0.iter_mut().for_each(|list| list[l] = 0.0);
                if let Some(hourglass) = stage.hourglass.get_mut(c) {
                    hourglass.iter_mut().for_each(|list| list[l] = 0.0);
                }
            }
            if !stage.records.is_empty() {
                stage.follow(c, block, false, nodes, dt);
            }
        }
    }

    fn pass(&mut self, pass: Pass<'_>) -> Result<(), Halt> {
        let Pass { nodes, dt, corners, user, .. } = pass;
        let Some(routine) = user else { return Ok(()) };
        if dt == 0.0 {
            self.probe(nodes, routine)?;
        }
        for c in 0..self.chunks.len() {
            self.strain(c, nodes, dt);
            self.stress(c, dt, routine)?;
            self.forces(c, dt, corners);
        }
        Ok(())
    }

    #[cold]
    fn halt(&self, c: usize, failure: &LoadFailure) -> Halt {
        let name = failure.point.and_then(|i| self.names.get(c * BLOCKS * LANES + i));
        let place = name.map_or(String::new(), |n| format!(" at element {n}"));
        let what = format!("the user material `{}`{place}", self.description.name);
        failure.halt(&what, &self.now)
    }

    /// What is followed of an element; `None` if nothing is.
    fn followed(&self, element: usize) -> Option<Followed> {
        let block = element / LANES;
        let followed = self.stages[block % BLOCKS].records.get(block / BLOCKS)?.of(element % LANES);
        let (chunk, i) = self.chunk(element);
        let dissipated = self.blocks[block].mass[element % LANES] * chunk.points.inelastic(i);
        Some(Followed { energy: [followed.energy[0] - dissipated, dissipated], ..followed })
    }

    fn chunk(&self, element: usize) -> (&Chunk, usize) {
        (&self.chunks[element / (BLOCKS * LANES)], element % (BLOCKS * LANES))
    }
}

impl ElementGroup for UserQuads {
    fn len(&self) -> usize {
        self.count
    }

    fn failure(&self) -> Option<Halt> {
        self.failure.clone()
    }

    fn update(&mut self, pass: Pass<'_>) -> Totals {
        self.now = *pass.now;
        self.stages.iter_mut().for_each(|s| s.sums = Sums::default());
        self.failure = self.pass(pass).err();
        let totals = totals(&self.stages, |_| f64::INFINITY);
        if self.failure.is_some() { Totals { rate: f64::NAN, ..totals } } else { totals }
    }

    fn value(&self, element: usize, part: Part) -> Option<f64> {
        let (block, lane) = (&self.blocks[element / LANES], element % LANES);
        let (chunk, i) = self.chunk(element);
        match part.variable {
            Variable::Stress => Some(block.stress.get(part.component)?[lane]),
            Variable::Temperature => Some(chunk.points.temperature(i)),
            Variable::State => {
                let kept = part.component < self.description.variables;
                kept.then(|| chunk.points.state_before(i, part.component))
            }
            Variable::Mass => Some(block.mass[lane]),
            Variable::Status => Some(if chunk.deleted[i] { 0.0 } else { 1.0 }),
            // Only the routine would know it.
            Variable::PlasticComponents => None,
            _ => self.followed(element)?.value(part),
        }
    }

    fn set(&mut self, element: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        let (chunk, i) = (&mut self.chunks[element / (BLOCKS * LANES)], element % (BLOCKS * LANES));
        chunk.points.start(i, stress, temperature);
        for (list, value) in self.blocks[element / LANES].stress.iter_mut().zip(stress.into_iter().flatten()) {
            list[element % LANES] = value;
        }
    }

    fn follow(&mut self) {
        self.stages.iter_mut().for_each(|s| s.records = vec![Record::default(); self.chunks.len()]);
    }

    fn corner_masses(&self, element: usize) -> [f64; 4] {
        self.blocks[element / LANES].corner_masses(element % LANES)
    }

    fn set_corner_masses(&mut self, element: usize, masses: [f64; 4]) {
        self.blocks[element / LANES].set_corner_masses(element % LANES, masses);
    }

    fn deleted(&mut self, gone: &mut Vec<[u32; 4]>) {
        if self.description.delete.is_none() {
            return;
        }
        let mut told = std::mem::take(&mut self.told);
        tell_deleted(self, &mut told, gone);
        self.told = told;
    }

    fn can_delete(&self) -> bool {
        self.description.delete.is_some()
    }

    fn copy(&self) -> Box<dyn ElementGroup> {
        Box::new(self.clone())
    }

    fn holds_state(&self) -> bool {
        false
    }

    fn set_energy(&mut self, _element: usize, _energy: f64) {}

    fn corners(&self, element: usize) -> [u32; 4] {
        [0, 1, 2, 3].map(|c| self.blocks[element / LANES].nodes[c][element % LANES])
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.blocks) + self.chunks.iter().map(|c| c.points.bytes()).sum::<usize>()
    }
}

fn start(element: [u32; 4], nodes: &[Node]) -> Gradient {
    let corners = element.map(|n| nodes[n as usize].place());
    gradient(corners.map(|c| c[0]), corners.map(|c| c[1]))
}

/// Puts an element that is not there where nothing can go wrong: at rest on a unit square. It weighs nothing.
fn park(nodes: &mut Nodes, lane: usize) {
    for (corner, [r, z]) in [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]].into_iter().enumerate() {
        nodes.0[corner][lane] = [r, z, 0.0, 0.0];
    }
}

/// The frame turned by a spin increment, as the stress is (Hughes and Winget 1980).
fn turned([cosine, sine]: [f64; 2], spin: f64) -> [f64; 2] {
    let quarter = 0.25 * spin * spin;
    let inverse = 1.0 / (1.0 + quarter);
    let (c, s) = ((1.0 - quarter) * inverse, spin * inverse);
    [cosine * c - sine * s, sine * c + cosine * s]
}

/// Components of a tensor in a frame turned by an angle of this cosine and sine: those of the inner loop's rotation.
fn components([rr, zz, hoop, rz]: [f64; 4], [cosine, sine]: [f64; 2]) -> [f64; 4] {
    if sine == 0.0 {
        return rotated([rr, zz, hoop, rz], 0.0);
    }
    let (cosine2, sine2) = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
    let (centre, radius) = (0.5 * (rr + zz), 0.5 * (rr - zz));
    let along = radius * cosine2 + rz * sine2;
    [centre + along, centre - along, hoop, rz * cosine2 - radius * sine2]
}

/// Mean deformation gradient: rr, zz, hoop, rz, zr.
fn deformation(start: &Gradient, r: [f64; 4], z: [f64; 4]) -> [f64; 5] {
    let per = 1.0 / start.volume;
    [dot(start.r, r), dot(start.z, z), dot(start.hoop, r), dot(start.z, r), dot(start.r, z)].map(|x| per * x)
}

impl Persist for Chunk {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Chunk { points, start: _, turn, deleted } = self;
        persist_fields!(archive; points, turn.as_mut_slice(), deleted.as_mut_slice());
    }
}

impl Persist for UserQuads {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let UserQuads {
            description: _,
            constants,
            count: _,
            names: _,
            blocks,
            chunks,
            stages,
            nodes: _,
            now: _,
            failure: _,
            told,
        } = self;
        // The moduli are those of the routine's answer at time zero, which is not asked for again.
        persist_fields!(archive; &mut constants.bulk, &mut constants.shear);
        persist_fields!(archive; blocks.as_mut_slice(), chunks.as_mut_slice(), stages.as_mut_slice());
        told.as_mut_slice().persist(archive);
    }
}
