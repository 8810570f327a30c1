//! Low-pass filter of histories: Butterworth, second order, forwards and backwards, without a shift in time (SAE
//! J211/1, appendix C).

use std::str::FromStr;

use super::history::HistoryColumns;
use super::units::UnitNames;
use crate::output::history::between;

/// Frequency at which the amplitude is reduced to 1/sqrt(2), divided by the number of the SAE class.
const CLASS: f64 = 5.0 / 3.0;
/// Frequency at which both passes together reduce the amplitude to 1/sqrt(2), divided by that of one pass:
/// (sqrt(2) - 1)^(1/4).
const BOTH_PASSES: f64 = 0.802_243_262_923_150_2;
/// Largest frequency times the interval of the rows.
const RESOLVED: f64 = 0.25;
/// Smallest number of periods of the cut-off frequency in a record. In a shorter one the ends, beyond which nothing is
/// known, influence all values.
const PERIODS: f64 = 3.0;

/// Frequency at which a filter reduces the amplitude to 1/sqrt(2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutoffFrequency {
    /// SAE channel frequency class 60, 180, 600 or 1000.
    Class(f64),
    /// Frequency in 1/time.
    Frequency(f64),
}

impl FromStr for CutoffFrequency {
    type Err = String;

    fn from_str(text: &str) -> Result<CutoffFrequency, String> {
        let lower = text.to_ascii_lowercase();
        let (digits, is_class) = lower.strip_prefix("cfc").map_or((&*lower, false), |digits| (digits, true));
        let number = digits.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite());
        match number {
            Some(number) if !is_class => Ok(CutoffFrequency::Frequency(number)),
            Some(number) if [60.0, 180.0, 600.0, 1000.0].contains(&number) => Ok(CutoffFrequency::Class(number)),
            _ => Err("expected a frequency above zero, cfc60, cfc180, cfc600 or cfc1000".into()),
        }
    }
}

impl CutoffFrequency {
    /// Returns the frequency in 1/time of the deck.
    fn in_deck_units(self, units: &UnitNames) -> Result<f64, String> {
        let class = match self {
            CutoffFrequency::Frequency(frequency) => return Ok(frequency),
            CutoffFrequency::Class(class) => class,
        };
        let [_, time] = units.length_and_time();
        let second = match time.to_lowercase().replace('µ', "u").as_str() {
            "s" | "sec" => 1.0,
            "ms" => 1e3,
            "us" => 1e6,
            _ => return Err("--filter: a class of SAE needs the unit of time: add *UNITS, or give a frequency".into()),
        };
        Ok(CLASS * class / second)
    }

    /// Filters all columns. They are interpolated to equal intervals first. The means of the interpolated values are kept.
    ///
    /// # Errors
    /// If the history is too short or has too few rows for the frequency, or if the unit of time of a class is unknown.
    pub fn filter(self, history: &mut HistoryColumns, units: &UnitNames) -> Result<(), String> {
        let frequency = self.in_deck_units(units)?;
        let (&[begin, .., end], rows) = (&history.times[..], history.times.len()) else {
            return Err("--filter: the history has fewer than two rows".into());
        };
        let interval = (end - begin) / (rows as f64 - 1.0);
        if frequency * interval > RESOLVED {
            return Err(format!(
                "--filter: the history has a row every {interval:.3e}; the cut-off frequency {frequency:.3e} needs one every {:.3e}",
                RESOLVED / frequency
            ));
        }
        let length = end - begin;
        if frequency * length < PERIODS {
            return Err(format!(
                "--filter: the record has a length of {length:.3e}; the cut-off frequency {frequency:.3e} needs {PERIODS} \
                 periods, {:.3e}. Use a frequency of {:.3e} or more",
                PERIODS / frequency,
                PERIODS / length
            ));
        }
        let times: Vec<f64> = (0..rows).map(|row| begin + interval * row as f64).collect();
        for values in history.columns.values_mut() {
            let value_at = |time: &f64| between(&history.times, |row| values[row], time.min(end));
            let even: Vec<f64> = times.iter().filter_map(value_at).collect();
            *values = filtered(&even, frequency * interval);
        }
        history.times = times;
        Ok(())
    }
}

/// Filters forwards and backwards; `frequency` is that of both passes times the interval. The values are continued by
/// their mirror images at both ends: a filter without a shift in time keeps the mean of the symmetric continuation, and
/// by symmetry that of the values.
fn filtered(values: &[f64], frequency: f64) -> Vec<f64> {
    let mirrored = || values.iter().rev();
    let mut continued: Vec<f64> = mirrored().chain(values).chain(mirrored()).copied().collect();
    for _ in 0..2 {
        pass(&mut continued, frequency);
        continued.reverse();
    }
    continued[values.len()..2 * values.len()].to_vec()
}

/// Filters in one direction; `frequency` is that of both passes times the interval. The filter begins in the steady state
/// of the first value.
fn pass(values: &mut [f64], frequency: f64) {
    let w = libm::tan(std::f64::consts::PI * frequency / BOTH_PASSES);
    let root = std::f64::consts::SQRT_2 * w;
    let scale = 1.0 + root + w * w;
    let (a, b) = (w * w / scale, [2.0 * (1.0 - w * w) / scale, (root - 1.0 - w * w) / scale]);
    let [mut x, mut y] = [[values.first().copied().unwrap_or(0.0); 2]; 2];
    for value in values {
        let filtered = a * (*value + 2.0 * x[0] + x[1]) + b[0] * y[0] + b[1] * y[1];
        (x, y) = ([*value, x[0]], [filtered, y[0]]);
        *value = filtered;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitudes of sine waves are 1/(1 + (0.8022 f/f_c)^4): 1 far below the cut-off frequency, 1/sqrt(2) at it.
    #[test]
    fn amplitudes_match_the_butterworth_response() {
        let amplitude = |frequency: f64| {
            let times: Vec<f64> = (0..20_000).map(|i| 1e-5 * f64::from(i)).collect();
            let wave = times.iter().map(|t| libm::sin(std::f64::consts::TAU * frequency * t)).collect();
            let columns = [("V2".to_owned(), wave)].into_iter().collect();
            let mut history = HistoryColumns { times, columns };
            CutoffFrequency::Frequency(300.0).filter(&mut history, &UnitNames::default()).expect("rows");
            history.columns["V2"][8000..12_000].iter().copied().fold(0.0, f64::max)
        };
        assert!((amplitude(30.0) - 1.0).abs() < 1e-3);
        assert!((amplitude(300.0) - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-3);
        let far = 1.0 / (1.0 + libm::pow(10.0 * BOTH_PASSES, 4.0));
        assert!((amplitude(3000.0) / far - 1.0).abs() < 0.05);
    }

    /// The impulse of a force is that of the record, also of one that begins or ends with a large force, and of one that is
    /// hardly longer than three periods.
    #[test]
    fn the_mean_is_kept() {
        for (rows, frequency) in [(301, 10.1), (3001, 30.0), (3001, 200.0)] {
            let times: Vec<f64> = (0..rows).map(|i| 0.3 * f64::from(i) / f64::from(rows - 1)).collect();
            let force = |t: &f64| 25.0 * libm::exp(-t / 0.05) + if *t > 0.25 { 40.0 } else { 3.0 };
            let forces: Vec<f64> = times.iter().map(force).collect();
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let mean_before = mean(&forces);
            let mut history = HistoryColumns { times, columns: [("CFN2".to_owned(), forces)].into_iter().collect() };
            CutoffFrequency::Frequency(frequency).filter(&mut history, &UnitNames::default()).expect("rows");
            let after = mean(&history.columns["CFN2"]);
            assert!((after / mean_before - 1.0).abs() < 1e-4, "{frequency}: {after} {mean_before}");
        }
    }

    #[test]
    fn constants_stay_and_coarse_histories_are_rejected() {
        let history = || HistoryColumns {
            times: (0..41).map(|i| 0.1 * f64::from(i)).collect(),
            columns: [("V2".to_owned(), vec![5.0; 41])].into_iter().collect(),
        };
        let mut filtered = history();
        CutoffFrequency::Frequency(1.0).filter(&mut filtered, &UnitNames::default()).expect("rows");
        assert!(filtered.columns["V2"].iter().all(|v| (v - 5.0).abs() < 1e-12));
        let wrong = |text: &str| {
            text.parse::<CutoffFrequency>().expect("a filter").filter(&mut history(), &UnitNames::default())
        };
        assert!(wrong("0.7").is_err_and(|e| e.contains("needs 3 periods")));
        assert!(wrong("10").is_err_and(|e| e.contains("needs one every")));
        assert!(wrong("cfc60").is_err_and(|e| e.contains("*UNITS")));
        assert!("cfc100".parse::<CutoffFrequency>().is_err() && "-1".parse::<CutoffFrequency>().is_err());
    }
}
