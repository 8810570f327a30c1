//! Comparing names as people write them: case and blanks aside, abbreviated, misspelt.
//! Never here: which names exist.

/// Longer words are not compared for likeness: nobody mistypes a name into them.
const LONGEST: usize = 64;

/// The text in upper case without any blanks.
pub fn fold(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect()
}

/// The candidate most like `text`, if one is like it at all. Case and blanks do not count.
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

/// How many insertions, deletions, replacements and swaps of neighbours lead from one word to the other; `None` above `limit`.
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

/// Row `i` of the edit-distance table from the two rows above it.
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
    fn likeness() {
        assert_eq!(nearest("Elastc", ["PLASTIC", "ELASTIC"]), Some("ELASTIC"));
        assert_eq!(nearest("SOLIDSECTOIN", ["SOLID SECTION", "SECTION CONTROLS"]), Some("SOLID SECTION"));
        assert_eq!(nearest("QQQQQQ", ["NODE", "NSET"]), None);
        assert_eq!(nearest("", ["NODE"]), None);
    }
}
