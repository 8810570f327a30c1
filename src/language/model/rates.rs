//! Rate dependence and tables of a material as the functions that laws evaluate.

use super::types::RateDependence;
use crate::kernel::hardening::{LinearTable, RateFactor, TableOverTemperature};

/// Returns the factor of a rate dependence on the yield stress; `None` without one.
pub fn rate_factor(rate: Option<&RateDependence>) -> Option<RateFactor> {
    match rate? {
        RateDependence::JohnsonCook([c, reference]) => Some(RateFactor::JohnsonCook { c: *c, reference: *reference }),
        RateDependence::PowerLaw(rows) => {
            let over = |i: usize| LinearTable { rows: rows.iter().map(|r| [r[i], r[2]]).collect() };
            Some(RateFactor::PowerLaw { d: over(0), n: over(1) })
        }
        RateDependence::YieldRatio(rows) => Some(RateFactor::Ratio(TableOverTemperature { tables: blocks(rows) })),
    }
}

/// Returns whether a rate dependence differs between temperatures.
pub fn depends_on_temperature(rate: &RateDependence) -> bool {
    match rate {
        RateDependence::JohnsonCook(_) => false,
        RateDependence::PowerLaw(rows) | RateDependence::YieldRatio(rows) => {
            rows.iter().any(|row| row[2].is_finite() && row[2] != rows[0][2])
        }
    }
}

/// Splits rows of a value, its abscissa and temperature (NaN if absent) into one table for each consecutive
/// temperature.
pub fn blocks(rows: &[[f64; 3]]) -> Vec<(f64, LinearTable)> {
    let mut tables: Vec<(f64, LinearTable)> = Vec::new();
    for [value, at, temperature] in rows {
        match tables.last_mut() {
            Some((last, table)) if *last == *temperature || temperature.is_nan() => table.rows.push([*value, *at]),
            _ => tables.push((*temperature, LinearTable { rows: vec![[*value, *at]] })),
        }
    }
    tables
}
