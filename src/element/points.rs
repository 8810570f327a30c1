//! Material points as the user's routine is shown them, and what it answers.
//! Never here: geometry of elements.

use crate::element::user_quads::Description;
use crate::kernel::heating::Heating;
use crate::state::Instant;
use crate::state::archive::{Archive, Persist};
use crate::user::{LoadFailure, MaterialAnswer, MaterialCall, UserMaterial};

/// Entries behind each answer that a routine must leave alone.
const GUARD: usize = 8;
/// What they hold: a number that is none, with a mark of its own.
const MARK: u64 = 0x7ff8_5afe_0000_5afe;
/// Fictitious strains of the call at time zero: dilation and shear at once, far below any yield.
const FICTITIOUS: [f64; 4] = [2e-7, -0.5e-7, 1e-7, 0.75e-7];

/// Values before and after an increment.
type Pair = [Vec<f64>; 2];

/// The points of one call, components one after the other as Fortran has them.
#[derive(Clone, Debug)]
pub struct Points {
    count: usize,
    variables: usize,
    coordinates: Vec<f64>,
    length: Vec<f64>,
    density: Vec<f64>,
    strain: Vec<f64>,
    spin: Vec<f64>,
    temperature: Vec<f64>,
    /// Before the increment, where it changes in it; else empty.
    temperature_before: Vec<f64>,
    stretch: Pair,
    gradient: Pair,
    stress: Pair,
    state: Pair,
    internal: Pair,
    inelastic: Pair,
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
    /// Points at rest, without stress; the variable that deletes is 1.
    pub fn new(count: usize, variables: usize, delete: Option<usize>) -> Self {
        let mut points = Points {
            count,
            variables,
            coordinates: vec![f64::NAN; 3 * count],
            length: vec![0.0; count],
            density: vec![0.0; count],
            strain: vec![0.0; 4 * count],
            spin: vec![0.0; count],
            temperature: vec![0.0; count],
            temperature_before: Vec::new(),
            stretch: pair(4 * count),
            gradient: pair(5 * count),
            stress: pair(4 * count),
            state: pair(variables * count),
            internal: pair(count),
            inelastic: pair(count),
        };
        for list in points.stretch.iter_mut().chain(&mut points.gradient) {
            list[..3 * count].fill(1.0);
        }
        if let Some(variable) = delete {
            points.state.iter_mut().for_each(|s| s[variable * count..(variable + 1) * count].fill(1.0));
        }
        points
    }

    /// Stress and temperature of a point at the start.
    pub fn start(&mut self, point: usize, stress: Option<[f64; 4]>, temperature: Option<f64>) {
        for (k, value) in stress.into_iter().flatten().enumerate() {
            self.stress[0][k * self.count + point] = value;
        }
        if let Some(temperature) = temperature {
            self.temperature[point] = temperature;
        }
    }

    /// Gives points the temperatures at the end of the increment; those that they have become those before it.
    pub fn warm(&mut self, temperatures: &[f64]) {
        self.temperature_before.clone_from(&self.temperature);
        self.temperature.copy_from_slice(temperatures);
    }

    /// Warms points by the inelastic energy that the call added.
    pub fn heat(&mut self, heating: &Heating) {
        for i in 0..self.count {
            self.temperature[i] += heating.rise(self.temperature[i], [self.dissipated(i)]);
        }
    }

    /// Strain increment of a point in the frame of its stress.
    pub fn set_strain(&mut self, point: usize, strain: [f64; 4]) {
        for (k, value) in strain.into_iter().enumerate() {
            self.strain[k * self.count + point] = value;
        }
    }

    /// Where a point is, by the corners of its element, and its density at the middle of the increment. The characteristic
    /// length is the root of the element's area in the (r, z) plane.
    pub fn set_place(&mut self, point: usize, r: [f64; 4], z: [f64; 4], density: f64) {
        let mean = |x: [f64; 4]| 0.25 * ((x[0] + x[1]) + (x[2] + x[3]));
        self.coordinates[point] = mean(r);
        self.coordinates[self.count + point] = mean(z);
        let area = 0.5 * ((r[2] - r[0]) * (z[3] - z[1]) - (r[3] - r[1]) * (z[2] - z[0]));
        self.length[point] = area.abs().sqrt();
        self.density[point] = density;
    }

    /// Deformation gradient (rr, zz, hoop, rz, zr) of a point now, and its stretch: the root of F^T F, in the plane
    /// (C + sqrt(det C) I) / sqrt(tr C + 2 sqrt(det C)).
    pub fn set_gradient(&mut self, point: usize, gradient: [f64; 5]) {
        let [rr, zz, hoop, rz, zr] = gradient;
        let (c_rr, c_zz, c_rz) = (rr * rr + zr * zr, rz * rz + zz * zz, rr * rz + zr * zz);
        let root = (rr * zz - rz * zr).abs();
        let per = 1.0 / (c_rr + c_zz + 2.0 * root).sqrt();
        let stretch = [per * (c_rr + root), per * (c_zz + root), hoop, per * c_rz];
        for (k, value) in gradient.into_iter().enumerate() {
            self.gradient[1][k * self.count + point] = value;
        }
        for (k, value) in stretch.into_iter().enumerate() {
            self.stretch[1][k * self.count + point] = value;
        }
    }

    /// The strains of the call at time zero.
    pub fn show_fictitious(&mut self) {
        for (list, value) in self.strain.chunks_mut(self.count).zip(FICTITIOUS) {
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
            let change = [0, 1, 2, 3].map(|k| of(&self.stress[1], k) - of(&self.stress[0], k));
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
        state[..m * n].fill(f64::NAN);
        // Energies may be left alone.
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
            length: &self.length,
            density: &self.density,
            strain: &self.strain,
            spin: &self.spin,
            temperature: [
                if self.temperature_before.is_empty() { &self.temperature } else { &self.temperature_before },
                &self.temperature,
            ],
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
        self.accept()
    }

    fn accept(&mut self) -> Result<(), LoadFailure> {
        let (n, m) = (self.count, self.variables);
        let answers = [
            ("stressNew", &mut self.stress[1], 4),
            ("stateNew", &mut self.state[1], m),
            ("enerInternNew", &mut self.internal[1], 1),
            ("enerInelasNew", &mut self.inelastic[1], 1),
        ];
        for (name, list, components) in answers {
            let (values, guard) = list.split_at_mut(components * n);
            if guard.iter().any(|g| g.to_bits() != MARK) {
                guard.fill(f64::from_bits(MARK));
                return Err(LoadFailure::new(format!("it wrote past the nblock = {n} points of its argument {name}")));
            }
            if let Some(at) = values.iter().position(|v| !v.is_finite()) {
                let hint = if values[at].is_nan() { "; a component that is left out keeps NaN" } else { "" };
                let (point, component) = (at % n, at / n + 1);
                let reason = format!("it gave {name}(k, {component}) = {}{hint}", values[at]);
                return Err(LoadFailure { point: Some(point), reason });
            }
        }
        Ok(())
    }

    /// An increment of no length: all stays as it is.
    pub fn keep(&mut self) {
        for [old, new] in [&mut self.stress, &mut self.state, &mut self.internal, &mut self.inelastic] {
            new.copy_from_slice(old);
        }
    }

    /// What was new is old.
    pub fn swap(&mut self) {
        let pairs = [&mut self.stress, &mut self.state, &mut self.internal, &mut self.inelastic];
        for [old, new] in pairs.into_iter().chain([&mut self.stretch, &mut self.gradient]) {
            std::mem::swap(old, new);
        }
    }

    /// Takes the stress of a deleted point away; the variable that deletes stays zero.
    pub fn delete(&mut self, point: usize, variable: Option<usize>) {
        (0..4).for_each(|k| self.stress[1][k * self.count + point] = 0.0);
        if let Some(variable) = variable {
            self.state[1][variable * self.count + point] = 0.0;
        }
    }

    /// New stress of a point.
    pub fn stress(&self, point: usize) -> [f64; 4] {
        [0, 1, 2, 3].map(|k| self.stress[1][k * self.count + point])
    }

    /// New state variable of a point.
    pub fn state(&self, point: usize, variable: usize) -> f64 {
        self.state[1][variable * self.count + point]
    }

    /// State variable of a point before the next call.
    pub fn state_before(&self, point: usize, variable: usize) -> f64 {
        self.state[0][variable * self.count + point]
    }

    /// Inelastic energy a mass of a point that the call added.
    pub fn dissipated(&self, point: usize) -> f64 {
        self.inelastic[1][point] - self.inelastic[0][point]
    }

    /// Inelastic energy a mass of a point.
    pub fn inelastic(&self, point: usize) -> f64 {
        self.inelastic[0][point]
    }

    /// Temperature of a point.
    pub fn temperature(&self, point: usize) -> f64 {
        self.temperature[point]
    }

    /// Bytes of the arrays.
    pub fn bytes(&self) -> usize {
        let Points { coordinates, length, density, strain, spin, temperature, temperature_before, .. } = self;
        let Points { stretch, gradient, stress, state, internal, inelastic, .. } = self;
        let single = [coordinates, length, density, strain, spin, temperature, temperature_before];
        let pairs = [stretch, gradient, stress, state, internal, inelastic];
        single.into_iter().chain(pairs.into_iter().flatten()).map(|list| 8 * list.capacity()).sum()
    }
}

impl Persist for Points {
    /// All of it: a deleted point goes on to be shown what it was shown last.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Points {
            count: _,
            variables: _,
            coordinates,
            length,
            density,
            strain,
            spin,
            temperature,
            temperature_before,
            stretch,
            gradient,
            stress,
            state,
            internal,
            inelastic,
        } = self;
        temperature_before.persist(archive);
        for list in [coordinates, length, density, strain, spin, temperature] {
            list.as_mut_slice().persist(archive);
        }
        for pair in [stretch, gradient, stress, state, internal, inelastic] {
            pair.iter_mut().for_each(|list| list.as_mut_slice().persist(archive));
        }
    }
}
