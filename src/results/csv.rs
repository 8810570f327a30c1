//! CSV fields, written and parsed (RFC 4180).

use std::borrow::Cow;

use revolve_diagnostics::printable;

/// Returns a field for writing: quoted if it contains a separator, with control characters escaped.
pub fn field(text: &str) -> Cow<'_, str> {
    let text = printable(text);
    if text.contains([',', '"', '\n']) || text.starts_with(' ') || text.ends_with(' ') {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " ")))
    } else {
        text
    }
}

/// Returns a line of fields with a line break.
pub fn line<S: AsRef<str>>(fields: impl IntoIterator<Item = S>) -> String {
    let fields: Vec<String> = fields.into_iter().map(|text| field(text.as_ref()).into_owned()).collect();
    fields.join(",") + "\n"
}

/// Returns lines that are neither empty nor comments (`#`), with their line numbers from 1.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let numbered = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    numbered.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
}

/// Returns the fields of a line without quotes.
pub fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let (mut quoted, mut remaining) = (false, line.trim_end_matches(['\r', '\n']).chars().peekable());
    while let Some(c) = remaining.next() {
        let last = fields.len() - 1;
        match c {
            '"' if quoted && remaining.peek() == Some(&'"') => {
                remaining.next();
                fields[last].push('"');
            }
            '"' if quoted || fields[last].trim().is_empty() => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields[last].push(c),
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::{field, fields};

    #[test]
    fn written_fields_are_parsed_back() {
        let names = ["time", "U2@R,E", "a \"b\"", " c", "d", ""];
        let line = names.map(|n| field(n).into_owned()).join(",");
        assert_eq!(line, "time,\"U2@R,E\",\"a \"\"b\"\"\",\" c\",d,");
        assert_eq!(fields(&(line + "\r\n")), names);
        assert_eq!(field("A\u{1b}[2J"), "A\\u{1b}[2J");
    }
}
