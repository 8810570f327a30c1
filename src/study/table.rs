//! Tables for the terminal and as CSV.
//! Never here: what is in them.

/// Text with columns lined up, numbers to the right.
pub fn terminal(header: &[String], rows: &[Vec<String>]) -> String {
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::NOTHING);
    table.set_header(header.to_vec());
    for row in rows {
        table.add_row(row.clone());
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    table.lines().map(|l| l.trim_end().to_owned() + "\n").collect()
}

/// CSV; fields with commas or quotes are quoted.
pub fn csv(header: &[String], rows: &[Vec<String>]) -> String {
    let field = |f: &String| {
        if f.contains([',', '"', '\n']) { format!("\"{}\"", f.replace('"', "\"\"")) } else { f.clone() }
    };
    let line = |row: &[String]| row.iter().map(field).collect::<Vec<_>>().join(",") + "\n";
    line(header) + &rows.iter().map(|r| line(r)).collect::<String>()
}
