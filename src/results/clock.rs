//! Wall-clock times as text.

use std::time::Duration;

/// Returns a time as text: `0.4 ms`, `0.3 s`, `12 s`, `3 min 05 s`, `2 h 07 min`, `12 days`.
pub fn span(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0 if time.as_micros() < 10_000 => format!("{:.1} ms", 1e3 * time.as_secs_f64()),
        0 if time.as_millis() < 100 => format!("{} ms", time.as_millis()),
        0..10 => format!("{:.1} s", time.as_secs_f64()),
        10..100 => format!("{seconds} s"),
        100..6000 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        6000..360_000 => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
        _ => format!("{} days", seconds / 86_400),
    }
}

/// Formats a number of seconds like [`span`]; an invalid or too large number becomes the longest time.
pub fn seconds(seconds: f64) -> String {
    span(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))
}

#[cfg(test)]
mod tests {
    use super::span;
    use std::time::Duration;

    #[test]
    fn durations_are_formatted_by_size() {
        let said = [2, 12, 950, 42_000, 185_000, 7_620_000, 864_000_000].map(|ms| span(Duration::from_millis(ms)));
        assert_eq!(said, ["2.0 ms", "12 ms", "0.9 s", "42 s", "3 min 05 s", "2 h 07 min", "10 days"]);
    }
}
