//! Constants of `*HYPERELASTIC, TEST DATA INPUT`: strain energies fitted to measured stresses.
//!
//! The sum of the squared relative errors of the nominal stresses is least (ABAQUS Theory Guide 4.6.2, "Fitting of
//! hyperelastic and hyperfoam constants"). The stresses of polynomial forms are linear in the constants, so that the fit
//! is one linear least-squares problem, solved by singular values. The Ogden form has its own method
//! ([`super::ogden_fit`]).

use nalgebra::{DMatrix, DVector};

use super::context::Context;
use super::families::MaterialReader;
use super::ogden_fit;
use super::types::{DeviatoricEnergy, HyperelasticLaw, RubberMeasurement, RubberTest};
use crate::deck::{Card, Diagnostic, Span};

/// Cards of test data.
const TESTS: [(&str, RubberTest); 4] = [
    ("UNIAXIAL TEST DATA", RubberTest::Uniaxial),
    ("BIAXIAL TEST DATA", RubberTest::Equibiaxial),
    ("PLANAR TEST DATA", RubberTest::Planar),
    ("VOLUMETRIC TEST DATA", RubberTest::Volumetric),
];

/// Form of a fitted strain energy.
#[derive(Clone, Debug)]
pub enum FittedForm {
    /// Exponents of I1 - 3 and I2 - 3 of each constant.
    Polynomial(Vec<(usize, usize)>),
    /// Number of terms.
    Ogden(usize),
}

/// A strain energy whose constants are fitted.
#[derive(Clone, Debug)]
pub struct RubberFit {
    /// Index of the material.
    pub material: usize,
    pub form: FittedForm,
    /// Order of the volumetric part.
    pub order: usize,
    pub span: Span,
    pub data: Vec<RubberMeasurement>,
}

/// Largest stretch of the test for stability, and number of steps.
const LARGEST_STRETCH: f64 = 6.0;
const STABILITY_STEPS: usize = 220;

/// Reads `*UNIAXIAL TEST DATA`, `*BIAXIAL TEST DATA`, `*PLANAR TEST DATA` and `*VOLUMETRIC TEST DATA`.
pub fn read_test_data(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    let test = TESTS.iter().find(|test| test.0 == card.keyword.name).map_or(RubberTest::Uniaxial, |test| test.1);
    let material = context.model.materials.len().wrapping_sub(1);
    let Some(fit) = materials.rubber_fits.iter_mut().find(|fit| fit.material == material) else {
        let message = "test data follow *HYPERELASTIC, TEST DATA INPUT";
        return context.error("M194", message, card.span, "no such card before");
    };
    let rows: Vec<[f64; 2]> = card.read_lines();
    let offset = if test == RubberTest::Volumetric { 0.0 } else { 1.0 };
    // A row without stress has no relative error.
    let rows = rows.into_iter().filter(|row| row[0] != 0.0);
    fit.data.extend(rows.map(|[stress, strain]| RubberMeasurement { test, stress, stretch: offset + strain }));
}

/// Fits the constants of all materials with test data.
pub fn fit_rubber(context: &mut Context<'_>, materials: &mut MaterialReader) {
    for fit in std::mem::take(&mut materials.rubber_fits) {
        match fit.law() {
            Ok((law, error)) => {
                report_fit(context, &fit, &law, error);
                if context.accepts_at(fit.span, law.check()) {
                    context.model.materials[fit.material].hyperelastic = Some(law);
                }
            }
            Err(why) => context.error("M194", why, fit.span, "this material"),
        }
    }
}

fn report_fit(context: &mut Context<'_>, fit: &RubberFit, law: &HyperelasticLaw, error: f64) {
    let mut constants: Vec<String> = match &law.shape {
        DeviatoricEnergy::NeoHooke(c) => vec![format!("C10 = {c:.6}")],
        DeviatoricEnergy::Polynomial(terms) => terms.iter().map(|(c, i, j)| format!("C{i}{j} = {c:.6}")).collect(),
        DeviatoricEnergy::Ogden(terms) => {
            let pair = |(i, [mu, alpha]): (usize, &[f64; 2])| format!("mu{0} = {mu:.6e}, alpha{0} = {alpha:.6}", i + 1);
            terms.iter().enumerate().map(pair).collect()
        }
    };
    let volumetric = law.compressibility.iter().enumerate().filter(|(_, d)| **d != 0.0);
    constants.extend(volumetric.map(|(i, d)| format!("D{} = {d:.6e}", i + 1)));
    let message = format!(
        "fitted to {} measured values: {}; root mean square of the relative errors {:.1} %",
        fit.data.len(),
        constants.join(", "),
        100.0 * error
    );
    context.diagnostics.push(Diagnostic::note("M194", message).at(fit.span, "this card"));
    for (name, stretch) in unstable_stretches(&law.shape) {
        let message = format!(
            "the fitted strain energy is unstable in {name} at nominal strains of {:.2} and beyond",
            stretch - 1.0
        );
        let finding = Diagnostic::warning("M194", message).at(fit.span, "this card");
        context.diagnostics.push(finding.help("give test data up to these strains, a lower order N, or YEOH"));
    }
}

impl RubberFit {
    /// Returns the fitted law, and the root mean square of the relative errors.
    ///
    /// # Errors
    /// The reason if the data do not determine the constants.
    fn law(&self) -> Result<(HyperelasticLaw, f64), String> {
        let (volumetric, deviatoric): (Vec<RubberMeasurement>, Vec<RubberMeasurement>) =
            self.data.iter().copied().partition(|measured| measured.test == RubberTest::Volumetric);
        let (shape, error) = match &self.form {
            FittedForm::Polynomial(exponents) => {
                let rows = |measured: &RubberMeasurement| {
                    let stress =
                        |&e: &(usize, usize)| term_stress(measured.test, measured.stretch, e) / measured.stress;
                    exponents.iter().map(stress).collect::<Vec<f64>>()
                };
                let (constants, error) =
                    relative_least_squares(&deviatoric.iter().map(rows).collect::<Vec<_>>(), exponents.len())?;
                let terms = constants.iter().zip(exponents).map(|(c, &(i, j))| (*c, i, j)).collect();
                (DeviatoricEnergy::Polynomial(terms), error)
            }
            FittedForm::Ogden(order) => {
                let ogden_fit::OgdenFit { terms, error } = ogden_fit::fit(&deviatoric, *order)?;
                (DeviatoricEnergy::Ogden(terms), error)
            }
        };
        let compressibility = self.compressibility(&volumetric)?;
        Ok((HyperelasticLaw { shape, compressibility, test_data: self.data.clone(), span: self.span }, error))
    }

    /// Returns D1, D2, ... of volumetric test data: as many terms as the data determine with positive constants; the others
    /// are zero, as all are without data.
    ///
    /// # Errors
    /// The reason if the data do not determine D1.
    fn compressibility(&self, data: &[RubberMeasurement]) -> Result<Vec<f64>, String> {
        let mut compressibility = vec![0.0; self.order];
        for order in (1..=self.order.min(data.len())).rev() {
            let rows = |&RubberMeasurement { stress: pressure, stretch: ratio, .. }: &RubberMeasurement| {
                (1..=order as i32)
                    .map(|i| -2.0 * f64::from(i) * (ratio - 1.0).powi(2 * i - 1) / pressure)
                    .collect::<Vec<f64>>()
            };
            let fitted = relative_least_squares(&data.iter().map(rows).collect::<Vec<_>>(), order);
            let inverse = match fitted {
                Ok((inverse, _)) if order == 1 || inverse.iter().all(|value| *value > 0.0) => inverse,
                Err(why) if order == 1 => return Err(why),
                _ => continue,
            };
            compressibility.iter_mut().zip(&inverse).for_each(|(constant, inverse)| *constant = 1.0 / inverse);
            break;
        }
        Ok(compressibility)
    }
}

/// Returns the unknowns with the least sum of squares of `1 - rows x`, and the root mean square of the errors.
///
/// # Errors
/// The reason if there are fewer rows than unknowns, or the rows do not determine them.
fn relative_least_squares(rows: &[Vec<f64>], unknowns: usize) -> Result<(Vec<f64>, f64), String> {
    if rows.len() < unknowns {
        return Err(format!(
            "{} measured values do not determine {unknowns} constants: give more test data",
            rows.len()
        ));
    }
    let matrix = DMatrix::from_fn(rows.len(), unknowns, |i, j| rows[i][j]);
    // Columns of equal size, so that the limit for singular values is relative.
    let scales: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(rows.len(), unknowns, |i, j| matrix[(i, j)] / scales[j]);
    let svd = scaled.svd(true, true);
    if svd.rank(1e-9) < unknowns {
        return Err("the test data do not determine all constants: give a lower order, or tests of another kind".into());
    }
    let ones = DVector::from_element(rows.len(), 1.0);
    let solution = svd.solve(&ones, 1e-12).map_err(str::to_owned)?;
    let values: Vec<f64> = solution.iter().zip(&scales).map(|(value, scale)| value / scale).collect();
    let errors = ones - matrix * DVector::from_vec(values.clone());
    Ok((values, errors.norm() / (rows.len() as f64).sqrt()))
}

/// Returns the invariants I1 - 3 and I2 - 3 of an incompressible deformation, and the factors of the derivatives of
/// the energy by I1 and by I2 in the nominal stress (ABAQUS Theory Guide 4.6.2).
fn kinematics(test: RubberTest, stretch: f64) -> ([f64; 2], [f64; 2]) {
    let l = stretch;
    match test {
        RubberTest::Uniaxial => {
            let factor = 2.0 * (1.0 - l.powi(-3));
            ([l * l + 2.0 / l - 3.0, l.powi(-2) + 2.0 * l - 3.0], [factor * l, factor])
        }
        RubberTest::Equibiaxial => {
            let factor = 2.0 * (l - l.powi(-5));
            ([2.0 * l * l + l.powi(-4) - 3.0, 2.0 * l.powi(-2) + l.powi(4) - 3.0], [factor, factor * l * l])
        }
        RubberTest::Planar | RubberTest::Volumetric => {
            let (factor, invariant) = (2.0 * (l - l.powi(-3)), l * l + l.powi(-2) - 2.0);
            ([invariant; 2], [factor; 2])
        }
    }
}

/// Returns the nominal stress by a term `(I1 - 3)^i (I2 - 3)^j` of the energy with the constant 1.
fn term_stress(test: RubberTest, stretch: f64, (i, j): (usize, usize)) -> f64 {
    let ([first, second], factors) = kinematics(test, stretch);
    let derivative =
        |value: f64, order: usize| if order == 0 { 0.0 } else { order as f64 * value.powi(order as i32 - 1) };
    factors[0] * derivative(first, i) * second.powi(j as i32)
        + factors[1] * first.powi(i as i32) * derivative(second, j)
}

impl HyperelasticLaw {
    /// Returns the nominal stress of a test of the incompressible material at a stretch, or the pressure at a volume ratio
    /// (0 if the material defines no compressibility).
    pub fn test_stress(&self, test: RubberTest, stretch: f64) -> f64 {
        if test == RubberTest::Volumetric {
            let inverse = self.compressibility.iter().map(|d| if *d == 0.0 { 0.0 } else { 1.0 / d });
            let part = |(i, inverse): (i32, f64)| -2.0 * f64::from(i) * (stretch - 1.0).powi(2 * i - 1) * inverse;
            return (1..).zip(inverse).map(part).sum();
        }
        match &self.shape {
            DeviatoricEnergy::NeoHooke(c) => c * term_stress(test, stretch, (1, 0)),
            DeviatoricEnergy::Polynomial(terms) => {
                terms.iter().map(|&(c, i, j)| c * term_stress(test, stretch, (i, j))).sum()
            }
            DeviatoricEnergy::Ogden(terms) => {
                terms.iter().map(|[mu, alpha]| mu * ogden_fit::term_stress(test, stretch, *alpha)[0]).sum()
            }
        }
    }
}

/// Returns the tests in which the energy loses stability (Drucker) in the range of stretches, with the stretch: the
/// energy as a function of two logarithmic strains is not convex there.
fn unstable_stretches(law: &DeviatoricEnergy) -> Vec<(&'static str, f64)> {
    // The second stretch is a power of the first.
    let cases = [("uniaxial tension", -0.5), ("equibiaxial tension", 1.0), ("planar tension", 0.0)];
    let step = (LARGEST_STRETCH - 1.0) / STABILITY_STEPS as f64;
    let first_of = |(name, power): (&'static str, f64)| {
        let mut stretches = (0..=STABILITY_STEPS).map(|k| 1.0 + k as f64 * step);
        stretches.find(|l| !is_stable(law, [*l, l.powf(power)])).map(|stretch| (name, stretch))
    };
    cases.into_iter().filter_map(first_of).collect()
}

/// Returns whether the second derivatives of the energy by the logarithmic strains are positive definite.
fn is_stable(law: &DeviatoricEnergy, [l1, l2]: [f64; 2]) -> bool {
    const STEP: f64 = 1e-4;
    let terms = match law {
        DeviatoricEnergy::Polynomial(terms) => &terms[..],
        DeviatoricEnergy::NeoHooke(c) => return *c > 0.0,
        DeviatoricEnergy::Ogden(terms) => return is_stable_ogden(terms, [l1, l2]),
    };
    let energy = |a: f64, b: f64| {
        let (x, y) = (l1.ln() + a * STEP, l2.ln() + b * STEP);
        let squares = [(2.0 * x).exp(), (2.0 * y).exp(), (-2.0 * (x + y)).exp()];
        let first: f64 = squares.iter().sum::<f64>() - 3.0;
        let second: f64 = squares.iter().map(|square| 1.0 / square).sum::<f64>() - 3.0;
        terms.iter().map(|&(c, i, j)| c * first.powi(i as i32) * second.powi(j as i32)).sum::<f64>()
    };
    let middle = energy(0.0, 0.0);
    let [xx, yy] =
        [energy(1.0, 0.0) + energy(-1.0, 0.0), energy(0.0, 1.0) + energy(0.0, -1.0)].map(|sum| sum - 2.0 * middle);
    let xy = 0.25 * (energy(1.0, 1.0) - energy(1.0, -1.0) - energy(-1.0, 1.0) + energy(-1.0, -1.0));
    xx + yy > 0.0 && xx * yy - xy * xy > 0.0
}

/// [`is_stable`] of the Ogden form, whose second derivatives are sums of powers of the stretches.
fn is_stable_ogden(terms: &[[f64; 2]], [l1, l2]: [f64; 2]) -> bool {
    let power = |stretch: f64| terms.iter().map(|[mu, alpha]| 2.0 * mu * stretch.powf(*alpha)).sum::<f64>();
    let [first, second, third] = [power(l1), power(l2), power(1.0 / (l1 * l2))];
    let [xx, yy] = [first + third, second + third];
    xx + yy > 0.0 && xx * yy - third * third > 0.0
}
