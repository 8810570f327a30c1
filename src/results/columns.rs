//! Text tables with aligned columns.

/// Returns a header and rows as aligned lines without trailing blanks; columns are aligned to the left or to the right.
pub fn aligned_table<S: AsRef<str>>(header: &[S], rows: &[Vec<String>], align_right: bool) -> String {
    let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
    let lines: Vec<Vec<&str>> =
        std::iter::once(header).chain(rows.iter().map(|row| row.iter().map(String::as_str).collect())).collect();
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |column: usize| lines.iter().filter_map(|l| l.get(column)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(text, &width): (&&str, &usize)| {
        if align_right { format!(" {text:>width$} ") } else { format!(" {text:<width$} ") }
    };
    let line = |cells: &Vec<&str>| cells.iter().zip(&widths).map(cell).collect::<String>().trim_end().to_owned() + "\n";
    lines.iter().map(line).collect()
}

/// Returns a table aligned to the left whose last column is wrapped at word boundaries to the line length `width`, if
/// possible.
pub fn wrapped(header: &[&str], rows: &[Vec<String>], width: usize) -> String {
    const LEAST: usize = 24;
    let leading = header.len().saturating_sub(1);
    let letters = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|c| c.chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0) + 2
    };
    let text_width = width.saturating_sub((0..leading).map(letters).sum::<usize>() + 1).max(LEAST);
    let lines = rows.iter().flat_map(|row| {
        let parts = broken(row.last().map_or("", String::as_str), text_width);
        parts.into_iter().enumerate().map(|(i, part)| {
            let blank = |cell: &String| if i == 0 { cell.clone() } else { String::new() };
            row.iter().take(leading).map(blank).chain([part]).collect()
        })
    });
    aligned_table(header, &lines.collect::<Vec<_>>(), false)
}

/// Wraps a text at word boundaries to lines of at most `text_width` characters; a longer word is not broken.
fn broken(text: &str, text_width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let Some(line) = lines.last_mut() else { break };
        let length = line.chars().count();
        if length > 0 && length + 1 + word.chars().count() > text_width {
            lines.push(word.to_owned());
        } else {
            if length > 0 {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}
