//! Motion of a rigid body along its axis against a resistance, by stages of its path: between two events the force is
//! `F = F0 + F1 v + F2 v²`, whose coefficients are quadratic polynomials of the depth. Without `F1` the square of the
//! velocity follows a linear equation; with it, and for times, the motion is a Taylor series in time.

use super::lanes::InlineMap;

/// Part of the path with one polynomial of the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceStage {
    /// Length of the path; infinite for the last stage.
    pub length: f64,
    /// `force[k][j]`: factor of `v^k ξ^j` of the force against the motion, with ξ = 0..1 along the stage. A stage of
    /// infinite length has factors of ξ⁰ only.
    pub force: [[f64; 3]; 3],
}

/// Motion of a body along its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathMotion {
    /// Distance from the start, length.
    pub distance: f64,
    /// Velocity along the path, not negative.
    pub velocity: f64,
    /// Deceleration at this instant; zero at rest.
    pub deceleration: f64,
    /// Time since the start.
    pub time: f64,
}

/// Event that ends the motion in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StageEnd {
    /// The body is at rest.
    Rest,
    /// The body has reached the end of the stage.
    Passed,
    /// The time is over.
    Time,
}

/// Effect of all previous stages on the square of the velocity: at the start of a stage `v² = gain (v0² - needed)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct StageTransfer {
    gain: f64,
    /// Square of the striking velocity with which the body just reaches the stage.
    needed: f64,
}

/// Path of a body with its mass, prepared for many striking velocities.
#[derive(Clone, Debug)]
pub struct ShotPath {
    mass: f64,
    stages: Vec<ForceStage>,
    /// Distance from the start to each stage.
    starts: Vec<f64>,
    /// Transfers to the starts of the first stages, as many as were needed; empty if a force has a linear term.
    transfers: Vec<StageTransfer>,
}

/// Highest power of the Taylor series.
const ORDER: usize = 16;
/// Size of the last terms of a series, relative to the sum or to the striking velocity.
const PRECISION: f64 = 1e-17;
/// Largest number of terms, of series in one stage, and of iterations for a root.
const MOST_TERMS: usize = 64;
const MOST_SERIES: usize = 10_000;
const MOST_ITERATIONS: usize = 100;

impl ForceStage {
    fn is_constant(&self) -> bool {
        self.force.iter().all(|factors| factors[1] == 0.0 && factors[2] == 0.0)
    }

    fn is_free(&self) -> bool {
        self.force.iter().flatten().all(|factor| *factor == 0.0)
    }

    fn is_valid(&self) -> bool {
        self.length > 0.0
            && self.force.iter().flatten().all(|factor| factor.is_finite())
            && (self.length.is_finite() || self.is_constant())
    }

    /// Returns the factors of v⁰, v¹ and v² at ξ.
    fn force_at(&self, xi: f64) -> [f64; 3] {
        self.force.inline_map(|[constant, linear, square]| constant + xi * (linear + xi * square))
    }

    /// Returns g and h with `v² = g v0² - h` at the end of the stage, for a force without linear term. Equation (2.19).
    fn transfer(&self, mass: f64) -> Option<[f64; 2]> {
        let scale = 2.0 * self.length / mass;
        let [a, b] = [self.force[0], self.force[2]].inline_map(|factors| factors.inline_map(|factor| scale * factor));
        if self.is_constant() {
            let loss = if b[0] > 0.0 { -libm::expm1(-b[0]) / b[0] } else { 1.0 };
            return Some([libm::exp(-b[0]), a[0] * loss]);
        }
        let parts = b.iter().map(|factor| factor.abs()).sum::<f64>().ceil().clamp(1.0, 1e6);
        let part_of = |[constant, linear, square]: [f64; 3], xi: f64| {
            let slope = linear + 2.0 * square * xi;
            [constant + xi * (linear + xi * square), slope / parts, square / (parts * parts)].inline_map(|f| f / parts)
        };
        let [mut gain, mut loss] = [1.0, 0.0];
        for part in 0..parts as usize {
            let xi = part as f64 / parts;
            let [g, h] = transfer_by_series(part_of(a, xi), part_of(b, xi))?;
            (gain, loss) = (g * gain, g * loss + h);
        }
        Some([gain, loss])
    }

    /// Moves a body from ξ = 0 to the end of the stage, to rest or to the time `duration`; `None` without convergence.
    /// `scale` is the striking velocity. Equation (2.21).
    fn traverse(&self, mass: f64, motion: &mut PathMotion, duration: f64, scale: f64) -> Option<StageEnd> {
        let unit = if self.length.is_finite() { self.length } else { 1.0 };
        let (start, mut xi) = (motion.distance, 0.0);
        for _ in 0..MOST_SERIES {
            let series = MotionSeries::new(self, mass, unit, [xi, motion.velocity]);
            let remaining = duration - motion.time;
            let whole = series.reach(scale).min(remaining);
            let mut time = whole;
            let rests = MotionSeries::value(&series.velocity, whole) <= 0.0;
            if rests {
                time = MotionSeries::root(&series.velocity, 0.0, whole);
            }
            let passes = self.length.is_finite() && MotionSeries::value(&series.place, time) >= 1.0;
            if passes {
                time = MotionSeries::root(&series.place, 1.0, time);
            }
            xi = if passes { 1.0 } else { MotionSeries::value(&series.place, time) };
            motion.time += time;
            motion.distance = start + xi * unit;
            motion.velocity = MotionSeries::value(&series.velocity, time).max(0.0);
            if passes {
                return Some(StageEnd::Passed);
            }
            if rests {
                (motion.velocity, motion.deceleration) = (0.0, 0.0);
                return Some(StageEnd::Rest);
            }
            if whole == remaining {
                let [constant, linear, square] = self.force_at(xi);
                motion.deceleration = (constant + motion.velocity * (linear + motion.velocity * square)) / mass;
                return Some(StageEnd::Time);
            }
        }
        None
    }
}

/// Returns g and h of `w(1) = g w(0) - h` for `w' = -(a + b w)` with quadratic polynomials a and b, by power series;
/// `None` without convergence. Equation (2.20).
fn transfer_by_series(a: [f64; 3], b: [f64; 3]) -> Option<[f64; 2]> {
    // The last three coefficients of the solution of the homogeneous equation from 1, and of the whole from 0.
    let (mut unit, mut from_rest) = ([1.0, 0.0, 0.0], [0.0; 3]);
    let (mut gain, mut loss) = (1.0, 0.0);
    for power in 0..MOST_TERMS {
        let factor = -1.0 / (power + 1) as f64;
        let sum = |last: [f64; 3]| b[0] * last[0] + b[1] * last[1] + b[2] * last[2];
        let next = factor * sum(unit);
        let next_from_rest = factor * (a.get(power).copied().unwrap_or(0.0) + sum(from_rest));
        unit = [next, unit[0], unit[1]];
        from_rest = [next_from_rest, from_rest[0], from_rest[1]];
        gain += next;
        loss -= next_from_rest;
        let is_small = |terms: [f64; 3], sum: f64| terms.iter().all(|term| term.abs() <= PRECISION * sum.abs());
        if power >= 3 && is_small(unit, gain) && is_small(from_rest, loss) {
            return Some([gain, loss]);
        }
    }
    None
}

/// Taylor series of the motion in time.
struct MotionSeries {
    /// Coefficients of ξ.
    place: [f64; ORDER + 1],
    velocity: [f64; ORDER + 1],
}

impl MotionSeries {
    /// Expands the motion from ξ and v; `unit` is the length of ξ = 1.
    fn new(stage: &ForceStage, mass: f64, unit: f64, [xi, speed]: [f64; 2]) -> MotionSeries {
        let [mut place, mut velocity] = [[0.0; ORDER + 1]; 2];
        (place[0], velocity[0]) = (xi, speed);
        let force = stage.force.inline_map(|factors| factors.inline_map(|factor| factor / mass));
        let varies = !stage.is_constant();
        let [mut square, mut speeds] = [[0.0; ORDER]; 2];
        let mut factors = [[0.0; ORDER]; 3];
        for n in 0..ORDER {
            let convolve = |a: &[f64], b: &[f64]| (0..=n).map(|i| a[i] * b[n - i]).sum::<f64>();
            if varies {
                square[n] = convolve(&place, &place);
            }
            speeds[n] = convolve(&velocity, &velocity);
            for (factor, [constant, linear, quadratic]) in factors.iter_mut().zip(force) {
                factor[n] = linear * place[n] + quadratic * square[n] + if n == 0 { constant } else { 0.0 };
            }
            let by_velocity = if varies {
                convolve(&factors[1], &velocity) + convolve(&factors[2], &speeds)
            } else {
                force[1][0] * velocity[n] + force[2][0] * speeds[n]
            };
            let count = (n + 1) as f64;
            place[n + 1] = velocity[n] / (unit * count);
            velocity[n + 1] = -(factors[0][n] + by_velocity) / count;
        }
        MotionSeries { place, velocity }
    }

    /// Returns the time over which the last terms are negligible (Jorba and Zou 2005, eq. 3-8).
    fn reach(&self, scale: f64) -> f64 {
        let of_term = |n: usize| {
            let term = self.velocity[n].abs();
            if term > 0.0 { libm::pow(PRECISION * scale / term, 1.0 / n as f64) } else { f64::INFINITY }
        };
        of_term(ORDER).min(of_term(ORDER - 1))
    }

    fn value(terms: &[f64; ORDER + 1], time: f64) -> f64 {
        terms.iter().rev().fold(0.0, |sum, term| sum * time + term)
    }

    fn slope(terms: &[f64; ORDER + 1], time: f64) -> f64 {
        (1..=ORDER).rev().fold(0.0, |sum, n| sum * time + n as f64 * terms[n])
    }

    /// Returns the time in `0..latest` at which a monotone series has a value: Newton's method, bisection where it leaves
    /// the bracket.
    fn root(terms: &[f64; ORDER + 1], value: f64, latest: f64) -> f64 {
        let rises = terms[0] < value;
        let [mut low, mut high] = [0.0, latest];
        let mut time = latest;
        for _ in 0..MOST_ITERATIONS {
            let excess = MotionSeries::value(terms, time) - value;
            if (excess > 0.0) == rises {
                high = time
            } else {
                low = time
            }
            let next = time - excess / MotionSeries::slope(terms, time);
            let next = if low <= next && next <= high { next } else { 0.5 * (low + high) };
            if (next - time).abs() <= 2.0 * f64::EPSILON * latest {
                return next;
            }
            time = next;
        }
        time
    }
}

impl ShotPath {
    /// Prepares the path of a body; `None` if a force is not finite. No force may be negative.
    pub fn new(mass: f64, stages: Vec<ForceStage>) -> Option<ShotPath> {
        let is_valid = mass > 0.0 && mass.is_finite() && stages.iter().all(ForceStage::is_valid);
        let mut starts = Vec::with_capacity(stages.len());
        let mut distance = 0.0;
        for stage in &stages {
            starts.push(distance);
            distance += stage.length;
        }
        let has_linear_term = stages.iter().any(|stage| stage.force[1] != [0.0; 3]);
        let first = StageTransfer { gain: 1.0, needed: 0.0 };
        let transfers = if has_linear_term || stages.is_empty() { Vec::new() } else { vec![first] };
        is_valid.then_some(ShotPath { mass, stages, starts, transfers })
    }

    /// Computes the transfers to the stages that a body with the square of a striking velocity reaches. Equation (2.19).
    fn extend_transfers(&mut self, squared: f64) {
        while let Some(&StageTransfer { gain, needed }) = self.transfers.last()
            && needed < squared
            && self.transfers.len() < self.stages.len()
        {
            match self.stages[self.transfers.len() - 1].transfer(self.mass) {
                Some([factor, loss]) => {
                    let gain = factor * gain;
                    let more = if loss > 0.0 { loss / gain } else { 0.0 };
                    self.transfers.push(StageTransfer { gain, needed: needed + more });
                }
                None => self.transfers.clear(),
            }
        }
    }

    /// Returns the motion at the time `duration` of a body with a striking velocity, or its rest before; `None` without
    /// convergence.
    pub fn motion_at(&mut self, velocity: f64, duration: f64) -> Option<PathMotion> {
        if velocity == 0.0 || self.stages.is_empty() {
            return Some(PathMotion { distance: velocity * duration, velocity, time: duration, deceleration: 0.0 });
        }
        self.rest(velocity, duration).or_else(|| self.integrated(velocity, duration))
    }

    /// Returns the place of rest from the squares of the velocity; `None` if the body is not certain to be at rest at the
    /// time `duration`. The time is an upper bound.
    fn rest(&mut self, striking: f64, duration: f64) -> Option<PathMotion> {
        let squared = striking * striking;
        self.extend_transfers(squared);
        let index = self.transfers.partition_point(|transfer| transfer.needed < squared).checked_sub(1)?;
        let (StageTransfer { gain, needed }, stage) = (self.transfers[index], &self.stages[index]);
        let entry = gain * (squared - needed);
        let (velocity, distance) = (entry.sqrt(), self.starts[index]);
        let mut motion = PathMotion { distance, velocity, time: distance / velocity, deceleration: 0.0 };
        if motion.time > duration {
            return None;
        }
        if !stage.is_constant() {
            return (stage.traverse(self.mass, &mut motion, duration, striking)? == StageEnd::Rest).then_some(motion);
        }
        let [[constant, ..], _, [square, ..]] = stage.force;
        if constant > 0.0 {
            motion.distance += rest_distance(self.mass, constant, square, entry);
            motion.time += velocity * self.mass / constant;
            motion.velocity = 0.0;
        }
        let is_inside = motion.distance <= distance + stage.length;
        (motion.velocity == 0.0 && is_inside && motion.time <= duration).then_some(motion)
    }

    /// Returns the motion with its times, by Taylor series in each stage.
    fn integrated(&self, striking: f64, duration: f64) -> Option<PathMotion> {
        let mut motion = PathMotion { velocity: striking, ..PathMotion::default() };
        for (stage, start) in self.stages.iter().zip(&self.starts) {
            motion.distance = *start;
            if stage.is_free() {
                let needed = stage.length / motion.velocity;
                if motion.time + needed > duration {
                    motion.distance += motion.velocity * (duration - motion.time);
                    return Some(PathMotion { time: duration, deceleration: 0.0, ..motion });
                }
                motion.time += needed;
            } else if stage.traverse(self.mass, &mut motion, duration, striking)? != StageEnd::Passed {
                return Some(motion);
            }
            if motion.velocity == 0.0 {
                return Some(motion);
            }
        }
        Some(motion)
    }
}

/// Returns the distance to rest from the square w of the velocity against `F0 + F2 v²` with F0 > 0. Equation (2.5).
fn rest_distance(mass: f64, constant: f64, square: f64, w: f64) -> f64 {
    let ratio = square * w / constant;
    // The logarithm over its argument is 1 at zero.
    let bend = if ratio > 0.0 { libm::log1p(ratio) / ratio } else { 1.0 };
    0.5 * mass * w / constant * bend
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: equation (2.5) with the digits of the theory manual, for the embedded ogive.
    #[test]
    fn embedded_ogive_matches_closed_form() {
        let force = [[55222.618593, 0.0, 0.0], [0.0; 3], [1.126227107768e-2, 0.0, 0.0]];
        let mut path = ShotPath::new(0.021, vec![ForceStage { length: f64::INFINITY, force }]).expect("a path");
        for (speed, depth, time) in [(569.0, 59.612643939e-3, 211.796527e-6), (1147.0, 221.597433967e-3, 402.452304e-6)]
        {
            let rest = path.motion_at(speed, 1.0).expect("a motion");
            assert!((rest.distance / depth - 1.0).abs() < 1e-10 && rest.velocity == 0.0, "{rest:?}");
            let integrated = path.integrated(speed, 1.0).expect("a motion");
            assert!((integrated.distance / depth - 1.0).abs() < 1e-10, "{integrated:?}");
            assert!((integrated.time / time - 1.0).abs() < 1e-8, "{integrated:?}");
        }
    }

    /// Both solutions of the same stages agree to rounding, at rest and at times before. A piecewise path with parts of a
    /// polynomial gives the motion of the whole.
    #[test]
    fn transfers_match_taylor_series() {
        let varied = [[2e4, 5e4, -2e4], [0.0; 3], [1e-3, 2e-2, 3e-2]];
        let end = [[5e4, 0.0, 0.0], [0.0; 3], [5.1e-2, 0.0, 0.0]];
        let last = ForceStage { length: f64::INFINITY, force: end };
        let mut path = ShotPath::new(0.02, vec![ForceStage { length: 0.4, force: varied }, last]).expect("a path");
        let half = varied.inline_map(|[constant, linear, square]| {
            let part = [constant, 0.5 * linear, 0.25 * square];
            [part, [part[0] + part[1] + part[2], part[1] + 2.0 * part[2], part[2]]]
        });
        let parts = [0, 1].inline_map(|i| ForceStage { length: 0.2, force: half.inline_map(|parts| parts[i]) });
        let mut divided = ShotPath::new(0.02, vec![parts[0], parts[1], last]).expect("a path");
        for speed in [1.0, 300.0, 700.0, 1500.0, 4000.0] {
            let mut motions = |duration| {
                let whole = path.motion_at(speed, duration).expect("a motion");
                [whole, divided.motion_at(speed, duration).expect("a motion")]
            };
            let (rest, [early, same]) = (motions(1.0), motions(1e-4));
            let integrated = path.integrated(speed, 1.0).expect("a motion");
            for motion in rest {
                assert!((motion.distance / integrated.distance - 1.0).abs() < 1e-12, "{motion:?} {integrated:?}");
            }
            assert!((early.distance / same.distance - 1.0).abs() < 1e-12, "{early:?} {same:?}");
            let difference = (early.deceleration - same.deceleration).abs();
            assert!(difference <= 1e-10 * same.deceleration, "{early:?} {same:?}");
        }
    }

    /// Source: m v dv/dx = -(α + γ v) with the closed form x = m/γ (v0 - α/γ ln(1 + γ v0/α)).
    #[test]
    fn linear_resistance_matches_closed_form() {
        let [mass, alpha, gamma] = [0.5, 3000.0, 40.0];
        let force = [[alpha, 0.0, 0.0], [gamma, 0.0, 0.0], [0.0; 3]];
        let mut path = ShotPath::new(mass, vec![ForceStage { length: f64::INFINITY, force }]).expect("a path");
        for speed in [0.1, 20.0, 3000.0] {
            let depth = mass / gamma * (speed - alpha / gamma * libm::log1p(gamma * speed / alpha));
            let rest = path.motion_at(speed, 10.0).expect("a motion");
            assert!((rest.distance / depth - 1.0).abs() < 1e-11, "{speed}: {} {depth}", rest.distance);
        }
    }
}
