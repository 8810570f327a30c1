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
pub trait EosLaw: Send + Sync + 'static {
    /// Returns the pressure line at a density.
    fn curve(&self, density: f64) -> EosLine;
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

impl EosLaw for IdealGas {
    #[inline(always)]
    fn curve(&self, density: f64) -> EosLine {
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

impl EosLaw for UsUp {
    /// Returns NaN at compressions eta >= 1/s, which no shock reaches.
    #[inline(always)]
    fn curve(&self, density: f64) -> EosLine {
        let (stiffness, per) = (self.density * self.c0 * self.c0, 1.0 / density);
        let eta = 1.0 - self.density * per;
        let rest = 1.0 - self.s * eta;
        let inverse = if rest > 0.0 { 1.0 / rest } else { f64::NAN };
        let square = stiffness * inverse * inverse;
        let thermal = 1.0 - 0.5 * self.gamma0 * eta;
        let by_eta = square * ((1.0 - self.gamma0 * eta) + 2.0 * self.s * eta * thermal * inverse);
        EosLine {
            cold: square * eta * thermal,
            per_energy: self.gamma0 * self.density,
            cold_slope: by_eta * self.density * per * per,
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
    pub density: f64,
    /// Rows of f1, f2 and the volumetric strain, in descending order of the strain; at least two.
    pub rows: Vec<[f64; 3]>,
}

impl Tabulated {
    /// Returns the pressure lines of a block; NaN for densities that are not positive numbers.
    #[inline(always)]
    fn lines(&self, densities: &Lanes) -> EosLines {
        let mut strain = [0.0; LANES];
        let mut lines = EosLines { cold: [f64::NAN; LANES], ..EosLines::default() };
        for l in 0..LANES {
            let ratio = self.density / densities[l];
            let log = if ratio >= f64::MIN_POSITIVE { ln_of(ratio) } else { f64::NAN };
            strain[l] = if ratio <= f64::MAX { log } else { f64::NAN };
        }
        // Each interval overwrites the lanes at smaller strains.
        let mut above = f64::INFINITY;
        for rows in self.rows.windows(2) {
            let (a, b) = (rows[0], rows[1]);
            let per = 1.0 / (b[2] - a[2]);
            let [steep, rising] = [(b[0] - a[0]) * per, (b[1] - a[1]) * per];
            for l in 0..LANES {
                let after = strain[l] - a[2];
                let line = [a[0] + steep * after, a[1] + rising * after];
                let here = strain[l] < above;
                lines.cold[l] = if here { line[0] } else { lines.cold[l] };
                lines.per_energy[l] = if here { line[1] } else { lines.per_energy[l] };
                lines.cold_slope[l] = if here { steep } else { lines.cold_slope[l] };
                lines.energy_slope[l] = if here { rising } else { lines.energy_slope[l] };
            }
            above = b[2];
        }
        for l in 0..LANES {
            // d(strain)/d(rho) = -1/rho.
            let per = -1.0 / densities[l];
            lines.per_energy[l] *= self.density;
            lines.cold_slope[l] *= per;
            lines.energy_slope[l] *= per * self.density;
        }
        lines
    }

    /// Returns the largest bulk modulus of the table at zero energy.
    fn stiffest(&self) -> f64 {
        self.rows.windows(2).map(|w| (w[1][0] - w[0][0]) / (w[0][2] - w[1][2])).fold(0.0, f64::max)
    }

    /// Updates pressures and energies of a block.
    #[inline(always)]
    pub(super) fn advance_block(&self, energy: &mut Lanes, mut update: PressureUpdate<'_>) {
        let mut densities = [0.0; LANES];
        for l in 0..LANES {
            densities[l] = update.mass[l] / update.volume[l];
        }
        let (lines, floor) = (self.lines(&densities), 1e-6 * self.stiffest());
        for l in 0..LANES {
            energy[l] = advance(&mut update, l, lines.of(l), energy[l], [0.0, floor]);
        }
    }
}

/// Updates pressure, bulk modulus and specific energy of a lane. The energy balance m de = -(p + p')/2 dV + deviatoric
/// and viscous work, with p' = a + b e' at the end of the increment, is linear in e' and solved in closed form. The
/// viscous work is estimated with the viscous stress of the previous increment. Returns the specific energy.
#[inline(always)]
pub(super) fn advance(
    update: &mut PressureUpdate<'_>,
    l: usize,
    curve: EosLine,
    before: f64,
    [ambient, floor]: [f64; 2],
) -> f64 {
    let EosLine { cold, per_energy, cold_slope, energy_slope } = curve;
    let inverse = 1.0 / update.mass[l];
    let density = update.mass[l] / update.volume[l];
    let change = update.middle[l] * update.dilation[l];
    let expected = update.viscous[l] * change;
    let absolute = 0.5 * (update.mean[l] - ambient - cold - ambient);
    let gained = absolute * change + update.work[l] + expected;
    let energy = (before + gained * inverse) / (1.0 + 0.5 * per_energy * change * inverse);
    let pressure = cold + per_energy * energy;
    // rho dp/drho with de = (p + p_A) drho/rho². A NaN is kept, so that the run halts.
    let bulk = density * (cold_slope + energy_slope * energy) + per_energy * (pressure + ambient) * (1.0 / density);
    update.bulk[l] = if bulk < floor { floor } else { bulk };
    update.mean[l] = -pressure;
    update.heat[l] = expected;
    energy
}

/// Updates pressures and energies of a block whose pressure line depends on density only.
#[inline(always)]
pub(super) fn advance_block(law: &impl EosLaw, energy: &mut Lanes, mut update: PressureUpdate<'_>) {
    let (ambient, floor) = (law.ambient(), law.floor());
    for l in 0..LANES {
        let curve = law.curve(update.mass[l] / update.volume[l]);
        energy[l] = advance(&mut update, l, curve, energy[l], [ambient, floor]);
    }
}

#[cfg(test)]
mod tests {
    use super::{EosLaw, IdealGas, UsUp};

    /// On the Hugoniot, e = p (1/rho0 - 1/rho)/2, the pressure is rho0 U_s U_p for every particle velocity U_p.
    #[test]
    fn pressure_on_the_hugoniot_matches_shock_relations() {
        let law = UsUp { density: 2.785, c0: 5.328, s: 1.338, gamma0: 2.0 };
        for up in [0.01, 0.5, 2.0] {
            let us = law.c0 + law.s * up;
            let (p, density) = (law.density * us * up, law.density * us / (us - up));
            let energy = 0.5 * p * (1.0 / law.density - 1.0 / density);
            let curve = law.curve(density);
            assert!(((curve.cold + curve.per_energy * energy) / p - 1.0).abs() < 1e-12);
        }
        assert!(law.curve(law.density / (1.0 - 1.0 / law.s)).cold.is_nan());
    }

    #[test]
    fn slopes_are_derivatives() {
        let law = UsUp { density: 2.785, c0: 5.328, s: 1.338, gamma0: 2.0 };
        for density in [2.5, 2.785, 3.3] {
            let step = 1e-6;
            let slope = (law.curve(density + step).cold - law.curve(density - step).cold) / (2.0 * step);
            assert!((slope / law.curve(density).cold_slope - 1.0).abs() < 1e-7);
        }
        let gas = IdealGas { gas_constant: 287.0, specific_heat: 717.5, ambient: 1e5, absolute_zero: 0.0 };
        // Air at 300 K and 1.2 kg/m^3: rho R T.
        let curve = gas.curve(1.2);
        assert!((curve.cold + curve.per_energy * 717.5 * 300.0 - (1.2 * 287.0 * 300.0 - 1e5)).abs() < 1e-6);
    }
}
