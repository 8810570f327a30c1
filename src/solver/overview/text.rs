//! Text of the model summary.

use std::fmt::Write as _;

use super::{DeckOverview, PartOverview, RunEstimate};
use crate::output::clock::seconds;
use crate::output::columns::aligned_table;

/// Powers of length, mass, time and temperature of a dimension.
const LENGTH: [i32; 4] = [1, 0, 0, 0];
const MASS: [i32; 4] = [0, 1, 0, 0];
const TIME: [i32; 4] = [0, 0, 1, 0];
const TEMPERATURE: [i32; 4] = [0, 0, 0, 1];
const VELOCITY: [i32; 4] = [1, 0, -1, 0];
const DENSITY: [i32; 4] = [-3, 1, 0, 0];
const ENERGY: [i32; 4] = [2, 1, -2, 0];

/// Formats a number with four digits, without an exponent if its size is moderate.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-2..1e5).contains(&size) {
        let digits = if size < 1.0 { 4 } else { 3 - (size.log10().floor() as i32).clamp(0, 3) };
        let text = format!("{value:.*}", digits.max(0) as usize);
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    format!("{value:.3e}")
}

pub(super) fn render(overview: &DeckOverview) -> String {
    let unit = |powers: [i32; 4]| {
        let name = overview.units.as_ref().map_or(String::new(), |units| units.name(powers));
        if name.is_empty() { name } else { format!(" {name}") }
    };
    let mut text = parts(overview, &unit);
    let (mass, energy) = (short(overview.mass), short(overview.kinetic_energy));
    let _ = writeln!(text, "mass {mass}{}, initial kinetic energy {energy}{} (full rings)", unit(MASS), unit(ENERGY));
    for waves in &overview.waves {
        let _ = writeln!(
            text,
            "{}: density {}{}, wave speeds {} (longitudinal) and {} (shear){}",
            waves.material,
            short(waves.density),
            unit(DENSITY),
            short(waves.longitudinal),
            short(waves.shear),
            unit(VELOCITY)
        );
    }
    if let Some([low, high]) = overview.temperatures {
        let range = if low == high { short(low) } else { format!("{} to {}", short(low), short(high)) };
        let _ = writeln!(text, "initial temperature {range}{}", unit(TEMPERATURE));
    }
    let steps: Vec<String> =
        overview.steps.iter().map(|s| format!("{} {}{}", s.name, short(s.duration), unit(TIME))).collect();
    let _ = writeln!(text, "steps: {}", steps.join(", "));
    text + &overview.effort.as_ref().map_or(String::new(), |e| effort(e, &unit(TIME)))
}

fn parts(overview: &DeckOverview, unit: &dyn Fn([i32; 4]) -> String) -> String {
    let header = |name: &str, powers| format!("{name}{}", unit(powers));
    let header = [
        "part".into(),
        "elements".into(),
        header("mass", MASS),
        header("r", LENGTH),
        header("z", LENGTH),
        "centre z".into(),
        header("velocity", VELOCITY),
    ];
    if overview.parts.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = overview.parts.iter().map(row).collect();
    aligned_table(&header, &rows, false)
}

fn row(part: &PartOverview) -> Vec<String> {
    let elements: Vec<String> = part.elements.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    let range = |[low, high]: [f64; 2]| format!("{} to {}", short(low), short(high));
    let [mean, fastest] = part.velocity;
    let velocity = match fastest {
        0.0 => "at rest".into(),
        _ if (fastest - mean.abs()).abs() <= 1e-9 * fastest => format!("v_z {}", short(mean)),
        _ => format!("mean v_z {}, up to {}", short(mean), short(fastest)),
    };
    vec![
        if part.rigid { format!("{} (rigid)", part.name) } else { part.name.clone() },
        if elements.is_empty() { "none".into() } else { elements.join(" ") },
        short(part.mass),
        range(part.extent[0]),
        range(part.extent[1]),
        part.centre.map_or(String::new(), short),
        velocity,
    ]
}

fn effort(effort: &RunEstimate, unit: &str) -> String {
    if let Some(halt) = &effort.halt {
        return format!("the trial run halted: {halt}\n");
    }
    let limited = match effort.limiting_element.as_str() {
        "" => String::new(),
        element => format!(" (element {element})"),
    };
    let least = at_least(effort);
    let looked = if effort.looked_at < 1.0 {
        format!("extrapolated from {} of the run", percent(effort.looked_at))
    } else {
        "counted over the whole run".to_owned()
    };
    let increment = short(effort.increment);
    format!("time increment {increment}{unit}{limited}: {least}{:.0} increments ({looked})\n", round(effort.increments))
}

/// Returns the words before an estimate: the increment decreases when elements are compressed, so that an estimate from a part
/// of the run is a lower bound.
fn at_least(effort: &RunEstimate) -> &'static str {
    if effort.looked_at < 1.0 { "at least " } else { "" }
}

/// Returns the run time as a sentence; `None` if the trial run halted. It is not part of the summary, which is the same each
/// time.
pub(super) fn run_time(effort: &RunEstimate) -> Option<String> {
    if effort.halt.is_some() {
        return None;
    }
    // One digit: the measured time varies.
    let time = seconds(to_digits(effort.seconds, 1));
    Some(format!("run time on this machine, measured without output: {}{time}", at_least(effort)))
}

fn percent(fraction: f64) -> String {
    if fraction < 1e-3 { "0.1 %".into() } else { format!("{:.1} %", 100.0 * fraction) }
}

/// Rounds an estimate of a number of increments to two digits; small numbers are exact.
fn round(count: f64) -> f64 {
    if count < 100.0 { count } else { to_digits(count, 2) }
}

/// Rounds a value to a number of digits.
fn to_digits(value: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(value.max(f64::MIN_POSITIVE).log10().floor() as i32 + 1 - digits);
    (value / unit).round() * unit
}

#[cfg(test)]
mod tests {
    use super::{round, short};

    #[test]
    fn numbers_are_formatted_briefly() {
        let texts = [0.0, 1.5, -227.0, 7850.0, 3.24e-2, 2.1e11, 1e-9, 99_999.0].map(short);
        assert_eq!(texts, ["0", "1.5", "-227", "7850", "0.0324", "2.100e11", "1.000e-9", "99999"]);
        assert_eq!([round(8469.0), round(12.0), round(1.23e7)], [8500.0, 12.0, 1.2e7]);
    }
}
