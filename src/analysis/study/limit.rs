//! `limit`: ballistic limit velocity by bisection, residual velocity curve, and scatter of the limit for random
//! parameters.

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::statistics::lambert_jonas::{self, LambertJonasFit};
use super::statistics::probit::{self, NormalFit};
use super::statistics::summary;

/// Options of the search for the limit velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitRequest {
    /// Lower and upper end of the search interval.
    pub between: [f64; 2],
    /// Largest width of the final bracket.
    pub tolerance: f64,
    /// Residual velocity above which a shot counts as perforation.
    pub least: f64,
    /// Number of shots above the limit for the residual velocity curve.
    pub shots: usize,
}

impl LimitRequest {
    /// Creates the request; `between` has the form `LOW,HIGH`.
    pub fn new(between: &str, tolerance: f64, least: f64, shots: usize) -> Result<LimitRequest, StudyError> {
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
        Ok(LimitRequest { between: [low, high], tolerance, least, shots })
    }

    /// Returns the number of bisections needed to reach the tolerance.
    fn rounds(&self) -> usize {
        libm::log2((self.between[1] - self.between[0]) / self.tolerance).ceil().max(0.0) as usize
    }
}

/// Function from striking velocities to residual velocities.
pub type FireShots<'a> = dyn FnMut(&[f64]) -> Result<Vec<f64>, StudyError> + 'a;

/// Function from pairs of draw and striking velocity to residual velocities; NaN if a shot fails.
pub type FireDraws<'a> = dyn FnMut(&[(usize, f64)]) -> Result<Vec<f64>, StudyError> + 'a;

#[derive(Clone, Debug, PartialEq)]
pub struct LimitVelocity {
    /// Largest velocity without and smallest velocity with perforation in the bisection.
    pub bracket: [f64; 2],
    /// Striking and residual velocity of all shots, sorted by striking velocity.
    pub shots: Vec<(f64, f64)>,
    /// Fitted Lambert-Jonas curve; `None` if the fit failed.
    pub curve: Option<LambertJonasFit>,
    /// Velocities above the limit without perforation; if there are any, there is more than one limit.
    pub gaps: Vec<f64>,
}

impl LimitVelocity {
    /// Returns the limit velocity: the midpoint of the bracket.
    pub fn velocity(&self) -> f64 {
        0.5 * (self.bracket[0] + self.bracket[1])
    }
}

/// Finds the limit by bisection, then fires the shots above it and fits the curve.
pub fn find(request: &LimitRequest, fire: &mut FireShots<'_>) -> Result<LimitVelocity, StudyError> {
    let [mut low, mut high] = request.between;
    let ends = fire(&[low, high])?;
    let mut shots = vec![(low, ends[0]), (high, ends[1])];
    if ends[0] > request.least {
        return Err(StudyError::Comparison(format!("a shot at {low} perforates: decrease the lower end of --between")));
    }
    if ends[1] <= request.least {
        return Err(StudyError::Comparison(format!(
            "a shot at {high} does not perforate: increase the upper end of --between"
        )));
    }
    for _ in 0..request.rounds() {
        let middle = 0.5 * (low + high);
        let residual = fire(&[middle])?[0];
        shots.push((middle, residual));
        if residual > request.least { high = middle } else { low = middle }
    }
    // Equally spaced from the limit to the upper end.
    let step = (request.between[1] - high) / request.shots.max(1) as f64;
    let velocities: Vec<f64> = (1..=request.shots).map(|i| high + step * i as f64).collect();
    let above: Vec<(f64, f64)> = velocities.iter().copied().zip(fire(&velocities)?).collect();
    let through: Vec<(f64, f64)> = above.iter().copied().filter(|shot| shot.1 > request.least).collect();
    let gaps = above.iter().filter(|shot| shot.1 <= request.least).map(|shot| shot.0).collect();
    shots.extend(above);
    shots.sort_by(|a, b| a.0.total_cmp(&b.0));
    shots.dedup_by_key(|shot| shot.0);
    let curve = lambert_jonas::fit(&through, 0.5 * (low + high));
    Ok(LimitVelocity { bracket: [low, high], shots, curve, gaps })
}

/// Scatter of the limit velocity for random parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimitScatter {
    /// Bracket of the limit of each draw; one end is infinite if the limit is outside the search interval.
    pub members: Vec<(f64, f64)>,
    /// Fitted normal distribution; `None` if the brackets do not determine one.
    pub scatter: Option<NormalFit>,
    /// Number of draws without a limit because a shot failed.
    pub lost: usize,
    /// Striking velocity with the 5 % and 95 % quantiles of the residual velocity.
    pub band: Vec<(f64, [f64; 2])>,
}

/// Number of intervals of striking velocity of the band, and the quantiles of its edges.
const ACROSS: u32 = 32;
const PARTS: [f64; 2] = [0.05, 0.95];

/// Finds the limit of each draw by bisection. `fire` returns NaN for a failed shot.
pub fn scatter(request: &LimitRequest, draws: usize, fire: &mut FireDraws<'_>) -> Result<LimitScatter, StudyError> {
    let [low, high] = request.between;
    let mut ends = vec![(low, high); draws];
    let mut open: Vec<usize> = (0..draws).collect();
    let mut lost = vec![false; draws];
    for (end, through) in [(low, true), (high, false)] {
        let shots: Vec<(usize, f64)> = open.iter().map(|draw| (*draw, end)).collect();
        for ((draw, _), residual) in shots.iter().zip(fire(&shots)?) {
            lost[*draw] |= residual.is_nan();
            if (residual > request.least) == through {
                ends[*draw] = if through { (f64::NEG_INFINITY, low) } else { (high, f64::INFINITY) };
            }
        }
        open.retain(|draw| !lost[*draw] && ends[*draw] == (low, high));
    }
    for _ in 0..request.rounds() {
        let middle = |draw: &usize| 0.5 * (ends[*draw].0 + ends[*draw].1);
        let shots: Vec<(usize, f64)> = open.iter().map(|draw| (*draw, middle(draw))).collect();
        for ((draw, velocity), residual) in shots.iter().zip(fire(&shots)?) {
            lost[*draw] |= residual.is_nan();
            if residual > request.least { ends[*draw].1 = *velocity } else { ends[*draw].0 = *velocity }
        }
        open.retain(|draw| !lost[*draw]);
    }
    let members: Vec<(f64, f64)> =
        ends.into_iter().zip(&lost).filter(|(_, lost)| !**lost).map(|(ends, _)| ends).collect();
    let lost = lost.into_iter().filter(|lost| *lost).count();
    let first = members.iter().map(|m| m.0).filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min);
    let band = band(if first.is_finite() { [first, high] } else { request.between }, request.least, draws, fire)?;
    Ok(LimitScatter { scatter: probit::fit(&members), members, lost, band })
}

/// Returns the band of residual velocities between two striking velocities; points are denser at the lower end, where
/// the curve is steep.
fn band(
    [low, high]: [f64; 2],
    least: f64,
    draws: usize,
    fire: &mut FireDraws<'_>,
) -> Result<Vec<(f64, [f64; 2])>, StudyError> {
    let place = |i: u32| low + (high - low) * (f64::from(i) / f64::from(ACROSS)).powi(2);
    (0..=ACROSS)
        .map(place)
        .map(|velocity| {
            let shots: Vec<(usize, f64)> = (0..draws).map(|draw| (draw, velocity)).collect();
            let finite = fire(&shots)?.into_iter().filter(|v| v.is_finite());
            let mut residuals: Vec<f64> = finite.map(|v| if v > least { v } else { 0.0 }).collect();
            residuals.sort_by(f64::total_cmp);
            Ok((velocity, PARTS.map(|part| summary::between(&residuals, part))))
        })
        .filter(|found| !matches!(found, Ok((_, edges)) if edges[0].is_nan()))
        .collect()
}

/// Returns the chart of residual over striking velocity with the fitted curve and, for random parameters, the band of
/// the draws.
pub fn chart(title: &str, found: &LimitVelocity, scattered: Option<&LimitScatter>) -> Chart {
    let mut series = vec![ChartSeries::new("shots", SeriesForm::Marks, found.shots.clone())];
    if let Some(band) = scattered.map(|s| &s.band).filter(|band| !band.is_empty()) {
        let edge = |side: usize| band.iter().map(move |(velocity, edges)| (*velocity, edges[side]));
        let points = edge(0).chain(edge(1).rev()).collect();
        series.push(ChartSeries::new("90 % of draws", SeriesForm::Band, points));
    }
    if let (Some(curve), Some(last)) = (&found.curve, found.shots.last()) {
        let constants = curve.estimates.map(|e| e.value);
        let limit = constants[2];
        // Points are denser near the limit, where the curve is steep.
        let place = |i: u32| limit + (last.0 - limit) * (f64::from(i) / 200.0).powi(2);
        let points = (0..=200).map(place).map(|v| (v, lambert_jonas::residual(constants, v))).collect();
        series.push(ChartSeries::new("Lambert and Jonas", SeriesForm::Line, points));
    }
    Chart::new(title, ["striking velocity", "residual velocity"], series)
}

/// Returns the chart of the fraction of draws that perforate over the striking velocity, with the fitted normal
/// distribution.
pub fn scatter_chart(title: &str, found: &LimitScatter) -> Chart {
    let mut limits: Vec<f64> = found.members.iter().map(|m| 0.5 * (m.0 + m.1)).filter(|v| v.is_finite()).collect();
    limits.sort_by(f64::total_cmp);
    let below = found.members.iter().filter(|m| m.0 == f64::NEG_INFINITY).count();
    let all = found.members.len().max(1) as f64;
    let step = |(i, v): (usize, &f64)| [(*v, (below + i) as f64 / all), (*v, (below + i + 1) as f64 / all)];
    let points = limits.iter().enumerate().flat_map(step).collect();
    let mut series = vec![ChartSeries::new("draws that perforate", SeriesForm::Line, points)];
    if let (Some(scatter), Some(low), Some(high)) = (&found.scatter, limits.first(), limits.last()) {
        let place = |i: u32| low + (high - low) * f64::from(i) / 200.0;
        let points = (0..=200).map(place).map(|v| (v, probit::part_below(scatter, v))).collect();
        series.push(ChartSeries::new("normal distribution", SeriesForm::Guide, points));
    }
    Chart::new(title, ["striking velocity", "fraction that perforates"], series)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f64; 3] = [0.9, 2.1, 417.3];

    fn request() -> LimitRequest {
        LimitRequest::new("200,900", 0.1, 0.0, 12).expect("sound")
    }

    #[test]
    fn limit_is_bracketed_and_curve_is_fitted() {
        let mut fired = 0;
        let found = find(&request(), &mut |velocities| {
            fired += velocities.len();
            Ok(velocities.iter().map(|v| lambert_jonas::residual(TRUTH, *v)).collect())
        });
        let found = found.expect("a limit");
        assert!(
            found.bracket[0] <= TRUTH[2] && TRUTH[2] <= found.bracket[1] && found.bracket[1] - found.bracket[0] <= 0.1
        );
        assert_eq!((fired, found.gaps.len()), (2 + 13 + 12, 0));
        let curve = found.curve.as_ref().expect("a curve");
        assert!(curve.estimates.iter().zip(TRUTH).all(|(e, truth)| (e.value / truth - 1.0).abs() < 1e-4), "{curve:?}");
        assert!(found.shots.is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn intervals_without_a_limit_are_errors() {
        for (always, message) in [(5.0, "at 200 perforates"), (0.0, "at 900 does not")] {
            let found = find(&request(), &mut |velocities| Ok(vec![always; velocities.len()]));
            assert!(found.is_err_and(|e| e.to_string().contains(message)));
        }
        for (between, tolerance) in
            [("200", 0.1), ("900,200", 0.1), ("-1,5", 0.1), ("1,x", 0.1), ("1,2", 0.0), ("1,2", f64::NAN)]
        {
            assert!(LimitRequest::new(between, tolerance, 0.0, 5).is_err(), "{between}");
        }
        // No perforation in an interval above the limit.
        let odd = |v: f64| if v > 400.0 && !(600.0..700.0).contains(&v) { v } else { 0.0 };
        let found = find(&request(), &mut |velocities| Ok(velocities.iter().map(|v| odd(*v)).collect()));
        assert!(!found.expect("a limit").gaps.is_empty());
    }

    #[test]
    fn each_draw_has_its_own_limit() {
        let limits = [150.0, 400.0, 410.0, 420.0, 425.0, f64::NAN, 1000.0];
        let found = scatter(&request(), limits.len(), &mut |shots| {
            Ok(shots
                .iter()
                .map(|(draw, v)| if limits[*draw].is_nan() { f64::NAN } else { v - limits[*draw] })
                .collect())
        });
        let found = found.expect("limits");
        assert_eq!((found.lost, found.members.len()), (1, 6));
        let known = limits.iter().filter(|limit| limit.is_finite());
        assert!(found.members.iter().zip(known).all(|(m, limit)| m.0 <= *limit && *limit <= m.1));
        assert_eq!([found.members[0].0, found.members[5].1], [f64::NEG_INFINITY, f64::INFINITY]);
        assert!(found.members[1..5].iter().all(|m| m.1 - m.0 <= 0.1) && found.scatter.is_some());
        // At 900 the residual velocity of a draw is 900 minus its limit, or zero; quantiles are of type 7 (Hyndman and
        // Fan).
        let (velocity, [low, high]) = found.band[ACROSS as usize];
        assert!((velocity - 900.0).abs() < 1e-9);
        assert!(
            (low - 0.25 * 475.0).abs() < 1e-9 && (high - (0.75 * 750.0 + 0.25 * 500.0)).abs() < 1e-9,
            "{low} {high}"
        );
    }
}
