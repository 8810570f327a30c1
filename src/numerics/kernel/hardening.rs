//! Yield stress of metals as a function of plastic strain, rate and temperature, and the scalar return to the yield
//! stress.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::lanes::{InlineMap, LANES, Lanes};

/// A yield stress that depends on the state of a material point.
pub trait YieldStress: Send + Sync {
    /// Returns the yield stress at an equivalent plastic strain, its rate, and a temperature.
    fn at(&self, strain: f64, rate: f64, temperature: f64) -> f64;
}

/// Table of a value (for example yield stress) over an abscissa (for example plastic strain), with linear
/// interpolation, constant beyond the ends (ABAQUS Analysis User's Guide, "Classical metal plasticity").
#[derive(Clone, Debug)]
pub struct LinearTable {
    /// `[value, abscissa]`, ascending in the abscissa.
    pub rows: Vec<[f64; 2]>,
}

/// Returns the value at an abscissa in rows `[value, abscissa]`, constant beyond the ends; 0 without rows.
pub fn interpolate(rows: &[[f64; 2]], at: f64) -> f64 {
    let next = rows.partition_point(|row| row[1] <= at);
    match (next.checked_sub(1).map(|i| rows[i]), rows.get(next)) {
        (Some(a), Some(b)) => a[0] + (b[0] - a[0]) * (at - a[1]) / (b[1] - a[1]),
        (Some(row), None) | (None, Some(&row)) => row[0],
        (None, None) => 0.0,
    }
}

impl LinearTable {
    /// Returns the interpolated value at an abscissa.
    pub fn value(&self, at: f64) -> f64 {
        interpolate(&self.rows, at)
    }

    /// Returns the integral of the value from the first abscissa, or from zero if there is only one row.
    pub fn integral(&self, at: f64) -> f64 {
        let ([first, .., last], true) = (self.rows.as_slice(), self.rows.len() > 1) else {
            return self.rows.first().map_or(0.0, |row| row[0] * at);
        };
        let part = |pair: &[[f64; 2]]| {
            let ([from, start], [last_value, end]) = (pair[0], pair[1]);
            let within = at.clamp(start, end) - start;
            let value = from + (last_value - from) * within / (end - start);
            0.5 * (from + value) * within
        };
        let outside = first[0] * (at - first[1]).min(0.0) + last[0] * (at - last[1]).max(0.0);
        outside + self.rows.windows(2).map(part).sum::<f64>()
    }
}

/// Line of a [`LinearTable`] around an abscissa, so that values near it need no search.
#[derive(Clone, Copy, Debug)]
pub struct TableLine<'a> {
    table: &'a LinearTable,
    /// Abscissae between which the line holds, and the one at which the value is [`TableLine::value`].
    range: [f64; 2],
    from: f64,
    /// Value at the abscissa for which the line was made.
    pub value: f64,
    /// Slope of the line.
    pub slope: f64,
}

impl LinearTable {
    /// Returns the line of the table to the right of an abscissa.
    pub fn line(&self, from: f64) -> TableLine<'_> {
        let next = self.rows.iter().position(|row| row[1] > from).unwrap_or(self.rows.len());
        let end = self.rows.get(next).map_or(f64::INFINITY, |row| row[1]);
        let (start, value, slope) = match (next.checked_sub(1).map(|i| self.rows[i]), self.rows.get(next)) {
            (Some(a), Some(b)) => {
                let slope = (b[0] - a[0]) / (b[1] - a[1]);
                (a[1], a[0] + slope * (from - a[1]), slope)
            }
            (Some(row), None) => (row[1], row[0], 0.0),
            (None, Some(row)) => (f64::NEG_INFINITY, row[0], 0.0),
            (None, None) => (f64::NEG_INFINITY, 0.0, 0.0),
        };
        TableLine { table: self, range: [start, end], from, value, slope }
    }
}

/// Lines of a [`LinearTable`] to the right of an abscissa of each lane.
#[derive(Clone, Copy, Debug)]
pub struct TableLines<'a> {
    table: &'a LinearTable,
    from: Lanes,
    end: Lanes,
    value: Lanes,
    slope: Lanes,
}

impl LinearTable {
    /// Returns the lines of [`Self::line`]; each row overwrites the lanes at and above its abscissa.
    #[inline(always)] // Into loops over lanes, compiled for the instruction set of the machine.
    pub fn lines(&self, from: &Lanes) -> TableLines<'_> {
        let [first, last] = [self.rows.first(), self.rows.last()].inline_map(|row| row.copied());
        let [first, last] = [first.unwrap_or([0.0, f64::INFINITY]), last.unwrap_or([0.0, f64::INFINITY])];
        let (mut value, mut slope, mut end) = ([first[0]; LANES], [0.0; LANES], [first[1]; LANES]);
        for pair in self.rows.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let steep = (b[0] - a[0]) / (b[1] - a[1]);
            for l in 0..LANES {
                let is_right = from[l] >= a[1];
                value[l] = if is_right { a[0] + steep * (from[l] - a[1]) } else { value[l] };
                slope[l] = if is_right { steep } else { slope[l] };
                end[l] = if is_right { b[1] } else { end[l] };
            }
        }
        for l in 0..LANES {
            let is_right = from[l] >= last[1];
            value[l] = if is_right { last[0] } else { value[l] };
            slope[l] = if is_right { 0.0 } else { slope[l] };
            end[l] = if is_right { f64::INFINITY } else { end[l] };
        }
        TableLines { table: self, from: *from, end, value, slope }
    }
}

impl<'a> TableLines<'a> {
    /// Returns the line of a lane.
    #[inline(always)] // Likewise.
    pub fn of(&self, l: usize) -> TableLine<'a> {
        let (from, value, slope) = (self.from[l], self.value[l], self.slope[l]);
        TableLine { table: self.table, range: [from, self.end[l]], from, value, slope }
    }
}

impl TableLine<'_> {
    /// Returns the value of the line at any abscissa, for loops over lanes; see [`Self::holds_at`].
    #[inline(always)] // Likewise.
    pub fn extended_to(&self, abscissa: f64) -> f64 {
        self.value + self.slope * (abscissa - self.from)
    }

    /// Returns [`Self::extended_to`] (`LINE`) or [`Self::at`].
    #[inline(always)] // Likewise.
    pub fn value_at<const LINE: bool>(&self, abscissa: f64) -> f64 {
        if LINE { self.extended_to(abscissa) } else { self.at(abscissa) }
    }

    /// Returns whether the value at an abscissa is on the line.
    #[inline(always)] // Likewise.
    pub fn holds_at(&self, abscissa: f64) -> bool {
        let [start, end] = self.range;
        abscissa >= start && abscissa <= end
    }

    /// Returns the value of the table at any abscissa.
    #[inline]
    pub fn at(&self, abscissa: f64) -> f64 {
        if self.holds_at(abscissa) { self.extended_to(abscissa) } else { self.table.value(abscissa) }
    }
}

impl YieldStress for LinearTable {
    fn at(&self, strain: f64, _rate: f64, _temperature: f64) -> f64 {
        self.value(strain)
    }
}

/// Tables at ascending temperatures, with linear interpolation, constant beyond the ends (ABAQUS Analysis User's Guide,
/// "Classical metal plasticity").
#[derive(Clone, Debug)]
pub struct TableOverTemperature {
    /// Temperature and the table at that temperature, ascending.
    pub tables: Vec<(f64, LinearTable)>,
}

impl YieldStress for TableOverTemperature {
    fn at(&self, strain: f64, _rate: f64, temperature: f64) -> f64 {
        let after = self.tables.partition_point(|t| t.0 <= temperature);
        match (after.checked_sub(1).map(|i| &self.tables[i]), self.tables.get(after)) {
            (Some((low, a)), Some((high, b))) => {
                let share = (temperature - low) / (high - low);
                let (a, b) = (a.value(strain), b.value(strain));
                a + share * (b - a)
            }
            (Some((_, only)), None) | (None, Some((_, only))) => only.value(strain),
            (None, None) => 0.0,
        }
    }
}

/// Johnson-Cook yield stress: (A + B p^n)(1 - θ^m), θ = (T - T_transition)/(T_melt - T_transition) limited to 0..1
/// (ABAQUS Analysis User's Guide, "Johnson-Cook plasticity").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JohnsonCook {
    /// Constant A, the yield stress without plastic strain, stress.
    pub a: f64,
    /// Constant B of the hardening term, stress.
    pub b: f64,
    pub n: f64,
    pub m: f64,
    pub melt: f64,
    /// Transition temperature; no softening below.
    pub transition: f64,
}

impl YieldStress for JohnsonCook {
    /// Equation (6.5).
    fn at(&self, strain: f64, _rate: f64, temperature: f64) -> f64 {
        let hardened = self.a + self.b * power(strain, self.n);
        let theta = (temperature - self.transition) / (self.melt - self.transition);
        if theta <= 0.0 || theta.is_nan() {
            return hardened;
        }
        if theta >= 1.0 { 0.0 } else { hardened * (1.0 - power(theta, self.m)) }
    }
}

/// Rate dependence: factor on a static yield stress.
#[derive(Clone, Debug)]
pub enum RateFactor {
    /// Johnson and Cook: 1 + C ln(rate/reference), not below 1.
    JohnsonCook {
        c: f64,
        /// Reference strain rate, 1/time.
        reference: f64,
    },
    /// Cowper and Symonds: 1 + (rate/D)^(1/n).
    PowerLaw {
        /// D over temperature.
        d: LinearTable,
        /// n over temperature.
        n: LinearTable,
    },
    /// Tabulated yield stress ratio over rate, at ascending temperatures.
    Ratio(TableOverTemperature),
}

impl RateFactor {
    /// Returns whether the factor is 1 at any rate.
    pub fn is_constant(&self) -> bool {
        matches!(self, RateFactor::JohnsonCook { c, .. } if *c == 0.0)
    }

    /// Returns the factor at a rate of equivalent plastic strain and a temperature (ABAQUS Analysis User's Guide
    /// 23.2.3, "Rate-dependent yield").
    pub fn at(&self, rate: f64, temperature: f64) -> f64 {
        match self {
            RateFactor::JohnsonCook { c, reference } if rate > *reference => 1.0 + c * libm::log(rate / reference),
            RateFactor::JohnsonCook { .. } => 1.0,
            RateFactor::PowerLaw { d, n } => 1.0 + power(rate / d.value(temperature), 1.0 / n.value(temperature)),
            RateFactor::Ratio(tables) => tables.at(rate, 0.0, temperature),
        }
    }
}

/// Returns x^n for positive x, otherwise zero, accurate to a few units in the last place: several times as fast as a
/// correctly rounded `pow`. Uses `libm`, so that every machine gives the same bits.
pub fn power(x: f64, n: f64) -> f64 {
    if x > 0.0 { libm::exp(n * libm::log(x)) } else { 0.0 }
}

/// A rate-independent yield stress.
#[derive(Clone, Debug)]
pub enum StaticYield {
    Tables(TableOverTemperature),
    JohnsonCook(JohnsonCook),
}

/// Yield stress of a metal: static yield stress times rate factor.
#[derive(Clone, Debug)]
pub struct FlowStress {
    pub base: StaticYield,
    pub factor: Option<RateFactor>,
}

impl YieldStress for FlowStress {
    fn at(&self, strain: f64, rate: f64, temperature: f64) -> f64 {
        let base = match &self.base {
            StaticYield::Tables(tables) => tables.at(strain, rate, temperature),
            StaticYield::JohnsonCook(law) => law.at(strain, rate, temperature),
        };
        self.factor.as_ref().map_or(base, |factor| base * factor.at(rate, temperature))
    }
}

/// Largest number of secants; three halve the bracket. Flow at a rate that is a high power of the overstress has a root as
/// small as the smallest number.
const MOST_SECANTS: usize = 4000;

/// Returns the increment dp of plastic strain for which `trial - 3 G dp` equals the yield stress at `strain + dp` and
/// `dp/dt`. The residual decreases with dp and has one root, which is found by bracketed secants. Returns NaN, which halts
/// the run at the element, if no root is found. Equation (6.2).
pub fn plastic_increment(
    law: &dyn YieldStress,
    trial: f64,
    strain: f64,
    temperature: f64,
    shear3: f64,
    dt: f64,
) -> f64 {
    let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
    let residual = |dp: f64| trial - shear3 * dp - law.at(strain + dp, dp * per_dt, temperature);
    let (mut low, mut at_low) = (0.0, residual(0.0));
    if at_low <= 0.0 || at_low.is_nan() {
        return 0.0;
    }
    // If the yield stress does not decrease, the root is below that of perfect plasticity; otherwise below zero stress.
    let mut high = at_low / shear3;
    let mut at_high = residual(high);
    if at_high > 0.0 {
        (low, at_low) = (high, at_high);
        high = trial / shear3;
        at_high = residual(high);
        if at_high >= 0.0 {
            return high;
        }
    }
    bracketed_root(residual, [low, at_low], [high, at_high], 1e-11 * trial)
}

/// Returns the root of a function between two points `[x, value]`, of which the first has a positive value and the second
/// a negative one, to a value of `enough`. Returns NaN if no root is found.
pub(super) fn bracketed_root(
    residual: impl Fn(f64) -> f64,
    [mut low, at_low]: [f64; 2],
    [mut high, at_high]: [f64; 2],
    enough: f64,
) -> f64 {
    // Secants through the last two points inside the bracket; bisection if two secants do not halve the bracket.
    let (mut previous, mut at_before) = (low, at_low);
    let (mut x, mut value) = (high, at_high);
    let (mut width, mut slow) = (high - low, 0);
    for _ in 0..MOST_SECANTS {
        if value.abs() <= enough || high - low <= 1e-15 * high || value.is_nan() {
            return x;
        }
        let secant = x - value * (x - previous) / (value - at_before);
        (previous, at_before) = (x, value);
        x = if slow < 2 && secant > low && secant < high { secant } else { 0.5 * (low + high) };
        value = residual(x);
        if value > 0.0 {
            low = x
        } else {
            high = x
        }
        slow = if high - low <= 0.5 * width { 0 } else { slow + 1 };
        width = if slow == 0 { high - low } else { width };
    }
    f64::NAN
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_between_rows() {
        let table = LinearTable { rows: vec![[100.0, 0.0], [150.0, 0.1], [160.0, 0.5]] };
        assert_eq!([0.0, 0.05, 0.1, 0.3, 9.0].map(|p| table.at(p, 0.0, 0.0)), [100.0, 125.0, 150.0, 155.0, 160.0]);
    }

    #[test]
    fn tables_are_linear_between_temperatures() {
        let table = |factor: f64| LinearTable { rows: vec![[100.0 * factor, 0.0], [150.0 * factor, 0.1]] };
        let tables = TableOverTemperature { tables: vec![(20.0, table(1.0)), (220.0, table(0.5))] };
        for (strain, temperature, expected) in
            [(0.0, 0.0, 100.0), (0.05, 20.0, 125.0), (0.0, 120.0, 75.0), (0.1, 170.0, 93.75), (0.2, 900.0, 75.0)]
        {
            assert_eq!(tables.at(strain, 0.0, temperature), expected);
        }
    }

    fn weldox(factor: RateFactor) -> FlowStress {
        let law = JohnsonCook { a: 806.0, b: 614.0, n: 0.168, m: 1.1, melt: 1540.0, transition: 20.0 };
        FlowStress { base: StaticYield::JohnsonCook(law), factor: Some(factor) }
    }

    #[test]
    fn johnson_cook_matches_its_formula() {
        let law = weldox(RateFactor::JohnsonCook { c: 0.0089, reference: 1.0 });
        let expected =
            (806.0 + 614.0 * 0.2f64.powf(0.168)) * (1.0 + 0.0089 * 1e4f64.ln()) * (1.0 - (480.0f64 / 1520.0).powf(1.1));
        assert!((law.at(0.2, 1e4, 500.0) / expected - 1.0).abs() < 1e-14);
        assert_eq!(law.at(0.0, 0.5, 20.0), 806.0);
        assert_eq!(law.at(0.0, 0.5, 1540.0), 0.0);
    }

    fn constant(value: f64) -> LinearTable {
        LinearTable { rows: vec![[value, 0.0]] }
    }

    #[test]
    fn rate_factors_are_linear_between_temperatures() {
        let over = |cold: f64, hot: f64| LinearTable { rows: vec![[cold, 20.0], [hot, 220.0]] };
        let law = RateFactor::PowerLaw { d: over(40.0, 80.0), n: over(4.0, 6.0) };
        // At the mean temperature D = 60 and n = 5.
        assert!((law.at(600.0, 120.0) / (1.0 + 10.0f64.powf(0.2)) - 1.0).abs() < 1e-14);
        let ratios = |factor: f64| LinearTable { rows: vec![[1.0, 0.0], [1.0 + factor, 1000.0]] };
        let law = RateFactor::Ratio(TableOverTemperature { tables: vec![(20.0, ratios(0.4)), (220.0, ratios(0.8))] });
        for (temperature, ratio) in [(20.0, 1.2), (120.0, 1.3), (500.0, 1.4)] {
            assert!((law.at(500.0, temperature) / ratio - 1.0f64).abs() < 1e-15);
        }
    }

    /// A yield stress that jumps above the trial stress has no root: a law with an infinite yield stress at any rate.
    #[test]
    fn a_missing_root_is_not_a_number() {
        struct Jump;
        impl YieldStress for Jump {
            fn at(&self, _: f64, rate: f64, _: f64) -> f64 {
                if rate > 0.0 { 1e9 } else { 1.0 }
            }
        }
        assert!(plastic_increment(&Jump, 900.0, 0.0, 300.0, 240_000.0, 1e-6).is_nan());
    }

    #[test]
    fn return_reaches_the_yield_surface() {
        let law = weldox(RateFactor::PowerLaw { d: constant(40.0), n: constant(5.0) });
        for (trial, strain) in [(900.0, 0.0), (5000.0, 0.3), (806.1, 0.0)] {
            let dp = plastic_increment(&law, trial, strain, 300.0, 3.0 * 80_000.0, 1e-6);
            let yields = law.at(strain + dp, dp / 1e-6, 300.0);
            assert!(
                dp == 0.0 && trial < law.at(strain, 0.0, 300.0) + 1.0
                    || ((trial - 240_000.0 * dp) / yields - 1.0).abs() < 1e-10
            );
        }
    }

    #[test]
    fn integral_of_a_table_is_that_of_its_values() {
        let table = LinearTable { rows: vec![[2.0, -1.0], [3.0, 1.0], [1.0, 2.0]] };
        assert_eq!(table.integral(-1.0), 0.0);
        for (at, expected) in [(-3.0, -4.0), (1.0, 5.0), (2.0, 7.0), (4.0, 9.0), (1.5, 5.0 + 0.5 * 0.5 * (3.0 + 2.0))] {
            assert!((table.integral(at) - expected).abs() < 1e-15, "{at}");
        }
        let constant = LinearTable { rows: vec![[385.0, f64::NAN]] };
        assert_eq!(constant.integral(300.0), 385.0 * 300.0);
    }
}
