//! Strain energies of the invariants of a fibre-reinforced material (`*ANISOTROPIC HYPERELASTIC`): the stress and a bound of the
//! stiffness from their derivatives. Tensors have the components rr, zz, hoop, rz in the axes of the right stretch tensor.
//! Stresses rz-hoop and r-hoop, which would twist an axisymmetric body, are not computed.

use super::description::UserMaterialData;
use super::points::{PointArguments, check_guards, check_values, guard_values};
use crate::kernel::lanes::InlineMap;
use crate::kernel::transcendental::exp_of;
use crate::routines::{EnergyAnswer, EnergyCall, LoadFailure, UserEnergy};
use crate::state::Instant;

/// Invariants that do not depend on fibres: Ī1, Ī2 and J.
const ISOTROPIC: usize = 3;
/// Index of J among the invariants.
const VOLUME: usize = 2;

/// A strain energy per initial volume with its fibres.
#[derive(Clone, Debug)]
pub struct AnisotropicEnergy {
    /// Directions of the families of fibres in the initial configuration: unit vectors along r, z and hoop.
    pub fibres: Vec<[f64; 3]>,
    /// Built-in energy; `None` if VUANISOHYPER_INV computes it.
    pub built_in: Option<HolzapfelEnergy>,
}

/// Energy of Gasser, Ogden and Holzapfel 2006 (J. R. Soc. Interface 3, 15, doi:10.1098/rsif.2005.0073) with the volumetric part
/// of ABAQUS (Analysis User's Guide, "Anisotropic hyperelastic behavior"). Fibres carry no compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HolzapfelEnergy {
    /// C10, half the shear modulus of the matrix.
    pub c10: f64,
    /// D, two over the bulk modulus.
    pub d: f64,
    /// Stiffness k1 of the fibres.
    pub k1: f64,
    /// Exponent k2 of the fibres.
    pub k2: f64,
    /// Dispersion of the fibres, from 0 (aligned) to 1/3 (isotropic).
    pub kappa: f64,
}

/// Invariants and results of one call.
#[derive(Clone, Debug)]
pub struct EnergyArguments {
    invariants: Vec<f64>,
    cosines: Vec<f64>,
    deviatoric: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    /// Invariants of a point.
    point: Vec<Invariant>,
}

/// An invariant at a point.
#[derive(Clone, Copy, Debug, Default)]
struct Invariant {
    value: f64,
    /// Derivative by the logarithmic strain, a deviator.
    gradient: [f64; 4],
    /// Bound of the second derivative by the logarithmic strain along one direction.
    growth: f64,
    /// Sum of the second derivatives along three directions.
    sum: f64,
}

/// Stress, modulus of the fastest wave and mean shear modulus.
struct EnergyResponse {
    stress: [f64; 4],
    modulus: f64,
    shear: f64,
}

/// Returns the place of the fourth invariant of the families i ≤ j; the fifth follows it.
fn place(i: usize, j: usize) -> usize {
    ISOTROPIC + j * (j + 1) + 2 * i
}

/// Returns the place of a second derivative by the invariants a ≤ b, or with a = 0 the number of derivatives by b invariants.
fn packed(a: usize, b: usize) -> usize {
    a + b * (b + 1) / 2
}

impl AnisotropicEnergy {
    /// Returns the number of invariants.
    fn count(&self) -> usize {
        ISOTROPIC + self.fibres.len() * (self.fibres.len() + 1)
    }
}

impl HolzapfelEnergy {
    /// Adds the derivatives of the energy at a point, given its invariants. Equation (6.24).
    fn differentiate(&self, families: usize, value: impl Fn(usize) -> f64, mut set: impl FnMut(Derivative, f64)) {
        let HolzapfelEnergy { c10, d, k1, k2, kappa } = *self;
        let (j, per) = (value(VOLUME), 1.0 / d);
        set(Derivative::First(VOLUME), per * (j - 1.0 / j));
        set(Derivative::Second(VOLUME, VOLUME), per * (1.0 + 1.0 / (j * j)));
        set(Derivative::First(0), c10);
        for i in 0..families {
            let along = place(i, i);
            let (of_mean, of_fibre) = (kappa, 1.0 - 3.0 * kappa);
            let strain = of_mean * (value(0) - 3.0) + of_fibre * (value(along) - 1.0);
            if strain < 0.0 {
                continue;
            }
            let exponential = exp_of(k2 * strain * strain);
            let (slope, curvature) = (k1 * strain * exponential, k1 * (1.0 + 2.0 * k2 * strain * strain) * exponential);
            set(Derivative::First(0), of_mean * slope);
            set(Derivative::First(along), of_fibre * slope);
            set(Derivative::Second(0, 0), of_mean * of_mean * curvature);
            set(Derivative::Second(0, along), of_mean * of_fibre * curvature);
            set(Derivative::Second(along, along), of_fibre * of_fibre * curvature);
        }
    }
}

/// A derivative to which a value is added.
enum Derivative {
    First(usize),
    Second(usize, usize),
}

impl EnergyArguments {
    /// Allocates the arguments for `count` points.
    pub(super) fn new(energy: &AnisotropicEnergy, count: usize) -> Self {
        let (families, invariants) = (energy.fibres.len(), energy.count());
        let guarded =
            |length: usize| std::iter::repeat_n(0.0, length * count).chain(guard_values(count)).collect::<Vec<f64>>();
        let pairs = (0..families).flat_map(|j| (0..j).map(move |i| (i, j)));
        let cosine = |(i, j): (usize, usize)| dot(energy.fibres[i], energy.fibres[j]);
        EnergyArguments {
            invariants: vec![0.0; invariants * count],
            cosines: pairs.flat_map(|pair| std::iter::repeat_n(cosine(pair), count)).collect(),
            deviatoric: guarded(1),
            first: guarded(invariants),
            second: guarded(packed(0, invariants)),
            point: vec![Invariant::default(); invariants],
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let EnergyArguments { invariants, cosines, deviatoric, first, second, point } = self;
        let lists = [invariants, cosines, deviatoric, first, second].inline_map(|list| 8 * list.capacity());
        lists.iter().sum::<usize>() + size_of_val(&**point)
    }

    /// Sets the results of `n` points to zero.
    fn clear(&mut self, n: usize) {
        let count = self.point.len();
        self.deviatoric[..n].fill(0.0);
        self.first[..count * n].fill(0.0);
        self.second[..packed(0, count) * n].fill(0.0);
    }

    /// Sets the derivatives of a built-in energy at all points.
    fn differentiate(&mut self, law: &HolzapfelEnergy, families: usize, n: usize) {
        let EnergyArguments { invariants, first, second, .. } = self;
        for i in 0..n {
            let value = |a: usize| invariants[a * n + i];
            law.differentiate(families, value, |derivative, value| match derivative {
                Derivative::First(a) => first[a * n + i] += value,
                Derivative::Second(a, b) => second[packed(a, b) * n + i] += value,
            });
        }
    }

    /// Computes the response of a point from the derivatives of the energy. Equation (6.23).
    fn respond(&self, i: usize, n: usize) -> EnergyResponse {
        let (j, count) = (self.point[VOLUME].value, self.point.len());
        let slope = |a: usize| self.first[a * n + i];
        let curvature = |a: usize, b: usize| self.second[packed(a.min(b), a.max(b)) * n + i];
        let (pressing, volumetric) = (j * slope(VOLUME), j * j * curvature(VOLUME, VOLUME));
        let (mut stress, mut growth, mut sum, mut mixed) = ([0.0; 4], 0.0, 0.0, 0.0);
        let mut stiffness = [[0.0; 4]; 4];
        for a in (0..count).filter(|a| *a != VOLUME) {
            let Invariant { gradient, growth: fastest, sum: along_all, .. } = self.point[a];
            let w = slope(a);
            stress.iter_mut().zip(gradient).for_each(|(stress, gradient)| *stress += w * gradient);
            growth += w.abs() * fastest;
            sum += w * along_all;
            mixed += 2.0 * (j * curvature(a, VOLUME)).abs() * norm(gradient);
            for b in (0..count).filter(|b| *b != VOLUME) {
                let w = curvature(a, b);
                if w != 0.0 {
                    let other = mandel(self.point[b].gradient).inline_map(|x| w * x);
                    for (row, x) in stiffness.iter_mut().zip(mandel(gradient)) {
                        row.iter_mut().zip(other).for_each(|(value, y)| *value += x * y);
                    }
                }
            }
        }
        sum += stiffness[0][0] + stiffness[1][1] + stiffness[2][2];
        let curved = stiffness.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
        stress[..3].iter_mut().for_each(|normal| *normal += pressing);
        let per = 1.0 / j;
        let stress = stress.inline_map(|tau| per * tau);
        // The deviator of a strain along one direction has the square 2/3.
        let deviatoric = growth + 2.0 / 3.0 * curved + (2.0_f64 / 3.0).sqrt() * mixed;
        let compressed = (-eigenvalues(stress).0).max(0.0);
        let modulus = per * (volumetric + pressing + deviatoric) + compressed;
        EnergyResponse { stress, modulus, shear: 0.25 * per * sum }
    }
}

/// Computes the invariants of a stretch tensor with their derivatives. Returns the volume ratio.
fn measure(stretch: [f64; 4], fibres: &[[f64; 3]], point: &mut [Invariant]) -> f64 {
    let [rr, zz, hoop, rz] = stretch;
    let j = (rr * zz - rz * rz) * hoop;
    let scale = 1.0 / libm::cbrt(j);
    let isochoric = stretch.inline_map(|x| scale * x);
    let square = product(isochoric, isochoric);
    let (first, (low, high)) = (trace(square), eigenvalues(square));
    let fourth = product(square, square);
    let second = 0.5 * (first * first - trace(fourth));
    let of_second = [0, 1, 2, 3].inline_map(|k| first * square[k] - fourth[k]);
    let invariant =
        |value, tensor: [f64; 4], growth, sum| Invariant { value, gradient: deviator2(tensor), growth, sum };
    point[0] = invariant(first, square, 4.0 / 9.0 * (3.0 * high + first), 8.0 / 3.0 * first);
    point[1] = invariant(second, of_second, 4.0 / 9.0 * (3.0 / low + second), 8.0 / 3.0 * second);
    point[VOLUME] = Invariant { value: j, ..Invariant::default() };
    for (b, &other) in fibres.iter().enumerate() {
        let (along_b, length_b) = fibre(isochoric, other);
        let turned_b = apply(square, along_b);
        for (a, &fibre_a) in fibres[..=b].iter().enumerate() {
            let (along_a, length_a) = fibre(isochoric, fibre_a);
            let (turned_a, both) = (apply(square, along_a), length_a * length_b);
            let (four, five) = (dot(along_a, along_b), dot(along_a, turned_b));
            let of_five = [symmetric(along_a, turned_b), symmetric(turned_a, along_b)];
            let of_five = [0, 1, 2, 3].inline_map(|k| of_five[0][k] + of_five[1][k]);
            let at = place(a, b);
            point[at] = invariant(four, symmetric(along_a, along_b), 16.0 / 9.0 * both, 8.0 / 3.0 * four);
            point[at + 1] = invariant(five, of_five, 64.0 / 9.0 * high * both, 32.0 / 3.0 * five);
        }
    }
    j
}

/// Returns a stretched fibre and its length.
fn fibre(stretch: [f64; 4], direction: [f64; 3]) -> ([f64; 3], f64) {
    let along = apply(stretch, direction);
    (along, dot(along, along).sqrt())
}

fn trace(t: [f64; 4]) -> f64 {
    t[0] + t[1] + t[2]
}

/// Returns twice the deviator of a tensor.
fn deviator2(t: [f64; 4]) -> [f64; 4] {
    let mean = trace(t) / 3.0;
    [2.0 * (t[0] - mean), 2.0 * (t[1] - mean), 2.0 * (t[2] - mean), 2.0 * t[3]]
}

/// Returns the components of a tensor whose sum of squares is that of the tensor.
fn mandel(t: [f64; 4]) -> [f64; 4] {
    [t[0], t[1], t[2], std::f64::consts::SQRT_2 * t[3]]
}

fn norm(t: [f64; 4]) -> f64 {
    mandel(t).iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Returns the product of two symmetric tensors with the same axes.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] * b[0] + a[3] * b[3], a[1] * b[1] + a[3] * b[3], a[2] * b[2], a[0] * b[3] + a[3] * b[1]]
}

fn apply(t: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    [t[0] * v[0] + t[3] * v[1], t[3] * v[0] + t[1] * v[1], t[2] * v[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the symmetric part of the product of two vectors.
fn symmetric(a: [f64; 3], b: [f64; 3]) -> [f64; 4] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2], 0.5 * (a[0] * b[1] + a[1] * b[0])]
}

/// Returns the smallest and the largest eigenvalue of a tensor.
fn eigenvalues([rr, zz, hoop, rz]: [f64; 4]) -> (f64, f64) {
    let (middle, half) = (0.5 * (rr + zz), 0.5 * (rr - zz));
    let radius = (half * half + rz * rz).sqrt();
    (hoop.min(middle - radius), hoop.max(middle + radius))
}

impl PointArguments {
    /// Computes stresses and moduli from the derivatives of the energy at the stretches at the end of the increment.
    ///
    /// # Errors
    /// Errors of the subroutine; values written past the points or not finite; a volume that is not positive.
    pub(super) fn call_energy(
        &mut self,
        law: (&UserMaterialData, &AnisotropicEnergy),
        routine: Option<&mut (dyn UserEnergy + 'static)>,
        time: (&Instant, f64),
    ) -> Result<(), LoadFailure> {
        let Some(mut arguments) = self.energy.take() else { return Ok(()) };
        let (_, energy) = law;
        let responded = self
            .measure_energy(energy, &mut arguments)
            .and_then(|()| self.differentiate_energy(law, routine, time, &mut arguments))
            .map(|()| self.take_responses(energy, &mut arguments));
        self.energy = Some(arguments);
        responded
    }

    /// Calls VUANISOHYPER_INV, or the built-in energy, and checks the results.
    fn differentiate_energy(
        &mut self,
        (material, energy): (&UserMaterialData, &AnisotropicEnergy),
        routine: Option<&mut (dyn UserEnergy + 'static)>,
        (now, dt): (&Instant, f64),
        arguments: &mut EnergyArguments,
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (self.count, self.variables, self.fields);
        let [state_old, state] = &mut self.state;
        state[..m * n].copy_from_slice(&state_old[..m * n]);
        arguments.clear(n);
        if let Some(law) = &energy.built_in {
            arguments.differentiate(law, energy.fibres.len(), n);
            return Ok(());
        }
        let Some(routine) = routine else { return Ok(()) };
        let (count, derivatives) = (energy.count(), packed(0, energy.count()));
        let EnergyArguments { invariants, cosines, deviatoric, first, second, .. } = arguments;
        let call = EnergyCall {
            name: &material.name,
            now: *now,
            dt,
            count: n,
            integration_point: self.integration_point,
            variables: m,
            fields: f,
            properties: &material.properties,
            elements: &self.elements,
            state: &state_old[..m * n],
            families: energy.fibres.len(),
            temperature: [&self.temperature[0], &self.temperature[1]],
            field: [&self.field[0][..f * n], &self.field[1][..f * n]],
            invariants,
            cosines,
        };
        let answer = &mut EnergyAnswer {
            deviatoric: &mut deviatoric[..n],
            first: &mut first[..count * n],
            second: &mut second[..derivatives * n],
            state: &mut state[..m * n],
        };
        routine.energy(&call, answer)?;
        check_guards("uDev", deviatoric, n, 1)?;
        check_values("duDi", first, n, count)?;
        check_values("d2uDiDi", second, n, derivatives)?;
        check_guards("stateNew", state, n, m)
    }

    /// Computes the invariants of all points.
    fn measure_energy(&self, energy: &AnisotropicEnergy, arguments: &mut EnergyArguments) -> Result<(), LoadFailure> {
        let n = self.count;
        for i in 0..n {
            let j = measure(self.stretch_of(i), &energy.fibres, &mut arguments.point);
            if j.is_nan() || j <= 0.0 {
                let reason = format!("its volume is {j:e} of the initial one");
                return Err(LoadFailure { point: Some(i), reason });
            }
            for (a, invariant) in arguments.point.iter().enumerate() {
                arguments.invariants[a * n + i] = invariant.value;
            }
        }
        Ok(())
    }

    /// Sets stresses and moduli of all points.
    fn take_responses(&mut self, energy: &AnisotropicEnergy, arguments: &mut EnergyArguments) {
        let n = self.count;
        for i in 0..n {
            measure(self.stretch_of(i), &energy.fibres, &mut arguments.point);
            let EnergyResponse { stress, modulus, shear } = arguments.respond(i, n);
            stress.into_iter().enumerate().for_each(|(k, value)| self.stress[1][k * n + i] = value);
            (self.moduli[0][i], self.moduli[1][i]) = (modulus, shear);
        }
        for [old, new] in [&mut self.internal, &mut self.inelastic] {
            new.copy_from_slice(old);
        }
    }

    /// Returns the stretch tensor of a point at the end of the increment.
    fn stretch_of(&self, i: usize) -> [f64; 4] {
        [0, 1, 2, 3].inline_map(|k| self.stretch[1][k * self.count + i])
    }

    /// Computes the response in the initial configuration. Returns the bulk and shear modulus, the maximum over all points, with
    /// which a bar has the modulus of the fastest wave.
    ///
    /// # Errors
    /// Errors of the subroutine; a bulk or shear modulus that is not positive.
    pub(super) fn probe_energy(
        &mut self,
        law: (&UserMaterialData, &AnisotropicEnergy),
        routine: Option<&mut (dyn UserEnergy + 'static)>,
        now: &Instant,
    ) -> Result<[f64; 2], LoadFailure> {
        for (list, value) in self.stretch[1].chunks_mut(self.count).zip([1.0, 1.0, 1.0, 0.0]) {
            list.fill(value);
        }
        self.call_energy(law, routine, (now, 1.0))?;
        let mut largest = [0.0_f64; 2];
        for i in 0..self.count {
            let pressing = |list: &[f64], place: usize| list[place * self.count + i];
            let volumetric = self.energy.as_ref().map_or(f64::NAN, |arguments| {
                pressing(&arguments.first, VOLUME) + pressing(&arguments.second, packed(VOLUME, VOLUME))
            });
            let (modulus, shear) = (self.moduli[0][i], self.moduli[1][i]);
            if !(volumetric > 0.0 && shear > 0.0) {
                let reason = format!(
                    "in the initial configuration its bulk modulus duDi(k,3) + d2uDiDi(k,6) is {volumetric:e} and its mean \
                     shear modulus {shear:e}; the stable time increment needs both"
                );
                return Err(LoadFailure { point: Some(i), reason });
            }
            largest = [largest[0].max(modulus - 4.0 / 3.0 * shear), largest[1].max(shear)];
        }
        Ok(largest)
    }
}
