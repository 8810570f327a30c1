//! Parsing and formatting of numbers, including Fortran's `1.d0`.

/// Reason why a text is not a number.
#[derive(Clone, Debug, PartialEq)]
pub enum NumberError {
    /// The text is empty.
    Empty,
    /// A letter was typed in place of a digit (`o` or `l`): the letter, and the text with digits.
    LookAlike(char, String),
    /// The number is too large for double precision.
    NotFinite,
    /// Any other fault, with a suggestion if there is one.
    Malformed(Option<String>),
}

/// Parses a finite number: `1`, `1.`, `.5`, `-1e-3`, `1.57d0`.
pub fn parse_number(text: &str) -> Result<f64, NumberError> {
    let text = text.trim();
    if text.is_empty() {
        return Err(NumberError::Empty);
    }
    if number_length(strip_sign(text)) != Some(strip_sign(text).len()) {
        return Err(explain(text));
    }
    let has_rust_exponent = !text.bytes().any(|b| matches!(b, b'd' | b'D'));
    let value: Result<f64, _> = if has_rust_exponent { text.parse() } else { text.replace(['d', 'D'], "e").parse() };
    let value = value.map_err(|_| NumberError::Malformed(None))?;
    if value.is_finite() { Ok(value) } else { Err(NumberError::NotFinite) }
}

fn strip_sign(text: &str) -> &str {
    text.strip_prefix(['+', '-']).unwrap_or(text)
}

/// Returns the number of bytes at the start of the text that form an unsigned number.
pub fn number_length(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let whole = digits(bytes, 0);
    let point = usize::from(bytes.get(whole) == Some(&b'.'));
    let fraction = digits(bytes, whole + point);
    if whole + fraction == 0 {
        return None;
    }
    let mantissa = whole + point + fraction;
    Some(mantissa + exponent_length(bytes, mantissa))
}

fn digits(bytes: &[u8], from: usize) -> usize {
    bytes.iter().skip(from).take_while(|b| b.is_ascii_digit()).count()
}

fn exponent_length(bytes: &[u8], at: usize) -> usize {
    if !matches!(bytes.get(at), Some(b'e' | b'E' | b'd' | b'D')) {
        return 0;
    }
    let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
    match digits(bytes, at + 1 + sign) {
        0 => 0,
        n => 1 + sign + n,
    }
}

fn explain(text: &str) -> NumberError {
    let repaired: String = text
        .chars()
        .map(|c| match c {
            'o' | 'O' => '0',
            'l' | 'I' => '1',
            c => c,
        })
        .collect();
    let culprit = text.chars().find(|c| "oOlI".contains(*c));
    if let (Some(letter), Ok(_)) = (culprit, parse_plain(&repaired)) {
        return NumberError::LookAlike(letter, repaired);
    }
    NumberError::Malformed(missing_exponent(text).or_else(|| semicolon(text)).or_else(|| without_comma(text)))
}

fn parse_plain(text: &str) -> Result<(), ()> {
    let body = strip_sign(text);
    if body.bytes().any(|b| b.is_ascii_digit()) && number_length(body) == Some(body.len()) { Ok(()) } else { Err(()) }
}

/// Suggests `1.0e-5` for `1.0-5`, an exponent without its letter.
fn missing_exponent(text: &str) -> Option<String> {
    let sign = text.rfind(['+', '-']).filter(|&i| i > 0)?;
    let guess = format!("{}e{}", &text[..sign], &text[sign..]);
    parse_plain(&guess).ok().map(|()| guess)
}

/// Suggests `1., 2.` for `1. 2.`, numbers without a comma between them.
fn without_comma(text: &str) -> Option<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    (words.len() > 1 && words.iter().all(|w| parse_plain(w).is_ok())).then(|| words.join(", "))
}

/// Suggests the number without a semicolon or colon at its end.
fn semicolon(text: &str) -> Option<String> {
    let guess = text.trim_end_matches([';', ':']);
    (guess != text && parse_plain(guess).is_ok()).then(|| guess.to_owned())
}

/// Formats a number for a deck: whole numbers without a decimal point, others with the fewest digits that parse to the
/// same value.
pub fn format_number(value: f64) -> String {
    let size = value.abs();
    if value.fract() == 0.0 && size < 1e15 {
        format!("{}", value as i64)
    } else if (1e-4..1e15).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fortran_forms_are_parsed() {
        for (text, value) in [
            ("1", 1.0),
            ("1.", 1.0),
            (".5", 0.5),
            ("1.57d0", 1.57),
            ("-1.D-3", -1e-3),
            ("+2E+2", 200.0),
            (" 8e-05 ", 8e-5),
        ] {
            assert_eq!(parse_number(text), Ok(value), "{text}");
        }
    }

    #[test]
    fn malformed_numbers_are_refused_with_a_suggestion() {
        assert_eq!(parse_number("1.o"), Err(NumberError::LookAlike('o', "1.0".into())));
        assert_eq!(parse_number("l.5"), Err(NumberError::LookAlike('l', "1.5".into())));
        assert_eq!(parse_number("1e999"), Err(NumberError::NotFinite));
        assert_eq!(parse_number("1.0-5"), Err(NumberError::Malformed(Some("1.0e-5".into()))));
        for text in ["nan", "inf", "1 2", "e5", ".", "-", "0x10", "1e", "--1", "é"] {
            assert!(parse_number(text).is_err(), "{text}");
        }
    }

    #[test]
    fn formatted_numbers_parse_to_the_same_value() {
        for value in [0.1, 1e-30, 20.0, -3.0, 1e300, 340e6, 1.0 / 3.0] {
            assert_eq!(parse_number(&format_number(value)), Ok(value));
        }
        assert_eq!(format_number(20.0), "20");
        assert_eq!(format_number(0.5), "0.5");
    }
}
