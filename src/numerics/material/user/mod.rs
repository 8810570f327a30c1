//! Materials whose stress, yield stress or fields are computed by user subroutines (VUMAT, VUANISOHYPER_INV, VUHARD,
//! VUSDFLD): the state of their elements and its conversion to the arguments of a call.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

pub mod description;
pub mod energy;
pub mod flow;
pub mod lengths;
pub mod points;

use super::increment::{LEAST_MODULUS, StrainIncrement, StressUpdate};
use super::{BlockStart, Material, PlasticFlow, PointValue};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, dot, inline_from_fn};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::quad::{CornerGradient, gradient};
use crate::kernel::rotation::{polar_decomposition, rotate, rotation_of_spin};
use crate::kernel::stress::mises;
use crate::kernel::topology::PerNode;
use crate::material::carried::{ArrivedElement, carried_state};
use crate::platform::PortableMath as _;
use crate::routines::{LoadFailure, MAX_MATERIAL_BLOCK, PointRoutines};
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};
use description::UserMaterialData;
use flow::{PointContext, ReturnScratch};
use points::{PointAccess, PointArguments};

/// Number of element blocks per call.
pub const CALL_BLOCKS: usize = MAX_MATERIAL_BLOCK / LANES;

/// A material that calls user subroutines at its points. With `FLOWS` elasticity and the return to the yield surface are
/// built in, and its axes rotate with the spin of the material (Jaumann rate), as those of other built-in laws. Otherwise
/// the subroutine computes the stress, or with `ENERGY` the derivatives of a strain energy, and its axes rotate by R of the polar
/// decomposition `F = R U` (Green-Naghdi rate).
pub struct SubroutineMaterial<const FLOWS: bool, const ENERGY: bool = false> {
    /// Data that the deck defines for the subroutine.
    pub description: UserMaterialData,
    /// Names of the elements, for messages.
    pub names: Vec<String>,
    /// Number of nodes of an element that VUCHARLENGTH receives.
    pub nodes: usize,
}

/// State of a block. Tensors have the components rr, zz, hoop, rz in the rotated axes of [`SubroutineMaterial`].
#[derive(Clone, Debug, Persist)]
#[persist(
    fixed: variables, field, moduli, plastic;
    present: transported;
    derived: numbers, start, has_nodal_temperature, nodal_field, flowed, dissipated
)]
pub struct UserState {
    /// The user's numbers of the elements.
    numbers: [i32; LANES],
    /// Initial geometry and masses. Densities and specific energies are those of the material, regardless of mass
    /// scaling.
    start: [CornerGradient; LANES],
    mass: Lanes,
    /// `None` without adaptive mesh.
    transported: Option<Box<TransportedReference>>,
    /// Cosine and sine of the rotation angle of the axes.
    turn: [Lanes; 2],
    deleted: [bool; LANES],
    /// Thermal strain that the next increment subtracts.
    thermal: Lanes,
    /// Centre `[r, z]`, characteristic length, density.
    place: [Lanes; 4],
    /// Values at the end of the increment.
    stress: [Lanes; 4],
    stretch: [Lanes; 4],
    gradient: [Lanes; 5],
    /// Temperatures, and nodal temperatures at the end of the increment where prescribed.
    temperature: [Lanes; 2],
    has_nodal_temperature: bool,
    variables: Vec<Lanes>,
    /// Field variables, and their nodal values.
    field: Vec<Lanes>,
    nodal_field: Vec<Lanes>,
    /// Bulk and shear modulus, for a strain energy the moduli of the fastest wave and of shear: NaN before the first increment,
    /// empty if they are constant.
    moduli: Vec<Lanes>,
    /// Equivalent plastic strain and its increment; empty if the subroutine computes the stress.
    plastic: Vec<Lanes>,
    flowed: Lanes,
    internal: Lanes,
    inelastic: Lanes,
    /// Inelastic energy per mass in this increment.
    dissipated: Lanes,
}

/// Configuration of each element at its last transport, to which its deformation refers from then on; the initial one
/// before.
#[derive(Clone, Debug, Persist)]
struct TransportedReference {
    start: [CornerGradient; LANES],
    /// Deformation gradient of the material in the element at that time (rr, zz, hoop, rz, zr).
    gradient: [Lanes; 5],
}

/// Kinematics of a block, as arguments of a call.
pub struct BlockKinematics<'a> {
    /// Strain increments rr, zz, hoop, rz (tensor shear).
    pub strain: [Lanes; 4],
    /// Spin increments in the (r, z) plane.
    pub spin: Lanes,
    /// Volumes in the middle of the increment; 0 for lanes without element.
    pub volume: Lanes,
    /// Deformation gradients (rr, zz, hoop, rz, zr); `None` if they follow from the corners.
    pub gradient: Option<&'a [Lanes; 5]>,
    /// Returns the corners `[r, z]` of a lane: of the element, or of its part around an integration point.
    pub corners: &'a dyn Fn(usize) -> [[f64; 4]; 2],
    /// Returns the nodes of the element of a lane, in the order of its topology.
    pub nodes: &'a dyn Fn(usize) -> PerNode<[f64; 2]>,
    /// Whether the update is that at the start, in which no routine is called.
    pub starts: bool,
}

/// Instant and increment length, as arguments of a call.
#[derive(Clone, Copy)]
pub struct CallTime<'a> {
    /// Time, step and increment.
    pub now: &'a Instant,
    pub dt: f64,
}

/// Materials with calls of user subroutines between the kinematics and the stresses of their elements.
pub trait PointCalls<S>: Send + Sync {
    /// Creates the arguments of a call for `count` points, which are the integration points of this number, from 1, of
    /// their elements.
    fn arguments(&self, count: usize, integration_point: usize) -> PointArguments;

    /// Creates the work arrays of the calls.
    fn scratch(&self) -> ReturnScratch;

    /// Copies the state of block number `block` of the call to the arguments.
    fn gather(&self, points: &mut PointArguments, block: usize, state: &mut S, kinematics: &BlockKinematics<'_>);

    /// Calls the subroutines. An increment of zero length changes nothing.
    ///
    /// # Errors
    /// Errors of the subroutines, and invalid results.
    fn call(
        &self,
        points: &mut PointArguments,
        user: PointRoutines<'_>,
        time: CallTime<'_>,
        access: &dyn PointAccess,
        returning: &mut ReturnScratch,
    ) -> Result<(), LoadFailure>;

    /// Calls the subroutine with small fictitious strains. Returns the bulk and shear modulus of its response, the
    /// maximum over all points; `None` if the moduli are known.
    ///
    /// # Errors
    /// Errors of the subroutine, and a response that is not elastic.
    fn probe(
        &self,
        points: &mut PointArguments,
        user: PointRoutines<'_>,
        now: &Instant,
    ) -> Result<Option<[f64; 2]>, LoadFailure>;

    /// Copies the results to the state of a block.
    fn scatter(&self, points: &PointArguments, block: usize, state: &mut S);

    /// Returns the name of the material, and of an element by its index in the group.
    fn names(&self, element: Option<usize>) -> (&str, Option<&str>);

    fn fields(&self) -> usize;

    fn bytes(&self) -> usize;
}

impl<const FLOWS: bool, const ENERGY: bool> Material for SubroutineMaterial<FLOWS, ENERGY> {
    type State = UserState;
    const FLOW: PlasticFlow = if FLOWS {
        PlasticFlow::Deviatoric
    } else if ENERGY {
        PlasticFlow::None
    } else {
        PlasticFlow::Unknown
    };
    const MODULI_VARY: bool = ENERGY;
    const OF_GRADIENT: bool = ENERGY;
    const FAILS: bool = true;
    const USES_SPIN: bool = true;
    const CALLS: bool = true;

    fn initial_state(&self, start: &BlockStart) -> UserState {
        let material = &self.description;
        let (zero, unity) = ([0.0; LANES], [1.0; LANES]);
        let varies = ENERGY || material.flow.as_ref().is_some_and(|flow| flow.elasticity.is_some());
        let mut state = UserState {
            numbers: inline_from_fn(|l| {
                let name = self.names.get(start.first + l.min(start.count - 1));
                name.map_or(0, |name| lengths::user_number(name))
            }),
            start: inline_from_fn(|l| {
                let [r, z] = start.corners[l];
                gradient(r, z)
            }),
            mass: start.volume.inline_map(|volume| material.density * volume),
            transported: None,
            turn: [unity, zero],
            deleted: [false; LANES],
            thermal: zero,
            place: [zero; 4],
            stress: [zero; 4],
            stretch: [unity, unity, unity, zero],
            gradient: [unity, unity, unity, zero, zero],
            temperature: [zero; 2],
            has_nodal_temperature: false,
            variables: vec![zero; material.variables],
            field: vec![zero; material.fields],
            nodal_field: vec![zero; material.fields],
            moduli: vec![[f64::NAN; LANES]; if varies { 2 } else { 0 }],
            plastic: vec![zero; usize::from(FLOWS)],
            flowed: zero,
            internal: zero,
            inelastic: zero,
            dissipated: zero,
        };
        if let Some(delete) = material.delete {
            state.variables[delete] = unity;
        }
        state
    }

    /// Sets the stress to that of the subroutine, and adds its work.
    fn update(
        &self,
        state: &mut UserState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        for l in 0..strain.count {
            self.delete(state, update, l);
            let new = components(column(&state.stress, l), state.rotation(l));
            let previous = if ENERGY { &*stress } else { &strain.carried };
            let double = |k: usize| strain.strain[k][l] * (previous[k][l] + new[k]);
            let work = 0.5 * strain.volume[l] * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            if strain.volume[l] != 0.0 {
                update.internal[l] += work;
                update.dissipated[l] += state.mass[l] * state.dissipated[l];
            }
            stress.iter_mut().zip(new).for_each(|(list, value)| list[l] = value);
        }
        if ENERGY {
            return state.set_moduli(strain, update);
        }
        if !state.moduli.is_empty() {
            // With varying moduli, the direction of plastic flow is that of the stress, not of a trial with the largest
            // moduli.
            for l in 0..LANES {
                let stress = column(stress, l);
                let mean = (stress[0] + stress[1] + stress[2]) * (1.0 / 3.0);
                for (k, list) in update.deviator.iter_mut().enumerate() {
                    list[l] = if k < 3 { stress[k] - mean } else { stress[k] };
                }
            }
        }
        for l in 0..LANES {
            let trial = mises(column(&update.deviator, l));
            update.trial[l] = trial;
            update.flow[l] = if FLOWS && !state.deleted[l] { state.flowed[l] } else { 0.0 };
            // A ratio within rounding of 1 is set to 1.
            let ratio = mises(column(stress, l)) / trial;
            update.returned[l] = if ratio < 1.0 - 1e-12 { ratio } else { 1.0 };
        }
    }

    fn share(&self, state: &UserState, lane: usize) -> f64 {
        if state.deleted[lane] { 0.0 } else { 1.0 }
    }

    fn can_delete(&self) -> bool {
        self.description.delete.is_some()
    }

    fn initial_volume(&self, state: &UserState, lane: usize) -> f64 {
        state.mass[lane] / self.description.density
    }

    fn value(&self, state: &UserState, lane: usize, part: VariableComponent) -> Option<f64> {
        match part.variable {
            Variable::Temperature => Some(state.temperature[0][lane]),
            Variable::State => Some(state.variables.get(part.component)?[lane]),
            Variable::Status => Some(self.share(state, lane)),
            Variable::PlasticStrain => Some(state.plastic.first()?[lane]),
            Variable::ElementPlasticEnergy if !FLOWS => Some(state.mass[lane] * state.inelastic[lane]),
            _ => None,
        }
    }

    fn set(&self, state: &mut UserState, lane: usize, value: PointValue) -> bool {
        let put = |list: Option<&mut Lanes>, value: f64| list.map(|list| list[lane] = value).is_some();
        match value {
            PointValue::Stress(_) if ENERGY => false,
            PointValue::Stress(stress) => {
                state.stress.iter_mut().zip(stress).for_each(|(list, value)| list[lane] = value);
                true
            }
            PointValue::Temperature(value) => {
                state.temperature.iter_mut().for_each(|list| list[lane] = value);
                true
            }
            PointValue::NodalTemperature(value) => {
                state.has_nodal_temperature = true;
                put(state.temperature.last_mut(), value)
            }
            PointValue::PlasticStrain(value) => put(state.plastic.first_mut(), value),
            PointValue::StateVariable(variable, value) => put(state.variables.get_mut(variable), value),
            PointValue::Field(variable, value) => {
                put(state.field.get_mut(variable), value) && put(state.nodal_field.get_mut(variable), value)
            }
            PointValue::NodalField(variable, value) => put(state.nodal_field.get_mut(variable), value),
            PointValue::ThermalStrain(strain) => {
                state.thermal[lane] += strain;
                true
            }
            PointValue::SpecificEnergy(_)
            | PointValue::Length(..)
            | PointValue::VolumeRatio(_)
            | PointValue::MassScale(_) => false,
        }
    }

    /// Moduli that vary refer to the previous increment of their element.
    fn can_be_carried(&self) -> bool {
        self.description.flow.as_ref().is_none_or(|flow| flow.elasticity.is_none())
    }

    fn prepare_transport(&self, state: &mut UserState) {
        let (start, gradient) = (&state.start, state.gradient);
        state.transported.get_or_insert_with(|| Box::new(TransportedReference { start: *start, gradient }));
    }

    fn arrive(&self, state: &mut UserState, lane: usize, element: &ArrivedElement) {
        state.arrive(lane, element, FLOWS);
    }

    fn calls(&self) -> Option<&dyn PointCalls<UserState>> {
        Some(self)
    }

    fn bytes(&self, state: &UserState) -> usize {
        let UserState { variables, field, nodal_field: given, moduli, plastic, transported, .. } = state;
        let lists: usize =
            [variables, field, given, moduli, plastic].inline_map(|lists| size_of_val(&**lists)).iter().sum();
        lists + transported.as_deref().map_or(0, size_of_val)
    }
}

impl<const FLOWS: bool, const ENERGY: bool> SubroutineMaterial<FLOWS, ENERGY> {
    /// Deletes a point whose deletion variable is zero.
    fn delete(&self, state: &mut UserState, update: &mut StressUpdate, l: usize) {
        let Some(variable) = self.description.delete else { return };
        if state.variables[variable][l] == 0.0 && !state.deleted[l] {
            state.deleted[l] = true;
            update.deleted += 1;
        }
        if state.deleted[l] {
            state.variables[variable][l] = 0.0;
            state.stress.iter_mut().for_each(|list| list[l] = 0.0);
        }
    }
}

impl UserState {
    /// Sets the moduli of a strain energy, that of the fastest wave without 4/3 of the shear modulus of the elements. A softening
    /// material keeps a finite stable time increment.
    fn set_moduli(&self, strain: &StrainIncrement, update: &mut StressUpdate) {
        let ElasticModuli { bulk, shear } = strain.moduli;
        let known = 4.0 / 3.0 * shear;
        for l in 0..LANES {
            let [modulus, of_shear] = [self.moduli[0][l], self.moduli[1][l]];
            // Before the first increment the moduli are those of the initial configuration.
            let [modulus, of_shear] = if modulus.is_nan() { [bulk + known, shear] } else { [modulus, of_shear] };
            update.bulk[l] = modulus.max(LEAST_MODULUS * (bulk + known)) - known;
            update.shear[l] = of_shear.max(LEAST_MODULUS * shear);
        }
    }

    /// Updates the geometry of a lane with an element.
    fn take_geometry(&mut self, l: usize, kinematics: &BlockKinematics<'_>) {
        let [r, z] = (kinematics.corners)(l);
        let gradient = match kinematics.gradient {
            Some(gradient) => gradient.inline_map(|list| list[l]),
            None => self.gradient_of_corners(l, r, z),
        };
        let [centre_r, centre_z] = lengths::middle(r, z);
        let geometry = [centre_r, centre_z, lengths::by_default(r, z), self.mass[l] / kinematics.volume[l]];
        self.place.iter_mut().zip(geometry).for_each(|(list, value)| list[l] = value);
        self.gradient.iter_mut().zip(gradient).for_each(|(list, value)| list[l] = value);
        let (stretch, _) = polar_decomposition(gradient);
        self.stretch.iter_mut().zip(stretch).for_each(|(list, value)| list[l] = value);
    }

    /// Returns the deformation gradient of a lane from the corners of its element. Equation (18.9).
    fn gradient_of_corners(&self, l: usize, r: [f64; 4], z: [f64; 4]) -> [f64; 5] {
        let start = self.transported.as_ref().map_or(&self.start[l], |reference| &reference.start[l]);
        let per = 1.0 / start.volume;
        let CornerGradient { r: by_r, z: by_z, hoop, .. } = *start;
        let gradient = [dot(by_r, r), dot(by_z, z), dot(hoop, r), dot(by_z, r), dot(by_r, z)].inline_map(|x| per * x);
        match &self.transported {
            Some(reference) => product(gradient, reference.gradient.inline_map(|list| list[l])),
            None => gradient,
        }
    }

    /// Makes the configuration of a transported element that to which its deformation refers, and finds its stress in its
    /// rotated axes: those of the transported deformation gradient, or of the transported rotation if the axes follow the
    /// spin (`spins`).
    fn arrive(&mut self, l: usize, element: &ArrivedElement, spins: bool) {
        self.mass[l] = element.mass;
        let gradient_now = self.gradient.inline_map(|list| list[l]);
        if let Some(reference) = &mut self.transported {
            let [r, z] = [0, 1].inline_map(|axis: usize| element.corners.inline_map(|place| place[axis]));
            reference.start[l] = gradient(r, z);
            reference.gradient.iter_mut().zip(gradient_now).for_each(|(list, value)| list[l] = value);
        }
        let (stretch, rotation) = polar_decomposition(gradient_now);
        self.stretch.iter_mut().zip(stretch).for_each(|(list, value)| list[l] = value);
        let [cosine, sine] = self.rotation(l);
        let length = cosine.portable_hypot(sine);
        if !spins {
            self.set_rotation(l, rotation);
        } else if length > 0.0 {
            self.set_rotation(l, [cosine / length, sine / length]);
        }
        let stress = components(element.stress, inverse(self.rotation(l)));
        self.stress.iter_mut().zip(stress).for_each(|(list, value)| list[l] = value);
    }

    /// Returns cosine and sine of the rotation of the axes of a lane.
    fn rotation(&self, l: usize) -> [f64; 2] {
        [self.turn[0][l], self.turn[1][l]]
    }

    fn set_rotation(&mut self, l: usize, rotation: [f64; 2]) {
        self.turn.iter_mut().zip(rotation).for_each(|(list, value)| list[l] = value);
    }

    /// Returns the strain increments of a lane without thermal strain, which they subtract once. That of a temperature which
    /// differs from the initial one at the start is subtracted in the first increment.
    fn mechanical_strain(&mut self, l: usize, kinematics: &BlockKinematics<'_>) -> [f64; 4] {
        let mut increment = column(&kinematics.strain, l);
        if kinematics.starts {
            return increment;
        }
        increment[..3].iter_mut().for_each(|strain| *strain -= self.thermal[l]);
        self.thermal[l] = 0.0;
        increment
    }

    /// Rotates the axes with the spin. Returns the strain increments in the axes after the increment.
    fn rotate_with_spin(&mut self, kinematics: &BlockKinematics<'_>) -> [Lanes; 4] {
        let mut rotated = [[0.0; LANES]; 4];
        for l in 0..LANES {
            let [c, s] = rotation_of_spin(kinematics.spin[l]);
            let [cosine, sine] = self.rotation(l);
            self.set_rotation(l, [cosine * c - sine * s, sine * c + cosine * s]);
            let strain = components(self.mechanical_strain(l, kinematics), inverse(self.rotation(l)));
            rotated.iter_mut().zip(strain).for_each(|(list, value)| list[l] = value);
        }
        rotated
    }

    /// Rotates the axes by R of the deformation gradient, which was `before` at the start of the increment. Returns the
    /// strain increments, and the spin (zr) relative to the axes. The strain increments refer to the axes in the middle of
    /// the increment, where the deformation gradient is the mean of both.
    fn rotate_with_material(&mut self, before: &[Lanes; 5], kinematics: &BlockKinematics<'_>) -> ([Lanes; 4], Lanes) {
        let (mut rotated, mut relative) = ([[0.0; LANES]; 4], [0.0; LANES]);
        for l in 0..LANES {
            let middle = |k: usize| 0.5 * (before[k][l] + self.gradient[k][l]);
            let (_, rotation) = polar_decomposition([0, 1, 2, 3, 4].inline_map(middle));
            let strain = components(self.mechanical_strain(l, kinematics), inverse(rotation));
            rotated.iter_mut().zip(strain).for_each(|(list, value)| list[l] = value);
            let (_, new) = polar_decomposition(self.gradient.inline_map(|list| list[l]));
            let [cosine, sine] = self.rotation(l);
            let (along, across) = (new[0] * cosine + new[1] * sine, new[1] * cosine - new[0] * sine);
            // Twice the tangent of half the angle, as in the rotation of a spin.
            relative[l] = 2.0 * across / (1.0 + along) - kinematics.spin[l];
            self.set_rotation(l, new);
        }
        (rotated, relative)
    }
}

/// Returns the product of two deformation gradients (rr, zz, hoop, rz, zr), the second of which is applied first.
fn product(later: [f64; 5], first: [f64; 5]) -> [f64; 5] {
    let ([rr, zz, hoop, rz, zr], [f_rr, f_zz, f_hoop, f_rz, f_zr]) = (later, first);
    [rr * f_rr + rz * f_zr, zr * f_rz + zz * f_zz, hoop * f_hoop, rr * f_rz + rz * f_zz, zr * f_rr + zz * f_zr]
}

/// Returns the components of a tensor in rotated axes. A rotation of zero changes nothing, not even the sign of zeros.
fn components(tensor: [f64; 4], [cosine, sine]: [f64; 2]) -> [f64; 4] {
    rotate(tensor, if sine == 0.0 { [1.0, 0.0] } else { [cosine, sine] })
}

/// Returns the inverse of a rotation.
fn inverse([cosine, sine]: [f64; 2]) -> [f64; 2] {
    [cosine, -sine]
}

/// Copies the lanes of a block to arrays of one component each, for the points that exist.
fn put(list: &mut [f64], (count, first): (usize, usize), lanes: &[Lanes]) {
    let points = LANES.min(count - first);
    for (list, lanes) in list.chunks_mut(count).zip(lanes) {
        list[first..first + points].copy_from_slice(&lanes[..points]);
    }
}

/// Copies arrays of one component each back to the lanes of a block, for the points that exist.
fn take(list: &[f64], (count, first): (usize, usize), lanes: &mut [Lanes]) {
    let points = LANES.min(count - first);
    for (list, lanes) in list.chunks(count).zip(lanes) {
        lanes[..points].copy_from_slice(&list[first..first + points]);
    }
}

impl<const FLOWS: bool, const ENERGY: bool> PointCalls<UserState> for SubroutineMaterial<FLOWS, ENERGY> {
    fn arguments(&self, count: usize, integration_point: usize) -> PointArguments {
        PointArguments::new(&self.description, (count, integration_point), self.nodes)
    }

    fn scratch(&self) -> ReturnScratch {
        ReturnScratch::new(&self.description)
    }

    fn gather(
        &self,
        points: &mut PointArguments,
        block: usize,
        state: &mut UserState,
        kinematics: &BlockKinematics<'_>,
    ) {
        let (first, count) = (block * LANES, points.count);
        let position = (count, first);
        // Values before the increment.
        put(&mut points.stretch[0], position, &state.stretch);
        put(&mut points.gradient[0], position, &state.gradient);
        let gradient_before = state.gradient;
        for l in 0..LANES.min(count - first) {
            points.elements[first + l] = state.numbers[l];
            // A lane whose element was deleted by another criterion (`*EROSION`) has no volume.
            state.deleted[l] |= kinematics.volume[l] == 0.0;
            if !state.deleted[l] {
                state.take_geometry(l, kinematics);
                points.show_nodes(first + l, || (kinematics.nodes)(l));
            }
        }
        let strain = if FLOWS {
            state.rotate_with_spin(kinematics)
        } else {
            let (strain, spin) = state.rotate_with_material(&gradient_before, kinematics);
            put(&mut points.spin, position, std::slice::from_ref(&spin));
            strain
        };
        put(&mut points.strain, position, &strain);
        put(&mut points.coordinates, position, &state.place[..2]);
        put(&mut points.length, position, &state.place[2..3]);
        put(&mut points.density, position, &state.place[3..]);
        put(&mut points.stretch[1], position, &state.stretch);
        put(&mut points.gradient[1], position, &state.gradient);
        put(&mut points.stress[0], position, &state.stress);
        put(&mut points.state[0], position, &state.variables);
        put(&mut points.internal[0], position, std::slice::from_ref(&state.internal));
        put(&mut points.inelastic[0], position, std::slice::from_ref(&state.inelastic));
        put(&mut points.field[0], position, &state.field);
        put(&mut points.field[1], position, &state.nodal_field);
        for (list, moduli) in points.moduli.iter_mut().zip(&state.moduli) {
            put(list, position, std::slice::from_ref(moduli));
        }
        put(&mut points.plastic[0], position, &state.plastic);
        let [old, nodal] = &state.temperature;
        put(&mut points.temperature[0], position, std::slice::from_ref(old));
        put(
            &mut points.temperature[1],
            position,
            std::slice::from_ref(if state.has_nodal_temperature { nodal } else { old }),
        );
        state.has_nodal_temperature = false;
    }

    fn call(
        &self,
        points: &mut PointArguments,
        user: PointRoutines<'_>,
        CallTime { now, dt }: CallTime<'_>,
        access: &dyn PointAccess,
        returning: &mut ReturnScratch,
    ) -> Result<(), LoadFailure> {
        let material = &self.description;
        if dt == 0.0 {
            points.keep();
            return Ok(());
        }
        if let (Some(properties), Some(routine)) = (&material.length_constants, user.lengths) {
            points.call_lengths(material, properties, routine, (now, dt))?;
        }
        if let (Some(properties), Some(routine)) = (&material.field_constants, user.fields) {
            points.call_fields(material, properties, routine, access, (now, dt))?;
        }
        if let Some(flow) = &material.flow {
            let context = PointContext { material, flow, heating: &material.heating, now, dt };
            return points.flow(context, user.hardening, returning);
        }
        if let Some(energy) = &material.energy {
            return points.call_energy((material, energy), user.energy, (now, dt));
        }
        let Some(routine) = user.material else { return Ok(()) };
        points.call(material, routine, now, dt)?;
        if !material.heating.is_none() {
            points.heat(&material.heating);
        }
        Ok(())
    }

    fn probe(
        &self,
        points: &mut PointArguments,
        user: PointRoutines<'_>,
        now: &Instant,
    ) -> Result<Option<[f64; 2]>, LoadFailure> {
        let material = &self.description;
        if FLOWS {
            return Ok(None);
        }
        if let (Some(properties), Some(routine)) = (&material.length_constants, user.lengths) {
            points.call_lengths(material, properties, routine, (now, 0.0))?;
        }
        if let Some(energy) = &material.energy {
            return points.probe_energy((material, energy), user.energy, now).map(Some);
        }
        let Some(routine) = user.material else { return Ok(None) };
        points.show_fictitious();
        points.call(material, routine, now, 1.0)?;
        points.moduli().map(Some)
    }

    fn scatter(&self, points: &PointArguments, block: usize, state: &mut UserState) {
        let (first, count) = (block * LANES, points.count);
        let position = (count, first);
        for l in 0..LANES.min(count - first) {
            state.dissipated[l] = points.dissipated(first + l);
            state.flowed[l] = if FLOWS { points.plastic[1][first + l] - points.plastic[0][first + l] } else { 0.0 };
        }
        take(&points.stress[1], position, &mut state.stress);
        take(&points.state[1], position, &mut state.variables);
        take(&points.internal[1], position, std::slice::from_mut(&mut state.internal));
        take(&points.inelastic[1], position, std::slice::from_mut(&mut state.inelastic));
        take(&points.field[1], position, &mut state.field);
        for (list, moduli) in points.moduli.iter().zip(&mut state.moduli) {
            take(list, position, std::slice::from_mut(moduli));
        }
        take(&points.plastic[1], position, &mut state.plastic);
        take(&points.temperature[1], position, &mut state.temperature[..1]);
    }

    fn names(&self, element: Option<usize>) -> (&str, Option<&str>) {
        (&self.description.name, element.and_then(|e| self.names.get(e)).map(String::as_str))
    }

    fn fields(&self) -> usize {
        self.description.fields
    }

    fn bytes(&self) -> usize {
        self.names.iter().map(|name| size_of_val(name) + name.capacity()).sum()
    }
}

// The stress in rotated axes follows from that in global axes.
carried_state!(UserState { turn, gradient, temperature, variables, field, nodal_field, plastic, internal, inelastic } stay {
    numbers, start, mass, transported, deleted, thermal, place, stress, stretch, has_nodal_temperature, moduli, flowed,
    dissipated
});
