//! Labels that the user gives to quantities for charts and tables: `COLUMN=TEXT`.

use super::data::{ReportPage, ReportTable};
use crate::deck::names::nearest;
use crate::study::chart::Chart;

/// Labels of quantities: history columns (`U2@REF`), variables or fields (`MISES`), columns of a sweep or study.
#[derive(Clone, Debug, Default)]
pub struct QuantityLabels(Vec<(String, String)>);

impl QuantityLabels {
    /// Parses `COLUMN=TEXT`.
    pub fn parse(words: &[String]) -> Result<QuantityLabels, String> {
        let pair = |word: &String| match word.split_once('=') {
            Some((column, text)) if !column.trim().is_empty() && !text.trim().is_empty() => {
                Ok((column.trim().to_owned(), text.trim().to_owned()))
            }
            _ => Err(format!("--label {word}: expected COLUMN=TEXT, for example U2@REF=depth")),
        };
        words.iter().map(pair).collect::<Result<_, _>>().map(QuantityLabels)
    }

    /// Returns the label of a quantity, or its name without a label.
    pub fn of<'a>(&'a self, name: &'a str) -> &'a str {
        self.0.iter().find(|(column, _)| column.eq_ignore_ascii_case(name)).map_or(name, |(_, text)| text)
    }

    /// Checks that each label belongs to a known quantity.
    pub fn check(&self, known: &[String]) -> Result<(), String> {
        let is_known = |column: &str| known.iter().any(|k| k.eq_ignore_ascii_case(column));
        match self.0.iter().find(|(column, _)| !is_known(column)) {
            None => Ok(()),
            Some((column, text)) => {
                let like = nearest(column, known.iter().map(String::as_str));
                let hint = like.map_or_else(String::new, |n| format!("; did you mean `{n}`?"));
                Err(format!("--label {column}={text}: there is no quantity `{column}`{hint}"))
            }
        }
    }

    /// Applies the labels to a page.
    pub(super) fn apply_to_page(&self, page: &mut ReportPage) -> Result<(), String> {
        if self.0.is_empty() {
            return Ok(());
        }
        self.check(&names(page))?;
        for run in &mut page.runs {
            run.charts.iter_mut().for_each(|chart| self.name(chart));
            run.columns.iter_mut().for_each(|column| column.name = self.of(&column.name).to_owned());
            let fields = run.meridian.iter_mut().flat_map(|m| &mut m.fields);
            fields.for_each(|field| field.name = self.of(&field.name).to_owned());
        }
        let studies = page.studies.iter_mut().map(|s| &mut s.table);
        let searches = page.searches.iter_mut().map(|s| &mut s.table);
        for table in page.sweeps.iter_mut().chain(studies).chain(searches) {
            table.charts.iter_mut().for_each(|chart| self.name(chart));
            table.header.iter_mut().for_each(|name| *name = self.of(name).to_owned());
        }
        Ok(())
    }

    pub fn applied(&self, mut chart: Chart) -> Chart {
        self.name(&mut chart);
        chart
    }

    fn name(&self, chart: &mut Chart) {
        for name in [&mut chart.title, &mut chart.x_label, &mut chart.y_label] {
            *name = self.of(name).to_owned();
        }
        chart.series.iter_mut().for_each(|series| series.name = self.of(&series.name).to_owned());
    }
}

fn names(page: &ReportPage) -> Vec<String> {
    let of_chart = |chart: &Chart| {
        let series = chart.series.iter().map(|s| s.name.clone());
        series.chain([chart.title.clone(), chart.x_label.clone(), chart.y_label.clone()]).collect::<Vec<_>>()
    };
    let of_table = |table: &ReportTable| {
        let charts = table.charts.iter().flat_map(of_chart);
        charts.chain(table.header.iter().cloned()).collect::<Vec<_>>()
    };
    let mut names: Vec<String> = Vec::new();
    for run in &page.runs {
        names.extend(run.charts.iter().flat_map(of_chart));
        names.extend(run.columns.iter().map(|c| c.name.clone()));
        names.extend(run.meridian.iter().flat_map(|m| &m.fields).map(|f| f.name.clone()));
    }
    names.extend(page.tables().flat_map(of_table));
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_apply_to_known_quantities_only() {
        let labels = QuantityLabels::parse(&["u2@ref = depth, m".into()]).expect("labels");
        assert_eq!([labels.of("U2@REF"), labels.of("V2@REF")], ["depth, m", "V2@REF"]);
        assert!(labels.check(&["U2@REF".into()]).is_ok());
        let message = labels.check(&["U2@REFF".into()]).expect_err("unknown label");
        assert!(message.contains("did you mean `U2@REFF`?"), "{message}");
        for wrong in ["depth", "=depth", "U2@REF="] {
            assert!(QuantityLabels::parse(&[wrong.into()]).is_err(), "{wrong}");
        }
    }
}
