//! Axes of charts: round ticks, and labels with a common power of ten.

/// Returns round numbers that divide an interval into about `parts` parts.
pub fn ticks(low: f64, high: f64, parts: f64) -> Vec<f64> {
    let raw = (high - low) / parts;
    if !(raw > 0.0 && raw.is_finite()) {
        return Vec::new();
    }
    let power = libm::pow(10.0, libm::log10(raw).floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * power).find(|s| *s >= raw).unwrap_or(10.0 * power);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// Returns the ticks of a logarithmic axis: powers of ten, with multiples of 2 and 5 if the axis has less than three
/// decades.
pub fn decades(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (libm::log10(low).floor() as i32, libm::log10(high).ceil() as i32);
    let between: &[f64] = if high < 1e3 * low { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let values = (first..=last).flat_map(|p| between.iter().map(move |f| f * libm::pow(10.0, f64::from(p))));
    values.filter(|v| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
}

/// Returns the common power of ten of the labels of an axis, a multiple of three; 0 if plain numbers are short.
pub fn exponent(ticks: &[f64]) -> i32 {
    let largest = ticks.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    if largest == 0.0 || !largest.is_finite() || (0.1..1e4).contains(&largest) {
        return 0;
    }
    3 * (libm::log10(largest) / 3.0 + 1e-9).floor() as i32
}

/// Formats a tick divided by the common power of ten.
pub fn label(tick: f64, exponent: i32) -> String {
    super::table::digits(tick / libm::pow(10.0, f64::from(exponent)), 4)
}

/// Formats the ticks of a logarithmic axis: all as plain numbers if these are short, otherwise all as powers of ten.
pub fn logarithmic(ticks: &[f64]) -> Vec<String> {
    if ticks.iter().all(|t| (1e-3..1e5).contains(t)) {
        return ticks.iter().map(|t| super::table::short(*t)).collect();
    }
    let label = |tick: &f64| {
        let power = (libm::log10(*tick) + 1e-9).floor();
        let digit = (tick / libm::pow(10.0, power)).round();
        let ten = format!("10{}", superscript(power as i32));
        if digit == 1.0 { ten } else { format!("{digit}·{ten}") }
    };
    ticks.iter().map(label).collect()
}

/// Formats the name of an axis with its common power of ten and unit, for example `time, 10⁻⁶ s`.
pub fn title(name: &str, unit: &str, exponent: i32) -> String {
    let power = if exponent == 0 { String::new() } else { format!("10{}", superscript(exponent)) };
    let unit = [power.as_str(), unit].into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ");
    [name, &unit].into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(", ")
}

fn superscript(number: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks(0.0, 1.0, 7.0).len(), 6);
        assert_eq!(ticks(-3.1, 7.2, 7.0), [-2.0, 0.0, 2.0, 4.0, 6.0]);
        assert!(ticks(1.0, 1.0, 7.0).is_empty() && ticks(0.0, f64::INFINITY, 7.0).is_empty());
        assert_eq!(decades(0.9, 120.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(decades(1e-6, 1e3).len(), 10);
    }

    #[test]
    fn labels_share_a_power_of_ten() {
        let times = ticks(0.0, 80e-6, 5.0);
        let power = exponent(&times);
        assert_eq!(power, -6);
        assert_eq!(times.iter().map(|t| label(*t, power)).collect::<Vec<_>>(), ["0", "20", "40", "60", "80"]);
        assert_eq!(title("time", "s", power), "time, 10⁻⁶ s");
        assert_eq!(title("S22", "", 9), "S22, 10⁹");
        assert_eq!([exponent(&[0.0, 0.5]), exponent(&[2000.0]), exponent(&[4e8]), exponent(&[1e-3])], [0, 0, 6, -3]);
        assert_eq!(logarithmic(&[0.02, 1.0]), ["0.02", "1"]);
        assert_eq!(logarithmic(&[1e-7, 1.0, 2e6]), ["10⁻⁷", "10⁰", "2·10⁶"]);
    }
}
