//! Material of a target, in consistent units and in dimensionless form (stresses divided by Y, velocities by
//! sqrt(Y/rho)).

use super::ResistanceError;
use super::rate::StrainRateEffect;
use super::root;

/// Shape of the cavity that opens in a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CavityShape {
    /// Sphere in an unbounded target: deep penetration.
    #[default]
    Spherical,
    /// Cylinder in plane strain: hole expansion in plates by slender noses.
    Cylindrical,
}

impl CavityShape {
    /// Returns the number of hoop directions g: 2 or 1.
    pub fn hoops(self) -> f64 {
        match self {
            CavityShape::Spherical => 2.0,
            CavityShape::Cylindrical => 1.0,
        }
    }

    /// Returns the ratio f of radial stress less pressure to the von Mises stress, for incompressible flow: 2/3 or
    /// 1/sqrt(3). The logarithmic hoop strain less the radial one is 1/f times the equivalent strain.
    pub fn deviator(self) -> f64 {
        match self {
            CavityShape::Spherical => 2.0 / 3.0,
            CavityShape::Cylindrical => 1.0 / 3.0_f64.sqrt(),
        }
    }

    /// Returns g times the difference of radial and hoop stress over the von Mises stress: f (g + 1).
    pub fn divergence(self) -> f64 {
        self.deviator() * (self.hoops() + 1.0)
    }

    /// Returns the end of the ledger row of derived constants: nothing for the default shape.
    pub fn ledger_note(self) -> &'static str {
        match self {
            CavityShape::Spherical => "",
            CavityShape::Cylindrical => "; cylindrical cavity",
        }
    }

    /// Returns the name on cards and in messages.
    pub fn word(self) -> &'static str {
        match self {
            CavityShape::Spherical => "spherical",
            CavityShape::Cylindrical => "cylindrical",
        }
    }
}

/// Material of a target, in any consistent units.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetMaterial {
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Young's modulus E, stress.
    pub young: f64,
    /// Poisson's ratio, 0 to 0.5; 0.5 is incompressible.
    pub poisson: f64,
    /// Density, mass per volume.
    pub density: f64,
    /// Yield stress Y (stress); for a brittle target the unconfined strength.
    pub yield_stress: f64,
    /// Yield stress as a function of strain.
    pub curve: YieldCurve,
    /// Slope of the yield stress over pressure (Mohr-Coulomb), dimensionless; 0 for metals.
    pub pressure_slope: f64,
    /// Tensile strength (stress), above which radial cracks form; `None` for targets without cracks.
    pub tension: Option<f64>,
    /// Strain-rate dependence of the yield stress.
    pub rate: Option<StrainRateEffect>,
}

/// Shape of the cavity and what a target needs in addition to its material.
#[derive(Clone, Copy, Debug, Default)]
pub struct TargetSizes {
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Radius of the cavity, which determines strain rates; `None` for quasi-static constants.
    pub radius: Option<f64>,
    /// Tensile strength at which a target without cards of strength cracks.
    pub tension: Option<f64>,
    /// Characteristic length of elements, for softening over displacements.
    pub length: Option<f64>,
}

/// Yield stress as a function of strain.
#[derive(Clone, Debug, PartialEq)]
pub enum YieldCurve {
    /// Perfect plasticity with the yield stress Y.
    Perfect,
    /// `Y (E e / Y)^n` with the total strain e (Luk, Forrestal and Amos 1991, J. Appl. Mech. 58, 1).
    Power(f64),
    /// Rows of yield stress and plastic strain as in `*PLASTIC`, with linear interpolation.
    Table {
        /// `[stress, plastic strain]` with increasing strain; the first row is Y and 0.
        rows: Vec<[f64; 2]>,
        /// Whether the curve is extrapolated linearly beyond the last row; otherwise it is constant.
        extrapolates: bool,
    },
}

/// Target material in dimensionless form. The strain is q = E e / Y with the total uniaxial strain e, so that yield
/// begins at q = 1.
#[derive(Clone, Debug)]
pub struct ScaledTarget {
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Young's modulus divided by the yield stress, E / Y.
    pub young: f64,
    /// Shear modulus divided by the yield stress, G / Y.
    pub shear: f64,
    /// Y / K with the bulk modulus K; zero for an incompressible target.
    pub compressibility: f64,
    /// Slope of the yield stress over pressure.
    pub pressure_slope: f64,
    /// Tensile strength divided by Y.
    pub tension: Option<f64>,
    /// Reference velocity sqrt(Y / rho), in the units of the material.
    pub velocity: f64,
    /// Y, in the units of the material.
    pub yield_stress: f64,
    /// Density, in the units of the material.
    pub density: f64,
    /// Strain-rate dependence, in the units of the material.
    pub rate: Option<StrainRateEffect>,
    /// Elastic factor (1 - 2 nu) / 3 with Poisson's ratio nu.
    lateral: f64,
    flow: FlowCurve,
}

/// Yield stress divided by Y as a function of q.
#[derive(Clone, Debug)]
enum FlowCurve {
    Power(f64),
    /// Rows `[stress, q]`, and the slope beyond the last row.
    Table(Vec<[f64; 2]>, f64),
}

impl ScaledTarget {
    /// Converts a material to dimensionless form.
    ///
    /// # Errors
    /// `C001` if the material is invalid.
    pub fn new(material: &TargetMaterial) -> Result<ScaledTarget, ResistanceError> {
        check(material)?;
        let (young, y, nu) = (material.young, material.yield_stress, material.poisson);
        let flow = match &material.curve {
            YieldCurve::Perfect => FlowCurve::Power(0.0),
            YieldCurve::Power(n) => FlowCurve::Power(*n),
            YieldCurve::Table { rows, extrapolates } => table(rows, *extrapolates, young, y)?,
        };
        Ok(ScaledTarget {
            shape: material.shape,
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

    /// Returns the yield stress at zero pressure divided by Y, and its slope over q.
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

    /// Returns the difference of the logarithmic hoop and radial strains at q, and its slope.
    pub fn shear_strain(&self, q: f64) -> [f64; 2] {
        self.shear_strain_of(q, self.flow(q))
    }

    /// Returns the same as [`shear_strain`](Self::shear_strain) for a known result of [`ScaledTarget::flow`]. Equations
    /// (2.8), (2.13).
    pub fn shear_strain_of(&self, q: f64, [stress, slope]: [f64; 2]) -> [f64; 2] {
        let scale = 1.0 / (self.shape.deviator() * self.young);
        [scale * (q - self.lateral * stress), scale * (1.0 - self.lateral * slope)]
    }

    /// Returns q for a difference of logarithmic strains.
    pub fn strain_at(&self, shear_strain: f64) -> f64 {
        let guess = shear_strain * self.shape.deviator() * self.young;
        // The yield stress is between 0 and E e, so q is between the guess and the guess divided by 1 - lateral.
        let high = (guess + 1.0) / (1.0 - self.lateral);
        let excess = |q: f64| Some(self.shear_strain(q)[0] - shear_strain);
        root::between(excess, [0.5 * guess, high], 1e-16 * shear_strain)[0]
    }

    /// Returns the values of q inside an interval at which the slope of the curve is discontinuous.
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
            return wrong(format!("needs increasing plastic strains: {} follows {}", pair[1][1], pair[0][1]));
        }
        if pair[1][0] <= 0.0 || !pair[1][0].is_finite() {
            return wrong(format!("has the stress {}, which is not above zero", pair[1][0]));
        }
        if q[1][1] <= q[0][1] {
            return wrong(format!("decreases from {} to {} more steeply than Young's modulus", pair[0][0], pair[1][0]));
        }
    }
    let last = scaled.windows(2).last().filter(|_| extrapolates);
    let beyond = last.map_or(0.0, |w| (w[1][0] - w[0][0]) / (w[1][1] - w[0][1]));
    if beyond < 0.0 {
        return wrong("decreases at its end and cannot be extrapolated".into());
    }
    Ok(FlowCurve::Table(scaled, beyond))
}

/// Checks the conditions of a cylindrical cavity.
fn check_cylindrical(material: &TargetMaterial) -> Result<(), ResistanceError> {
    let wrong = |what: &str| Err(ResistanceError::Target(what.into()));
    if material.poisson == 0.5 {
        return wrong(
            "Poisson's ratio must be below 0.5 for a cylindrical cavity, because the inertia of an incompressible target \
             is unbounded",
        );
    }
    if material.tension.is_some() {
        return wrong("a tensile strength is supported for spherical cavities only: remove it");
    }
    if material.yield_stress >= material.young / (1.0 + material.poisson) * 3.0_f64.sqrt() / 2.0 {
        return wrong("the yield stress must be below the shear modulus times the square root of 3");
    }
    Ok(())
}

fn check(material: &TargetMaterial) -> Result<(), ResistanceError> {
    let wrong = |what: String| Err(ResistanceError::Target(what));
    let positive = [
        ("Young's modulus", material.young),
        ("the density", material.density),
        ("the yield stress", material.yield_stress),
    ];
    for (name, value) in positive {
        if value <= 0.0 || !value.is_finite() {
            return wrong(format!("{name} must be above zero, found {value}"));
        }
    }
    let TargetMaterial { young, poisson, yield_stress, pressure_slope, .. } = material;
    if material.shape == CavityShape::Cylindrical {
        check_cylindrical(material)?;
    }
    if !(0.0..=0.5).contains(poisson) {
        return wrong(format!("Poisson's ratio must be between 0 and 0.5, found {poisson}"));
    }
    // At yield the difference of strains must be below one.
    if *yield_stress >= young / (1.0 + poisson) {
        return wrong(format!(
            "the yield stress must be below twice the shear modulus: found yield stress {yield_stress}, Young's modulus {young}"
        ));
    }
    if let YieldCurve::Power(n) = material.curve
        && !(0.0..=1.0).contains(&n)
    {
        return wrong(format!("the hardening exponent must be between 0 and 1, found {n}"));
    }
    if !(0.0..3.0).contains(pressure_slope) {
        return wrong(format!(
            "the slope of the yield stress over pressure must be at least 0 and below 3, found {pressure_slope}"
        ));
    }
    if *pressure_slope > 0.0 && material.curve != YieldCurve::Perfect {
        return wrong("pressure-dependent strength and hardening cannot be combined: remove one".into());
    }
    if let Some(tension) = material.tension
        && (tension <= 0.0 || tension.is_nan())
    {
        return wrong(format!("the tensile strength must be above zero, found {tension}"));
    }
    material.rate.as_ref().map_or(Ok(()), StrainRateEffect::check)
}
