//! Reads the table of a sweep (`<job>_sweep.csv`) and draws charts over its first parameter.

use super::data::ReportTable;
use crate::output::csv;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};
use crate::study::compare::Agreement;

/// Largest number of charts of a sweep, and of lines of a chart.
const MOST: usize = 8;
const ROWS: usize = 500;

/// Reads a sweep from the text of its CSV file.
pub fn table(name: &str, text: &str) -> Result<ReportTable, String> {
    let mut table = ReportTable::parse(name, text)?;
    table.charts = charts(&table.header, &table.rows);
    table.facts = deviations(&table.header, &table.rows);
    Ok(table.limited())
}

impl ReportTable {
    /// Reads the header and all rows of a CSV file.
    pub(super) fn parse(name: &str, text: &str) -> Result<ReportTable, String> {
        let mut records = text.lines().filter(|l| !l.trim().is_empty()).map(csv::fields);
        let header = records.next().ok_or("the table is empty")?;
        let rows: Vec<Vec<String>> = records.collect();
        if let Some(i) = rows.iter().position(|r| r.len() != header.len()) {
            return Err(format!("row {} has {} fields, but the header has {}", i + 1, rows[i].len(), header.len()));
        }
        Ok(ReportTable { name: name.to_owned(), header, rows, ..ReportTable::default() })
    }

    /// Keeps the rows that a page shows, with a note if there are more.
    pub(super) fn limited(mut self) -> ReportTable {
        if self.rows.len() > ROWS {
            self.notes.push(format!("{ROWS} of {} rows are shown", self.rows.len()));
            self.rows.truncate(ROWS);
        }
        self
    }
}

struct ColumnRoles {
    /// Number of parameter columns, which come first.
    parameters: usize,
    quantities: Vec<usize>,
    references: Vec<usize>,
}

/// Determines the roles of the columns: names of quantities contain parentheses, and a reference is followed by the
/// difference from it.
fn columns(header: &[String]) -> ColumnRoles {
    let is_difference = |i: usize| header.get(i).is_some_and(|h| h.starts_with("difference from "));
    let is_reference =
        |i: usize| header.get(i + 1).is_some_and(|h| h.strip_prefix("difference from ") == Some(header[i].as_str()));
    let parameters = header.iter().position(|h| h.contains('(')).unwrap_or(1).max(1);
    let (references, others): (Vec<usize>, Vec<usize>) =
        (parameters..header.len()).filter(|&i| !is_difference(i)).partition(|&i| is_reference(i));
    ColumnRoles { parameters, quantities: others, references }
}

/// Returns one chart per quantity over the first parameter, with one line for each combination of the other parameters.
fn charts(header: &[String], rows: &[Vec<String>]) -> Vec<Chart> {
    let columns = columns(header);
    let chart = |(i, &quantity): (usize, &usize)| {
        let mut series = lines(header, rows, columns.parameters, quantity);
        let references = columns.references.iter().filter(|_| i == 0);
        series.extend(references.map(|&r| points(rows, r, &header[r])));
        series.retain(|s| !s.points.is_empty());
        Chart::new(&header[quantity], [&header[0], &header[quantity]], series)
    };
    let charts = columns.quantities.iter().take(MOST).enumerate().map(chart);
    charts.filter(|c| !c.series.is_empty()).collect()
}

/// Returns the agreement of the predictions with each reference, whose column precedes the column of its differences.
fn deviations(header: &[String], rows: &[Vec<String>]) -> Vec<(String, String)> {
    let agreement_of = |(i, name): (usize, &String)| {
        name.strip_prefix("difference from ")?;
        let pair = |row: &Vec<String>| {
            let [known, difference] = [i.checked_sub(1)?, i].map(|column| row[column].parse::<f64>());
            Some((known.clone().ok()? + difference.ok()?, known.ok()?))
        };
        let pairs: Vec<(f64, f64)> = rows.iter().filter_map(pair).collect();
        Some((name.clone(), Agreement::of(&pairs)?.text()))
    };
    header.iter().enumerate().filter_map(agreement_of).collect()
}

fn lines(header: &[String], rows: &[Vec<String>], parameters: usize, quantity: usize) -> Vec<ChartSeries> {
    let mut series: Vec<ChartSeries> = Vec::new();
    for row in rows {
        let (Ok(x), Ok(y)) = (row[0].parse(), row[quantity].parse()) else { continue };
        let others: Vec<String> = (1..parameters).map(|i| format!("{} = {}", header[i], row[i])).collect();
        let name = if others.is_empty() { header[quantity].clone() } else { others.join(", ") };
        match series.iter_mut().find(|s| s.name == name) {
            Some(known) => known.points.push((x, y)),
            None => series.push(ChartSeries::new(name, SeriesForm::Line, vec![(x, y)])),
        }
    }
    series.truncate(MOST);
    series
}

/// Returns a reference series with one point per value of the parameter.
fn points(rows: &[Vec<String>], column: usize, name: &str) -> ChartSeries {
    let mut points: Vec<(f64, f64)> =
        rows.iter().filter_map(|r| Some((r[0].parse().ok()?, r[column].parse().ok()?))).collect();
    points.dedup();
    ChartSeries::new(name, SeriesForm::Marks, points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_quantities_and_references_are_distinguished() {
        let text = "V,n,final(U2@REF),\"max(A,B)\",depth,difference from depth\n\
                    1,10,3,4,5,-2\n1,20,3.5,4,5,-1.5\n2,10,6,7,,\n";
        let table = table("job", text).expect("a table");
        assert_eq!(table.header[3], "max(A,B)");
        assert_eq!(table.charts.len(), 2);
        let names: Vec<&str> = table.charts[0].series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["n = 10", "n = 20", "depth"]);
        assert_eq!(table.charts[0].series[0].points, [(1.0, 3.0), (2.0, 6.0)]);
        assert_eq!(table.charts[0].series[2].points, [(1.0, 5.0)], "once");
        assert_eq!(table.charts[1].series.len(), 2);
        let agreement = Agreement::of(&[(3.0, 5.0), (3.5, 5.0)]).expect("rows");
        assert_eq!(table.facts, [("difference from depth".to_owned(), agreement.text())]);
    }
}
