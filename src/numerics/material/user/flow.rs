//! Return mapping of user materials with built-in elasticity. The yield stress is that of VUHARD
//! (`*PLASTIC, HARDENING=USER`), or of a built-in law for materials with user-defined fields. Each call of VUHARD
//! covers all points of a chunk that have not converged.
#![allow(clippy::needless_range_loop)] // Loops over points, with one array per quantity.

use super::description::{BuiltInPlasticity, PointYieldStress, UserMaterialData, YieldOverFields, YieldSource};
use super::points::{CHECKED_COMPONENTS, PointArguments, check_guards, check_values, guard_values};
use crate::kernel::hardening::{YieldStress, plastic_increment};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::routines::{HardeningAnswer, HardeningCall, LoadFailure, MAX_MATERIAL_BLOCK, UserHardening};
use crate::state::Instant;

/// Largest number of calls per increment; points that have not converged by then stop the run.
const ITERATIONS: usize = 120;
/// Number of calls after which every second one halves the bounds. The remaining calls then reduce them below
/// [`ENOUGH`] for any yield stress.
const BISECTED: usize = 40;
/// Convergence tolerance on |stress - yield stress| / trial stress; after [`BISECTED`] calls also on the width of the
/// bounds, as a stress relative to the trial stress.
const ENOUGH: f64 = 1e-11;
/// Smallest ratio of successive plastic strain increments of Newton's method in the logarithm.
const LEAST: f64 = 0.02;

/// Arguments and results of one VUHARD call for the points that have not converged, in their order.
#[derive(Clone, Debug, Default, Memory)]
pub struct HardeningBuffers {
    points: Vec<usize>,
    elements: Vec<i32>,
    temperature: [Vec<f64>; 2],
    field: [Vec<f64>; 2],
    state: [Vec<f64>; 2],
    strain: Vec<f64>,
    rate: Vec<f64>,
    stress: Vec<f64>,
    by_temperature: Vec<f64>,
    slopes: Vec<f64>,
}

/// Work arrays of the return mapping, one entry per point of a chunk.
#[derive(Clone, Debug, Default, Memory)]
pub struct ReturnScratch {
    buffers: HardeningBuffers,
    /// Points that have not converged.
    open: Vec<usize>,
    trial: Vec<f64>,
    /// Plastic strain increment, with its lower and upper bound.
    increment: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl ReturnScratch {
    /// Allocates the work arrays of a material, so that nothing is allocated during the run.
    pub fn new(material: &UserMaterialData) -> Self {
        let Some(flow) = &material.flow else { return ReturnScratch::default() };
        let n = MAX_MATERIAL_BLOCK;
        let reserved = |of: usize| Vec::with_capacity(of * n);
        let mut returning = ReturnScratch { trial: vec![0.0; n], increment: vec![0.0; n], ..ReturnScratch::default() };
        if matches!(flow.yields, YieldSource::User(_)) {
            (returning.low, returning.high) = (vec![0.0; n], vec![0.0; n]);
            returning.open = Vec::with_capacity(n);
            // Guard values follow each result, as for material results.
            let state_and_guards = material.variables + CHECKED_COMPONENTS + 1;
            returning.buffers = HardeningBuffers {
                points: Vec::with_capacity(n),
                elements: Vec::with_capacity(n),
                temperature: [reserved(1), reserved(1)],
                field: [reserved(material.fields), reserved(material.fields)],
                state: [reserved(material.variables), reserved(state_and_guards)],
                strain: reserved(1),
                rate: reserved(1),
                stress: reserved(2),
                by_temperature: reserved(2),
                slopes: reserved(3),
            };
        }
        returning
    }
}

/// Material and increment of a chunk.
#[derive(Clone, Copy)]
pub struct PointContext<'a> {
    pub material: &'a UserMaterialData,
    pub flow: &'a BuiltInPlasticity,
    pub heating: &'a PlasticHeating,
    /// Time, step and increment.
    pub now: &'a Instant,
    pub dt: f64,
}

impl PointArguments {
    /// Computes stresses, plastic strains and temperatures at the end of an increment.
    ///
    /// # Errors
    /// Errors of the subroutine; a missing yield stress; no convergence.
    pub fn flow(
        &mut self,
        context: PointContext<'_>,
        routine: Option<&mut (dyn UserHardening + 'static)>,
        returning: &mut ReturnScratch,
    ) -> Result<(), LoadFailure> {
        self.keep_state();
        self.try_elastic(context.flow, &mut returning.trial);
        returning.increment[..self.count].fill(0.0);
        match (&context.flow.yields, routine) {
            (YieldSource::Never, _) => {}
            (YieldSource::Law(law), _) => self.return_by_law(&**law, context, returning),
            (YieldSource::OverFields(law), _) => self.return_by_table(law, context, returning),
            (YieldSource::User(properties), Some(routine)) => self.search(properties, context, routine, returning)?,
            (YieldSource::User(_), None) => return Ok(()),
        }
        self.apply_plastic_increments(context, returning);
        Ok(())
    }

    fn keep_state(&mut self) {
        for [old, new] in [&mut self.state, &mut self.inelastic, &mut self.plastic] {
            new.copy_from_slice(old);
        }
    }

    /// Computes the elastic trial stress and its von Mises stress with the moduli of each point at its temperature and
    /// fields. The stress is that of the total elastic strain with the current moduli: the previous stress is scaled by
    /// the ratio of the moduli (ABAQUS Analysis User's Guide 22.2.1, "Linear elastic behavior").
    fn try_elastic(&mut self, flow: &BuiltInPlasticity, trial: &mut [f64]) {
        let n = self.count;
        for i in 0..n {
            let moduli_at = |end: usize| {
                let (temperature, field) = (self.temperature[end][i], &self.field[end]);
                let varying = flow.elasticity.as_ref().map(|e| e.moduli(temperature, |v| field[v * n + i]));
                varying.unwrap_or([flow.bulk, flow.shear])
            };
            let [bulk, shear] = moduli_at(1);
            let previous_moduli = self.moduli.each_ref().inline_map(|list| list.get(i).copied().unwrap_or(f64::NAN));
            let [bulk_before, shear_before] = if previous_moduli[0].is_nan() { moduli_at(0) } else { previous_moduli };
            let strain = [0, 1, 2, 3].inline_map(|k| self.strain[k * n + i]);
            let old = [0, 1, 2, 3].inline_map(|k| self.stress[0][k * n + i]);
            let dilation = strain[0] + strain[1] + strain[2];
            let mean = (old[0] + old[1] + old[2]) * (1.0 / 3.0);
            let (of_mean, of_deviator) = (bulk / bulk_before, shear / shear_before);
            let deviator = |k: usize| {
                let (base, dilation) = if k < 3 { (mean, dilation * (1.0 / 3.0)) } else { (0.0, 0.0) };
                of_deviator * (old[k] - base) + 2.0 * shear * (strain[k] - dilation)
            };
            let s = [0, 1, 2, 3].inline_map(deviator);
            let pressure = of_mean * mean + bulk * dilation;
            for (k, part) in s.into_iter().enumerate() {
                self.stress[1][k * n + i] = if k < 3 { pressure + part } else { part };
            }
            for (list, modulus) in self.moduli.iter_mut().zip([bulk, shear]) {
                list.iter_mut().skip(i).take(1).for_each(|kept| *kept = modulus);
            }
            let [a, b, c, d] = s.inline_map(|s| s * s);
            trial[i] = (1.5 * (a + b + c) + 3.0 * d).sqrt();
        }
    }

    /// Returns three times the shear modulus of a point.
    fn shear3(&self, flow: &BuiltInPlasticity, point: usize) -> f64 {
        3.0 * self.moduli[1].get(point).copied().unwrap_or(flow.shear)
    }

    /// Computes the plastic strain increments with a built-in law.
    fn return_by_law(&self, law: &dyn YieldStress, context: PointContext<'_>, returning: &mut ReturnScratch) {
        (0..self.count).for_each(|i| returning.increment[i] = self.increment(law, i, context, returning.trial[i]));
    }

    /// Computes the plastic strain increments with a table over field variables.
    fn return_by_table(&self, law: &YieldOverFields, context: PointContext<'_>, returning: &mut ReturnScratch) {
        for i in 0..self.count {
            let law = PointYieldStress::new(law, |v| self.field[1][v * self.count + i]);
            returning.increment[i] = self.increment(&law, i, context, returning.trial[i]);
        }
    }

    fn increment(&self, law: &dyn YieldStress, i: usize, context: PointContext<'_>, trial: f64) -> f64 {
        let (strain, temperature) = (self.plastic[0][i], self.temperature[1][i]);
        plastic_increment(law, trial, strain, temperature, self.shear3(context.flow, i), context.dt)
    }

    /// Computes the plastic strain increments with VUHARD, by Newton's method with its slopes over all points at once;
    /// bounds enclose each increment. The trial stress minus `3 G dp` decreases with dp, and equals the yield stress at
    /// `p + dp` and `dp/dt`. Above the root, where the yield stress is steeper than 3 G, the variable of the method is
    /// the logarithm of dp, as for built-in laws: the slope of power laws is unbounded at first yield.
    fn search(
        &mut self,
        properties: &[f64],
        context: PointContext<'_>,
        routine: &mut dyn UserHardening,
        returning: &mut ReturnScratch,
    ) -> Result<(), LoadFailure> {
        let ReturnScratch { buffers, open, trial, increment, low, high } = returning;
        open.clear();
        open.extend(0..self.count);
        for iteration in 0..ITERATIONS {
            if open.is_empty() {
                return Ok(());
            }
            self.call_hardening(properties, context, routine, (&*open, &*increment), buffers)?;
            let (stress, slopes) = (&buffers.stress, &buffers.slopes);
            let count = open.len();
            let mut unchanged = 0;
            for at in 0..count {
                let i = open[at];
                let shear3 = self.shear3(context.flow, i);
                let (dp, returned) = (increment[i], trial[i] - shear3 * increment[i]);
                let over = returned - stress[at];
                if iteration == 0 {
                    (low[i], high[i]) = (0.0, trial[i] / shear3);
                    if over <= 0.0 {
                        continue;
                    }
                } else if over.abs() <= ENOUGH * trial[i]
                    || high[i] - low[i] <= 1e-15 * high[i]
                    || iteration > BISECTED && shear3 * (high[i] - low[i]) <= ENOUGH * trial[i]
                {
                    continue;
                } else if over > 0.0 {
                    low[i] = dp;
                } else {
                    high[i] = dp;
                }
                let mut hardening = slopes[at];
                // In the first iteration the rate is zero, where derivatives of logarithmic rate laws are undefined.
                if iteration > 0 && context.dt > 0.0 {
                    hardening += slopes[count + at] / context.dt;
                }
                let change = over / (shear3 + hardening);
                let is_steep = over < 0.0 && hardening > shear3;
                let newton = if is_steep { dp * (dp / (dp - change)).max(LEAST) } else { dp + change };
                let perfect = dp + over / shear3;
                let bisects = iteration > BISECTED && iteration % 2 == 0;
                increment[i] = if bisects {
                    0.5 * (low[i] + high[i])
                } else if newton > low[i] && newton < high[i] {
                    newton
                } else if iteration == 0 && perfect < high[i] {
                    perfect
                } else {
                    0.5 * (low[i] + high[i])
                };
                open[unchanged] = i;
                unchanged += 1;
            }
            open.truncate(unchanged);
        }
        let i = open[0];
        let reason = format!(
            "the return to the yield surface has not converged after {ITERATIONS} calls: von Mises stress of the trial \
             {:e}, plastic strain {:e}, its increment between {:e} and {:e}",
            trial[i], self.plastic[0][i], low[i], high[i]
        );
        Err(LoadFailure { point: Some(i), reason })
    }

    /// Calls VUHARD for some points with trial plastic strains, and stores their state variables.
    fn call_hardening(
        &mut self,
        properties: &[f64],
        context: PointContext<'_>,
        routine: &mut dyn UserHardening,
        (open, increment): (&[usize], &[f64]),
        buffers: &mut HardeningBuffers,
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (open.len(), context.material.variables, context.material.fields);
        self.gather(context, (open, increment), buffers);
        let [state_before, state] = &mut buffers.state;
        let call = HardeningCall {
            name: &context.material.name,
            now: *context.now,
            dt: context.dt,
            count: n,
            integration_point: self.integration_point,
            variables: m,
            fields: f,
            properties,
            elements: &buffers.elements,
            temperature: [&buffers.temperature[0], &buffers.temperature[1]],
            field: [&buffers.field[0], &buffers.field[1]],
            state: &state_before[..m * n],
            strain: &buffers.strain,
            rate: &buffers.rate,
        };
        let answer = &mut HardeningAnswer {
            stress: &mut buffers.stress[..n],
            by_temperature: &mut buffers.by_temperature[..n],
            slopes: &mut buffers.slopes[..2 * n],
            state: &mut state[..m * n],
        };
        routine.yield_stress(&call, answer).map_err(|failure| self.of_chunk(failure, open))?;
        let answers = [
            ("dyieldDtemp", &mut buffers.by_temperature, 1),
            ("dyieldDeqps", &mut buffers.slopes, 2),
            ("stateNew", &mut buffers.state[1], m),
        ];
        answers.into_iter().try_for_each(|(name, list, components)| check_guards(name, list, n, components))?;
        check_values("stateNew", &mut buffers.state[1], n, m).map_err(|failure| self.of_chunk(failure, open))?;
        check_guards("yield", &mut buffers.stress, n, 1)?;
        if let Some(at) = buffers.stress[..n].iter().position(|y| y.is_nan()) {
            let reason = format!(
                "it returned yield(k) = NaN at the plastic strain {:e}, its rate {:e} and the temperature {:e}",
                buffers.strain[at], buffers.rate[at], buffers.temperature[1][at]
            );
            return Err(LoadFailure { point: Some(open[at]), reason });
        }
        // Slopes that are not finite are ignored; the bounds converge without them.
        for slope in buffers.slopes.iter_mut().chain(&mut buffers.by_temperature).filter(|s| !s.is_finite()) {
            *slope = 0.0;
        }
        for (at, &i) in open.iter().enumerate() {
            (0..m).for_each(|v| self.state[1][v * self.count + i] = buffers.state[1][v * n + at]);
        }
        Ok(())
    }

    /// Collects the arguments of a call for some points.
    fn gather(&self, context: PointContext<'_>, (open, increment): (&[usize], &[f64]), buffers: &mut HardeningBuffers) {
        let per_dt = if context.dt > 0.0 { 1.0 / context.dt } else { 0.0 };
        refill(&mut buffers.elements, open.iter().map(|&i| self.elements[i]));
        // Temperatures exclude the heat of this increment, as for built-in laws.
        for (list, all) in buffers.temperature.iter_mut().zip(&self.temperature) {
            refill(list, open.iter().map(|&i| all[i]));
        }
        refill(&mut buffers.strain, open.iter().map(|&i| self.plastic[0][i] + increment[i]));
        refill(&mut buffers.rate, open.iter().map(|&i| increment[i] * per_dt));
        let n = open.len();
        for (list, all) in buffers.field.iter_mut().zip(&self.field) {
            refill(list, (0..context.material.fields).flat_map(|v| open.iter().map(move |&i| all[v * self.count + i])));
        }
        let variables = context.material.variables;
        let states = || (0..variables).flat_map(|v| open.iter().map(move |&i| self.state[0][v * self.count + i]));
        refill(&mut buffers.state[0], states());
        refill(&mut buffers.state[1], states().chain(guard_values(CHECKED_COMPONENTS * n)));
        refill(&mut buffers.stress, std::iter::repeat_n(f64::NAN, n).chain(guard_values(0)));
        refill(&mut buffers.by_temperature, std::iter::repeat_n(0.0, n).chain(guard_values(0)));
        refill(&mut buffers.slopes, std::iter::repeat_n(0.0, 2 * n).chain(guard_values(0)));
    }

    /// Converts the point of a failure from its index in the call to its index in the chunk.
    fn of_chunk(&self, failure: LoadFailure, open: &[usize]) -> LoadFailure {
        LoadFailure { point: failure.point.and_then(|at| open.get(at).copied()), ..failure }
    }

    /// Applies the plastic strain increments: stress on the yield surface, plastic strain, work of the mean of previous
    /// and new stress, and its heat.
    fn apply_plastic_increments(&mut self, context: PointContext<'_>, returning: &ReturnScratch) {
        let n = self.count;
        for i in 0..n {
            let shear3 = self.shear3(context.flow, i);
            let (trial, dp) = (returning.trial[i], returning.increment[i]);
            if dp <= 0.0 {
                continue;
            }
            let returned = trial - shear3 * dp;
            let factor = returned / trial;
            let mean = (0..3).map(|k| self.stress[1][k * n + i]).sum::<f64>() * (1.0 / 3.0);
            let mut along = 0.0;
            for k in 0..4 {
                let (base, twice) = if k < 3 { (mean, 1.0) } else { (0.0, 2.0) };
                let (old, stress) = (self.stress[0][k * n + i], &mut self.stress[1][k * n + i]);
                let deviator = *stress - base;
                *stress = base + factor * deviator;
                along += twice * (old + *stress) * deviator;
            }
            let work = 0.75 * along * dp / trial;
            self.plastic[1][i] = self.plastic[0][i] + dp;
            self.inelastic[1][i] = self.inelastic[0][i] + work / self.density[i];
            let without = self.temperature[1][i];
            self.temperature[1][i] = without + context.heating.rise(without, [work]);
        }
    }
}

fn refill<T>(list: &mut Vec<T>, values: impl Iterator<Item = T>) {
    list.clear();
    list.extend(values);
}
