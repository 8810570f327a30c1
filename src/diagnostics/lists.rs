//! Splitting of comma-separated lists.

/// Splits a list at the commas that are outside parentheses. Blanks around the parts are kept.
pub fn split(list: &str) -> Vec<&str> {
    let mut depth = 0;
    let ends_part = |c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth == 0
    };
    list.split(ends_part).collect()
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
