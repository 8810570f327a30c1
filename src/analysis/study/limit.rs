//! `limit`: ballistic limit velocity by bisection, residual velocity curve, bands of other outcomes, and scatter of the
//! limit for random parameters.

use serde::Serialize;
use serde_json::{Value, json};

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::evaluate::SampleEvaluator;
use super::shot::{FiredShot, ShotEnd, ShotResult};
use super::statistics::lambert_jonas::{self, LambertJonasFit};
use super::statistics::probit::{self, NormalFit};
use super::statistics::summary;

/// Names of the axes of the curve of shots.
pub const AXES: [&str; 2] = ["striking velocity", "residual velocity"];

/// Options of the search for the limit velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitRequest {
    /// Lower and upper end of the search interval.
    pub between: [f64; 2],
    /// Largest width of the final bracket.
    pub tolerance: f64,
    /// Residual velocity that a shot must exceed to count as perforation.
    pub least: Option<f64>,
    /// Number of shots on each side of the limit.
    pub shots: usize,
}

/// Shot of the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shot {
    /// Striking velocity.
    pub velocity: f64,
    /// Residual velocity; without perforation, the speed at the end of the run.
    pub residual: f64,
    /// End of the shot.
    pub end: ShotEnd,
}

impl Shot {
    /// Returns whether the shot perforates.
    pub fn perforates(&self) -> bool {
        self.end == ShotEnd::Perforation
    }
}

/// Error of a shot whose run records no event and is not judged by its velocity.
const NO_EVENT: &str = "the run records no perforation, because no rigid body meets a *TARGET, and no moving projectile \
                        can be distinguished from a meshed target: give --residual EXPR and --least SPEED; a shot \
                        perforates if its residual velocity exceeds SPEED";

impl LimitRequest {
    /// Creates the request; `between` has the form `LOW,HIGH`.
    pub fn new(between: &str, tolerance: f64, least: Option<f64>, shots: usize) -> Result<LimitRequest, StudyError> {
        let wrong = |why: &str| StudyError::Setting(why.into());
        let ends: Option<Vec<f64>> = between.split(',').map(|end| end.trim().parse().ok()).collect();
        let Some(&[low, high]) = ends.as_deref() else {
            return Err(wrong("--between: expected two velocities LOW,HIGH, for example 300,900"));
        };
        if !(0.0 <= low && low < high && high.is_finite()) {
            return Err(wrong("--between LOW,HIGH: expected 0 <= LOW < HIGH"));
        }
        if tolerance.is_nan() || tolerance <= 1e-12 * high {
            return Err(wrong("--tolerance: expected a velocity above zero, for example 0.1"));
        }
        if least.is_some_and(|least| !(0.0..f64::INFINITY).contains(&least)) {
            return Err(wrong("--least: expected a velocity of at least zero"));
        }
        Ok(LimitRequest { between: [low, high], tolerance, least, shots })
    }

    /// Judges a shot by its end. Its first quantity, if there is one, is the residual velocity. Only a shot without an end
    /// is judged by the residual velocity alone.
    pub fn judge(&self, velocity: f64, fired: &FiredShot) -> Result<Shot, StudyError> {
        let residual_quantity = fired.values.first().copied();
        let end = match (fired.end, residual_quantity, self.least) {
            (None, Some(_), Some(_)) => ShotEnd::Perforation,
            (None, ..) => return Err(StudyError::Setting(NO_EVENT.into())),
            (Some(end), ..) => end,
        };
        if end != ShotEnd::Perforation {
            return Ok(Shot { velocity, residual: fired.speed, end });
        }
        let residual = residual_quantity.unwrap_or(fired.speed);
        let is_opposite = if self.least.is_some() { residual < -0.5 * fired.speed } else { residual <= 0.0 };
        if fired.end.is_some() && is_opposite {
            return Err(StudyError::Setting(format!(
                "--residual is {residual} for the shot at {velocity}, which perforates: give it positive in the direction \
                 of flight, or omit it"
            )));
        }
        let end = if residual > self.least.unwrap_or(0.0) { end } else { ShotEnd::Slow };
        Ok(Shot { velocity, residual, end })
    }

    /// Returns the number of bisections needed to reach the tolerance.
    fn rounds(&self) -> usize {
        libm::log2((self.between[1] - self.between[0]) / self.tolerance).ceil().max(0.0) as usize
    }
}

/// Function from striking velocities to shots.
pub type FireShots<'a> = dyn FnMut(&[f64]) -> Result<Vec<Shot>, StudyError> + 'a;

/// Function from pairs of draw and striking velocity to shots; `None` if a shot fails.
pub type FireDraws<'a> = dyn FnMut(&[(usize, f64)]) -> Result<Vec<Option<Shot>>, StudyError> + 'a;

/// Result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitVelocity {
    /// Largest velocity without and smallest velocity with perforation in the bisection; `None` if the ends of the
    /// search interval do not enclose a limit.
    pub bracket: Option<[f64; 2]>,
    /// All shots, sorted by striking velocity.
    pub shots: Vec<Shot>,
    /// Fitted Lambert-Jonas curve; `None` if the fit failed.
    pub curve: Option<LambertJonasFit>,
}

/// Fires shots of an evaluator at striking velocities, its first parameter; `others` are the values of its other
/// parameters.
pub fn fire(
    request: &LimitRequest,
    evaluator: &SampleEvaluator,
    velocities: &[f64],
    others: &[f64],
    threads: usize,
) -> Result<Vec<Shot>, StudyError> {
    let sample = |velocity: &f64| [*velocity].into_iter().chain(others.iter().copied());
    let samples: Vec<f64> = velocities.iter().flat_map(sample).collect();
    let fired = evaluator.shots(&samples, threads)?;
    let judge = |(shot, velocity): (ShotResult, &f64)| {
        let failed = |reason| StudyError::Shot { velocity: *velocity, reason: Box::new(reason) };
        request.judge(*velocity, &shot.map_err(failed)?)
    };
    fired.into_iter().zip(velocities).map(judge).collect()
}

/// Interval of striking velocities whose shots have the same end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VelocityBand {
    /// End of all shots.
    pub end: ShotEnd,
    /// Lowest striking velocity.
    pub from: f64,
    /// Highest striking velocity.
    pub to: f64,
}

impl LimitVelocity {
    /// Returns the limit velocity: the midpoint of the bracket.
    pub fn velocity(&self) -> Option<f64> {
        self.bracket.map(|[low, high]| 0.5 * (low + high))
    }

    /// Returns the velocities above the limit that certainly do not perforate; if there are any, there is more than one
    /// limit.
    pub fn gaps(&self) -> impl Iterator<Item = f64> {
        let limit = self.bracket.map_or(f64::INFINITY, |bracket| bracket[1]);
        let stays = |shot: &&Shot| !shot.perforates() && shot.end != ShotEnd::Moving;
        self.shots.iter().filter(move |shot| shot.velocity > limit && stays(shot)).map(|shot| shot.velocity)
    }

    /// Returns the bands of striking velocity, ascending.
    pub fn bands(&self) -> Vec<VelocityBand> {
        let band = |shots: &[Shot]| {
            let [from, to] = [shots.first()?, shots.last()?].map(|shot| shot.velocity);
            Some(VelocityBand { end: shots[0].end, from, to })
        };
        self.shots.chunk_by(|a, b| a.end == b.end).filter_map(band).collect()
    }

    /// Returns the result as a JSON object.
    pub fn record(&self) -> Value {
        json!({
            "bracket": self.bracket,
            "shots": self.shots,
            "bands": self.bands(),
            "undecided": self.undecided(),
            "a": self.curve.as_ref().map(|c| c.estimates[0]),
            "p": self.curve.as_ref().map(|c| c.estimates[1]),
            "limit_of_curve": self.curve.as_ref().map(|c| c.estimates[2]),
        })
    }

    /// Returns the interval from the first to the last shot that still moves at the end of its run: any shot in it
    /// may perforate.
    pub fn undecided(&self) -> Option<VelocityBand> {
        let mut moving = self.shots.iter().filter(|shot| shot.end == ShotEnd::Moving).map(|shot| shot.velocity);
        let from = moving.next()?;
        Some(VelocityBand { end: ShotEnd::Moving, from, to: moving.next_back().unwrap_or(from) })
    }
}

/// Finds the limit by bisection, then fires shots above and below the limit, finds the bands of equal ends, and fits
/// the curve.
pub fn find(request: &LimitRequest, fire: &mut FireShots<'_>) -> Result<LimitVelocity, StudyError> {
    let mut shots = fire(&request.between)?;
    let [low, high] = match shots[..] {
        [low, high] if !low.perforates() && high.perforates() => bisect(request, &mut shots, fire)?,
        _ => [request.between[1]; 2],
    };
    let above = fire(&spaced(high, request.between[1], request.shots))?;
    shots.extend(&above);
    // Without events, shots below the limit do not differ.
    if shots[0].end != ShotEnd::Slow {
        shots.extend(fire(&spaced(request.between[0], low, request.shots))?);
    }
    sort(&mut shots);
    refine(request.tolerance, &mut shots, fire)?;
    let bracket = lowest_limit(&shots);
    let through = above.iter().filter(|shot| shot.perforates());
    let through: Vec<(f64, f64)> = through.map(|shot| (shot.velocity, shot.residual)).collect();
    let curve = bracket.and_then(|[low, high]| lambert_jonas::fit(&through, 0.5 * (low + high)));
    Ok(LimitVelocity { bracket, shots, curve })
}

/// Returns the lowest pair of neighbouring shots of which the faster one perforates and the slower one does not; `None`
/// without such a pair, or if the slowest shot perforates.
fn lowest_limit(shots: &[Shot]) -> Option<[f64; 2]> {
    let pair = shots.windows(2).find(|pair| pair[1].perforates())?;
    (!pair[0].perforates()).then_some([pair[0].velocity, pair[1].velocity])
}

/// Bisects the search interval and returns the final bracket.
fn bisect(request: &LimitRequest, shots: &mut Vec<Shot>, fire: &mut FireShots<'_>) -> Result<[f64; 2], StudyError> {
    let [mut low, mut high] = request.between;
    for _ in 0..request.rounds() {
        let middle = fire(&[0.5 * (low + high)])?;
        shots.extend(&middle);
        for shot in middle {
            if shot.perforates() { high = shot.velocity } else { low = shot.velocity }
        }
    }
    Ok([low, high])
}

/// Returns equally spaced velocities, without the first end of the interval; none in an interval without width.
fn spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    let (step, count) = ((to - from) / count.max(1) as f64, if from < to { count } else { 0 });
    (1..=count).map(|i| from + step * i as f64).collect()
}

/// Largest number of boundaries of bands that are refined at a time, and largest number of rounds: sufficient for any
/// tolerance above the rounding of numbers.
const BOUNDARIES: usize = 32;
const ROUNDS: usize = 64;

/// Bisects the intervals between neighbouring shots with different ends to the tolerance.
fn refine(tolerance: f64, shots: &mut Vec<Shot>, fire: &mut FireShots<'_>) -> Result<(), StudyError> {
    for _ in 0..ROUNDS {
        let is_wide = |pair: &&[Shot]| pair[0].end != pair[1].end && pair[1].velocity - pair[0].velocity > tolerance;
        let middle = |pair: &[Shot]| 0.5 * (pair[0].velocity + pair[1].velocity);
        let middles: Vec<f64> = shots.windows(2).filter(is_wide).map(middle).take(BOUNDARIES).collect();
        if middles.is_empty() {
            break;
        }
        shots.extend(fire(&middles)?);
        sort(shots);
    }
    Ok(())
}

fn sort(shots: &mut Vec<Shot>) {
    shots.sort_by(|a, b| a.velocity.total_cmp(&b.velocity));
    shots.dedup_by_key(|shot| shot.velocity);
}

/// Shot of a draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnShot {
    /// Number of the draw.
    pub draw: usize,
    /// Striking velocity.
    pub velocity: f64,
    /// Result; `None` if the shot failed.
    pub result: Option<Shot>,
}

/// Shots of the draws of a scatter, with the parameters of each draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnShots {
    /// Names of the random parameters.
    pub names: Vec<String>,
    /// Values of the parameters, draw by draw.
    pub values: Vec<f64>,
    /// All shots, in the order of the search.
    pub shots: Vec<DrawnShot>,
}

impl DrawnShots {
    /// Returns the values of the parameters of a draw.
    pub fn of(&self, draw: usize) -> &[f64] {
        &self.values[draw * self.names.len()..(draw + 1) * self.names.len()]
    }

    /// Returns the JSON array of the draws: parameters, bracket of the limit (`null` for an end outside the search
    /// interval, or for a lost draw), and shots.
    pub fn record(&self, scattered: &LimitScatter) -> Value {
        let mut shots = vec![Vec::new(); scattered.brackets.len()];
        for &DrawnShot { draw, velocity, result } in &self.shots {
            shots[draw].push(result.map_or(json!({ "velocity": velocity, "end": FAILED }), |shot| json!(shot)));
        }
        let draw = |(draw, shots): (usize, Vec<Value>)| {
            let parameters: serde_json::Map<_, _> =
                self.names.iter().cloned().zip(self.of(draw).iter().map(|value| json!(value))).collect();
            json!({ "parameters": parameters, "bracket": scattered.brackets[draw], "shots": shots })
        };
        shots.into_iter().enumerate().map(draw).collect()
    }
}

/// End of a shot whose run failed.
pub const FAILED: &str = "failed";

/// Scatter of the limit velocity for random parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitScatter {
    /// Bracket of the limit of each draw; one end is infinite if the limit is outside the search interval.
    pub members: Vec<(f64, f64)>,
    /// The same of each draw, in order; `None` for a lost one.
    pub brackets: Vec<Option<(f64, f64)>>,
    /// Fitted normal distribution; `None` if the brackets do not determine one.
    pub scatter: Option<NormalFit>,
    /// Number of draws without a limit because a shot failed, or a body still moved at its end.
    pub lost: usize,
    /// Striking velocity with the 5 % and 95 % quantiles of the residual velocity.
    pub band: Vec<(f64, [f64; 2])>,
}

fn is_lost(shot: Option<Shot>) -> bool {
    shot.is_none_or(|shot| shot.end == ShotEnd::Moving)
}

fn perforates(shot: Option<Shot>) -> bool {
    shot.is_some_and(|shot| shot.perforates())
}

/// Number of intervals of striking velocity of the band, and the quantiles of its edges.
const ACROSS: u32 = 32;
const PARTS: [f64; 2] = [0.05, 0.95];

/// Finds the limit of each draw by bisection. A draw with a failed or undecided shot is lost.
pub fn scatter(request: &LimitRequest, draws: usize, fire: &mut FireDraws<'_>) -> Result<LimitScatter, StudyError> {
    let [low, high] = request.between;
    let mut ends = vec![(low, high); draws];
    let mut open: Vec<usize> = (0..draws).collect();
    let mut lost = vec![false; draws];
    for (end, through) in [(low, true), (high, false)] {
        let shots: Vec<(usize, f64)> = open.iter().map(|draw| (*draw, end)).collect();
        for ((draw, _), shot) in shots.iter().zip(fire(&shots)?) {
            lost[*draw] |= is_lost(shot);
            if perforates(shot) == through {
                ends[*draw] = if through { (f64::NEG_INFINITY, low) } else { (high, f64::INFINITY) };
            }
        }
        open.retain(|draw| !lost[*draw] && ends[*draw] == (low, high));
    }
    for _ in 0..request.rounds() {
        let middle = |draw: &usize| 0.5 * (ends[*draw].0 + ends[*draw].1);
        let shots: Vec<(usize, f64)> = open.iter().map(|draw| (*draw, middle(draw))).collect();
        for ((draw, velocity), shot) in shots.iter().zip(fire(&shots)?) {
            lost[*draw] |= is_lost(shot);
            if perforates(shot) { ends[*draw].1 = *velocity } else { ends[*draw].0 = *velocity }
        }
        open.retain(|draw| !lost[*draw]);
    }
    let brackets: Vec<_> = ends.into_iter().zip(lost).map(|(ends, lost)| (!lost).then_some(ends)).collect();
    let members: Vec<(f64, f64)> = brackets.iter().flatten().copied().collect();
    let lost = draws - members.len();
    let first = members.iter().map(|m| m.0).filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min);
    let band = band(if first.is_finite() { [first, high] } else { request.between }, draws, fire)?;
    Ok(LimitScatter { scatter: probit::fit(&members), members, brackets, lost, band })
}

/// Returns the band of residual velocities between two striking velocities; points are denser at the lower end, where
/// the curve is steep.
fn band([low, high]: [f64; 2], draws: usize, fire: &mut FireDraws<'_>) -> Result<Vec<(f64, [f64; 2])>, StudyError> {
    let velocity_of = |i: u32| low + (high - low) * (f64::from(i) / f64::from(ACROSS)).powi(2);
    (0..=ACROSS)
        .map(velocity_of)
        .map(|velocity| {
            let shots: Vec<(usize, f64)> = (0..draws).map(|draw| (draw, velocity)).collect();
            let fired = fire(&shots)?.into_iter().flatten();
            let mut residuals: Vec<f64> = fired.map(|s| if s.perforates() { s.residual } else { 0.0 }).collect();
            residuals.sort_by(f64::total_cmp);
            Ok((velocity, PARTS.map(|part| summary::between(&residuals, part))))
        })
        .filter(|found| !matches!(found, Ok((_, edges)) if edges[0].is_nan()))
        .collect()
}

/// Returns the chart of residual over striking velocity with the fitted curve and, for random parameters, the band of
/// the draws. Shots that do not perforate have their speed at the end of the run.
pub fn chart(title: &str, found: &LimitVelocity, scattered: Option<&LimitScatter>) -> Chart {
    let points = |end: ShotEnd| {
        let shots = found.shots.iter().filter(move |shot| shot.end == end);
        (end.words(), shots.map(|shot| (shot.velocity, shot.residual)).collect())
    };
    let mut series = marks(points);
    if let Some(band) = scattered.map(|s| &s.band).filter(|band| !band.is_empty()) {
        let edge = |side: usize| band.iter().map(move |(velocity, edges)| (*velocity, edges[side]));
        let points = edge(0).chain(edge(1).rev()).collect();
        series.push(ChartSeries::new("90 % of draws", SeriesForm::Band, points));
    }
    if let (Some(curve), Some(last)) = (&found.curve, found.shots.last()) {
        let constants = curve.estimates.map(|e| e.value);
        let limit = constants[2];
        // Points are denser near the limit, where the curve is steep.
        let velocity_of = |i: u32| limit + (last.velocity - limit) * (f64::from(i) / 200.0).powi(2);
        let points = (0..=200).map(velocity_of).map(|v| (v, lambert_jonas::residual(constants, v))).collect();
        series.push(ChartSeries::new("Lambert and Jonas", SeriesForm::Line, points));
    }
    Chart::new(title, AXES, series)
}

/// Returns one series of markers for each end of shots that occurs.
fn marks(points: impl Fn(ShotEnd) -> (&'static str, Vec<(f64, f64)>)) -> Vec<ChartSeries> {
    let series = ShotEnd::ALL.into_iter().map(points).filter(|(_, points)| !points.is_empty());
    series.map(|(name, points)| ChartSeries::new(name, SeriesForm::Marks, points)).collect()
}

/// Returns the chart of the limit velocity over another parameter, with the ends of all shots.
pub fn map_chart(title: &str, name: &str, found: &[(f64, LimitVelocity)]) -> Chart {
    let points = |end: ShotEnd| {
        let shots = found.iter().flat_map(|(value, found)| found.shots.iter().map(move |shot| (*value, shot)));
        (end.words(), shots.filter(|(_, shot)| shot.end == end).map(|(value, shot)| (value, shot.velocity)).collect())
    };
    let mut series = marks(points);
    let limits = found.iter().filter_map(|(value, found)| Some((*value, found.velocity()?))).collect();
    series.push(ChartSeries::new("limit velocity", SeriesForm::Line, limits));
    Chart::new(title, [name, "striking velocity"], series)
}

/// Returns the chart of the fraction of draws that perforate over the striking velocity, with the fitted normal
/// distribution.
pub fn scatter_chart(title: &str, found: &LimitScatter) -> Chart {
    let mut limits: Vec<f64> = found.members.iter().map(|m| 0.5 * (m.0 + m.1)).filter(|v| v.is_finite()).collect();
    limits.sort_by(f64::total_cmp);
    let below = found.members.iter().filter(|m| m.0 == f64::NEG_INFINITY).count();
    let member_count = found.members.len().max(1) as f64;
    let step =
        |(i, v): (usize, &f64)| [(*v, (below + i) as f64 / member_count), (*v, (below + i + 1) as f64 / member_count)];
    let points = limits.iter().enumerate().flat_map(step).collect();
    let mut series = vec![ChartSeries::new("draws that perforate", SeriesForm::Line, points)];
    if let (Some(scatter), Some(low), Some(high)) = (&found.scatter, limits.first(), limits.last()) {
        let velocity_of = |i: u32| low + (high - low) * f64::from(i) / 200.0;
        let points = (0..=200).map(velocity_of).map(|v| (v, probit::part_below(scatter, v))).collect();
        series.push(ChartSeries::new("normal distribution", SeriesForm::Guide, points));
    }
    Chart::new(title, ["striking velocity", "fraction that perforates"], series)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f64; 3] = [0.9, 2.1, 417.3];

    fn request() -> LimitRequest {
        LimitRequest::new("200,900", 0.1, None, 12).expect("sound")
    }

    /// Shot that ricochets, is embedded, or perforates with a residual velocity of the curve.
    fn shot(velocity: f64, ricochets: bool, residual: f64) -> Shot {
        let end = match residual > 0.0 {
            true => ShotEnd::Perforation,
            false if ricochets => ShotEnd::Ricochet,
            false => ShotEnd::Embedded,
        };
        Shot { velocity, residual, end }
    }

    fn on_curve(velocity: f64) -> Shot {
        shot(velocity, velocity < 310.0, lambert_jonas::residual(TRUTH, velocity))
    }

    #[test]
    fn limit_bands_and_curve_are_found() {
        let mut fired = 0;
        let outcome = find(&request(), &mut |velocities| {
            fired += velocities.len();
            Ok(velocities.iter().copied().map(on_curve).collect())
        });
        let limit_velocity = outcome.expect("a search");
        let [low, high] = limit_velocity.bracket.expect("a limit");
        assert!(low <= TRUTH[2] && TRUTH[2] <= high && high - low <= 0.1);
        // Two ends, 13 bisections, 12 shots on each side, and 8 of the boundary between ricochet and embedding.
        assert_eq!((fired, limit_velocity.gaps().count(), limit_velocity.undecided()), (2 + 13 + 24 + 8, 0, None));
        let curve = limit_velocity.curve.as_ref().expect("a curve");
        assert!(curve.estimates.iter().zip(TRUTH).all(|(e, truth)| (e.value / truth - 1.0).abs() < 1e-4), "{curve:?}");
        assert!(limit_velocity.shots.is_sorted_by(|a, b| a.velocity < b.velocity));
        let bands = limit_velocity.bands();
        assert_eq!(
            bands.iter().map(|band| band.end).collect::<Vec<_>>(),
            [ShotEnd::Ricochet, ShotEnd::Embedded, ShotEnd::Perforation]
        );
        let [first, second, _] = bands[..] else { panic!("{bands:?}") };
        assert!(first.from == 200.0 && first.to < 310.0 && second.from >= 310.0 && second.from - first.to <= 0.1);
        assert_eq!([second.to, bands[2].to], [low, 900.0]);
    }

    #[test]
    fn intervals_without_a_limit_have_no_bracket() {
        for residual in [5.0, 0.0] {
            let fire = &mut |velocities: &[f64]| Ok(velocities.iter().map(|v| shot(*v, true, residual)).collect());
            let limit_velocity = find(&request(), fire).expect("a search");
            assert_eq!((limit_velocity.bracket, limit_velocity.bands().len(), limit_velocity.curve), (None, 1, None));
        }
        for (between, tolerance) in
            [("200", 0.1), ("900,200", 0.1), ("-1,5", 0.1), ("1,x", 0.1), ("1,2", 0.0), ("1,2", f64::NAN)]
        {
            assert!(LimitRequest::new(between, tolerance, None, 5).is_err(), "{between}");
        }
        assert!(LimitRequest::new("1,2", 0.1, Some(-1.0), 5).is_err());
        // No perforation in an interval above the limit.
        let odd = |v: f64| if v > 400.0 && !(600.0..700.0).contains(&v) { v } else { 0.0 };
        let fire = &mut |velocities: &[f64]| Ok(velocities.iter().map(|v| shot(*v, true, odd(*v))).collect());
        let limit_velocity = find(&request(), fire).expect("a search");
        assert!(limit_velocity.gaps().all(|v| (600.0..700.0).contains(&v)) && limit_velocity.gaps().count() > 0);
    }

    #[test]
    fn shots_that_still_move_leave_the_limit_undecided() {
        let fire = &mut |velocities: &[f64]| {
            let moving = |v: f64| Shot { end: ShotEnd::Moving, ..on_curve(v) };
            let shot_at = |v: f64| if (400.0..420.0).contains(&v) { moving(v) } else { on_curve(v) };
            Ok(velocities.iter().copied().map(shot_at).collect())
        };
        let limit_velocity = find(&request(), fire).expect("a search");
        let [low, high] = limit_velocity.bracket.expect("a limit");
        let band = limit_velocity.undecided().expect("a band");
        assert!((low - 420.0).abs() < 0.1 && (high - 420.0).abs() < 0.1 && (band.from - 400.0).abs() < 0.1, "{band:?}");
    }

    #[test]
    fn recorded_ends_outrank_velocities() {
        let fired = |end: Option<ShotEnd>, values: &[f64]| FiredShot { end, speed: 70.0, values: values.to_vec() };
        let judged = |least: Option<f64>, shot: &FiredShot| {
            LimitRequest { least, ..request() }.judge(300.0, shot).map(|shot| (shot.end, shot.residual))
        };
        for end in [ShotEnd::Ricochet, ShotEnd::Embedded, ShotEnd::Moving, ShotEnd::NotMet] {
            assert_eq!(judged(None, &fired(Some(end), &[50.0])), Ok((end, 70.0)));
            assert_eq!(judged(Some(5.0), &fired(Some(end), &[50.0])), Ok((end, 70.0)));
        }
        let through = |values: &[f64]| fired(Some(ShotEnd::Perforation), values);
        assert_eq!(judged(None, &through(&[])), Ok((ShotEnd::Perforation, 70.0)));
        assert_eq!(judged(None, &through(&[50.0])), Ok((ShotEnd::Perforation, 50.0)));
        assert_eq!(judged(Some(60.0), &through(&[50.0])), Ok((ShotEnd::Slow, 50.0)));
        assert!(judged(None, &through(&[-50.0])).is_err_and(|e| e.to_string().contains("direction of flight")));
        assert_eq!(judged(Some(20.0), &fired(None, &[50.0])), Ok((ShotEnd::Perforation, 50.0)));
        assert_eq!(judged(Some(60.0), &fired(None, &[50.0])), Ok((ShotEnd::Slow, 50.0)));
        for (least, values) in [(None, &[50.0][..]), (Some(5.0), &[])] {
            assert!(judged(least, &fired(None, values)).is_err_and(|e| e.to_string().contains("no rigid body meets")));
        }
    }

    #[test]
    fn each_draw_has_its_own_limit() {
        let limits = [150.0, 400.0, 410.0, 420.0, 425.0, f64::NAN, 1000.0];
        let outcome = scatter(&request(), limits.len(), &mut |shots| {
            let fired = |(draw, v): &(usize, f64)| (!limits[*draw].is_nan()).then(|| shot(*v, true, v - limits[*draw]));
            Ok(shots.iter().map(fired).collect())
        });
        let scattered = outcome.expect("limits");
        assert_eq!((scattered.lost, scattered.members.len()), (1, 6));
        assert_eq!(scattered.brackets.iter().position(Option::is_none), Some(5));
        let known = limits.iter().filter(|limit| limit.is_finite());
        assert!(scattered.members.iter().zip(known).all(|(m, limit)| m.0 <= *limit && *limit <= m.1));
        assert_eq!([scattered.members[0].0, scattered.members[5].1], [f64::NEG_INFINITY, f64::INFINITY]);
        assert!(scattered.members[1..5].iter().all(|m| m.1 - m.0 <= 0.1) && scattered.scatter.is_some());
        // At 900 the residual velocity of a draw is 900 minus its limit, or zero; quantiles are of type 7 (Hyndman and
        // Fan).
        let (velocity, [low, high]) = scattered.band[ACROSS as usize];
        assert!((velocity - 900.0).abs() < 1e-9);
        assert!(
            (low - 0.25 * 475.0).abs() < 1e-9 && (high - (0.75 * 750.0 + 0.25 * 500.0)).abs() < 1e-9,
            "{low} {high}"
        );
    }
}
