//! Arguments and results of user material subroutines, for the points of several blocks, one component of all points
//! after the other.

use super::description::UserMaterialData;
use super::energy::EnergyArguments;
use super::lengths::{ShownElements, above_zero};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::InlineMap;
use crate::kernel::rotation::polar_decomposition;
use crate::kernel::topology::PerNode;
use crate::routines::{
    FieldAnswer, FieldCall, LengthCall, LoadFailure, MaterialAnswer, MaterialCall, PointValues, UserFields,
    UserLengths, UserMaterial, bounds_advice, host,
};
use crate::state::Instant;
use crate::variables::{Variable, VariableComponent};

/// Number of guard values after each result, which a subroutine must not change.
const GUARD: usize = 8;
/// Number of guard values per point after stresses and state variables: components that do not exist, which a subroutine
/// can write if it declares the array with `*`.
const GUARD_COMPONENTS: usize = 16;
/// Number of guard components whose values are all checked; of the other guard components two values each are checked.
pub(super) const CHECKED_COMPONENTS: usize = 4;
/// Number of tensor components of three-dimensional solids that axisymmetric solids lack. They are allocated, so that a
/// subroutine for three dimensions only is detected without damage.
const SPARE: usize = 2;
/// Bit pattern of the guard values, a NaN.
const MARK: u64 = 0x7ff8_5afe_0000_5afe;
/// Fictitious strains of the call at time zero: dilation and shear, far below yield.
const FICTITIOUS: [f64; 4] = [2e-7, -0.5e-7, 1e-7, 0.75e-7];

/// Values before and after an increment.
type OldAndNew = [Vec<f64>; 2];

/// Arguments and results of one call, in the order of Fortran arrays; index 0 of a pair is before the increment, 1
/// after it.
#[derive(Clone, Debug)]
pub struct PointArguments {
    pub(super) count: usize,
    /// Number of the integration points, from 1.
    pub(super) integration_point: usize,
    pub(super) variables: usize,
    pub(super) fields: usize,
    /// Element numbers of the user.
    pub(super) elements: Vec<i32>,
    pub(super) coordinates: Vec<f64>,
    pub(super) length: Vec<f64>,
    /// Nodes of the elements, if VUCHARLENGTH is called.
    shown: Option<ShownElements>,
    pub(super) density: Vec<f64>,
    pub(super) strain: Vec<f64>,
    pub(super) spin: Vec<f64>,
    pub(super) temperature: OldAndNew,
    pub(super) stretch: OldAndNew,
    pub(super) gradient: OldAndNew,
    pub(super) stress: OldAndNew,
    pub(super) state: OldAndNew,
    pub(super) field: OldAndNew,
    /// Bulk and shear modulus, for a strain energy the moduli of the fastest wave and of shear: NaN before the first increment,
    /// empty if they are constant.
    pub(super) moduli: OldAndNew,
    pub(super) internal: OldAndNew,
    pub(super) inelastic: OldAndNew,
    /// Equivalent plastic strain; empty if the subroutine computes the stress.
    pub(super) plastic: OldAndNew,
    /// Invariants and derivatives of a strain energy of invariants.
    pub(super) energy: Option<Box<EnergyArguments>>,
    /// Whether a warning about a state variable that is not finite was given.
    warned: bool,
}

/// Returns an array of zeros, followed by guard values.
fn guarded(length: usize) -> Vec<f64> {
    std::iter::repeat_n(0.0, length).chain(guard_values(0)).collect()
}

/// Returns two arrays of zeros with so many components of `count` points, followed by guard values.
fn guarded_components(components: usize, count: usize) -> OldAndNew {
    let list: Vec<f64> =
        std::iter::repeat_n(0.0, components * count).chain(guard_values(GUARD_COMPONENTS * count)).collect();
    [list.clone(), list]
}

fn pair(length: usize) -> OldAndNew {
    [guarded(length), guarded(length)]
}

impl PointArguments {
    /// Allocates the arguments for `count` integration points of one number, in elements of so many nodes.
    pub fn new(material: &UserMaterialData, (count, integration_point): (usize, usize), nodes: usize) -> Self {
        let (variables, fields) = (material.variables, material.fields);
        let flows = if material.flow.is_some() { count } else { 0 };
        let varies = material.flow.as_ref().is_some_and(|f| f.elasticity.is_some()) || material.energy.is_some();
        let varying = if varies { count } else { 0 };
        let mut points = PointArguments {
            count,
            integration_point,
            variables,
            fields,
            elements: vec![0; count],
            coordinates: vec![f64::NAN; 3 * count],
            length: guarded(count),
            shown: material.length_constants.as_ref().map(|_| ShownElements::new(count, nodes)),
            density: vec![0.0; count],
            strain: vec![0.0; (4 + SPARE) * count],
            spin: vec![0.0; count],
            temperature: [vec![0.0; count], vec![0.0; count]],
            stretch: pair(4 * count),
            gradient: pair(5 * count),
            stress: guarded_components(4 + SPARE, count),
            state: guarded_components(variables, count),
            field: guarded_components(fields, count),
            moduli: [vec![f64::NAN; varying], vec![f64::NAN; varying]],
            internal: pair(count),
            inelastic: pair(count),
            plastic: [vec![0.0; flows], vec![0.0; flows]],
            energy: material.energy.as_ref().map(|energy| Box::new(EnergyArguments::new(energy, count))),
            warned: false,
        };
        points.coordinates[2 * count..].fill(f64::NAN);
        points
    }

    /// Sets the nodes of a point's element, if VUCHARLENGTH is called.
    pub(super) fn show_nodes(&mut self, point: usize, nodes: impl FnOnce() -> PerNode<[f64; 2]>) {
        if let Some(shown) = &mut self.shown {
            shown.set(point, &nodes());
        }
    }

    /// Sets the fictitious strains of the call at time zero and the consistent deformation gradient and stretch;
    /// subroutines differ in which of the three they use.
    pub fn show_fictitious(&mut self) {
        for (list, value) in self.strain.chunks_mut(self.count).zip(FICTITIOUS) {
            list.fill(value);
        }
        let [rr, zz, hoop, rz] = FICTITIOUS;
        let gradient = [1.0 + rr, 1.0 + zz, 1.0 + hoop, rz, rz];
        let (stretch, _) = polar_decomposition(gradient);
        for (list, value) in self.gradient[1].chunks_mut(self.count).zip(gradient) {
            list.fill(value);
        }
        for (list, value) in self.stretch[1].chunks_mut(self.count).zip(stretch) {
            list.fill(value);
        }
    }

    /// Returns the bulk and shear modulus of the response to the fictitious strains, the maximum over all points: K =
    /// dp/d(dilation), 2 G = ds : de / de : de.
    ///
    /// # Errors
    /// If the moduli are not those of an elastic material.
    pub fn moduli(&self) -> Result<[f64; 2], LoadFailure> {
        let dot = |a: [f64; 4], b: [f64; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3];
        let split = |t: [f64; 4]| {
            let mean = (t[0] + t[1] + t[2]) / 3.0;
            (mean, [t[0] - mean, t[1] - mean, t[2] - mean, t[3]])
        };
        let (dilation, deviator) = split(FICTITIOUS);
        let mut largest = [0_f64; 2];
        for i in 0..self.count {
            let component = |list: &[f64], k: usize| list[k * self.count + i];
            let change = [0, 1, 2, 3].inline_map(|k| component(&self.stress[1], k) - component(&self.stress[0], k));
            let (mean, s) = split(change);
            let (bulk, shear) = (mean / (3.0 * dilation), 0.5 * dot(s, deviator) / dot(deviator, deviator));
            // Tolerances for rounding errors.
            if !(bulk > 1e-9 * shear.abs() && shear >= -1e-9 * bulk) {
                let reason = format!(
                    "its response to small strains at time zero (stepTime = totalTime = 0) is not elastic: bulk \
                     modulus {bulk:e}, shear modulus {shear:e}; the stable time increment is computed from them"
                );
                return Err(LoadFailure { point: Some(i), reason });
            }
            largest = [largest[0].max(bulk), largest[1].max(shear)];
        }
        Ok(largest)
    }

    /// Calls VUMAT and checks its results.
    ///
    /// # Errors
    /// Errors of the subroutine; values written past the points, missing or not finite.
    pub fn call(
        &mut self,
        material: &UserMaterialData,
        routine: &mut dyn UserMaterial,
        now: &Instant,
        dt: f64,
    ) -> Result<(), LoadFailure> {
        let (n, m) = (self.count, self.variables);
        let [stress_old, stress] = &mut self.stress;
        let [state_old, state] = &mut self.state;
        let [internal_old, internal] = &mut self.internal;
        let [inelastic_old, inelastic] = &mut self.inelastic;
        stress[..4 * n].fill(f64::NAN);
        // Components that an axisymmetric solid lacks read as zero; values written there are detected.
        stress_old[4 * n..(4 + SPARE) * n].fill(0.0);
        stress[4 * n..(4 + SPARE) * n].fill(f64::from_bits(MARK));
        // A subroutine need not set state variables and energies.
        state[..m * n].copy_from_slice(&state_old[..m * n]);
        internal.copy_from_slice(internal_old);
        inelastic.copy_from_slice(inelastic_old);
        let call = MaterialCall {
            name: &material.name,
            now: *now,
            dt,
            count: n,
            integration_point: self.integration_point,
            variables: m,
            properties: &material.properties,
            coordinates: &self.coordinates,
            length: &self.length[..n],
            density: &self.density,
            strain: &self.strain,
            spin: &self.spin,
            elements: &self.elements,
            temperature: [&self.temperature[0], &self.temperature[1]],
            fields: self.fields,
            field: [&self.field[0][..self.fields * n], &self.field[1][..self.fields * n]],
            stretch: [&self.stretch[0][..4 * n], &self.stretch[1][..4 * n]],
            gradient: [&self.gradient[0][..5 * n], &self.gradient[1][..5 * n]],
            stress: &stress_old[..4 * n],
            state: &state_old[..m * n],
            internal: &internal_old[..n],
            inelastic: &inelastic_old[..n],
        };
        let answer = &mut MaterialAnswer {
            stress: &mut stress[..4 * n],
            state: &mut state[..m * n],
            internal: &mut internal[..n],
            inelastic: &mut inelastic[..n],
        };
        routine.stress(&call, answer)?;
        self.accept(&material.name)
    }

    /// Calls VUCHARLENGTH; the lengths are the defaults on entry.
    ///
    /// # Errors
    /// Errors of the subroutine; values written past the points; lengths that are not positive.
    pub fn call_lengths(
        &mut self,
        material: &UserMaterialData,
        properties: &[f64],
        routine: &mut dyn UserLengths,
        (now, dt): (&Instant, f64),
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (self.count, self.variables, self.fields);
        let Some(shown) = &self.shown else { return Ok(()) };
        let call = LengthCall {
            name: &material.name,
            now: *now,
            dt,
            count: n,
            variables: m,
            fields: f,
            integration_point: self.integration_point,
            corners: shown.nodes,
            properties,
            elements: &self.elements,
            coordinates: &self.coordinates[..2 * n],
            nodes: &shown.places,
            field: &self.field[1][..f * n],
            state: &self.state[0][..m * n],
        };
        routine.lengths(&call, &mut self.length[..n])?;
        check_guards("charLength", &mut self.length, n, 1)?;
        above_zero(&self.length[..n])
    }

    /// Calls VUSDFLD. Its state variables become the previous ones of the other subroutines. `access` provides the
    /// output variables of the points.
    ///
    /// # Errors
    /// Errors of the subroutine; values written past the points or not finite.
    pub fn call_fields(
        &mut self,
        material: &UserMaterialData,
        properties: &[f64],
        routine: &mut dyn UserFields,
        access: &dyn PointAccess,
        (now, dt): (&Instant, f64),
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (self.count, self.variables, self.fields);
        let [state_old, state] = &mut self.state;
        let field = &mut self.field[1];
        state.copy_from_slice(state_old);
        let previous_values = PreviousPointValues {
            access,
            count: n,
            variables: m,
            state: state_old,
            temperature: &self.temperature[0],
            plastic: &self.plastic[0],
        };
        let call = FieldCall {
            name: &material.name,
            now: *now,
            dt,
            count: n,
            variables: m,
            fields: f,
            integration_point: self.integration_point,
            properties,
            elements: &self.elements,
            coordinates: &self.coordinates,
            length: &self.length[..n],
            state: &state_old[..m * n],
            values: &previous_values,
        };
        let answer = &mut FieldAnswer { state: &mut state[..m * n], field: &mut field[..f * n] };
        routine.fields(&call, answer)?;
        check_values("stateNew", state, n, m)?;
        check_values("field", field, n, f)?;
        std::mem::swap(state_old, state);
        Ok(())
    }

    fn accept(&mut self, material: &str) -> Result<(), LoadFailure> {
        let (n, m) = (self.count, self.variables);
        let touched = self.stress[1][4 * n..(4 + SPARE) * n].iter().filter(|g| g.to_bits() != MARK).count();
        if touched >= n {
            let reason = "it returned stressNew(k, 5): the subroutine uses 6 components, an axisymmetric solid has 4 (\
                          rr, zz, hoop, rz); guard the code of the others with `if (nshr .gt. 1)`";
            return Err(LoadFailure::new(reason));
        }
        check_values("stressNew", &mut self.stress[1], n, 4)?;
        check_guards("stateNew", &mut self.state[1], n, m)?;
        self.warn_of_state(material);
        check_values("enerInternNew", &mut self.internal[1], n, 1)?;
        check_values("enerInelasNew", &mut self.inelastic[1], n, 1)
    }

    /// Warns once of state variables that are not finite. They belong to the subroutine, so a NaN (usually a
    /// triaxiality without stress) is not replaced. NaN in the stress is detected separately.
    fn warn_of_state(&mut self, material: &str) {
        let values = &self.state[1][..self.variables * self.count];
        if self.warned || values.iter().all(|v| v.is_finite()) {
            return;
        }
        self.warned = true;
        for (variable, list) in values.chunks(self.count).enumerate() {
            if let Some(value) = list.iter().find(|v| !v.is_finite()) {
                let text = format!(
                    "the user material `{material}` returned stateNew(k, {}) = {value}; the value is kept",
                    variable + 1
                );
                host::report_message(host::MessageLevel::Warning, text);
            }
        }
    }

    /// Keeps all values, for an increment of zero length.
    pub fn keep(&mut self) {
        let PointArguments { stress, state, internal, inelastic, field, plastic, .. } = self;
        for [old, new] in [stress, state, internal, inelastic, field, plastic] {
            new.copy_from_slice(old);
        }
    }

    /// Adds the heat of the inelastic work of the call to the temperature.
    pub fn heat(&mut self, heating: &PlasticHeating) {
        for i in 0..self.count {
            let (without, work) = (self.temperature[1][i], self.density[i] * self.dissipated(i));
            self.temperature[1][i] = without + heating.rise(without, [work]);
        }
    }

    /// Returns the inelastic energy per mass that the call added at a point.
    pub fn dissipated(&self, point: usize) -> f64 {
        self.inelastic[1][point] - self.inelastic[0][point]
    }

    pub fn bytes(&self) -> usize {
        let PointArguments { coordinates, length, density, strain, spin, elements, .. } = self;
        let PointArguments {
            temperature, stretch, gradient, stress, state, field, internal, inelastic, plastic, ..
        } = self;
        let PointArguments { moduli, .. } = self;
        let single = [coordinates, length, density, strain, spin];
        let pairs = [moduli, temperature, stretch, gradient, stress, state, field, internal, inelastic, plastic];
        let numbers = single.into_iter().chain(pairs.into_iter().flatten()).map(|list| 8 * list.capacity());
        let of_elements = self.shown.as_ref().map_or(0, ShownElements::bytes);
        let of_energy = self.energy.as_deref().map_or(0, EnergyArguments::bytes);
        numbers.sum::<usize>() + 4 * elements.capacity() + of_elements + of_energy
    }
}

/// Access to output variables of points that [`PointArguments`] do not contain.
pub trait PointAccess {
    /// Returns a component of an output variable of a point; `None` if it is not computed.
    fn component(&self, point: usize, part: VariableComponent) -> Option<f64>;
}

/// Values of points at the beginning of an increment (`vgetvrm`).
struct PreviousPointValues<'a> {
    access: &'a dyn PointAccess,
    count: usize,
    variables: usize,
    state: &'a [f64],
    temperature: &'a [f64],
    plastic: &'a [f64],
}

impl PointValues for PreviousPointValues<'_> {
    fn give(&self, variable: &str, to: &mut dyn FnMut(usize, usize, f64)) -> Option<usize> {
        let lists: &[f64] = match variable {
            "TEMP" => self.temperature,
            "SDV" => &self.state[..self.variables * self.count],
            "PEEQ" => self.plastic,
            _ => return self.tensor(variable, to),
        };
        if self.count == 0 || lists.is_empty() {
            return None;
        }
        lists.iter().enumerate().for_each(|(i, value)| to(i / self.count, i % self.count, *value));
        Some(lists.len() / self.count)
    }
}

impl PreviousPointValues<'_> {
    /// Passes the components of a tensor in global axes: rr, zz, hoop, rz; strains with the engineering shear, as in
    /// output.
    fn tensor(&self, variable: &str, to: &mut dyn FnMut(usize, usize, f64)) -> Option<usize> {
        let variable = match variable {
            "S" => Variable::Stress,
            "LE" | "E" => Variable::LogarithmicStrain,
            "PE" => Variable::PlasticComponents,
            "ER" => Variable::StrainRate,
            _ => return None,
        };
        for point in 0..self.count {
            for component in 0..4 {
                to(component, point, self.access.component(point, VariableComponent { variable, component })?);
            }
        }
        Some(4)
    }
}

/// Returns the guard values that follow a result, with so many more.
pub(super) fn guard_values(more: usize) -> impl Iterator<Item = f64> {
    std::iter::repeat_n(f64::from_bits(MARK), GUARD + more)
}

/// Checks that a subroutine has not changed the guard values after a result.
pub(super) fn check_guards(name: &str, list: &mut [f64], n: usize, components: usize) -> Result<(), LoadFailure> {
    let guard = &mut list[components * n..];
    let (next, others) = guard.split_at(guard.len().min(GUARD + CHECKED_COMPONENTS * n));
    // Without a branch per value, so that the loop is vectorised.
    let change = |changed: u64, value: &f64| changed | (value.to_bits() ^ MARK);
    if next.iter().fold(0, change) == 0 && others.iter().step_by((n / 2).max(1)).fold(0, change) == 0 {
        return Ok(());
    }
    let first = guard.iter().position(|value| value.to_bits() != MARK).unwrap_or_default();
    guard.fill(f64::from_bits(MARK));
    let more = match name {
        "stateNew" => format!("; *DEPVAR defines nstatev = {components} state variables"),
        "field" => format!("; the model has nfieldv = {components} field variables"),
        _ => String::new(),
    };
    let place = if components == 1 && more.is_empty() {
        format!("{}", n + first + 1)
    } else {
        format!("{},{}", first % n + 1, components + first / n + 1)
    };
    let bounds = bounds_advice(name);
    let reason =
        format!("it wrote past the nblock = {n} points of its argument {name}, at {name}({place}){more}{bounds}");
    Err(LoadFailure::new(reason))
}

/// Checks the guard values of a result, and that all values are finite.
pub(super) fn check_values(name: &str, list: &mut [f64], n: usize, components: usize) -> Result<(), LoadFailure> {
    check_guards(name, list, n, components)?;
    let values = &list[..components * n];
    let Some(at) = values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
    let hint = if values[at].is_nan() && name == "stressNew" { "; a component that was left out is NaN" } else { "" };
    let reason = format!("it returned {name}(k, {}) = {}{hint}", at / n + 1, values[at]);
    Err(LoadFailure { point: Some(at % n), reason })
}
