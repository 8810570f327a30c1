//! Friction by a user subroutine (VFRICTION).
//!
//! The impulses are solved for with the friction coefficients of the previous increment. The subroutine receives the
//! normal forces and the slip; for a sticking point the slip that would occur without its friction. The ratio of its friction
//! force to the normal force is the friction coefficient of the point, with which the impulses are solved for again; the
//! force itself is not exceeded. A point whose friction force prevents the slip sticks in this increment.

use super::dofs::ContactDofs;
use super::mesh_continuation::{KeyPlace, MeshContinuation};
use super::surfaces::ContactSurfaces;
use super::sweeps::{ContactRow, ContactRows, ContactStep, NONE};
use crate::kernel::interaction::FrictionRoutine;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::routines::{FrictionCall, FrictionInput, LoadFailure, MAX_BLOCK};
use crate::state::archive::Persist;
use crate::state::dofs::Dof;
use crate::state::halt::HaltReason;

/// Components of vectors in a call.
const COMPONENTS: usize = 3;
/// Components of the friction force of a point: along the slip and along the hoop.
const TANGENTS: usize = 2;
/// Numbers after the forces of a block that a subroutine may write if it declares other sizes.
const SPARE: usize = 64;
/// Relative rounding error of forces that a subroutine returns.
const ROUNDING: f64 = 1e-9;
/// Slip of a sticking point by rounding errors, as a fraction of the slip without friction.
const STICKING_SLIP: f64 = 1e-6;

/// Contact whose friction a subroutine sets, after the impulses have been solved for.
#[derive(Clone, Copy)]
pub(super) struct FrictionScene<'a> {
    pub(super) surfaces: &'a ContactSurfaces,
    pub(super) dofs: &'a ContactDofs,
    pub(super) step: ContactStep<'a>,
    /// Energy dissipated by friction since the analysis began.
    pub(super) friction_work: f64,
}

/// Values of the keys for friction by a user subroutine, and work arrays of its calls.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: coefficients, states; derived: variables, points, numbers, block)]
pub(super) struct UserFrictionKeys {
    /// Friction coefficient of each key in the previous increment under pressure; infinite for a sticking point.
    coefficients: Vec<f64>,
    /// State variables: the first one of all keys, then the second, and so on.
    states: Vec<f64>,
    variables: usize,
    /// Point of each key.
    pub(super) points: Vec<u32>,
    /// Node number in the deck of each point; 0 for none.
    pub(super) numbers: Vec<i32>,
    block: PointBlock,
}

/// Arguments and results of a call.
#[derive(Clone, Debug, Default, Memory)]
struct PointBlock {
    rows: Vec<u32>,
    nodes: Vec<i32>,
    stick: Vec<f64>,
    normal: Vec<f64>,
    area: Vec<f64>,
    slip: Vec<f64>,
    previous: Vec<f64>,
    directions: [Vec<f64>; 2],
    coordinates: [Vec<f64>; 2],
    velocities: [Vec<f64>; 2],
    forces: Vec<f64>,
    state: Vec<f64>,
}

impl PointBlock {
    fn new(variables: usize) -> PointBlock {
        let vectors = || Vec::with_capacity(COMPONENTS * MAX_BLOCK);
        let numbers = || Vec::with_capacity(MAX_BLOCK);
        PointBlock {
            rows: Vec::with_capacity(MAX_BLOCK),
            nodes: Vec::with_capacity(MAX_BLOCK),
            stick: numbers(),
            normal: numbers(),
            area: numbers(),
            slip: vectors(),
            previous: vectors(),
            directions: [vectors(), vectors()],
            coordinates: [vectors(), vectors()],
            velocities: [vectors(), vectors()],
            forces: Vec::with_capacity(TANGENTS * MAX_BLOCK + SPARE),
            state: Vec::with_capacity(variables * MAX_BLOCK + SPARE),
        }
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.nodes.clear();
        self.state.clear();
        [&mut self.stick, &mut self.normal, &mut self.area, &mut self.slip, &mut self.previous]
            .into_iter()
            .chain(&mut self.directions)
            .chain(&mut self.coordinates)
            .chain(&mut self.velocities)
            .for_each(Vec::clear);
    }
}

impl UserFrictionKeys {
    /// Creates the values of a number of keys; `variables` is the largest number of state variables of a point.
    pub(super) fn new(keys: usize, variables: usize) -> UserFrictionKeys {
        UserFrictionKeys {
            coefficients: vec![0.0; keys],
            states: vec![0.0; variables * keys],
            variables,
            block: PointBlock::new(variables),
            ..UserFrictionKeys::default()
        }
    }

    /// Takes the values of a key from a place among those of a previous contact.
    pub(super) fn take_over(&mut self, key: usize, previous: &UserFrictionKeys, place: KeyPlace) {
        self.coefficients[key] = place.value(|other| previous.coefficients[other]);
        let (keys, previous_keys) = (self.coefficients.len(), previous.coefficients.len());
        for variable in 0..self.variables.min(previous.variables) {
            self.states[variable * keys + key] = place.value(|other| previous.states[variable * previous_keys + other]);
        }
    }

    /// Moves the values to the new places of the keys on adaptive meshes.
    pub(super) fn carry(&mut self, mesh: &mut MeshContinuation) {
        mesh.carry(&mut self.coefficients, |coefficient| coefficient);
        let keys = self.coefficients.len();
        if keys > 0 {
            self.states.chunks_mut(keys).for_each(|values| mesh.carry(values, |value| value));
        }
    }

    /// Sets the friction of the previous increment.
    pub(super) fn set_coefficients(&self, rows: &mut ContactRows, step: ContactStep<'_>) {
        for row in rows.rows.iter_mut().filter(|row| step.laws[row.law as usize].friction_routine.is_some()) {
            row.coefficient = self.coefficients[row.key as usize];
            let [_, shear] = step.pressures[row.key as usize];
            row.largest_shear = row.coefficient.is_finite().then_some(shear.abs() * step.span.half);
        }
    }

    /// Calls the subroutine for all points under pressure, and sets their friction coefficients. Returns whether one has
    /// changed. Equation (10.5c).
    ///
    /// # Errors
    /// If the subroutine fails, or returns an invalid force.
    pub(super) fn call(
        &mut self,
        rows: &mut ContactRows,
        scene: FrictionScene<'_>,
        input: &mut FrictionInput<'_>,
    ) -> Result<bool, HaltReason> {
        let mut changes = false;
        for (law, interaction) in (0..).zip(scene.step.laws) {
            let Some(routine) = interaction.friction_routine.as_deref() else { continue };
            let mut next = 0;
            while next < rows.rows.len() {
                next = self.gather(rows, scene, (law, routine), next);
                if self.block.rows.is_empty() {
                    continue;
                }
                let outcome = self.call_block(routine, scene, input);
                outcome.map_err(|failure| {
                    failure.halt(&format!("vfriction of `{}`", routine.interaction), &input.arrival)
                })?;
                changes |= self.apply_forces(rows, routine, scene.step.span.half);
            }
        }
        Ok(changes)
    }

    /// Gathers the arguments of at most [`MAX_BLOCK`] rows of a law from the row with index `from` on. Returns the index of
    /// the next row.
    fn gather(
        &mut self,
        rows: &ContactRows,
        scene: FrictionScene<'_>,
        (law, routine): (u32, &FrictionRoutine),
        from: usize,
    ) -> usize {
        self.block.clear();
        for (index, row) in rows.rows.iter().enumerate().skip(from) {
            if row.law != law || row.normal_impulse <= 0.0 || row.compliance[1] <= 0.0 {
                continue;
            }
            if self.block.rows.len() == MAX_BLOCK {
                return index;
            }
            self.block.rows.push(index as u32);
            self.add_point(rows, row, scene);
            let keys = self.coefficients.len();
            let states = (0..routine.variables).map(|variable| self.states[variable * keys + row.key as usize]);
            self.block.state.extend(states);
        }
        rows.rows.len()
    }

    /// Adds the arguments of the point of a row.
    fn add_point(&mut self, rows: &ContactRows, row: &ContactRow, scene: FrictionScene<'_>) {
        let FrictionScene { surfaces, dofs, step, .. } = scene;
        let (motion, point, block) = (&dofs.motion, self.points[row.key as usize], &mut self.block);
        let [rate, slip] = motion.rates(rows.terms_of(row));
        let free_slip = slip - row.compliance[1] * row.shear_impulse;
        let sign = if free_slip < 0.0 { -1.0 } else { 1.0 };
        let known_slip = if slip.abs() > STICKING_SLIP * free_slip.abs() { slip.abs() } else { free_slip.abs() };
        let to_force = row.area / step.span.half;
        let normal = normal_of(rows, row, dofs.of_points[point as usize], dofs);
        let tangent = [-normal[1], normal[0]];
        let place = surfaces.places[point as usize];
        let velocity_of = |dof: u32| if dof == NONE { 0.0 } else { motion.velocity[dof as usize] };
        let velocity = dofs.of_points[point as usize].inline_map(velocity_of);
        let opposite = |own: [f64; 2], along_normal: f64, along_surface: f64| {
            [0, 1]
                .inline_map(|axis| own[axis] - (along_normal * normal[axis] + along_surface * tangent[axis]) / row.area)
        };
        let vector = |[r, z]: [f64; 2]| [r, z, 0.0];
        block.nodes.push(self.numbers.get(point as usize).copied().unwrap_or_default());
        block.slip.extend(vector([known_slip / row.area * step.span.dt, 0.0]));
        block.stick.push(free_slip.abs() / row.compliance[1] * to_force);
        block.previous.extend(vector([sign * step.pressures[row.key as usize][1] * row.area, 0.0]));
        block.normal.push(row.normal_impulse * to_force);
        block.area.push(row.area);
        block.directions[0].extend(vector(normal));
        block.directions[1].extend(vector(tangent.inline_map(|along| sign * along)));
        block.coordinates[0].extend(vector(place));
        block.coordinates[1].extend(vector(opposite(place, row.gap, 0.0)));
        block.velocities[0].extend(vector(velocity));
        block.velocities[1].extend(vector(opposite(velocity, rate, slip)));
    }

    fn call_block(
        &mut self,
        routine: &FrictionRoutine,
        scene: FrictionScene<'_>,
        input: &mut FrictionInput<'_>,
    ) -> Result<(), LoadFailure> {
        let PointBlock {
            rows,
            nodes,
            stick,
            normal,
            area,
            slip,
            previous,
            directions,
            coordinates,
            velocities,
            forces,
            state,
        } = &mut self.block;
        forces.clear();
        forces.resize(TANGENTS * rows.len(), 0.0);
        let call = FrictionCall {
            interaction: &routine.interaction,
            now: input.arrival,
            dt: scene.step.span.dt,
            friction_work: scene.friction_work,
            variables: routine.variables,
            properties: &routine.properties,
            nodes,
            slip,
            stick,
            previous,
            normal,
            area,
            directions: [&directions[0], &directions[1]],
            coordinates: [&coordinates[0], &coordinates[1]],
            velocities: [&velocities[0], &velocities[1]],
        };
        input.routine.friction(&call, forces, state)?;
        for ((force, stick), node) in forces.chunks(TANGENTS).zip(&*stick).zip(&*nodes) {
            let component = usize::from(force[0] <= ROUNDING * stick);
            if component == 0 || force[1] != 0.0 {
                let allowed = ["between -fStickForce and 0", "0: there is no motion along the hoop"][component];
                let number = component + 1;
                let found =
                    format!("fTangential({number}) of the contact point at node {node} to {}", force[component]);
                return Err(LoadFailure::new(format!("it set {found}; it must be {allowed}")));
            }
        }
        match state.iter().position(|value| !value.is_finite()) {
            Some(at) => {
                let (variable, node) = (at % routine.variables + 1, nodes[at / routine.variables]);
                Err(LoadFailure::new(format!("it set state variable {variable} at node {node} to {}", state[at])))
            }
            None => Ok(()),
        }
    }

    /// Sets the friction limits from the forces of a call, and stores the state variables. Returns whether a limit has
    /// changed. Friction falls with the normal force, but does not exceed the force of the subroutine.
    fn apply_forces(&mut self, rows: &mut ContactRows, routine: &FrictionRoutine, half: f64) -> bool {
        let (keys, mut changes) = (self.coefficients.len(), false);
        for (point, &index) in self.block.rows.iter().enumerate() {
            let row = &mut rows.rows[index as usize];
            let (limit, stick) = (-self.block.forces[TANGENTS * point], self.block.stick[point]);
            let sticks = limit >= (1.0 - ROUNDING) * stick;
            let coefficient = if sticks { f64::INFINITY } else { limit.max(0.0) / self.block.normal[point] };
            let largest = (!sticks).then_some(limit.max(0.0) * half / row.area);
            changes |= coefficient != row.coefficient || largest != row.largest_shear;
            (row.coefficient, row.largest_shear) = (coefficient, largest);
            self.coefficients[row.key as usize] = coefficient;
            for variable in 0..routine.variables {
                self.states[variable * keys + row.key as usize] =
                    self.block.state[point * routine.variables + variable];
            }
        }
        changes
    }
}

/// Returns the unit normal of the opposite surface at the point of a row, from the derivatives of the gap. The point of a
/// rigid body has no degree of freedom along r; the sum of the derivatives along r over all other points is then opposite.
fn normal_of(rows: &ContactRows, row: &ContactRow, [r, z]: [u32; 2], dofs: &ContactDofs) -> [f64; 2] {
    let terms = rows.terms_of(row);
    let of_dof = |dof: u32| terms.iter().filter(|term| term.dof == dof).map(|term| term.normal).sum::<f64>();
    let is_radial = |dof: u32| matches!(dofs.list[dof as usize].0, Dof::Node(_, 0));
    let along_r = match r {
        NONE => -terms.iter().filter(|term| is_radial(term.dof)).map(|term| term.normal).sum::<f64>(),
        _ => of_dof(r),
    };
    let along_z = of_dof(z);
    let length = libm::hypot(along_r, along_z);
    if length > 0.0 { [along_r / length, along_z / length] } else { [0.0; 2] }
}
