//! The material of a target, and the same in its own units: stresses by the yield stress Y, velocities by sqrt(Y/rho).

use super::ResistanceError;
use super::rate::Rate;
use super::root;

/// The material of a target, in any consistent units.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E, stress.
    pub young: f64,
    /// Poisson's ratio, 0 to 0.5; 0.5 is incompressible.
    pub poisson: f64,
    /// Density, mass per volume.
    pub density: f64,
    /// Yield stress Y, stress; of a brittle target without confinement.
    pub yield_stress: f64,
    /// Yield stress over strain.
    pub curve: Curve,
    /// Growth of the yield stress with pressure, stress by stress (Mohr and Coulomb); 0 for metals.
    pub pressure_slope: f64,
    /// Largest tension, stress: where it is passed the target cracks along rays. `None`: never.
    pub tension: Option<f64>,
    /// Growth of the yield stress with strain rate.
    pub rate: Option<Rate>,
}

/// Yield stress over strain.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// Y throughout.
    Perfect,
    /// `Y (E e / Y)^n` with the total strain e (Luk, Forrestal and Amos 1991, J. Appl. Mech. 58, 1).
    Power(f64),
    /// Rows of yield stress and plastic strain, as of `*PLASTIC`: linear between them.
    Table {
        /// `[stress, plastic strain]`, ascending in the strain; the first has Y and 0.
        rows: Vec<[f64; 2]>,
        /// Whether the curve goes on beyond the last row as between the last two, else it is constant.
        extrapolates: bool,
    },
}

/// A target in its own units. The strain is q = E e / Y, of the total uniaxial strain e: yield begins at 1.
#[derive(Clone, Debug)]
pub struct Target {
    /// E / Y.
    pub young: f64,
    /// G / Y.
    pub shear: f64,
    /// Y / K; zero where nothing is compressible.
    pub compressibility: f64,
    /// Growth of the yield stress with pressure.
    pub pressure_slope: f64,
    /// Largest tension over Y.
    pub tension: Option<f64>,
    /// sqrt(Y / rho).
    pub velocity: f64,
    /// Y, in the units of the material.
    pub yield_stress: f64,
    /// Density, likewise.
    pub density: f64,
    /// Growth with the strain rate.
    pub rate: Option<Rate>,
    /// (1 - 2 nu) / 3.
    lateral: f64,
    flow: FlowCurve,
}

/// Yield stress over Y as a function of q.
#[derive(Clone, Debug)]
enum FlowCurve {
    Power(f64),
    /// `[stress, q]`, and the slope beyond the last.
    Table(Vec<[f64; 2]>, f64),
}

impl Target {
    /// A material in its own units.
    ///
    /// # Errors
    /// `C001`, where there can be no such target.
    pub fn new(material: &Material) -> Result<Target, ResistanceError> {
        check(material)?;
        let (young, y, nu) = (material.young, material.yield_stress, material.poisson);
        let flow = match &material.curve {
            Curve::Perfect => FlowCurve::Power(0.0),
            Curve::Power(n) => FlowCurve::Power(*n),
            Curve::Table { rows, extrapolates } => table(rows, *extrapolates, young, y)?,
        };
        Ok(Target {
            young: young / y,
            shear: 0.5 * young / (1.0 + nu) / y,
            compressibility: 3.0 * (1.0 - 2.0 * nu) * y / young,
            pressure_slope: material.pressure_slope,
            tension: material.tension.map(|t| t / y),
            velocity: (y / material.density).sqrt(),
            yield_stress: y,
            density: material.density,
            rate: material.rate.clone(),
            lateral: (1.0 - 2.0 * nu) / 3.0,
            flow,
        })
    }

    /// Yield stress without pressure over Y, and its slope in q.
    pub fn flow(&self, q: f64) -> [f64; 2] {
        match &self.flow {
            FlowCurve::Power(0.0) => [1.0, 0.0],
            FlowCurve::Power(n) => {
                let stress = libm::exp(n * libm::log(q));
                [stress, n * stress / q]
            }
            FlowCurve::Table(rows, beyond) => {
                let after = rows.partition_point(|r| r[1] <= q).max(1);
                let from = rows[after - 1];
                let slope = rows.get(after).map_or(*beyond, |to| (to[0] - from[0]) / (to[1] - from[1]));
                [from[0] + slope * (q - from[1]), slope]
            }
        }
    }

    /// Difference of the logarithmic strains around and along a radius at q, and its slope.
    pub fn shear_strain(&self, q: f64) -> [f64; 2] {
        self.shear_strain_of(q, self.flow(q))
    }

    /// The same, where what [`Target::flow`] gives is known.
    pub fn shear_strain_of(&self, q: f64, [stress, slope]: [f64; 2]) -> [f64; 2] {
        let scale = 1.5 / self.young;
        [scale * (q - self.lateral * stress), scale * (1.0 - self.lateral * slope)]
    }

    /// q at a difference of strains.
    pub fn strain_at(&self, shear_strain: f64) -> f64 {
        let guess = shear_strain / 1.5 * self.young;
        // The yield stress is at most E e, and not below zero: q lies between the guess and the guess over 1 - lateral.
        let high = (guess + 1.0) / (1.0 - self.lateral);
        let excess = |q: f64| Some(self.shear_strain(q)[0] - shear_strain);
        root::between(excess, [0.5 * guess, high], 1e-16 * shear_strain)[0]
    }

    /// Values of q between two at which the slope of the curve jumps.
    pub fn kinks(&self, [from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
        let rows: &[[f64; 2]] = if let FlowCurve::Table(rows, _) = &self.flow { rows } else { &[] };
        rows.iter().map(|r| r[1]).filter(move |q| *q > from && *q < to)
    }
}

fn table(rows: &[[f64; 2]], extrapolates: bool, young: f64, y: f64) -> Result<FlowCurve, ResistanceError> {
    let wrong = |what: String| Err(ResistanceError::Target(format!("the stress-strain curve {what}")));
    match rows.first() {
        None => return wrong("has no rows".into()),
        Some(first) if first[1] != 0.0 || (first[0] / y - 1.0).abs() > 1e-12 => {
            return wrong(format!(
                "begins at stress {}, plastic strain {}, not at the yield stress {y} and 0",
                first[0], first[1]
            ));
        }
        Some(_) => {}
    }
    let scaled: Vec<[f64; 2]> = rows.iter().map(|r| [r[0] / y, (r[0] + young * r[1]) / y]).collect();
    for (pair, q) in rows.windows(2).zip(scaled.windows(2)) {
        if pair[1][1] <= pair[0][1] || !pair[1][1].is_finite() {
            return wrong(format!("has plastic strains that do not ascend: {} follows {}", pair[1][1], pair[0][1]));
        }
        if pair[1][0] <= 0.0 || !pair[1][0].is_finite() {
            return wrong(format!("has the stress {}, which is not above zero", pair[1][0]));
        }
        if q[1][1] <= q[0][1] {
            return wrong(format!("falls from {} to {} more steeply than Young's modulus", pair[0][0], pair[1][0]));
        }
    }
    let last = scaled.windows(2).last().filter(|_| extrapolates);
    let beyond = last.map_or(0.0, |w| (w[1][0] - w[0][0]) / (w[1][1] - w[0][1]));
    if beyond < 0.0 {
        return wrong("falls, and would fall below zero beyond its last row".into());
    }
    Ok(FlowCurve::Table(scaled, beyond))
}

fn check(material: &Material) -> Result<(), ResistanceError> {
    let wrong = |what: String| Err(ResistanceError::Target(what));
    let positive = [
        ("Young's modulus", material.young),
        ("the density", material.density),
        ("the yield stress", material.yield_stress),
    ];
    for (name, value) in positive {
        if value <= 0.0 || !value.is_finite() {
            return wrong(format!("{name} is {value}, and must be above zero"));
        }
    }
    let Material { young, poisson, yield_stress, pressure_slope, .. } = material;
    if !(0.0..=0.5).contains(poisson) {
        return wrong(format!("Poisson's ratio is {poisson}, and must be from 0 to 0.5"));
    }
    // At yield the difference of strains is below one: else no cavity is left to open.
    if *yield_stress >= young / (1.0 + poisson) {
        return wrong(format!(
            "the yield stress {yield_stress} is not below twice the shear modulus of Young's modulus {young}"
        ));
    }
    if let Curve::Power(n) = material.curve
        && !(0.0..=1.0).contains(&n)
    {
        return wrong(format!("the exponent of hardening is {n}, and must be from 0 to 1"));
    }
    if !(0.0..3.0).contains(pressure_slope) {
        return wrong(format!(
            "the strength grows {pressure_slope} times as fast as the pressure, and must do so from 0 to below 3 times"
        ));
    }
    if *pressure_slope > 0.0 && material.curve != Curve::Perfect {
        return wrong("a strength that grows with pressure does not harden as well: leave one out".into());
    }
    if let Some(tension) = material.tension
        && (tension <= 0.0 || tension.is_nan())
    {
        return wrong(format!("the largest tension is {tension}, and must be above zero"));
    }
    material.rate.as_ref().map_or(Ok(()), Rate::check)
}
