//! Equations of state: pressure as a function of density and specific energy, and the energy update of an increment.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use crate::kernel::lanes::{LANES, Lanes};
use crate::kernel::transcendental::ln_of;
use crate::material::volumetric::PressureUpdate;

/// Pressure at one density, linear in the specific energy e (energy per mass): p = cold + per_energy e.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EosLine {
    /// Pressure at zero energy.
    pub cold: f64,
    /// Derivative of the pressure with respect to the specific energy (density times Grueneisen coefficient).
    pub per_energy: f64,
    /// Derivative of `cold` with respect to density.
    pub cold_slope: f64,
    /// Derivative of `per_energy` with respect to density.
    pub energy_slope: f64,
}

impl EosLine {
    /// Returns the isentropic bulk modulus at a density and specific energy, at least that of the law's `floor`.
    pub(super) fn bulk_modulus(&self, law: &impl LinearEos, density: f64, energy: f64) -> f64 {
        self.bulk_above(law.floor(), law.ambient(), [density, energy])
    }

    fn bulk_above(&self, floor: f64, ambient: f64, [density, energy]: [f64; 2]) -> f64 {
        let pressure = self.cold + self.per_energy * energy;
        let bulk =
            density * (self.cold_slope + self.energy_slope * energy) + self.per_energy * (pressure + ambient) / density;
        bulk.max(floor)
    }
}

/// Pressure lines of a block; see [`EosLine`].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EosLines {
    cold: Lanes,
    per_energy: Lanes,
    cold_slope: Lanes,
    energy_slope: Lanes,
}

impl EosLines {
    #[inline(always)]
    fn of(&self, l: usize) -> EosLine {
        let EosLines { cold, per_energy, cold_slope, energy_slope } = self;
        EosLine { cold: cold[l], per_energy: per_energy[l], cold_slope: cold_slope[l], energy_slope: energy_slope[l] }
    }
}

/// An equation of state that is linear in the specific energy.
pub trait LinearEos: Send + Sync + 'static {
    /// Returns the pressure line at a density, given with its inverse, the specific volume: a division takes as long as
    /// ten multiplications. Equation (7.1).
    fn curve(&self, density: f64, specific_volume: f64) -> EosLine;
    /// Returns the ambient pressure: it is not part of the stress, but the gas works against it.
    fn ambient(&self) -> f64 {
        0.0
    }
    /// Returns the smallest bulk modulus, which keeps the stable time increment finite for states without stiffness.
    fn floor(&self) -> f64;
}

/// Ideal gas: p + p_A = rho R (T - T_Z), e = c_v (T - T_Z), so p = (R/c_v) rho e - p_A (ABAQUS Analysis User's Guide,
/// "Equation of state", ideal gas).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealGas {
    /// Specific gas constant R, energy per mass and temperature.
    pub gas_constant: f64,
    /// Specific heat at constant volume c_v, energy per mass and temperature.
    pub specific_heat: f64,
    /// Ambient pressure p_A.
    pub ambient: f64,
    /// Absolute zero T_Z on the temperature scale of the deck.
    pub absolute_zero: f64,
}

impl LinearEos for IdealGas {
    #[inline(always)]
    fn curve(&self, density: f64, _: f64) -> EosLine {
        let ratio = self.gas_constant / self.specific_heat;
        EosLine { cold: -self.ambient, per_energy: ratio * density, cold_slope: 0.0, energy_slope: ratio }
    }

    fn ambient(&self) -> f64 {
        self.ambient
    }

    fn floor(&self) -> f64 {
        1e-40
    }
}

/// Mie and Grueneisen with a linear Hugoniot U_s = c0 + s U_p: p = rho0 c0^2 eta (1 - Gamma0 eta/2)/(1 - s eta)^2 +
/// Gamma0 rho0 e with eta = 1 - rho0/rho (ABAQUS Analysis User's Guide, "Equation of state", linear U_s - U_p Hugoniot
/// form).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UsUp {
    /// Reference density rho0, at zero pressure and energy.
    pub density: f64,
    /// Sound speed at the reference state.
    pub c0: f64,
    /// Slope of the shock speed U_s over the particle velocity U_p.
    pub s: f64,
    /// Grueneisen coefficient.
    pub gamma0: f64,
}

impl LinearEos for UsUp {
    /// Returns NaN at compressions eta >= 1/s, which no shock reaches.
    #[inline(always)]
    fn curve(&self, _: f64, specific_volume: f64) -> EosLine {
        let stiffness = self.density * self.c0 * self.c0;
        let eta = 1.0 - self.density * specific_volume;
        let remainder = 1.0 - self.s * eta;
        let inverse = if remainder > 0.0 { 1.0 / remainder } else { f64::NAN };
        let square = stiffness * inverse * inverse;
        let thermal = 1.0 - 0.5 * self.gamma0 * eta;
        let by_eta = square * ((1.0 - self.gamma0 * eta) + 2.0 * self.s * eta * thermal * inverse);
        EosLine {
            cold: square * eta * thermal,
            per_energy: self.gamma0 * self.density,
            cold_slope: by_eta * self.density * specific_volume * specific_volume,
            energy_slope: 0.0,
        }
    }

    fn floor(&self) -> f64 {
        1e-6 * self.density * self.c0 * self.c0
    }
}

/// Tabulated equation of state: p = f1 + rho0 f2 e, both functions linear in the volumetric strain ln(rho0/rho),
/// extrapolated with the slopes at the ends (ABAQUS Analysis User's Guide, "Equation of state", tabulated equation of
/// state).
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    /// Reference density rho0.
    density: f64,
    /// Intervals in descending order of the strain.
    intervals: Vec<TableInterval>,
    /// Smallest bulk modulus.
    floor: f64,
}

/// Interval of the volumetric strain in which f1 and f2 are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TableInterval {
    /// Upper end of the interval.
    strain: f64,
    /// Strain below which the interval counts; infinite for the first one, which is extrapolated.
    limit: f64,
    /// f1 and f2 at the upper end.
    values: [f64; 2],
    /// Slopes of f1 and f2 over the strain.
    slopes: [f64; 2],
}

impl Tabulated {
    /// Creates the law from the reference density and rows of f1, f2 and the volumetric strain, in descending order of the
    /// strain; at least two.
    pub fn new(density: f64, rows: &[[f64; 3]]) -> Tabulated {
        let interval = |rows: &[[f64; 3]]| {
            let (a, b) = (rows[0], rows[1]);
            let slope = |i: usize| (b[i] - a[i]) / (b[2] - a[2]);
            TableInterval { strain: a[2], limit: a[2], values: [a[0], a[1]], slopes: [slope(0), slope(1)] }
        };
        let mut intervals: Vec<TableInterval> = rows.windows(2).map(interval).collect();
        intervals.iter_mut().take(1).for_each(|first| first.limit = f64::INFINITY);
        let stiffest = intervals.iter().map(|interval| -interval.slopes[0]).fold(0.0, f64::max);
        Tabulated { density, intervals, floor: 1e-6 * stiffest }
    }

    /// Returns the isentropic bulk modulus.
    pub(super) fn bulk_modulus(&self, specific_volume: f64, energy: f64) -> f64 {
        self.line(specific_volume).bulk_above(self.floor, 0.0, [1.0 / specific_volume, energy])
    }

    /// Returns the pressure line at a specific volume.
    pub(super) fn line(&self, specific_volume: f64) -> EosLine {
        let ones = [1.0; LANES];
        let volume = [specific_volume; LANES];
        let update = PressureUpdate {
            mean: ones,
            bulk: ones,
            viscous: ones,
            heat: ones,
            compacted: ones,
            dilation: ones,
            work: ones,
            middle: ones,
            volume,
            mass: ones,
        };
        self.lines(&update).of(0)
    }

    /// Returns the pressure lines of a block; NaN for densities that are not positive numbers.
    #[inline(always)]
    fn lines(&self, update: &PressureUpdate) -> EosLines {
        let (mut volumes, mut strain) = ([0.0; LANES], [0.0; LANES]);
        let mut lines = EosLines { cold: [f64::NAN; LANES], ..EosLines::default() };
        for l in 0..LANES {
            volumes[l] = specific_volume(update, l);
            let ratio = self.density * volumes[l];
            let log = if ratio >= f64::MIN_POSITIVE { ln_of(ratio) } else { f64::NAN };
            strain[l] = if ratio <= f64::MAX { log } else { f64::NAN };
        }
        // Each interval overwrites the lanes at smaller strains.
        for &TableInterval { strain: start, limit, values, slopes } in &self.intervals {
            for l in 0..LANES {
                let after = strain[l] - start;
                let line = [values[0] + slopes[0] * after, values[1] + slopes[1] * after];
                let is_below = strain[l] < limit;
                lines.cold[l] = if is_below { line[0] } else { lines.cold[l] };
                lines.per_energy[l] = if is_below { line[1] } else { lines.per_energy[l] };
                lines.cold_slope[l] = if is_below { slopes[0] } else { lines.cold_slope[l] };
                lines.energy_slope[l] = if is_below { slopes[1] } else { lines.energy_slope[l] };
            }
        }
        for l in 0..LANES {
            // d(strain)/d(rho) = -1/rho.
            lines.per_energy[l] *= self.density;
            lines.cold_slope[l] *= -volumes[l];
            lines.energy_slope[l] *= -volumes[l] * self.density;
        }
        lines
    }

    /// Updates pressures and energies of a block.
    #[inline(always)]
    pub(super) fn advance_block(&self, energy: &mut Lanes, update: &mut PressureUpdate) {
        let lines = self.lines(update);
        for l in 0..LANES {
            energy[l] = advance(update, l, lines.of(l), energy[l], [0.0, self.floor]);
        }
    }
}

/// Returns the specific volume of a lane. The inverse mass is also part of the energy update.
#[inline(always)]
pub(super) fn specific_volume(update: &PressureUpdate, l: usize) -> f64 {
    update.volume[l] * (1.0 / update.mass[l])
}

/// Updates pressure, bulk modulus and specific energy of a lane. The energy balance m de = -(p + p')/2 dV + deviatoric
/// and viscous work, with p' = a + b e' at the end of the increment, is linear in e' and solved in closed form. The
/// viscous work is estimated with the viscous stress of the previous increment. Returns the specific energy. Equations
/// (7.2), (7.3), (7.4).
#[inline(always)]
pub(super) fn advance(
    update: &mut PressureUpdate,
    l: usize,
    curve: EosLine,
    before: f64,
    [ambient, floor]: [f64; 2],
) -> f64 {
    let EosLine { cold, per_energy, cold_slope, energy_slope } = curve;
    let density = update.mass[l] / update.volume[l];
    let expected = update.viscous[l] * (update.middle[l] * update.dilation[l]);
    let energy = advance_energy(update, l, curve, before, ambient);
    let pressure = cold + per_energy * energy;
    // rho dp/drho with de = (p + p_A) drho/rho². A NaN is kept, so that the run halts.
    let volume = specific_volume(update, l);
    let bulk = density * (cold_slope + energy_slope * energy) + per_energy * (pressure + ambient) * volume;
    update.bulk[l] = if bulk < floor { floor } else { bulk };
    update.mean[l] = -pressure;
    update.heat[l] = expected;
    energy
}

/// Returns the specific energy of a lane at the end of an increment. Equation (7.3).
#[inline(always)]
pub(super) fn advance_energy(update: &PressureUpdate, l: usize, curve: EosLine, before: f64, ambient: f64) -> f64 {
    let inverse = 1.0 / update.mass[l];
    let change = update.middle[l] * update.dilation[l];
    let absolute = 0.5 * (update.mean[l] - ambient - curve.cold - ambient);
    let gained = absolute * change + update.work[l] + update.viscous[l] * change;
    (before + gained * inverse) / (1.0 + 0.5 * curve.per_energy * change * inverse)
}

/// Updates pressures and energies of a block whose pressure line depends on density only.
#[inline(always)]
pub(super) fn advance_block(law: &impl LinearEos, energy: &mut Lanes, update: &mut PressureUpdate) {
    let (ambient, floor) = (law.ambient(), law.floor());
    for l in 0..LANES {
        let curve = law.curve(update.mass[l] / update.volume[l], specific_volume(update, l));
        energy[l] = advance(update, l, curve, energy[l], [ambient, floor]);
    }
}

#[cfg(test)]
mod tests {
    use super::{EosLine, IdealGas, LinearEos, UsUp};

    fn at(law: impl LinearEos, density: f64) -> EosLine {
        law.curve(density, 1.0 / density)
    }

    /// On the Hugoniot, e = p (1/rho0 - 1/rho)/2, the pressure is rho0 U_s U_p for every particle velocity U_p.
    #[test]
    fn pressure_on_the_hugoniot_matches_shock_relations() {
        let law = UsUp { density: 2.785, c0: 5.328, s: 1.338, gamma0: 2.0 };
        for up in [0.01, 0.5, 2.0] {
            let us = law.c0 + law.s * up;
            let (p, density) = (law.density * us * up, law.density * us / (us - up));
            let energy = 0.5 * p * (1.0 / law.density - 1.0 / density);
            let curve = at(law, density);
            assert!(((curve.cold + curve.per_energy * energy) / p - 1.0).abs() < 1e-12);
        }
        assert!(at(law, law.density / (1.0 - 1.0 / law.s)).cold.is_nan());
    }

    #[test]
    fn slopes_are_derivatives() {
        let law = UsUp { density: 2.785, c0: 5.328, s: 1.338, gamma0: 2.0 };
        for density in [2.5, 2.785, 3.3] {
            let step = 1e-6;
            let slope = (at(law, density + step).cold - at(law, density - step).cold) / (2.0 * step);
            assert!((slope / at(law, density).cold_slope - 1.0).abs() < 1e-7);
        }
        let gas = IdealGas { gas_constant: 287.0, specific_heat: 717.5, ambient: 1e5, absolute_zero: 0.0 };
        // Air at 300 K and 1.2 kg/m^3: rho R T.
        let curve = at(gas, 1.2);
        assert!((curve.cold + curve.per_energy * 717.5 * 300.0 - (1.2 * 287.0 * 300.0 - 1e5)).abs() < 1e-6);
    }
}
