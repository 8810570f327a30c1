//! The energy balance as stacked areas: stored energies at the bottom, dissipated energies on top, and the supplied
//! energy as a line. Energies that the history does not have are one area, so that the areas always add up to the line.

use super::history::HistoryColumns;
use super::pack::spread;
use super::shorten;
use super::units::UnitNames;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};

pub const TITLE: &str = "Energy balance";
/// Energies from the bottom to the top of the stack: column and name. ALLIE is the sum of recoverable, plastic and
/// artificial strain energy, and that lost by damage.
const STORED: [(&str, &str); 2] = [("ALLKE", "kinetic"), ("ALLSE", "elastic")];
const DISSIPATED: [(&str, &str); 10] = [
    ("ALLPD", "plastic"),
    ("ALLDMD", "damage"),
    ("ALLAE", "hourglass control"),
    ("ALLVD", "bulk viscosity"),
    ("ALLFD", "friction"),
    ("ALLCW", "contact"),
    ("ALLPW", "penalty springs"),
    ("ALLDC", "distortion control"),
    ("ALLADV", "transport through adaptive meshes"),
    ("ALLCAV", "opening the cavity"),
];
/// Energies that are part of ALLIE.
const INTERNAL: [&str; 4] = ["ALLSE", "ALLPD", "ALLAE", "ALLDMD"];
/// Largest number of rows that are drawn; all areas use the same rows.
const ROWS: usize = 300;
/// Energies below this fraction of the largest one are not drawn.
const VISIBLE: f64 = 1e-4;

/// Returns the history columns of the balance.
pub fn columns() -> impl Iterator<Item = &'static str> {
    STORED.into_iter().chain(DISSIPATED).map(|c| c.0).chain(["ALLIE", "ALLWK", "ALLFKE", "ETOTAL"])
}

/// Returns the balance of a history; `None` if it has fewer than two energies.
pub fn chart(history: &HistoryColumns, units: &UnitNames) -> Option<Chart> {
    let rows = spread(history.times.len(), ROWS);
    let sampled = |column: &str| -> Option<Vec<f64>> {
        history.columns.get(column).map(|values| rows.iter().map(|&i| values[i]).collect())
    };
    let stored = STORED.into_iter().filter_map(|(column, name)| Some((name, sampled(column)?)));
    let dissipated = DISSIPATED.into_iter().filter_map(|(column, name)| Some((name, sampled(column)?)));
    let mut parts: Vec<(&str, Vec<f64>)> = stored
        .chain(unlisted_internal_energy(&sampled).map(|rest| ("other internal", rest)))
        .chain(dissipated)
        .collect();
    parts.extend(unlisted_energy(&sampled, &parts).map(|rest| ("energies without a column", rest)));
    let largest = parts.iter().flat_map(|p| &p.1).fold(0.0_f64, |m, v| m.max(v.abs()));
    parts.retain(|(_, values)| values.iter().any(|v| v.abs() > VISIBLE * largest));
    if parts.len() < 2 || rows.len() < 2 {
        return None;
    }
    let times: Vec<f64> = rows.iter().map(|&i| shorten(history.times[i])).collect();
    let series = |name: &str, values: Vec<f64>, form: SeriesForm| {
        ChartSeries::new(name, form, times.iter().copied().zip(values.into_iter().map(shorten)).collect())
    };
    let mut all_series: Vec<ChartSeries> =
        parts.into_iter().map(|(name, values)| series(name, values, SeriesForm::Area)).collect();
    if let Some(supplied) = supplied(&sampled) {
        all_series.push(series("initial energy + work of loads", supplied, SeriesForm::Guide));
    }
    let words = "stored energies below, dissipated energies above".into();
    Some(Chart { units: units.over_time("Energy"), words, ..Chart::new(TITLE, ["time", "energy"], all_series) })
}

/// Returns the part of ALLIE for which the history has no column.
fn unlisted_internal_energy(of: &impl Fn(&str) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
    let mut remainder = of("ALLIE")?;
    for part in INTERNAL.into_iter().filter_map(of) {
        remainder.iter_mut().zip(part).for_each(|(remainder, part)| *remainder -= part);
    }
    Some(remainder)
}

/// Returns the energy from outside: work of loads and prescribed motions, and kinetic energy through Eulerian boundaries.
fn from_outside(of: &impl Fn(&str) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
    let mut sum = of("ALLWK")?;
    sum.iter_mut().zip(of("ALLFKE").unwrap_or_default()).for_each(|(sum, flow)| *sum += flow);
    Some(sum)
}

/// Returns the part of the total energy for which the history has no column; `None` without ETOTAL and ALLWK.
fn unlisted_energy(of: &impl Fn(&str) -> Option<Vec<f64>>, parts: &[(&str, Vec<f64>)]) -> Option<Vec<f64>> {
    // ETOTAL is the sum of all stored and dissipated energies minus the energy from outside.
    let mut remainder = of("ETOTAL")?;
    remainder.iter_mut().zip(from_outside(of)?).for_each(|(remainder, work)| *remainder += work);
    for (_, part) in parts {
        remainder.iter_mut().zip(part).for_each(|(remainder, part)| *remainder -= part);
    }
    Some(remainder)
}

/// Returns the total energy at the start plus the energy from outside; the areas must add up to it.
fn supplied(of: &impl Fn(&str) -> Option<Vec<f64>>) -> Option<Vec<f64>> {
    let initial = *of("ETOTAL")?.first()?;
    Some(from_outside(of)?.into_iter().map(|work| initial + work).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series_of(columns: &[(&str, [f64; 3])]) -> Vec<(String, f64)> {
        let columns = columns.iter().map(|(name, values)| ((*name).to_owned(), values.to_vec())).collect();
        let history = HistoryColumns { times: vec![0.0, 1.0, 2.0], columns };
        let chart = chart(&history, &UnitNames::default()).expect("a chart");
        chart.series.iter().map(|s| (s.name.clone(), s.points[2].1)).collect()
    }

    /// Each energy above 1 % of the largest one is drawn; energies without a column are one area.
    #[test]
    fn every_energy_above_one_percent_is_drawn() {
        let energies: Vec<&str> = STORED.iter().chain(&DISSIPATED).map(|c| c.0).collect();
        for name in energies.iter().filter(|name| **name != "ALLKE") {
            let small = [0.0, 0.5, 1.1];
            let internal = if INTERNAL.contains(name) { small } else { [0.0; 3] };
            let known =
                [("ALLKE", [100.0, 99.5, 98.9]), ("ALLIE", internal), ("ALLWK", [0.0; 3]), ("ETOTAL", [100.0; 3])];
            let with = series_of(&[&known[..], &[(*name, small)]].concat());
            assert_eq!((with.len(), with[1].1), (3, 1.1), "{name}: {with:?}");
            assert!(with[1].0 != "energies without a column" && with[1].0 != "other internal", "{with:?}");
            let without = series_of(&known);
            let expected_name = if INTERNAL.contains(name) { "other internal" } else { "energies without a column" };
            assert!(without[1].0 == expected_name && (without[1].1 - 1.1).abs() < 1e-6, "{name}: {without:?}");
        }
    }

    #[test]
    fn areas_add_up_to_the_supplied_energy() {
        let columns = [
            ("ALLKE", vec![10.0, 4.0, 1.0]),
            ("ALLIE", vec![0.0, 5.0, 4.0]),
            ("ALLPD", vec![0.0, 3.0, 4.5]),
            ("ALLWK", vec![0.0, -1.0, -5.0]),
            ("ETOTAL", vec![10.0, 10.0, 10.0]),
        ];
        let columns = columns.into_iter().map(|(name, values)| (name.to_owned(), values)).collect();
        let history = HistoryColumns { times: vec![0.0, 1.0, 2.0], columns };
        let chart = chart(&history, &UnitNames::default()).expect("a chart");
        let names: Vec<&str> = chart.series.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["kinetic", "other internal", "plastic", "initial energy + work of loads"]);
        let (areas, line) = chart.series.split_at(3);
        for i in 0..3 {
            let sum: f64 = areas.iter().map(|a| a.points[i].1).sum();
            assert!((sum - line[0].points[i].1).abs() < 1e-12, "{i}");
        }
        assert_eq!(areas[1].points[2].1, -0.5, "negative energies stay negative");
        assert!(super::chart(&HistoryColumns::default(), &UnitNames::default()).is_none());
    }
}
