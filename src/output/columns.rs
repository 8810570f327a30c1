//! Tables as text, columns lined up.
//! Never here: what is in them.

/// A header and rows, each line with an end and without blanks before it; columns begin on the left or end on the right.
pub fn lined_up<S: AsRef<str>>(header: &[S], rows: &[Vec<String>], to_the_right: bool) -> String {
    let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
    let lines: Vec<Vec<&str>> =
        std::iter::once(header).chain(rows.iter().map(|row| row.iter().map(String::as_str).collect())).collect();
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |column: usize| lines.iter().filter_map(|l| l.get(column)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(text, &width): (&&str, &usize)| {
        if to_the_right { format!(" {text:>width$} ") } else { format!(" {text:<width$} ") }
    };
    let line = |cells: &Vec<&str>| cells.iter().zip(&widths).map(cell).collect::<String>().trim_end().to_owned() + "\n";
    lines.iter().map(line).collect()
}
