//! Motion of a rigid body along its axis against a resistance, by stages of its path: between two events the force is
//! `F = F0 + F1 v + F2 v²`, whose coefficients are quadratic polynomials of the depth. Without `F1` the square of the
//! velocity follows a linear equation; with it, and for times, the motion is a Taylor series in time. Numbers with
//! derivatives ([`super::dual`]) give the exact derivatives of the motion.

use super::dual::Scalar;
use super::lanes::InlineMap;

/// Part of the path with one polynomial of the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceStage<T = f64> {
    /// Length of the path; infinite for the last stage.
    pub length: T,
    /// `force[k][j]`: factor of `v^k ξ^j` of the force against the motion, with ξ = 0..1 along the stage. A stage of
    /// infinite length has factors of ξ⁰ only.
    pub force: [[T; 3]; 3],
}

/// Motion of a body along its path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathMotion<T = f64> {
    /// Distance from the start, length.
    pub distance: T,
    /// Velocity along the path, not negative.
    pub velocity: T,
    /// Deceleration at this instant; zero at rest.
    pub deceleration: T,
    /// Time since the start.
    pub time: T,
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
struct StageTransfer<T> {
    gain: T,
    /// Square of the striking velocity with which the body just reaches the stage.
    needed: T,
}

/// Path of a body with its mass, prepared for many striking velocities.
#[derive(Clone, Debug)]
pub struct ShotPath<T = f64> {
    mass: T,
    stages: Vec<ForceStage<T>>,
    /// Distance from the start to each stage.
    starts: Vec<T>,
    /// Transfers to the starts of the first stages, as many as were needed; empty if a force has a linear term.
    transfers: Vec<StageTransfer<T>>,
}

/// Highest power of the Taylor series.
const ORDER: usize = 16;
/// Size of the last terms of a series, relative to the sum or to the striking velocity.
const PRECISION: f64 = 1e-17;
/// Largest number of terms, of series in one stage, and of iterations for a root.
const MOST_TERMS: usize = 64;
const MOST_SERIES: usize = 10_000;
const MOST_ITERATIONS: usize = 100;

impl<T: Scalar> ForceStage<T> {
    fn is_constant(&self) -> bool {
        let zero = T::constant(0.0);
        self.force.iter().all(|factors| factors[1] == zero && factors[2] == zero)
    }

    fn is_free(&self) -> bool {
        self.force.iter().flatten().all(|factor| *factor == T::constant(0.0))
    }

    fn is_valid(&self) -> bool {
        self.length.value() > 0.0
            && self.force.iter().flatten().all(|factor| factor.is_finite())
            && (self.is_bounded() || self.is_constant())
    }

    /// Returns whether the stage has an end.
    fn is_bounded(&self) -> bool {
        self.length.value().is_finite()
    }

    /// Returns the factors of v⁰, v¹ and v² at ξ.
    fn force_at(&self, xi: T) -> [T; 3] {
        self.force.inline_map(|[constant, linear, square]| constant + xi * (linear + xi * square))
    }

    /// Returns g and h with `v² = g v0² - h` at the end of the stage, for a force without linear term. Equation (2.19).
    fn transfer(&self, mass: T) -> Option<[T; 2]> {
        let scale = self.length * 2.0 / mass;
        let [a, b] = [self.force[0], self.force[2]].inline_map(|factors| factors.inline_map(|factor| scale * factor));
        if self.is_constant() {
            return Some([(-b[0]).exp(), a[0] * b[0].mean_of_decay()]);
        }
        let parts = b.iter().map(|factor| factor.value().abs()).sum::<f64>().ceil().clamp(1.0, 1e6);
        let over = |factor: T, count: f64| factor / T::constant(count);
        let part_of = |[constant, linear, square]: [T; 3], xi: f64| {
            let slope = linear + square * 2.0 * xi;
            [constant + (linear + square * xi) * xi, over(slope, parts), over(square, parts * parts)]
                .inline_map(|factor| over(factor, parts))
        };
        let [mut gain, mut loss] = [1.0, 0.0].inline_map(T::constant);
        for part in 0..parts as usize {
            let xi = part as f64 / parts;
            let [g, h] = transfer_by_series(part_of(a, xi), part_of(b, xi))?;
            (gain, loss) = (g * gain, g * loss + h);
        }
        Some([gain, loss])
    }

    /// Moves a body from ξ = 0 to the end of the stage, to rest or to the time `duration`; `None` without convergence.
    /// `scale` is the striking velocity. Equation (2.21).
    fn traverse(&self, mass: T, motion: &mut PathMotion<T>, duration: f64, scale: f64) -> Option<StageEnd> {
        let unit = if self.is_bounded() { self.length } else { T::constant(1.0) };
        let (start, mut xi) = (motion.distance, T::constant(0.0));
        for _ in 0..MOST_SERIES {
            let series = MotionSeries::new(self, mass, unit, [xi, motion.velocity]);
            let remaining = T::constant(duration) - motion.time;
            let reach = series.reach(scale);
            let ends = remaining.value() <= reach || reach.is_nan();
            let whole = if ends { remaining } else { T::constant(reach) };
            let mut time = whole;
            let rests = value(&series.velocity, whole).value() <= 0.0;
            if rests {
                time = root(&series.velocity, 0.0, whole.value());
            }
            let passes = self.is_bounded() && value(&series.place, time).value() >= 1.0;
            if passes {
                time = root(&series.place, 1.0, time.value());
            }
            xi = if passes { T::constant(1.0) } else { value(&series.place, time) };
            motion.time = motion.time + time;
            motion.distance = start + xi * unit;
            let velocity = value(&series.velocity, time);
            motion.velocity = if velocity.value() > 0.0 { velocity } else { T::constant(0.0) };
            if passes {
                return Some(StageEnd::Passed);
            }
            if rests {
                (motion.velocity, motion.deceleration) = (T::constant(0.0), T::constant(0.0));
                return Some(StageEnd::Rest);
            }
            if ends {
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
fn transfer_by_series<T: Scalar>(a: [T; 3], b: [T; 3]) -> Option<[T; 2]> {
    // The last three coefficients of the solution of the homogeneous equation from 1, and of the whole from 0.
    let [zero, one] = [0.0, 1.0].inline_map(T::constant);
    let (mut unit, mut from_rest) = ([one, zero, zero], [zero; 3]);
    let (mut gain, mut loss) = (one, zero);
    for power in 0..MOST_TERMS {
        let factor = -1.0 / (power + 1) as f64;
        let sum = |last: [T; 3]| b[0] * last[0] + b[1] * last[1] + b[2] * last[2];
        let next = sum(unit) * factor;
        let next_from_rest = (a.get(power).copied().unwrap_or(zero) + sum(from_rest)) * factor;
        unit = [next, unit[0], unit[1]];
        from_rest = [next_from_rest, from_rest[0], from_rest[1]];
        gain = gain + next;
        loss = loss - next_from_rest;
        let is_small = |terms: [T; 3], sum: T| terms.iter().all(|term| term.is_negligible(sum, PRECISION));
        if power >= 3 && is_small(unit, gain) && is_small(from_rest, loss) {
            return Some([gain, loss]);
        }
    }
    None
}

/// Taylor series of the motion in time.
struct MotionSeries<T> {
    /// Coefficients of ξ.
    place: [T; ORDER + 1],
    velocity: [T; ORDER + 1],
}

impl<T: Scalar> MotionSeries<T> {
    /// Expands the motion from ξ and v; `unit` is the length of ξ = 1.
    fn new(stage: &ForceStage<T>, mass: T, unit: T, [xi, speed]: [T; 2]) -> MotionSeries<T> {
        let zero = T::constant(0.0);
        let [mut place, mut velocity] = [[zero; ORDER + 1]; 2];
        (place[0], velocity[0]) = (xi, speed);
        let force = stage.force.inline_map(|factors| factors.inline_map(|factor| factor / mass));
        let varies = !stage.is_constant();
        let [mut square, mut speeds] = [[zero; ORDER]; 2];
        let mut factors = [[zero; ORDER]; 3];
        for n in 0..ORDER {
            let convolve = |a: &[T], b: &[T]| (1..=n).fold(a[0] * b[n], |sum, i| sum + a[i] * b[n - i]);
            if varies {
                square[n] = convolve(&place, &place);
            }
            speeds[n] = convolve(&velocity, &velocity);
            for (factor, [constant, linear, quadratic]) in factors.iter_mut().zip(force) {
                factor[n] = linear * place[n] + quadratic * square[n] + if n == 0 { constant } else { zero };
            }
            let by_velocity = if varies {
                convolve(&factors[1], &velocity) + convolve(&factors[2], &speeds)
            } else {
                force[1][0] * velocity[n] + force[2][0] * speeds[n]
            };
            let count = (n + 1) as f64;
            place[n + 1] = velocity[n] / (unit * count);
            velocity[n + 1] = -(factors[0][n] + by_velocity) / T::constant(count);
        }
        MotionSeries { place, velocity }
    }

    /// Returns the time over which the last terms are negligible (Jorba and Zou 2005, eq. 3-8).
    fn reach(&self, scale: f64) -> f64 {
        let of_term = |n: usize| {
            let term = self.velocity[n].value().abs();
            if term > 0.0 { libm::pow(PRECISION * scale / term, 1.0 / n as f64) } else { f64::INFINITY }
        };
        of_term(ORDER).min(of_term(ORDER - 1))
    }
}

/// Returns the sum of a series.
fn value<T: Scalar>(terms: &[T; ORDER + 1], time: T) -> T {
    terms.iter().rev().fold(T::constant(0.0), |sum, term| sum * time + *term)
}

fn slope(terms: &[f64; ORDER + 1], time: f64) -> f64 {
    (1..=ORDER).rev().fold(0.0, |sum, n| sum * time + n as f64 * terms[n])
}

/// Returns the time in `0..latest` at which a monotone series has a value. It depends on the terms.
fn root<T: Scalar>(terms: &[T; ORDER + 1], target: f64, latest: f64) -> T {
    let mut numbers = [0.0; ORDER + 1];
    numbers.iter_mut().zip(terms).for_each(|(number, term)| *number = term.value());
    let time = root_of_numbers(&numbers, target, latest);
    T::of_root(time, value(terms, T::constant(time)), slope(&numbers, time))
}

/// Returns this root by Newton's method, and bisection where it leaves the bracket.
fn root_of_numbers(terms: &[f64; ORDER + 1], target: f64, latest: f64) -> f64 {
    let rises = terms[0] < target;
    let [mut low, mut high] = [0.0, latest];
    let mut time = latest;
    for _ in 0..MOST_ITERATIONS {
        let excess = value(terms, time) - target;
        if (excess > 0.0) == rises {
            high = time
        } else {
            low = time
        }
        let next = time - excess / slope(terms, time);
        let next = if low <= next && next <= high { next } else { 0.5 * (low + high) };
        if (next - time).abs() <= 2.0 * f64::EPSILON * latest {
            return next;
        }
        time = next;
    }
    time
}

impl<T: Scalar> ShotPath<T> {
    /// Prepares the path of a body; `None` if a force is not finite. No force may be negative.
    pub fn new(mass: T, stages: Vec<ForceStage<T>>) -> Option<ShotPath<T>> {
        let is_valid = mass.value() > 0.0 && mass.is_finite() && stages.iter().all(ForceStage::is_valid);
        let mut starts = Vec::with_capacity(stages.len());
        let mut distance = T::constant(0.0);
        for stage in &stages {
            starts.push(distance);
            distance = distance + stage.length;
        }
        let has_linear_term = stages.iter().any(|stage| stage.force[1] != [T::constant(0.0); 3]);
        let first = StageTransfer { gain: T::constant(1.0), needed: T::constant(0.0) };
        let transfers = if has_linear_term || stages.is_empty() { Vec::new() } else { vec![first] };
        is_valid.then_some(ShotPath { mass, stages, starts, transfers })
    }

    /// Returns the stages.
    pub fn stages(&self) -> &[ForceStage<T>] {
        &self.stages
    }

    /// Computes the transfers to the stages that a body with the square of a striking velocity reaches. Equation (2.19).
    fn extend_transfers(&mut self, squared: f64) {
        while let Some(&StageTransfer { gain, needed }) = self.transfers.last()
            && needed.value() < squared
            && self.transfers.len() < self.stages.len()
        {
            match self.stages[self.transfers.len() - 1].transfer(self.mass) {
                Some([factor, loss]) => {
                    let gain = factor * gain;
                    let more = if loss.value() > 0.0 { loss / gain } else { T::constant(0.0) };
                    self.transfers.push(StageTransfer { gain, needed: needed + more });
                }
                None => self.transfers.clear(),
            }
        }
    }

    /// Returns the motion at the time `duration` of a body with a striking velocity, or its rest before; `None` without
    /// convergence.
    pub fn motion_at(&mut self, velocity: T, duration: f64) -> Option<PathMotion<T>> {
        if velocity.value() == 0.0 || self.stages.is_empty() {
            let [time, deceleration] = [duration, 0.0].inline_map(T::constant);
            return Some(PathMotion { distance: velocity * duration, velocity, time, deceleration });
        }
        self.rest(velocity, duration).or_else(|| self.integrated(velocity, duration))
    }

    /// Returns the place of rest from the squares of the velocity; `None` if the body is not certain to be at rest at the
    /// time `duration`. The time is an upper bound.
    fn rest(&mut self, striking: T, duration: f64) -> Option<PathMotion<T>> {
        let squared = striking * striking;
        self.extend_transfers(squared.value());
        let index =
            self.transfers.partition_point(|transfer| transfer.needed.value() < squared.value()).checked_sub(1)?;
        let (StageTransfer { gain, needed }, stage) = (self.transfers[index], &self.stages[index]);
        let entry = gain * (squared - needed);
        let (velocity, distance) = (entry.sqrt(), self.starts[index]);
        let mut motion = PathMotion { distance, velocity, time: distance / velocity, deceleration: T::constant(0.0) };
        if motion.time.value() > duration {
            return None;
        }
        if !stage.is_constant() {
            return (stage.traverse(self.mass, &mut motion, duration, striking.value())? == StageEnd::Rest)
                .then_some(motion);
        }
        let [[constant, ..], _, [square, ..]] = stage.force;
        if constant.value() > 0.0 {
            motion.distance = distance + rest_distance(self.mass, constant, square, entry);
            motion.time = motion.time + velocity * self.mass / constant;
            motion.velocity = T::constant(0.0);
        }
        let is_inside = motion.distance.value() <= (distance + stage.length).value();
        (motion.velocity.value() == 0.0 && is_inside && motion.time.value() <= duration).then_some(motion)
    }

    /// Returns the motion with its times, by Taylor series in each stage.
    fn integrated(&self, striking: T, duration: f64) -> Option<PathMotion<T>> {
        let zero = T::constant(0.0);
        let mut motion = PathMotion { velocity: striking, distance: zero, deceleration: zero, time: zero };
        for (stage, start) in self.stages.iter().zip(&self.starts) {
            motion.distance = *start;
            if stage.is_free() {
                let needed = stage.length / motion.velocity;
                if (motion.time + needed).value() > duration {
                    let remaining = T::constant(duration) - motion.time;
                    motion.distance = motion.distance + motion.velocity * remaining;
                    return Some(PathMotion { time: T::constant(duration), deceleration: zero, ..motion });
                }
                motion.time = motion.time + needed;
            } else if stage.traverse(self.mass, &mut motion, duration, striking.value())? != StageEnd::Passed {
                return Some(motion);
            }
            if motion.velocity.value() == 0.0 {
                return Some(motion);
            }
        }
        Some(motion)
    }
}

/// Returns the distance to rest from the square w of the velocity against `F0 + F2 v²` with F0 > 0. Equation (2.5).
fn rest_distance<T: Scalar>(mass: T, constant: T, square: T, w: T) -> T {
    let ratio = square * w / constant;
    mass * 0.5 * w / constant * ratio.mean_of_logarithm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::dual::Dual;

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

    /// Returns the stages with derivatives: by the mass, by all factors of v⁰, and by all factors of v².
    fn with_derivatives(mass: f64, stages: &[ForceStage]) -> ShotPath<Dual<4>> {
        let dual = |value: f64, at: usize, slope: f64| {
            let mut dual = Dual::constant(value);
            dual.slopes[at] = slope;
            dual
        };
        let with_slopes = |stage: &ForceStage| {
            let [constant, linear, square] = stage.force;
            let force = [
                constant.inline_map(|factor| dual(factor, 1, factor)),
                linear.inline_map(Dual::constant),
                square.inline_map(|factor| dual(factor, 2, factor)),
            ];
            ForceStage { length: Dual::constant(stage.length), force }
        };
        ShotPath::new(dual(mass, 0, mass), stages.iter().map(with_slopes).collect()).expect("a path")
    }

    /// Source: derivatives of equation (2.5), P = m/(2β) ln(1 + βV²/α), by the logarithms of mass, α, β and V, at rest by
    /// the closed form and by series.
    #[test]
    fn derivatives_of_the_embedded_ogive_match_closed_form() {
        let [mass, speed, alpha, beta] = [0.021, 569.0, 55222.618593, 1.126227107768e-2];
        let force = [[alpha, 0.0, 0.0], [0.0; 3], [beta, 0.0, 0.0]];
        let mut path = with_derivatives(mass, &[ForceStage { length: f64::INFINITY, force }]);
        let velocity = Dual { value: speed, slopes: [0.0, 0.0, 0.0, speed] };
        let expected = [59.6126439, -57.7467957, -1.8658482, 115.4935914].inline_map(|slope| 1e-3 * slope);
        for motion in [path.motion_at(velocity, 1.0), path.integrated(velocity, 1.0)].into_iter().flatten() {
            for (slope, expected) in motion.distance.slopes.iter().zip(expected) {
                assert!((slope - expected).abs() < 1e-10, "{slope} {expected}");
            }
        }
    }

    /// Motions with derivatives have the bits of motions without them, and their derivatives are those of differences: at
    /// rest, before, and beyond the last layer.
    #[test]
    fn derivatives_match_differences() {
        let varied = [[2e4, 5e4, -2e4], [0.0; 3], [1e-3, 2e-2, 3e-2]];
        let ends = [[[5e4, 0.0, 0.0], [0.0; 3], [5.1e-2, 0.0, 0.0]], [[0.0; 3]; 3]];
        for (linear, end) in [(0.0, ends[0]), (3.0, ends[0]), (0.0, ends[1]), (3.0, ends[1])] {
            let stages = |[constant, square]: [f64; 2]| {
                let mut force = varied;
                force[0].iter_mut().for_each(|factor| *factor *= constant);
                force[1][1] = linear;
                force[2].iter_mut().for_each(|factor| *factor *= square);
                let [first, last] = [end[0], end[2]];
                let scaled = [first.inline_map(|f| f * constant), end[1], last.inline_map(|f| f * square)];
                vec![ForceStage { length: 0.1, force }, ForceStage { length: f64::INFINITY, force: scaled }]
            };
            for (speed, duration) in [(300.0, 1.0), (900.0, 1.0), (700.0, 1e-4), (1500.0, 2e-4), (4000.0, 1e-3)] {
                let motion = |mass: f64, factors: [f64; 2], speed: f64| {
                    let mut path = ShotPath::new(mass, stages(factors)).expect("a path");
                    path.motion_at(speed, duration).expect("a motion")
                };
                let mut path = with_derivatives(0.02, &stages([1.0; 2]));
                let velocity = Dual { value: speed, slopes: [0.0, 0.0, 0.0, speed] };
                let found = path.motion_at(velocity, duration).expect("a motion");
                let whole = motion(0.02, [1.0; 2], speed);
                let bits = [found.distance.value, found.velocity.value, found.deceleration.value];
                assert_eq!(bits, [whole.distance, whole.velocity, whole.deceleration], "{speed} {duration}");
                let moved = |at: usize, step: f64| {
                    let factor = |index: usize| if index == at { 1.0 + step } else { 1.0 };
                    motion(0.02 * factor(0), [factor(1), factor(2)], speed * factor(3))
                };
                for at in 0..4 {
                    let [near, back, far, far_back] = [5e-4, -5e-4, 1e-3, -1e-3].inline_map(|step| moved(at, step));
                    let slope =
                        |of: fn(&PathMotion) -> f64| (8.0 * (of(&near) - of(&back)) - of(&far) + of(&far_back)) / 6e-3;
                    let pairs = [
                        (found.distance, slope(|motion| motion.distance), whole.distance),
                        (found.velocity, slope(|motion| motion.velocity), speed),
                    ];
                    for (dual, difference, scale) in pairs {
                        let error = (dual.slopes[at] - difference).abs();
                        assert!(
                            error < 1e-9 * scale,
                            "{linear} {end:?} {speed} {duration} {at}: {dual:?} {difference}"
                        );
                    }
                }
            }
        }
    }
}
