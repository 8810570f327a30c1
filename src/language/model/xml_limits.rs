//! Limits for the tags of XML files, checked before a reader that compares all pairs of attributes of a tag
//! (RUSTSEC-2026-0194).

/// Largest number of attributes of a tag; VTK writes about a dozen.
const MOST_ATTRIBUTES: usize = 64;
/// Largest number of tags of a file; VTK writes two per array.
const MOST_TAGS: usize = 100_000;
/// Start and end of constructs without attributes.
const SKIPPED: [(&str, &str); 3] = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];

/// Returns the exceeded limit with the line of the tag; `None` if there is none. Appended binary data is not scanned.
pub fn exceeded_limit(text: &str) -> Option<String> {
    let mut rest = text;
    for _ in 0..MOST_TAGS {
        let tag = &rest[rest.find('<')?..];
        if let Some((_, end)) = SKIPPED.iter().find(|(begin, _)| tag.starts_with(begin)) {
            rest = &tag[tag.find(end)?..];
            continue;
        }
        let (length, attributes) = measure(tag);
        if attributes > MOST_ATTRIBUTES {
            let line = text[..text.len() - tag.len()].matches('\n').count() + 1;
            let name = tag[1..].split(|c: char| c.is_whitespace()).next().unwrap_or_default();
            return Some(format!(
                "line {line}: the tag `{name}` has {attributes} attributes, at most {MOST_ATTRIBUTES} are allowed"
            ));
        }
        if tag.starts_with("<AppendedData") {
            return None;
        }
        rest = &tag[length..];
    }
    Some(format!("it has more than {MOST_TAGS} tags"))
}

/// Returns the length of the tag at the start of a text, up to its `>`, and its number of attributes.
fn measure(tag: &str) -> (usize, usize) {
    let (mut quote, mut attributes) = (None, 0);
    let end = tag.bytes().position(|byte| {
        match (quote, byte) {
            (Some(begun), _) if begun == byte => quote = None,
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'=') => attributes += 1,
            _ => {}
        }
        quote.is_none() && byte == b'>'
    });
    (end.unwrap_or(tag.len()), attributes)
}

#[cfg(test)]
mod tests {
    use super::{MOST_ATTRIBUTES, MOST_TAGS, exceeded_limit};

    #[test]
    fn ordinary_files_keep_to_the_limits() {
        let text = "<?xml version=\"1.0\"?>\n<!-- don't > = -->\n<VTKFile type='a>\"=b'>\n<A/>1 = 2 = 3</VTKFile>";
        assert_eq!(exceeded_limit(text), None);
        assert_eq!(exceeded_limit("no tags"), None);
        assert_eq!(exceeded_limit("<unclosed a='"), None);
        let binary = "<".repeat(MOST_TAGS + 1);
        assert_eq!(exceeded_limit(&format!("<A><AppendedData encoding=\"raw\">_{binary}</AppendedData></A>")), None);
    }

    #[test]
    fn many_attributes_and_many_tags_exceed_them() {
        let with = |count: usize| format!("<A>\n<B{}/>\n</A>", " c=\"\"".repeat(count));
        assert_eq!(exceeded_limit(&with(MOST_ATTRIBUTES)), None);
        let message = exceeded_limit(&with(MOST_ATTRIBUTES + 1)).expect("a limit");
        assert!(message.starts_with("line 2: the tag `B` has 65 attributes"), "{message}");
        assert!(exceeded_limit(&"<a></a>".repeat(MOST_TAGS / 2 - 1)).is_none());
        assert!(exceeded_limit(&"<a></a>".repeat(MOST_TAGS / 2 + 1)).is_some_and(|m| m.contains("100000 tags")));
    }
}
