//! Splitting of comma-separated lists.

/// Splits a list at the commas that are outside parentheses. Blanks around the parts are kept.
pub fn split(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in list.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn commas_in_parentheses_do_not_split() {
        assert_eq!(split("a, f(b, (c, d)), e"), ["a", " f(b, (c, d))", " e"]);
        assert_eq!(split(""), [""]);
    }
}
