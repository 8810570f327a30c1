//! Comparison of names that ignores case and blanks, and search for the most similar name.

/// Maximum length of a word for which a similar name is searched.
const LONGEST: usize = 64;

/// Returns the text in upper case without blanks.
pub fn fold(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect()
}

/// Returns the candidate most similar to `text`: at most a third of its letters (one to four) may differ. Case and
/// blanks are ignored.
pub fn nearest<'a>(text: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = fold(text);
    let count = wanted.chars().count();
    if count == 0 || count > LONGEST {
        return None;
    }
    let limit = (count / 3).clamp(1, 4);
    let rated = candidates.into_iter().filter_map(|c| Some((distance(&wanted, &fold(c), limit)?, c)));
    rated.min_by_key(|(d, _)| *d).map(|(_, c)| c)
}

/// Returns the edit distance of two words: insertions, deletions, replacements and swaps of neighbours; `None` above
/// `limit`.
fn distance(a: &str, b: &str, limit: usize) -> Option<usize> {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > limit || b.len() > 2 * LONGEST {
        return None;
    }
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let row = next_row(&a, &b, i, &last, &before);
        before = std::mem::replace(&mut last, row);
    }
    last.last().copied().filter(|&d| d <= limit)
}

/// Returns row `i` of the edit-distance table from the two previous rows.
fn next_row(a: &[char], b: &[char], i: usize, last: &[usize], before: &[usize]) -> Vec<usize> {
    let mut row = vec![i; b.len() + 1];
    for j in 1..=b.len() {
        let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
        row[j] = replaced.min(last[j] + 1).min(row[j - 1] + 1);
        if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
            row[j] = row[j].min(before[j - 2] + 1);
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_found() {
        assert_eq!(nearest("Elastc", ["PLASTIC", "ELASTIC"]), Some("ELASTIC"));
        assert_eq!(nearest("SOLIDSECTOIN", ["SOLID SECTION", "SECTION CONTROLS"]), Some("SOLID SECTION"));
        assert_eq!(nearest("QQQQQQ", ["NODE", "NSET"]), None);
        assert_eq!(nearest("", ["NODE"]), None);
    }
}
