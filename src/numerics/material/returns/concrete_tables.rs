//! Tables of concrete damaged plasticity: stress and damage over plastic strain, from the rows of the cards.
#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use crate::kernel::hardening::interpolate;
use crate::kernel::lanes::{InlineMap, LANES, Lanes};

/// Largest damage.
pub const LARGEST_DAMAGE: f64 = 0.99;

/// Share of the largest stress that remains after the last row.
const RESIDUAL: f64 = 1e-3;

/// Abscissa of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConcreteAbscissa {
    /// Inelastic or cracking strain.
    Strain,
    /// Cracking displacement, a strain after division by the length of the element.
    Displacement,
}

/// Row of a table.
#[derive(Clone, Copy, Debug)]
struct ConcreteRow {
    /// Inelastic strain, or cracking displacement.
    abscissa: f64,
    /// Inelastic strain minus plastic strain: d/(1 - d) stress/E.
    elastic: f64,
    /// Nominal stress.
    stress: f64,
    /// Damage d.
    damage: f64,
}

/// Values of a table at a plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConcreteStrength {
    /// Yield stress of the undamaged section: stress/(1 - d).
    pub effective: f64,
    /// Damage d.
    pub damage: f64,
    /// Inelastic strain.
    pub inelastic: f64,
}

/// Stress and damage in uniaxial tension or compression, linear between rows over the plastic strain, constant beyond them
/// (ABAQUS Analysis User's Guide, "Concrete damaged plasticity"). Plastic strain is inelastic strain - d/(1 - d) stress/E.
#[derive(Clone, Debug)]
pub struct ConcreteTable {
    /// Abscissa of the rows.
    abscissa: ConcreteAbscissa,
    /// Strain rates of the curves, ascending, 1/time.
    rates: Vec<f64>,
    /// Rows at each rate. The slowest curve gives the damage.
    curves: Vec<Vec<ConcreteRow>>,
}

impl ConcreteTable {
    /// Converts rows stress, inelastic strain (or cracking displacement), strain rate, ascending in the rate, and rows damage,
    /// inelastic strain (or displacement), possibly none. Returns the reason if they are no table.
    pub fn new(
        abscissa: ConcreteAbscissa,
        stresses: &[[f64; 3]],
        damages: &[[f64; 2]],
        young: f64,
    ) -> Result<ConcreteTable, String> {
        let mut table = ConcreteTable { abscissa, rates: vec![], curves: vec![] };
        if let Some([damage, abscissa]) = damages.iter().find(|row| !(0.0..=1.0).contains(&row[0])) {
            return Err(format!("damage {damage} at {abscissa} is not between 0 and 1"));
        }
        ascending(damages, "damage")?;
        if let Some(pair) = damages.windows(2).find(|pair| pair[1][0] < pair[0][0]) {
            return Err(format!("damage decreases to {}", pair[1][0]));
        }
        let damages: Vec<[f64; 2]> = damages.iter().map(|row| [row[0].min(LARGEST_DAMAGE), row[1]]).collect();
        for rows in stresses.chunk_by(|a, b| a[2] == b[2]) {
            let rate = rows[0][2];
            if table.rates.last().is_some_and(|&slower| slower >= rate) {
                return Err(format!("strain rates do not increase at {rate}"));
            }
            let curve: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
            table.rates.push(rate);
            table.curves.push(converted(&curve, &damages, young)?);
        }
        match abscissa {
            _ if table.curves.is_empty() => Err("no stress is given".to_owned()),
            ConcreteAbscissa::Strain => table.check(1.0).map(|()| table),
            ConcreteAbscissa::Displacement => Ok(table),
        }
    }

    /// Converts rows strength, fracture energy per area, strain rate: linear softening to the displacement 2 Gf/ft.
    pub fn of_fracture_energy(rows: &[[f64; 3]], damages: &[[f64; 2]], young: f64) -> Result<ConcreteTable, String> {
        if let Some([strength, energy, _]) = rows.iter().find(|row| row[0] <= 0.0 || row[1] <= 0.0) {
            return Err(format!("strength {strength} and fracture energy {energy} must be positive"));
        }
        // The line ends at the residual.
        let line = |&[strength, energy, rate]: &[f64; 3]| {
            let last = (1.0 - RESIDUAL) * 2.0 * energy / strength;
            [[strength, 0.0, rate], [RESIDUAL * strength, last, rate]]
        };
        let stresses: Vec<[f64; 3]> = rows.iter().flat_map(line).collect();
        ConcreteTable::new(ConcreteAbscissa::Displacement, &stresses, damages, young)
    }

    /// Checks that plastic strains increase in elements up to a length. Returns the reason if they do not.
    pub fn check(&self, length: f64) -> Result<(), String> {
        let scale = self.scale(length);
        for [a, b] in self.curves.iter().flat_map(|rows| rows.windows(2)).map(|pair| [pair[0], pair[1]]) {
            let [first, next] = [a, b].inline_map(|row| row.abscissa * scale - row.elastic);
            if next <= first {
                let abscissae = format!("{} to {}", a.abscissa, b.abscissa);
                let lengths = match self.abscissa {
                    ConcreteAbscissa::Strain => String::new(),
                    ConcreteAbscissa::Displacement => {
                        let longest = (b.abscissa - a.abscissa) / (b.elastic - a.elastic);
                        format!("; elements are up to {length:.4} long, and {longest:.4} is the limit")
                    }
                };
                return Err(format!(
                    "plastic strain, strain - d/(1 - d) stress/E, does not increase from {first:.4e} to {next:.4e} between \
                     the abscissae {abscissae}: damage grows too fast{lengths}"
                ));
            }
        }
        Ok(())
    }

    /// Returns the length of an element above which its stress falls faster than its elasticity allows (snap back).
    /// Equation (20.20).
    pub fn snap_back_length(&self, young: f64) -> f64 {
        if self.abscissa == ConcreteAbscissa::Strain {
            return f64::INFINITY;
        }
        let limit = |pair: &[ConcreteRow]| {
            (pair[1].abscissa - pair[0].abscissa) / ((pair[0].stress - pair[1].stress) / young).max(0.0)
        };
        self.curves.iter().flat_map(|rows| rows.windows(2)).map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Returns the factor from abscissae to strains in an element of a length.
    pub fn scale(&self, length: f64) -> f64 {
        if self.abscissa == ConcreteAbscissa::Displacement { 1.0 / length } else { 1.0 }
    }

    /// Returns the first yield stress of the slowest curve.
    pub fn first(&self) -> f64 {
        self.curves[0][0].stress / (1.0 - self.curves[0][0].damage)
    }

    /// Returns the values at a plastic strain, its rate, and a factor from [`Self::scale`]. Equation (20.17).
    pub fn strength(&self, plastic: f64, rate: f64, scale: f64) -> ConcreteStrength {
        let ConcreteRow { mut stress, damage, elastic, .. } = row_at(&self.curves[0], plastic, scale);
        if self.rates.len() > 1 {
            let faster = self.rates.partition_point(|&limit| limit <= rate).max(1);
            let [slow, slow_rate] = [row_at(&self.curves[faster - 1], plastic, scale).stress, self.rates[faster - 1]];
            let change = |(&fast_rate, rows): (&f64, &Vec<ConcreteRow>)| {
                (rate - slow_rate).max(0.0) / (fast_rate - slow_rate) * (row_at(rows, plastic, scale).stress - slow)
            };
            stress = slow + self.rates.get(faster).zip(self.curves.get(faster)).map_or(0.0, change);
        }
        ConcreteStrength { effective: stress / (1.0 - damage), damage, inelastic: plastic + elastic }
    }
}

/// Part of a [`ConcreteTable`] around a plastic strain, so that values near it need no search.
#[derive(Clone, Copy, Debug)]
pub struct ConcreteLine<'a> {
    table: &'a ConcreteTable,
    scale: f64,
    /// Plastic strains between which the part holds; empty with several rates.
    range: [f64; 2],
    from: f64,
    /// Values at the plastic strain for which it was made, and their slopes.
    stress: [f64; 2],
    damage: [f64; 2],
    elastic: [f64; 2],
    /// Effective strength there at rest.
    pub effective: f64,
}

impl ConcreteTable {
    /// Returns the part of the table around a plastic strain, with a factor from [`Self::scale`].
    pub fn line(&self, from: f64, scale: f64) -> ConcreteLine<'_> {
        let rows = &self.curves[0];
        let strain = |row: &ConcreteRow| row.abscissa * scale - row.elastic;
        let next = rows.iter().position(|row| strain(row) > from).unwrap_or(rows.len());
        let a = &rows[next.saturating_sub(1)];
        let [mut stress, mut damage, mut elastic] = [[a.stress, 0.0], [a.damage, 0.0], [a.elastic, 0.0]];
        let mut range = [if next == 0 { f64::NEG_INFINITY } else { strain(a) }, f64::INFINITY];
        if let (Some(b), true) = (rows.get(next), next > 0) {
            range[1] = strain(b);
            let (per, distance) = (1.0 / (range[1] - range[0]), from - range[0]);
            let between = |first: f64, second: f64| {
                let slope = per * (second - first);
                [first + slope * distance, slope]
            };
            stress = between(a.stress, b.stress);
            damage = between(a.damage, b.damage);
            elastic = between(a.elastic, b.elastic);
        } else if next == 0 {
            range[1] = strain(a);
        }
        if self.rates.len() > 1 {
            range = [f64::INFINITY, f64::NEG_INFINITY];
        }
        let effective = stress[0] / (1.0 - damage[0]);
        ConcreteLine { table: self, scale, range, from, stress, damage, elastic, effective }
    }
}

/// Parts of a [`ConcreteTable`] of one rate around a plastic strain of each lane.
#[derive(Clone, Copy, Debug)]
pub struct ConcreteLines<'a> {
    table: &'a ConcreteTable,
    scale: Lanes,
    from: Lanes,
    end: Lanes,
    stress: [Lanes; 2],
    damage: [Lanes; 2],
    elastic: [Lanes; 2],
    effective: Lanes,
}

impl ConcreteTable {
    /// Returns whether the table has a curve at one rate only.
    pub fn is_static(&self) -> bool {
        self.rates.len() == 1
    }

    /// Returns parts that [`ConcreteLines::fill`] sets.
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    pub fn empty_lines(&self) -> ConcreteLines<'_> {
        ConcreteLines {
            table: self,
            scale: [1.0; LANES],
            from: [0.0; LANES],
            end: [0.0; LANES],
            stress: [[0.0; LANES]; 2],
            damage: [[0.0; LANES]; 2],
            elastic: [[0.0; LANES]; 2],
            effective: [0.0; LANES],
        }
    }
}

impl<'a> ConcreteLines<'a> {
    /// Sets the parts of [`ConcreteTable::line`], for elements of given lengths.
    #[inline(always)] // Likewise.
    pub fn fill(&mut self, from: &Lanes, length: &Lanes) {
        let (table, lines, zero) = (self.table, self, [0.0; LANES]);
        lines.from = *from;
        if table.abscissa == ConcreteAbscissa::Displacement {
            for l in 0..LANES {
                lines.scale[l] = 1.0 / length[l];
            }
        }
        let rows = &table.curves[0];
        // Number of rows at or below the plastic strain.
        let mut below = [0_u64; LANES];
        for row in rows {
            for l in 0..LANES {
                below[l] += u64::from(from[l] >= row.abscissa * lines.scale[l] - row.elastic);
            }
        }
        // Both ends of the part; before the first row and beyond the last one they are the same row.
        let [mut start_abscissa, mut stresses, mut damages, mut elastics] = [zero; 4];
        let [mut end_abscissa, mut to_stress, mut to_damage, mut to_elastic] = [zero; 4];
        let last = rows.len() - 1;
        for l in 0..LANES {
            let next = below[l] as usize;
            let (a, b) = (&rows[next.max(1) - 1], &rows[next.min(last)]);
            (start_abscissa[l], stresses[l], damages[l], elastics[l]) = (a.abscissa, a.stress, a.damage, a.elastic);
            (end_abscissa[l], to_stress[l], to_damage[l], to_elastic[l]) = (b.abscissa, b.stress, b.damage, b.elastic);
        }
        for l in 0..LANES {
            let start = start_abscissa[l] * lines.scale[l] - elastics[l];
            let end = end_abscissa[l] * lines.scale[l] - to_elastic[l];
            let is_line = end > start;
            let (per, distance) = (1.0 / (end - start), from[l] - start);
            let line = |low: f64, high: f64| {
                let slope = per * (high - low);
                if is_line { [low + slope * distance, slope] } else { [low, 0.0] }
            };
            [lines.stress[0][l], lines.stress[1][l]] = line(stresses[l], to_stress[l]);
            [lines.damage[0][l], lines.damage[1][l]] = line(damages[l], to_damage[l]);
            [lines.elastic[0][l], lines.elastic[1][l]] = line(elastics[l], to_elastic[l]);
            let last = if from[l] >= end { f64::INFINITY } else { end };
            lines.end[l] = if is_line { end } else { last };
            lines.effective[l] = lines.stress[0][l] / (1.0 - lines.damage[0][l]);
        }
    }

    /// Returns the part of a lane.
    #[inline(always)] // Likewise.
    pub fn of(&self, l: usize) -> ConcreteLine<'a> {
        let [stress, damage, elastic] =
            [&self.stress, &self.damage, &self.elastic].inline_map(|[value, slope]| [value[l], slope[l]]);
        ConcreteLine {
            table: self.table,
            scale: self.scale[l],
            range: [self.from[l], self.end[l]],
            from: self.from[l],
            stress,
            damage,
            elastic,
            effective: self.effective[l],
        }
    }
}

/// Methods with `LINE` use the part alone, also beyond its end, as loops over lanes need.
impl ConcreteLine<'_> {
    /// Returns whether the values at a plastic strain are on the part.
    #[inline(always)] // Into the return of each point.
    pub fn holds_at(&self, plastic: f64) -> bool {
        let [start, end] = self.range;
        plastic >= start && plastic <= end
    }

    /// Returns the values at a plastic strain and its rate, like [`ConcreteTable::strength`].
    #[inline(always)] // Into the return of each point.
    pub fn at<const LINE: bool>(&self, plastic: f64, rate: f64) -> ConcreteStrength {
        if LINE || self.holds_at(plastic) {
            let [stress, damage, elastic] = [self.stress, self.damage, self.elastic]
                .inline_map(|[value, slope]| value + slope * (plastic - self.from));
            return ConcreteStrength { effective: stress / (1.0 - damage), damage, inelastic: plastic + elastic };
        }
        self.table.strength(plastic, rate, self.scale)
    }

    /// Returns the effective strength of [`ConcreteLine::at`].
    #[inline(always)] // Into the return of each point.
    pub fn effective_at<const LINE: bool>(&self, plastic: f64, rate: f64) -> f64 {
        if LINE || self.holds_at(plastic) {
            let distance = plastic - self.from;
            let [stress, damage] = [self.stress, self.damage].inline_map(|[value, slope]| value + slope * distance);
            return stress / (1.0 - damage);
        }
        self.table.strength(plastic, rate, self.scale).effective
    }

    /// Returns the slope of the effective strength over the plastic strain at rest.
    #[inline(always)] // Into the return of each point.
    pub fn slope(&self) -> f64 {
        (self.stress[1] + self.effective * self.damage[1]) / (1.0 - self.damage[0])
    }
}

/// Returns the interpolated row at a plastic strain; the abscissa is not set.
fn row_at(rows: &[ConcreteRow], plastic: f64, scale: f64) -> ConcreteRow {
    let strain = |row: &ConcreteRow| row.abscissa * scale - row.elastic;
    let next = rows.iter().position(|row| strain(row) > plastic).unwrap_or(rows.len());
    if next == 0 || next == rows.len() {
        return rows[next.saturating_sub(1)];
    }
    let (a, b) = (&rows[next - 1], &rows[next]);
    // Strains ascend up to `next`.
    let share = (plastic - strain(a)) / (strain(b) - strain(a));
    let between = |first: f64, second: f64| first + share * (second - first);
    ConcreteRow {
        abscissa: 0.0,
        elastic: between(a.elastic, b.elastic),
        stress: between(a.stress, b.stress),
        damage: between(a.damage, b.damage),
    }
}

/// Checks that abscissae of rows `[value, abscissa]` are not negative and increase.
fn ascending(rows: &[[f64; 2]], name: &str) -> Result<(), String> {
    match rows.windows(2).find(|pair| pair[0][1] >= pair[1][1]) {
        Some(pair) => Err(format!("abscissae of {name} do not increase from {} to {}", pair[0][1], pair[1][1])),
        None if rows.first().is_some_and(|row| row[1] < 0.0) => Err(format!("an abscissa of {name} is negative")),
        None => Ok(()),
    }
}

/// Merges rows `[stress, abscissa]` and `[damage, abscissa]`. Equation (20.17).
fn converted(stresses: &[[f64; 2]], damages: &[[f64; 2]], young: f64) -> Result<Vec<ConcreteRow>, String> {
    ascending(stresses, "stress")?;
    let peak = stresses.iter().fold(0.0_f64, |largest, row| largest.max(row[0]));
    if stresses.iter().any(|row| row[0] < 0.0) || stresses[0][0] == 0.0 {
        return Err("the first stress must be positive, the others not negative".to_owned());
    }
    let mut abscissae: Vec<f64> = stresses.iter().chain(damages).map(|row| row[1]).collect();
    abscissae.sort_by(f64::total_cmp);
    abscissae.dedup();
    let row = |abscissa: f64| {
        let stress = interpolate(stresses, abscissa).max(RESIDUAL * peak);
        let damage = interpolate(damages, abscissa);
        ConcreteRow { abscissa, elastic: damage / (1.0 - damage) * stress / young, stress, damage }
    };
    Ok(abscissae.into_iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::{ConcreteAbscissa, ConcreteTable};

    const STRESSES: [[f64; 3]; 3] = [[2.0, 0.0, 0.0], [1.0, 0.002, 0.0], [0.0, 0.006, 0.0]];

    #[test]
    fn abscissae_are_merged_and_stress_has_a_residual() {
        let damages = [[0.0, 0.0], [0.5, 0.004], [1.0, 0.006]];
        let table = ConcreteTable::new(ConcreteAbscissa::Strain, &STRESSES, &damages, 1000.0).unwrap();
        // At the strain 0.002 damage is 0.25: plastic strain 0.002 - (0.25/0.75) 1.0/1000.
        let value = table.strength(0.002 - 1.0 / 3000.0, 0.0, 1.0);
        assert!((value.effective - 1.0 / 0.75).abs() < 1e-12 && (value.damage - 0.25).abs() < 1e-12);
        assert!((value.inelastic - 0.002).abs() < 1e-12);
        let last = table.strength(1.0, 0.0, 1.0);
        assert!((last.damage - 0.99).abs() < 1e-15 && (last.effective - 0.2).abs() < 1e-12, "{last:?}");
    }

    #[test]
    fn tables_without_increasing_plastic_strain_are_errors() {
        let damages = [[0.0, 0.0], [0.9, 0.002]];
        let table = |abscissa| ConcreteTable::new(abscissa, &STRESSES, &damages, 1000.0);
        assert!(table(ConcreteAbscissa::Strain).unwrap_err().contains("does not increase"));
        // The limit of the length is displacement over d/(1 - d) stress/E: 0.002/0.009.
        let by_displacement = table(ConcreteAbscissa::Displacement).unwrap();
        assert!(by_displacement.check(0.22).is_ok());
        assert!(by_displacement.check(0.23).unwrap_err().contains("0.2222 is the limit"));
        assert_eq!(by_displacement.snap_back_length(1000.0), 2.0);
    }

    #[test]
    fn stress_is_linear_over_the_rate() {
        let rows = [[2.0, 0.0, 0.0], [1.0, 0.01, 0.0], [4.0, 0.0, 10.0], [2.0, 0.01, 10.0]];
        let table = ConcreteTable::new(ConcreteAbscissa::Strain, &rows, &[], 1000.0).unwrap();
        for (rate, stress) in [(-1.0, 1.5), (0.0, 1.5), (5.0, 2.25), (10.0, 3.0), (99.0, 3.0)] {
            assert!((table.strength(0.005, rate, 1.0).effective - stress).abs() < 1e-12, "{rate}");
        }
    }
}
