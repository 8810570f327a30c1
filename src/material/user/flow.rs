//! Plastic flow behind a yield stress that the user's routine gives (`*PLASTIC, HARDENING=USER`), or of a material whose state
//! the user's routines change: radial return of von Mises plasticity over the points of a chunk, with one call for all points
//! that still look for their plastic strain.
//! Never here: geometry of elements, laws of yield stresses.
#![allow(clippy::needless_range_loop)] // Loops over points, of which several lists hold something.

use super::description::{AtFields, Description, Flow, Yield, YieldOverFields};
use super::points::{Points, answered, marks, untouched};
use crate::kernel::hardening::{YieldStress, plastic_increment};
use crate::kernel::heating::Heating;
use crate::kernel::lanes::InlineMap;
use crate::state::Instant;
use crate::user::{HardeningAnswer, HardeningCall, LoadFailure, MAX_MATERIAL_BLOCK, UserHardening};

/// Calls of the routine for one increment after which what has not converged is told.
const ITERATIONS: usize = 80;
/// How near the stress must be to the yield stress, relative to the trial's.
const ENOUGH: f64 = 1e-11;

/// What a question for a chunk's points needs, and its answers: of the points asked for, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Asked {
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

/// Scratch memory of the return: of each point of a chunk.
#[derive(Clone, Debug, Default)]
pub struct Returning {
    asked: Asked,
    /// Points that still look for their plastic strain.
    open: Vec<usize>,
    trial: Vec<f64>,
    /// Increment of the plastic strain, and what it lies between.
    increment: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Returning {
    /// Room for all that a material asks: nothing allocates later.
    pub fn new(material: &Description) -> Self {
        let Some(flow) = &material.flow else { return Returning::default() };
        let n = MAX_MATERIAL_BLOCK;
        let room = |of: usize| Vec::with_capacity(of * n);
        let mut returning = Returning { trial: vec![0.0; n], increment: vec![0.0; n], ..Returning::default() };
        if matches!(flow.yields, Yield::User(_)) {
            (returning.low, returning.high) = (vec![0.0; n], vec![0.0; n]);
            returning.open = Vec::with_capacity(n);
            // Guards stand behind each answer, as behind those of a material.
            returning.asked = Asked {
                points: Vec::with_capacity(n),
                elements: Vec::with_capacity(n),
                temperature: [room(1), room(1)],
                field: [room(material.fields), room(material.fields)],
                state: [room(material.variables), room(material.variables + 1)],
                strain: room(1),
                rate: room(1),
                stress: room(2),
                by_temperature: room(2),
                slopes: room(3),
            };
        }
        returning
    }

    pub fn bytes(&self) -> usize {
        let Returning { asked, open, trial, increment, low, high } = self;
        let Asked { points, elements, temperature, field, state, strain, rate, stress, by_temperature, slopes } = asked;
        let single = [trial, increment, low, high, strain, rate, stress, by_temperature, slopes];
        let lists = single.into_iter().chain(temperature).chain(field).chain(state);
        let numbers: usize = lists.map(|list| 8 * list.capacity()).sum();
        numbers + 8 * (open.capacity() + points.capacity()) + 4 * elements.capacity()
    }
}

/// What a chunk's increment is under.
#[derive(Clone, Copy)]
pub struct PointContext<'a> {
    pub material: &'a Description,
    pub flow: &'a Flow,
    pub heating: &'a Heating,
    /// Clock, step and increment.
    pub now: &'a Instant,
    pub dt: f64,
}

impl Points {
    /// Stresses, plastic strains and temperatures at the end of an increment.
    ///
    /// # Errors
    /// The routine's own, and where it gave no yield stress or none that the stress can meet.
    pub fn flow(
        &mut self,
        under: PointContext<'_>,
        routine: Option<&mut (dyn UserHardening + 'static)>,
        returning: &mut Returning,
    ) -> Result<(), LoadFailure> {
        self.keep_state();
        self.try_elastic(under.flow, &mut returning.trial);
        returning.increment[..self.count].fill(0.0);
        match (&under.flow.yields, routine) {
            (Yield::Never, _) => {}
            (Yield::Law(law), _) => self.meet(&**law, under, returning),
            (Yield::OverFields(law), _) => self.meet_over_fields(law, under, returning),
            (Yield::User(properties), Some(routine)) => self.search(properties, under, routine, returning)?,
            (Yield::User(_), None) => return Ok(()),
        }
        self.settle(under, returning);
        Ok(())
    }

    fn keep_state(&mut self) {
        for [old, new] in [&mut self.state, &mut self.inelastic, &mut self.plastic] {
            new.copy_from_slice(old);
        }
    }

    /// The stress of an elastic increment by the moduli of each point at its temperature and fields, and its von Mises stress.
    /// The stress is that of the whole elastic strain by the moduli now: what stood by the moduli before is scaled by their
    /// change (ABAQUS Analysis User's Guide 22.2.1, "Linear elastic behavior").
    fn try_elastic(&mut self, flow: &Flow, trial: &mut [f64]) {
        let n = self.count;
        for i in 0..n {
            let at = |end: usize| {
                let (temperature, field) = (self.temperature[end][i], &self.field[end]);
                let varying = flow.elasticity.as_ref().map(|e| e.moduli(temperature, |v| field[v * n + i]));
                varying.unwrap_or([flow.bulk, flow.shear])
            };
            let [bulk, shear] = at(1);
            let before = self.moduli.each_ref().inline_map(|list| list.get(i).copied().unwrap_or(f64::NAN));
            let [bulk_before, shear_before] = if before[0].is_nan() { at(0) } else { before };
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

    /// Three times the shear modulus of a point.
    fn shear3(&self, flow: &Flow, point: usize) -> f64 {
        3.0 * self.moduli[1].get(point).copied().unwrap_or(flow.shear)
    }

    /// The plastic strain of each point by a law that is built in.
    fn meet(&self, law: &dyn YieldStress, under: PointContext<'_>, returning: &mut Returning) {
        (0..self.count).for_each(|i| returning.increment[i] = self.increment(law, i, under, returning.trial[i]));
    }

    /// The same by a table over the fields of the point.
    fn meet_over_fields(&self, law: &YieldOverFields, under: PointContext<'_>, returning: &mut Returning) {
        for i in 0..self.count {
            let law = AtFields::new(law, |v| self.field[1][v * self.count + i]);
            returning.increment[i] = self.increment(&law, i, under, returning.trial[i]);
        }
    }

    fn increment(&self, law: &dyn YieldStress, i: usize, under: PointContext<'_>, trial: f64) -> f64 {
        let (strain, temperature) = (self.plastic[0][i], self.temperature[1][i]);
        plastic_increment(law, trial, strain, temperature, self.shear3(under.flow, i), under.dt)
    }

    /// The plastic strain of each point by the routine: Newton's method with its slopes over all points at once, each kept
    /// between bounds that enclose it. The trial stress less 3 G dp falls with dp, and meets the yield stress at p + dp and
    /// dp/dt.
    fn search(
        &mut self,
        properties: &[f64],
        under: PointContext<'_>,
        routine: &mut dyn UserHardening,
        returning: &mut Returning,
    ) -> Result<(), LoadFailure> {
        let Returning { asked, open, trial, increment, low, high } = returning;
        open.clear();
        open.extend(0..self.count);
        for iteration in 0..ITERATIONS {
            if open.is_empty() {
                return Ok(());
            }
            self.ask(properties, under, routine, (&*open, &*increment), asked)?;
            let (stress, slopes) = (&asked.stress, &asked.slopes);
            let count = open.len();
            let mut kept = 0;
            for at in 0..count {
                let i = open[at];
                let shear3 = self.shear3(under.flow, i);
                let (dp, returned) = (increment[i], trial[i] - shear3 * increment[i]);
                let over = returned - stress[at];
                if iteration == 0 {
                    (low[i], high[i]) = (0.0, trial[i] / shear3);
                    if over <= 0.0 {
                        continue;
                    }
                } else if over.abs() <= ENOUGH * trial[i] || high[i] - low[i] <= 1e-15 * high[i] {
                    continue;
                } else if over > 0.0 {
                    low[i] = dp;
                } else {
                    high[i] = dp;
                }
                let mut hardening = slopes[at];
                // At the beginning the rate is none, where slopes over its logarithm have no meaning.
                if iteration > 0 && under.dt > 0.0 {
                    hardening += slopes[count + at] / under.dt;
                }
                let newton = dp + over / (shear3 + hardening);
                let perfect = dp + over / shear3;
                increment[i] = if newton > low[i] && newton < high[i] {
                    newton
                } else if iteration == 0 && perfect < high[i] {
                    perfect
                } else {
                    0.5 * (low[i] + high[i])
                };
                open[kept] = i;
                kept += 1;
            }
            open.truncate(kept);
        }
        let i = open[0];
        let reason = format!(
            "its yield stress is not met by the stress after {ITERATIONS} calls: von Mises stress of the trial {:e}, plastic \
             strain {:e}, its increment between {:e} and {:e}",
            trial[i], self.plastic[0][i], low[i], high[i]
        );
        Err(LoadFailure { point: Some(i), reason })
    }

    /// Asks the routine for some points with the plastic strain tried, and keeps the state variables that it gives them.
    fn ask(
        &mut self,
        properties: &[f64],
        under: PointContext<'_>,
        routine: &mut dyn UserHardening,
        (open, increment): (&[usize], &[f64]),
        asked: &mut Asked,
    ) -> Result<(), LoadFailure> {
        let (n, m, f) = (open.len(), under.material.variables, under.material.fields);
        self.gather(under, (open, increment), asked);
        let [state_before, state] = &mut asked.state;
        let call = HardeningCall {
            name: &under.material.name,
            now: *under.now,
            dt: under.dt,
            count: n,
            variables: m,
            fields: f,
            properties,
            elements: &asked.elements,
            temperature: [&asked.temperature[0], &asked.temperature[1]],
            field: [&asked.field[0], &asked.field[1]],
            state: &state_before[..m * n],
            strain: &asked.strain,
            rate: &asked.rate,
        };
        let answer = &mut HardeningAnswer {
            stress: &mut asked.stress[..n],
            by_temperature: &mut asked.by_temperature[..n],
            slopes: &mut asked.slopes[..2 * n],
            state: &mut state[..m * n],
        };
        routine.yield_stress(&call, answer).map_err(|failure| self.of_chunk(failure, open))?;
        let answers = [
            ("dyieldDtemp", &mut asked.by_temperature, 1),
            ("dyieldDeqps", &mut asked.slopes, 2),
            ("stateNew", &mut asked.state[1], m),
        ];
        answers.into_iter().try_for_each(|(name, list, components)| untouched(name, list, n, components))?;
        answered("stateNew", &mut asked.state[1], n, m).map_err(|failure| self.of_chunk(failure, open))?;
        untouched("yield", &mut asked.stress, n, 1)?;
        if let Some(at) = asked.stress[..n].iter().position(|y| y.is_nan()) {
            let reason = format!(
                "it gave yield(k) = NaN at the plastic strain {:e}, its rate {:e} and the temperature {:e}",
                asked.strain[at], asked.rate[at], asked.temperature[1][at]
            );
            return Err(LoadFailure { point: Some(open[at]), reason });
        }
        // A slope that is none says nothing: the bounds find the plastic strain without it.
        for slope in asked.slopes.iter_mut().chain(&mut asked.by_temperature).filter(|s| !s.is_finite()) {
            *slope = 0.0;
        }
        for (at, &i) in open.iter().enumerate() {
            (0..m).for_each(|v| self.state[1][v * self.count + i] = asked.state[1][v * n + at]);
        }
        Ok(())
    }

    /// Puts before the routine what it is asked for.
    fn gather(&self, under: PointContext<'_>, (open, increment): (&[usize], &[f64]), asked: &mut Asked) {
        let per_dt = if under.dt > 0.0 { 1.0 / under.dt } else { 0.0 };
        refill(&mut asked.elements, open.iter().map(|&i| self.elements[i]));
        // As laws that are built in take it: without the heat of the increment.
        for (list, all) in asked.temperature.iter_mut().zip(&self.temperature) {
            refill(list, open.iter().map(|&i| all[i]));
        }
        refill(&mut asked.strain, open.iter().map(|&i| self.plastic[0][i] + increment[i]));
        refill(&mut asked.rate, open.iter().map(|&i| increment[i] * per_dt));
        let n = open.len();
        for (list, all) in asked.field.iter_mut().zip(&self.field) {
            refill(list, (0..under.material.fields).flat_map(|v| open.iter().map(move |&i| all[v * self.count + i])));
        }
        let variables = under.material.variables;
        let states = || (0..variables).flat_map(|v| open.iter().map(move |&i| self.state[0][v * self.count + i]));
        refill(&mut asked.state[0], states());
        refill(&mut asked.state[1], states().chain(marks()));
        refill(&mut asked.stress, std::iter::repeat_n(f64::NAN, n).chain(marks()));
        refill(&mut asked.by_temperature, std::iter::repeat_n(0.0, n).chain(marks()));
        refill(&mut asked.slopes, std::iter::repeat_n(0.0, 2 * n).chain(marks()));
    }

    /// A failure at one of the points asked for, as that point of the chunk.
    fn of_chunk(&self, failure: LoadFailure, open: &[usize]) -> LoadFailure {
        LoadFailure { point: failure.point.and_then(|at| open.get(at).copied()), ..failure }
    }

    /// The stress on the yield surface, its plastic strain, work and heat.
    fn settle(&mut self, under: PointContext<'_>, returning: &Returning) {
        let n = self.count;
        for i in 0..n {
            let shear3 = self.shear3(under.flow, i);
            let (trial, dp) = (returning.trial[i], returning.increment[i]);
            if dp <= 0.0 {
                continue;
            }
            let returned = trial - shear3 * dp;
            let factor = returned / trial;
            let mean = (0..3).map(|k| self.stress[1][k * n + i]).sum::<f64>() * (1.0 / 3.0);
            for k in 0..4 {
                let base = if k < 3 { mean } else { 0.0 };
                let stress = &mut self.stress[1][k * n + i];
                *stress = base + factor * (*stress - base);
            }
            self.plastic[1][i] = self.plastic[0][i] + dp;
            self.inelastic[1][i] = self.inelastic[0][i] + returned * dp / self.density[i];
            let without = self.temperature[1][i];
            self.temperature[1][i] = without + under.heating.rise(without, [returned, dp]);
        }
    }
}

fn refill<T>(list: &mut Vec<T>, values: impl Iterator<Item = T>) {
    list.clear();
    list.extend(values);
}
