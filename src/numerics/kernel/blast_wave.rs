//! Blast waves of TNT charges in air: fits to measurements of C. N. Kingery and G. Bulmash, "Airblast parameters from TNT
//! spherical air burst and hemispherical surface burst", ARBRL-TR-02555, 1984, which CONWEP uses. Units: kg, m, s, Pa.

use std::f64::consts::LN_10;

use super::lanes::InlineMap;

/// Shape of a blast wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BurstShape {
    /// Spherical wave of a charge in free air.
    Spherical,
    /// Hemispherical wave of a charge on the ground.
    Hemispherical,
}

/// A fit: the decimal logarithm is a polynomial in a linear function of the decimal logarithm of the scaled distance.
struct BlastFit {
    /// Largest scaled distance, m/kg^(1/3).
    to: f64,
    /// Constant and factor of the linear function.
    scale: [f64; 2],
    /// Coefficients of ascending powers.
    terms: &'static [f64],
}

/// Fits for one shape of burst. Pressures are in kPa, times in ms/kg^(1/3), impulses in kPa ms/kg^(1/3).
struct BurstFits {
    /// Range of scaled distances in which all fits hold, m/kg^(1/3).
    range: [f64; 2],
    incident_pressure: &'static [BlastFit],
    reflected_pressure: &'static [BlastFit],
    incident_impulse: &'static [BlastFit],
    reflected_impulse: &'static [BlastFit],
    arrival: &'static [BlastFit],
    duration: &'static [BlastFit],
}

/// Declares the fits of both shapes: the largest scaled distance, the linear function and the coefficients of each.
macro_rules! burst_fits {
    ($($shape:ident: $range:tt { $($quantity:ident: $($to:literal, $scale:tt $terms:tt),+;)* })*) => {$(
        const $shape: BurstFits = BurstFits {
            range: $range,
            $($quantity: &[$(BlastFit { to: $to, scale: $scale, terms: &$terms }),+],)*
        };
    )*};
}

burst_fits! {
    SPHERICAL: [0.147, 40.0] {
        incident_pressure: 40.0, [-0.214362789151, 1.35034249993]
                [2.611368669, -1.69012801396, 0.00804973591951, 0.336743114941, -0.00516226351334, -0.0809228619888,
                -0.00478507266747, 0.00793030472242, 0.0007684469735];
        reflected_pressure: 40.0, [-0.214362789151, 1.35034249993]
                [3.22958031387, -2.21400538997, 0.035119031446, 0.657599992109, 0.0141818951887, -0.243076636231,
                -0.0158699803158, 0.0492741184234, 0.00227639644004, -0.00397126276058];
        incident_impulse: 0.792, [2.34723921354, 3.24299066475]
                [2.38830516757, -0.443749377691, 0.168825414684, 0.0348138030308, -0.010435192824],
            40.0, [-1.75305660315, 2.30629231803]
                [1.55197227115, -0.40463292088, -0.0142721946082, 0.00912366316617, -0.0006750681404,
                -0.00800863718901, 0.00314819515931, 0.00152044783382, -0.0007470265899];
        reflected_impulse: 40.0, [-0.204004553231, 1.37882996018]
                [2.55875660396, -0.903118886091, 0.101771877942, -0.0242139751146];
        arrival: 40.0, [-0.253273111999, 1.37407043777]
                [0.0720707787637, 1.36456871214, -0.0570035692784, -0.182832224796, 0.0118851436014, 0.0432648687627,
                -0.0007997367834, -0.00436073555033];
        duration: 0.888, [2.26367268496, 5.11588554305]
                [-0.686608550419, 0.164953518069, 0.127788499497, 0.00291430135946, 0.00187957449227, 0.0173413962543,
                0.00269739758043, -0.00361976502798, -0.00100926577934],
            2.28, [-1.33361206714, 9.2996288611]
                [0.23031841078, -0.0297944268969, 0.0306329542941, 0.0183405574074, -0.0173964666286,
                -0.00106321963576, 0.0056206003128, 0.0001618217499, -0.0006860188944],
            40.0, [-3.13005805346, 3.1524725364]
                [0.621036276475, 0.0967031995552, -0.00801302059667, 0.00482705779732, 0.00187587272287,
                -0.00246738509321, -0.000841116668, 0.0006193291052];
    }
    HEMISPHERICAL: [0.178, 40.0] {
        incident_pressure: 40.0, [-0.214362789151, 1.35034249993]
                [2.78076916577, -1.6958988741, -0.154159376846, 0.514060730593, 0.0988534365274, -0.293912623038,
                -0.0268112345019, 0.109097496421, 0.00162846756311, -0.0214631030242, 0.0001456723382,
                0.00167847752266];
        reflected_pressure: 40.0, [-0.240657322658, 1.36637719229]
                [3.40283217581, -2.21030870597, -0.218536586295, 0.895319589372, 0.24989009775, -0.569249436807,
                -0.11791682383, 0.224131161411, 0.0245620259375, -0.0455116002694, -0.00190930738887, 0.00361471193389];
        incident_impulse: 0.955, [2.06761908721, 3.0760329666]
                [2.52455620925, -0.502992763686, 0.171335645235, 0.0450176963051, -0.0118964626402],
            40.0, [-1.94708846747, 2.40697745406]
                [1.67281645863, -0.384519026965, -0.0260816706301, 0.00595798753822, 0.014544526107,
                -0.00663289334734, -0.00284189327204, 0.0013644816227];
        reflected_impulse: 40.0, [-0.246208804814, 1.33422049854]
                [2.70588058103, -0.949516092853, 0.112136118689, -0.0250659183287];
        arrival: 40.0, [-0.202425716178, 1.37784223635]
                [-0.0591634288046, 1.35706496258, 0.052492798645, -0.196563954086, -0.0601770052288, 0.0696360270891,
                0.0215297490092, -0.0161658930785, -0.00232531970294, 0.00147752067524];
        duration: 1.01, [1.92946154068, 5.25099193925]
                [-0.614227603559, 0.130143717675, 0.134872511954, 0.0391574276906, -0.00475933664702,
                -0.00428144598008],
            2.78, [-2.12492525216, 9.2996288611]
                [0.315409245784, -0.0297944268976, 0.030632954288, 0.0183405574086, -0.0173964666211,
                -0.00106321963633, 0.00562060030977, 0.0001618217499, -0.0006860188944],
            40.0, [-3.53626218091, 3.46349745571]
                [0.686906642409, 0.0933035304009, -0.0005849420883, -0.00226884995013, -0.00295908591505,
                0.00148029868929];
    }
}

/// Returns the value of the fit whose range contains the scaled distance.
fn value(fits: &[BlastFit], scaled: f64) -> f64 {
    let Some(fit) = fits.iter().find(|fit| scaled <= fit.to).or(fits.last()) else { return 0.0 };
    let u = fit.scale[0] + fit.scale[1] * libm::log10(scaled);
    libm::exp(LN_10 * fit.terms.iter().rev().fold(0.0, |sum, term| sum * u + term))
}

impl BurstShape {
    fn fits(self) -> &'static BurstFits {
        match self {
            BurstShape::Spherical => &SPHERICAL,
            BurstShape::Hemispherical => &HEMISPHERICAL,
        }
    }

    /// Returns the scaled distances between which the fits hold, m/kg^(1/3).
    pub fn range(self) -> [f64; 2] {
        self.fits().range
    }
}

/// A blast wave at one distance from the charge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlastWave {
    /// Largest pressures above that of the atmosphere: incident, and reflected by a wall at normal incidence.
    pub pressures: [f64; 2],
    /// Time from detonation to arrival.
    pub arrival: f64,
    /// Time in which the pressure is above that of the atmosphere.
    pub duration: f64,
    /// Decay coefficients of both pressures.
    pub decay: [f64; 2],
}

impl BlastWave {
    /// Returns the wave of a mass of TNT at a distance. Nearer than the range of the fits the wave is that at its lower
    /// end; beyond the range there is none.
    pub fn at(shape: BurstShape, mass: f64, distance: f64) -> Option<BlastWave> {
        let (root, fits) = (libm::cbrt(mass), shape.fits());
        let scaled = (distance / root).max(fits.range[0]);
        if scaled > fits.range[1] {
            return None;
        }
        let fitted = |list: &[BlastFit]| value(list, scaled);
        let pressures = [fitted(fits.incident_pressure), fitted(fits.reflected_pressure)];
        let duration = fitted(fits.duration);
        let share = |impulse: f64, pressure: f64| impulse / (pressure * duration);
        let decay = [
            decay_coefficient(share(fitted(fits.incident_impulse), pressures[0])),
            decay_coefficient(share(fitted(fits.reflected_impulse), pressures[1])),
        ];
        let [incident, reflected] = pressures;
        Some(BlastWave {
            pressures: [1e3 * incident, 1e3 * reflected],
            arrival: 1e-3 * root * fitted(fits.arrival),
            duration: 1e-3 * root * duration,
            decay,
        })
    }

    /// Returns the pressure on a surface at a time after the detonation: p_r cos² + p_i (1 + cos - 2 cos²), where the
    /// cosine is that of the angle between the outward normal and the direction to the charge; p_i on a surface that
    /// faces away (ABAQUS Analysis User's Guide 34.4.6, "CONWEP blast loading"). Both pressures are
    /// p (1 - t/d) exp(-a t/d) in the positive phase (Friedlander), and zero after it. Equations (16.2), (16.4).
    pub fn pressure(&self, time: f64, cosine: f64) -> f64 {
        let phase = ((time - self.arrival) / self.duration).max(0.0);
        if !has_arrived(time, self.arrival) || phase >= 1.0 {
            return 0.0;
        }
        let [incident, reflected] =
            [0, 1].inline_map(|k: usize| self.pressures[k] * (1.0 - phase) * libm::exp(-self.decay[k] * phase));
        let c = cosine.max(0.0);
        reflected * c * c + incident * (1.0 + c - 2.0 * c * c)
    }
}

/// Returns whether a wave has arrived, to the rounding of an increment that ends at its arrival.
pub fn has_arrived(time: f64, arrival: f64) -> bool {
    time >= arrival * (1.0 - 1e-12)
}

/// Returns the decay coefficient a of a pulse (1 - x) exp(-a x) whose integral over 0 to 1, 1/a - (1 - exp(-a))/a², is
/// given; by bisection. Equation (16.3).
fn decay_coefficient(integral: f64) -> f64 {
    let integral_of = |a: f64| {
        if a.abs() < 1e-3 { 0.5 - a / 6.0 } else { 1.0 / a + libm::expm1(-a) / (a * a) }
    };
    let [mut low, mut high] = [-5.0, 1e3];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if integral_of(middle) > integral { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [BurstShape; 2] = [BurstShape::Spherical, BurstShape::Hemispherical];

    /// The ratio of reflected to incident pressure in an ideal gas of ratio 1.4 (Rankine and Hugoniot):
    /// 2 (7 p0 + 4 p)/(7 p0 + p), from 1 m/kg^(1/3) on, where air is ideal.
    #[test]
    fn reflected_pressure_is_that_of_an_ideal_gas() {
        for shape in SHAPES {
            for step in 0..=60 {
                let scaled = 10f64.powf(step as f64 / 40.0);
                let wave = BlastWave::at(shape, 1.0, scaled).expect("a wave");
                let (p, p0) = (wave.pressures[0], 101_325.0);
                let ideal = 2.0 * p * (7.0 * p0 + 4.0 * p) / (7.0 * p0 + p);
                assert!(
                    (wave.pressures[1] / ideal - 1.0).abs() < 0.02,
                    "{shape:?} {scaled}: {}",
                    wave.pressures[1] / ideal
                );
            }
        }
    }

    /// M. M. Swisdak's independent fit of the incident pressure of surface bursts (1994), to its stated 1 %.
    #[test]
    fn incident_pressure_agrees_with_the_simplified_fit() {
        for (scaled, terms) in [
            (0.5, [7.2106, -2.1069, -0.3229, 0.1117, 0.0685]),
            (2.0, [7.2106, -2.1069, -0.3229, 0.1117, 0.0685]),
            (5.0, [7.5938, -3.0523, 0.40977, 0.0261, -0.01267]),
            (20.0, [7.5938, -3.0523, 0.40977, 0.0261, -0.01267]),
            (30.0, [6.0536, -1.4066, 0.0, 0.0, 0.0]),
        ] {
            let log = f64::ln(scaled);
            let simplified = 1e3 * terms.iter().rev().fold(0.0, |sum, term| sum * log + term).exp();
            let wave = BlastWave::at(BurstShape::Hemispherical, 1.0, scaled).expect("a wave");
            assert!((wave.pressures[0] / simplified - 1.0).abs() < 0.01, "{scaled}");
        }
    }

    /// Parts of a fit meet within 2 %, a wrong sign of a coefficient would leave a step of more.
    #[test]
    fn parts_of_fits_meet() {
        for shape in SHAPES {
            let fits = shape.fits();
            for parts in [fits.incident_impulse, fits.duration] {
                for two in parts.windows(2) {
                    let step = value(&two[..1], two[0].to) / value(&two[1..], two[0].to);
                    assert!((step - 1.0).abs() < 0.02, "{shape:?} at {}: {step}", two[0].to);
                }
            }
        }
    }

    /// The impulse of the pulse is that of the fit, and the wave scales with the cube root of the mass.
    #[test]
    fn impulse_is_that_of_the_fit() {
        for shape in SHAPES {
            for scaled in [0.2, 0.5, 1.0, 3.0, 10.0, 39.0] {
                let wave = BlastWave::at(shape, 8.0, 2.0 * scaled).expect("a wave");
                let steps = 20_000;
                let dt = wave.duration / steps as f64;
                let sum: f64 = (0..steps).map(|i| dt * wave.pressure(wave.arrival + (i as f64 + 0.5) * dt, 1.0)).sum();
                let impulse = 2.0 * value(shape.fits().reflected_impulse, scaled);
                assert!((sum / impulse - 1.0).abs() < 1e-5, "{shape:?} {scaled}: {sum} {impulse}");
            }
            assert_eq!(BlastWave::at(shape, 1.0, 41.0), None);
        }
    }
}
