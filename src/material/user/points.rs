//! Arguments of a call of user subroutines: material points of up to eight blocks, components one after the other.
//! Never here: what elements keep, their geometry.

use super::description::Description;
use super::lengths::{ShownElements, above_zero};
use crate::kernel::heating::Heating;
use crate::kernel::lanes::InlineMap;
use crate::state::Instant;
use crate::user::{
    FieldAnswer, FieldCall, LengthCall, LoadFailure, MaterialAnswer, MaterialCall, PointValues, UserFields,
    UserLengths, UserMaterial, host,
};
use crate::variables::{Part, Variable};

/// Entries behind each answer that a routine must leave alone.
const GUARD: usize = 8;
/// Components of a symmetric tensor in three dimensions that an axisymmetric solid does not have: a routine that is written
/// for those alone shall find room, and be told.
const SPARE: usize = 2;
/// What they hold: a number that is none, with a mark of its own.
const MARK: u64 = 0x7ff8_5afe_0000_5afe;
/// Fictitious strains of the call at time zero: dilation and shear at once, far below any yield.
const FICTITIOUS: [f64; 4] = [2e-7, -0.5e-7, 1e-7, 0.75e-7];

/// Values before and after an increment.
type Pair = [Vec<f64>; 2];

/// The points of one call, components one after the other as Fortran has them: those before the increment and those after it.
#[derive(Clone, Debug)]
pub struct Points {
    pub(super) count: usize,
    variables: usize,
    fields: usize,
    /// User's numbers of the elements.
    pub(super) elements: Vec<i32>,
    pub(super) coordinates: Vec<f64>,
    pub(super) length: Vec<f64>,
    /// Corners, where a routine of the user gives the lengths.
    shown: Option<ShownElements>,
    pub(super) density: Vec<f64>,
    pub(super) strain: Vec<f64>,
    spin: Vec<f64>,
    pub(super) temperature: Pair,
    pub(super) stretch: Pair,
    pub(super) gradient: Pair,
    pub(super) stress: Pair,
    pub(super) state: Pair,
    pub(super) field: Pair,
    /// Bulk and shear modulus of the stress; not a number before the first increment, empty where they are constant.
    pub(super) moduli: Pair,
    pub(super) internal: Pair,
    pub(super) inelastic: Pair,
    /// Equivalent plastic strain, where it is not the routine's affair; else empty.
    pub(super) plastic: Pair,
    /// Whether a state variable that is not finite has been told.
    told: bool,
}

/// Room for so many numbers with the guard behind.
fn guarded(length: usize) -> Vec<f64> {
    let mut list = vec![0.0; length];
    list.resize(length + GUARD, f64::from_bits(MARK));
    list
}

fn pair(length: usize) -> Pair {
    [guarded(length), guarded(length)]
}

impl Points {
    pub fn new(material: &Description, count: usize, triangles: bool) -> Self {
        let (variables, fields) = (material.variables, material.fields);
        let flows = if material.flow.is_some() { count } else { 0 };
        let varying = if material.flow.as_ref().is_some_and(|f| f.elasticity.is_some()) { count } else { 0 };
        let mut points = Points {
            count,
            variables,
            fields,
            elements: vec![0; count],
            coordinates: vec![f64::NAN; 3 * count],
            length: guarded(count),
            shown: material.asks_lengths.as_ref().map(|_| ShownElements::new(count, if triangles { 3 } else { 4 })),
            density: vec![0.0; count],
            strain: vec![0.0; (4 + SPARE) * count],
            spin: vec![0.0; count],
            temperature: [vec![0.0; count], vec![0.0; count]],
            stretch: pair(4 * count),
            gradient: pair(5 * count),
            stress: pair((4 + SPARE) * count),
            state: pair(variables * count),
            field: pair(fields * count),
            moduli: [vec![f64::NAN; varying], vec![f64::NAN; varying]],
            internal: pair(count),
            inelastic: pair(count),
            plastic: [vec![0.0; flows], vec![0.0; flows]],
            told: false,
        };
        points.coordinates[2 * count..].fill(f64::NAN);
        points
    }

    /// Takes the corners of a point's element, where a routine is shown them.
    pub(super) fn show_corners(&mut self, point: usize, r: [f64; 4], z: [f64; 4]) {
        if let Some(shown) = &mut self.shown {
            shown.set(point, r, z);
        }
    }

    /// The strains of the call at time zero, and the deformation that they lead to: a routine may take its stress from
    /// either.
    pub fn show_fictitious(&mut self) {
        for (list, value) in self.strain.chunks_mut(self.count).zip(FICTITIOUS) {
            list.fill(value);
        }
        let [rr, zz, hoop, rz] = FICTITIOUS;
        let gradient = [1.0 + rr, 1.0 + zz, 1.0 + hoop, rz, rz];
        let stretch = stretch(gradient);
        for (list, value) in self.gradient[1].chunks_mut(self.count).zip(gradient) {
            list.fill(value);
        }
        for (list, value) in self.stretch[1].chunks_mut(self.count).zip(stretch) {
            list.fill(value);
        }
    }

    /// Bulk and shear modulus of the answer to the fictitious strains, the largest of all points: K = dp/d(dilation),
    /// 2 G = ds : de / de : de.
    ///
    /// # Errors
    /// Where they are not those of something elastic.
    pub fn moduli(&self) -> Result<[f64; 2], LoadFailure> {
        let dot = |a: [f64; 4], b: [f64; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3];
        let split = |t: [f64; 4]| {
            let mean = (t[0] + t[1] + t[2]) / 3.0;
            (mean, [t[0] - mean, t[1] - mean, t[2] - mean, t[3]])
        };
        let (dilation, deviator) = split(FICTITIOUS);
        let mut largest = [0_f64; 2];
        for i in 0..self.count {
            let of = |list: &[f64], k: usize| list[k * self.count + i];
            let change = [0, 1, 2, 3].inline_map(|k| of(&self.stress[1], k) - of(&self.stress[0], k));
            let (mean, s) = split(change);
            let (bulk, shear) = (mean / (3.0 * dilation), 0.5 * dot(s, deviator) / dot(deviator, deviator));
            // Beyond rounding.
            if !(bulk > 1e-9 * shear.abs() && shear >= -1e-9 * bulk) {
                let reason = format!(
                    "its answer to small strains at time zero (stepTime = totalTime = 0) is not elastic: bulk modulus \
                     {bulk:e}, shear modulus {shear:e}; the stable increment needs them"
                );
                return Err(LoadFailure { point: Some(i), reason });
            }
            largest = [largest[0].max(bulk), largest[1].max(shear)];
        }
        Ok(largest)
    }

    /// Calls the routine and looks at what it answered.
    ///
    /// # Errors
    /// Its own, and where it wrote past its points, left something out or gave what is not finite.
    pub fn call(
        &mut self,
        material: &Description,
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
        // What an axisymmetric solid does not have reads as zero; that a routine answers it is seen.
        stress_old[4 * n..(4 + SPARE) * n].fill(0.0);
        stress[4 * n..(4 + SPARE) * n].fill(f64::from_bits(MARK));
        // State variables and energies may be left alone.
        state.copy_from_slice(state_old);
        internal.copy_from_slice(internal_old);
        inelastic.copy_from_slice(inelastic_old);
        let call = MaterialCall {
            name: &material.name,
            now: *now,
            dt,
            count: n,
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

    /// Asks the routine of characteristic lengths, which find the default there.
    ///
    /// # Errors
    /// Its own, and where it wrote past its points or gave a length that is not above zero.
    pub fn call_lengths(
        &mut self,
        material: &Description,
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
            corners: shown.corners,
            properties,
            elements: &self.elements,
            coordinates: &self.coordinates[..2 * n],
            nodes: &shown.places,
            field: &self.field[1][..f * n],
            state: &self.state[0][..m * n],
        };
        routine.lengths(&call, &mut self.length[..n])?;
        untouched("charLength", &mut self.length, n, 1)?;
        above_zero(&self.length[..n])
    }

    /// Asks the routine of user-defined fields, whose state variables are the old ones from now on. `tells` gives what the
    /// points hold besides what is here.
    ///
    /// # Errors
    /// Its own, and where it wrote past its points or gave what is not finite.
    pub fn call_fields(
        &mut self,
        material: &Description,
        properties: &[f64],
        routine: &mut dyn UserFields,
        tells: &dyn PointAccess,
        (now, dt): (&Instant, f64),
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (self.count, self.variables, self.fields);
        let [state_old, state] = &mut self.state;
        let field = &mut self.field[1];
        state.copy_from_slice(state_old);
        let held = Held {
            tells,
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
            properties,
            elements: &self.elements,
            coordinates: &self.coordinates,
            length: &self.length[..n],
            state: &state_old[..m * n],
            values: &held,
        };
        let answer = &mut FieldAnswer { state: &mut state[..m * n], field: &mut field[..f * n] };
        routine.fields(&call, answer)?;
        answered("stateNew", state, n, m)?;
        answered("field", field, n, f)?;
        std::mem::swap(state_old, state);
        Ok(())
    }

    fn accept(&mut self, material: &str) -> Result<(), LoadFailure> {
        let (n, m) = (self.count, self.variables);
        let touched = self.stress[1][4 * n..(4 + SPARE) * n].iter().filter(|g| g.to_bits() != MARK).count();
        if touched >= n {
            let reason = "it gave stressNew(k, 5): this routine uses 6 components, an axisymmetric solid has 4 (rr, zz, hoop, \
                          rz); what belongs to the others stands behind `if (nshr .gt. 1)`";
            return Err(LoadFailure::new(reason));
        }
        answered("stressNew", &mut self.stress[1], n, 4)?;
        untouched("stateNew", &mut self.state[1], n, m)?;
        self.tell_state(material);
        answered("enerInternNew", &mut self.internal[1], n, 1)?;
        answered("enerInelasNew", &mut self.inelastic[1], n, 1)
    }

    /// State variables are the routine's own: one that is not a number (a triaxiality without stress, as a rule) is told once
    /// and kept. What becomes of the stress is looked after.
    fn tell_state(&mut self, material: &str) {
        let values = &self.state[1][..self.variables * self.count];
        if self.told || values.iter().all(|v| v.is_finite()) {
            return;
        }
        self.told = true;
        for (variable, list) in values.chunks(self.count).enumerate() {
            if let Some(value) = list.iter().find(|v| !v.is_finite()) {
                let text = format!("the user material `{material}` gave stateNew(k, {}) = {value}: kept", variable + 1);
                host::tell(host::Level::Warning, text);
            }
        }
    }

    /// An increment of no length: all stays as it is.
    pub fn keep(&mut self) {
        let Points { stress, state, internal, inelastic, field, plastic, .. } = self;
        for [old, new] in [stress, state, internal, inelastic, field, plastic] {
            new.copy_from_slice(old);
        }
    }

    /// Adds the heat of the inelastic work that a call added.
    pub fn heat(&mut self, heating: &Heating) {
        for i in 0..self.count {
            let (without, work) = (self.temperature[1][i], self.density[i] * self.dissipated(i));
            self.temperature[1][i] = without + heating.rise(without, [work]);
        }
    }

    /// Inelastic energy a mass of a point that the call added.
    pub fn dissipated(&self, point: usize) -> f64 {
        self.inelastic[1][point] - self.inelastic[0][point]
    }

    pub fn bytes(&self) -> usize {
        let Points { coordinates, length, density, strain, spin, elements, .. } = self;
        let Points { temperature, stretch, gradient, stress, state, field, internal, inelastic, plastic, .. } = self;
        let Points { moduli, .. } = self;
        let single = [coordinates, length, density, strain, spin];
        let pairs = [moduli, temperature, stretch, gradient, stress, state, field, internal, inelastic, plastic];
        let numbers = single.into_iter().chain(pairs.into_iter().flatten()).map(|list| 8 * list.capacity());
        let shown = self.shown.as_ref().map_or(0, ShownElements::bytes);
        numbers.sum::<usize>() + 4 * elements.capacity() + shown
    }
}

/// Stretch of a deformation gradient (rr, zz, hoop, rz, zr): the root of F^T F, in the plane
/// (C + sqrt(det C) I) / sqrt(tr C + 2 sqrt(det C)).
pub(super) fn stretch([rr, zz, hoop, rz, zr]: [f64; 5]) -> [f64; 4] {
    let (c_rr, c_zz, c_rz) = (rr * rr + zr * zr, rz * rz + zz * zz, rr * rz + zr * zz);
    let root = (rr * zz - rz * zr).abs();
    let per = 1.0 / (c_rr + c_zz + 2.0 * root).sqrt();
    [per * (c_rr + root), per * (c_zz + root), hoop, per * c_rz]
}

/// What elements know of their points beside what [`Points`] hold.
pub trait PointAccess {
    /// Component of an output variable of a point; `None` if it is not followed.
    fn component(&self, point: usize, part: Part) -> Option<f64>;
}

/// What points hold at the beginning of an increment.
struct Held<'a> {
    tells: &'a dyn PointAccess,
    count: usize,
    variables: usize,
    state: &'a [f64],
    temperature: &'a [f64],
    plastic: &'a [f64],
}

impl PointValues for Held<'_> {
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

impl Held<'_> {
    /// Components of a tensor in the axes of the model: rr, zz, hoop, rz; of strains the engineering shear, as output shows
    /// them.
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
                to(component, point, self.tells.component(point, Part { variable, component })?);
            }
        }
        Some(4)
    }
}

/// What stands behind an answer.
pub(super) fn marks() -> impl Iterator<Item = f64> {
    std::iter::repeat_n(f64::from_bits(MARK), GUARD)
}

/// Whether a routine left alone what stands behind its answer.
pub(super) fn untouched(name: &str, list: &mut [f64], n: usize, components: usize) -> Result<(), LoadFailure> {
    let guard = &mut list[components * n..];
    if guard.iter().any(|g| g.to_bits() != MARK) {
        guard.fill(f64::from_bits(MARK));
        let more = match name {
            "stateNew" => format!("; *DEPVAR gives it nstatev = {components} state variables"),
            "field" => format!("; there are nfieldv = {components} field variables"),
            _ => String::new(),
        };
        return Err(LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument {name}{more}")));
    }
    Ok(())
}

/// The same, and whether it gave all of it, finite.
pub(super) fn answered(name: &str, list: &mut [f64], n: usize, components: usize) -> Result<(), LoadFailure> {
    untouched(name, list, n, components)?;
    let values = &list[..components * n];
    let Some(at) = values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
    let hint = if values[at].is_nan() && name == "stressNew" { "; a component that is left out keeps NaN" } else { "" };
    let reason = format!("it gave {name}(k, {}) = {}{hint}", at / n + 1, values[at]);
    Err(LoadFailure { point: Some(at % n), reason })
}
