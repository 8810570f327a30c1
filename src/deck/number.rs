//! Numbers as decks write them: `1.`, `.5`, `1.57d0`.
//! Never here: names.

/// A finite number in Fortran or C notation.
///
/// # Errors
/// In words, with the likely slip.
pub fn parse_number(text: &str) -> Result<f64, String> {
    let plain: String = text.trim().chars().map(|c| if matches!(c, 'd' | 'D') { 'e' } else { c }).collect();
    let looks_right = plain.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E'));
    match plain.parse::<f64>() {
        Ok(value) if looks_right && value.is_finite() => Ok(value),
        Ok(_) if looks_right => Err(format!("`{text}` is too large for a number")),
        _ => Err(slip(text)),
    }
}

/// What may have been meant: letters that look like digits are the commonest slip.
fn slip(text: &str) -> String {
    let repaired: String = text
        .chars()
        .map(|c| match c {
            'o' | 'O' => '0',
            'l' | 'I' => '1',
            _ => c,
        })
        .collect();
    if repaired != text && text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) && parse_plain(&repaired)
    {
        let letter = if text.contains(['o', 'O']) { "letter o" } else { "letter l" };
        return format!("`{text}` is not a number: {letter}; did you mean {repaired}?");
    }
    if text.contains(',') || text.contains(' ') {
        return format!("`{text}` is not one number; fields are separated by commas");
    }
    format!("`{text}` is not a number")
}

fn parse_plain(text: &str) -> bool {
    text.parse::<f64>().is_ok_and(f64::is_finite)
}

#[cfg(test)]
mod tests {
    use super::parse_number;

    #[test]
    fn fortran_and_c_forms() {
        for (text, value) in
            [("1.", 1.0), (".5", 0.5), ("1.57d0", 1.57), ("-2E-3", -2e-3), ("1D+2", 100.0), (" 7 ", 7.0)]
        {
            assert_eq!(parse_number(text), Ok(value));
        }
    }

    #[test]
    fn slips_are_named() {
        assert_eq!(parse_number("1.o"), Err("`1.o` is not a number: letter o; did you mean 1.0?".into()));
        for text in ["inf", "nan", "1e999", "", "abc", "1 2", "0x10"] {
            assert!(parse_number(text).is_err(), "{text}");
        }
    }
}
