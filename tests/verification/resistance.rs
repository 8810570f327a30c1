//! Pressures on an expanding cavity, and the constants fitted to them, against closed forms and published values.
//!
//! Goal: A, B, C from a target's own curve. Sources: Hopkins 1960 (incompressible, perfectly plastic), Luk, Forrestal and Amos
//! 1991 (hardening), Warren and Forrestal 1998 (rates), Forrestal and Tzou 1997 (cracks); compressible values from an
//! independent integration along labels with another solver. Material: aluminium 6061 unless said.

use std::f64::consts::PI;

use revolve::resistance::fit::FitWeight;
use revolve::resistance::rate::{StrainRateEffect, StrainRateFactor};
use revolve::resistance::similarity::{CavityPressure, ExpandingCavity};
use revolve::resistance::{
    DerivedResistance, FitRequest, ResistanceError, ScaledTarget, TargetMaterial, YieldCurve, derive,
};

const YOUNG: f64 = 68.9e9;
const Y: f64 = 276e6;
const DENSITY: f64 = 2710.0;

fn aluminium(curve: YieldCurve, poisson: f64) -> TargetMaterial {
    let (young, density, yield_stress) = (YOUNG, DENSITY, Y);
    TargetMaterial { young, poisson, density, yield_stress, curve, pressure_slope: 0.0, tension: None, rate: None }
}

fn pressure(target: &ScaledTarget, velocity: f64) -> Result<CavityPressure, ResistanceError> {
    ExpandingCavity::new(target)?.pressure(velocity)
}

fn point(material: &TargetMaterial, velocity: f64) -> CavityPressure {
    pressure(&ScaledTarget::new(material).expect("a target"), velocity).expect("a pressure")
}

fn fitted(material: &TargetMaterial, to: f64, linear: bool) -> DerivedResistance {
    let request = FitRequest { linear, ..FitRequest::over([0.0, to]) };
    derive(&ScaledTarget::new(material).expect("a target"), &request).expect("a fit")
}

/// The integral of a function over 0..1 whose slope may be infinite at the ends: the tanh-sinh rule, which knows nothing of the
/// solver's steps.
fn quadrature(f: impl Fn(f64) -> f64) -> f64 {
    let h = 1.0 / 64.0;
    let term = |i: i32| {
        let t = h * f64::from(i);
        let s = 0.5 * PI * t.sinh();
        // x near 0 keeps its digits.
        let x = 1.0 / (1.0 + (-2.0 * s).exp());
        let weight = 0.25 * PI * t.cosh() / s.cosh().powi(2);
        if x > 0.0 && x < 1.0 { weight * f(x) } else { 0.0 }
    };
    h * (-320..=320).map(term).sum::<f64>()
}

/// 2/3 (1 + (2E/3Y)^n times the integral of (-ln x)^n / (1 - x) from 0 to 1 - 3Y/2E).
fn incompressible_at_rest(young: f64, y: f64, n: f64) -> f64 {
    let top = 1.0 - 1.5 * y / young;
    let inner = quadrature(|s| top * (-(top * s).ln()).powf(n) / (1.0 - top * s));
    2.0 / 3.0 * (1.0 + (2.0 * young / (3.0 * y)).powf(n) * inner)
}

#[test]
fn incompressible_perfectly_plastic_closed_form() {
    for velocity in [0.0, 1e-3, 1.0, 300.0, 2000.0] {
        let exact = 2.0 / 3.0 * (1.0 + (2.0 * YOUNG / (3.0 * Y)).ln()) + 1.5 * velocity * velocity * DENSITY / Y;
        let off = point(&aluminium(YieldCurve::Perfect, 0.5), velocity).stress / exact - 1.0;
        assert!(off.abs() < 1e-10, "{velocity}: {off:e}");
    }
}

/// The elastic zone ends at c_d t, so the limit is reached with 1/c_d: with the root of 1/2 - nu.
#[test]
fn compressibility_goes_to_its_limit() {
    let at = |poisson: f64| point(&aluminium(YieldCurve::Power(0.051), poisson), 600.0).stress;
    let limit = at(0.5);
    let slopes = [1e-5, 1e-7, 1e-9].map(|below: f64| (limit - at(0.5 - below)) / below.sqrt());
    println!("slopes over the root of 1/2 - nu: {slopes:?}");
    assert!((slopes[1] / slopes[2] - 1.0).abs() < 0.01 && (slopes[0] / slopes[1] - 1.0).abs() < 0.05, "{slopes:?}");
}

#[test]
fn incompressible_hardening_closed_form() {
    for (young, y, n) in [(73.1e9, 448e6, 0.089), (YOUNG, Y, 0.051), (200e9, 400e6, 0.4)] {
        let exact = incompressible_at_rest(young, y, n);
        let material = TargetMaterial { young, yield_stress: y, ..aluminium(YieldCurve::Power(n), 0.5) };
        let got = point(&material, 0.0).stress;
        println!("n = {n}: {got} {exact}");
        assert!((got / exact - 1.0).abs() < 1e-8, "{n}: {got} {exact}");
    }
}

/// Linear hardening, H the slope over total strain: (2/3)(1 + the integral of 1/(1-x) and of (2/3) H (-ln x)/(1-x)), whose last
/// part is pi^2/6 but for the front's (Hill 1950, The Mathematical Theory of Plasticity, V.2).
#[test]
fn linear_hardening_of_a_table() {
    let modulus = 1e9;
    let tangent = YOUNG * modulus / (YOUNG + modulus);
    let rows = vec![[Y, 0.0], [Y + 0.3 * modulus, 0.3], [Y + 30.0 * modulus, 30.0]];
    let got = point(&aluminium(YieldCurve::Table { rows, extrapolates: true }, 0.5), 0.0).stress;
    let top = 1.0 - 1.5 * Y / YOUNG;
    let flow = |x: f64| 1.0 + tangent / Y * (-2.0 / 3.0 * x.ln() - Y / YOUNG);
    let exact = 2.0 / 3.0 * (1.0 + quadrature(|s| top * flow(top * s) / (1.0 - top * s)));
    println!("linear hardening {got} {exact}");
    assert!((got / exact - 1.0).abs() < 1e-8, "{got} {exact}");
}

/// A table with many kinks that follows a power law is the power law.
#[test]
fn a_table_is_the_law_that_it_follows() {
    let rows = |count: usize| {
        let strain = |i: usize| if i == 0 { Y / YOUNG } else { Y / YOUNG * 1e5_f64.powf(i as f64 / count as f64) };
        let row = |e: f64| {
            let stress = Y * (YOUNG * e / Y).powf(0.051);
            [stress, e - stress / YOUNG]
        };
        (0..=count).map(|i| row(strain(i))).collect::<Vec<_>>()
    };
    for velocity in [0.0, 700.0] {
        let exact = point(&aluminium(YieldCurve::Power(0.051), 1.0 / 3.0), velocity).stress;
        let off = [20, 40].map(|n| {
            let rows = rows(n);
            point(&aluminium(YieldCurve::Table { rows, extrapolates: false }, 1.0 / 3.0), velocity).stress / exact - 1.0
        });
        println!("tables of 20 and 40 rows at {velocity}: {off:?}");
        // Chords of a concave curve: below it, by the square of their length.
        assert!(off[0] < 0.0 && off[0].abs() < 2e-3 && (3.0..5.0).contains(&(off[0] / off[1])), "{off:?}");
    }
}

/// Compressible pressures at velocities from 50 to 1500 m/s, without hardening and with n = 0.051.
#[test]
fn compressible_pressures() {
    let table = [
        (50.0, 3.924_730, 4.433_285),
        (100.0, 4.016_608, 4.524_825),
        (200.0, 4.379_136, 4.886_004),
        (300.0, 4.973_091, 5.477_732),
        (400.0, 5.790_499, 6.292_068),
        (500.0, 6.823_881, 7.321_575),
        (600.0, 8.066_287, 8.559_349),
        (800.0, 11.153_078, 11.634_802),
        (1000.0, 15.005_786, 15.473_748),
        (1200.0, 19.586_983, 20.039_155),
        (1500.0, 27.759_895, 28.185_370),
    ];
    let mut worst: f64 = 0.0;
    for (velocity, perfect, hardening) in table {
        for (exact, curve) in [(perfect, YieldCurve::Perfect), (hardening, YieldCurve::Power(0.051))] {
            let off = point(&aluminium(curve, 1.0 / 3.0), velocity).stress / exact - 1.0;
            worst = worst.max(off.abs());
            // The table's elastic zone leaves out the convective acceleration, rho v^2 / 2 at the plastic front.
            assert!(off.abs() < 2e-4, "{velocity}: {off:e}");
        }
    }
    println!("compressible pressures: at most {worst:.1e} off");
}

/// 7075-T651, E = 73.1 GPa, Y = 448 MPa, n = 0.089: A = 4.418 (Forrestal, Luk, Rosenberg and Brar 1992, Int. J. Solids Struct. 29,
/// 1729), between the pressure at rest and fits in two terms over more and more.
#[test]
fn the_constant_of_7075() {
    let material =
        TargetMaterial { young: 73.1e9, yield_stress: 448e6, ..aluminium(YieldCurve::Power(0.089), 1.0 / 3.0) };
    let still = point(&material, 0.0).stress;
    let fits = [200.0, 300.0, 320.0, 340.0, 400.0].map(|to| fitted(&material, to, false).constants[0]);
    println!("7075 at rest {still}, fits {fits:?}");
    assert!((still / 4.418 - 1.0).abs() < 5e-4, "{still}");
    assert!((fits[1] / 4.418 - 1.0).abs() < 1e-4, "{fits:?}");
    assert!(still < fits[0] && fits.windows(2).all(|w| w[0] < w[1]), "{fits:?}");
}

/// A and C of the literature's fits in two terms, and what a third one leaves over.
#[test]
fn constants_of_6061() {
    for (n, to, a, c) in [(0.0, 400.0, 3.90, 1.21), (0.051, 400.0, 4.41, 1.21), (0.051, 1000.0, 4.48, 1.13)] {
        let derived = fitted(&aluminium(YieldCurve::Power(n), 1.0 / 3.0), to, false);
        let got = derived.constants;
        assert!((got[0] - a).abs() < 5.5e-3 && got[1] == 0.0 && (got[2] - c).abs() < 5.5e-3, "{n} {to}: {got:?}");
    }
    let material = aluminium(YieldCurve::Power(0.051), 1.0 / 3.0);
    let [two, three] = [false, true].map(|linear| fitted(&material, 1000.0, linear));
    assert!(three.fit.residual < 0.4 * two.fit.residual && three.constants[1] > 0.0, "{three:?}");
    let half = three.fit.half_widths.map(|h| h.expect("fitted"));
    assert!(half.iter().all(|h| *h > 0.0 && *h < 0.05), "{half:?}");
    // Six digits, as a card shows them.
    assert!(three.constants.iter().zip(three.fit.constants).all(|(card, fit)| (card / fit - 1.0).abs() < 1e-5));
}

#[test]
fn weights_and_the_pressure_at_rest() {
    let target = ScaledTarget::new(&aluminium(YieldCurve::Power(0.051), 1.0 / 3.0)).expect("a target");
    let with = |request: FitRequest| derive(&target, &request).expect("a fit");
    let plain = FitRequest::over([0.0, 1000.0]);
    let pinned = with(FitRequest { pinned: true, ..plain });
    assert!((pinned.constants[0] / pinned.static_pressure - 1.0).abs() < 1e-5 && pinned.fit.half_widths[0].is_none());
    let [even, relative, fast] =
        [FitWeight::Even, FitWeight::Relative, FitWeight::Velocity].map(|weight| with(FitRequest { weight, ..plain }));
    // Relative weights look at low pressures, those by velocity at high ones.
    let at = |d: &DerivedResistance, v: f64| {
        (d.fit.at(v / target.velocity) / pressure(&target, v).expect("a pressure").stress - 1.0).abs()
    };
    assert!(at(&relative, 0.0) < at(&even, 0.0) && at(&even, 0.0) < at(&fast, 0.0));
    assert!(at(&fast, 1000.0) < at(&even, 1000.0));
}

/// The growth with rate of an incompressible target against quadrature, and constants near those of the literature (A = 5.035,
/// B = 0.961, C = 0.946), which fitted another choice of velocities.
#[test]
fn strain_rates_raise_the_pressure() {
    let rate =
        |radius: f64| StrainRateEffect { factor: StrainRateFactor::Power { reference: 8e5, exponent: 0.3 }, radius };
    let with =
        |radius: f64| TargetMaterial { rate: Some(rate(radius)), ..aluminium(YieldCurve::Power(0.051), 1.0 / 3.0) };
    let still = aluminium(YieldCurve::Power(0.051), 1.0 / 3.0);
    for (velocity, radius) in [(100.0, 3.555e-3), (1000.0, 3.555e-3), (500.0, 35.55e-3)] {
        let gain = point(&with(radius), velocity).stress - point(&still, velocity).stress;
        let top = 1.0 - 1.5 * Y / YOUNG;
        let scale = 2.0 / 3.0 * (2.0 * YOUNG / (3.0 * Y)).powf(0.051) * (2.0 * velocity / radius / 8e5_f64).powf(0.3);
        let exact = scale * quadrature(|s| top * (-(top * s).ln()).powf(0.051) * (1.0 - top * s).powf(-0.7));
        println!("{velocity} m/s, {radius} m: rates add {gain} {exact}");
        assert!((gain / exact - 1.0).abs() < 1e-7, "{gain} {exact}");
    }
    assert_eq!(point(&with(3.555e-3), 0.0), point(&still, 0.0));
    let target = ScaledTarget::new(&with(3.555e-3)).expect("a target");
    let derived = derive(&target, &FitRequest::over([50.0, 1500.0])).expect("a fit");
    println!("with rates A, B, C = {:?}", derived.constants);
    assert!((derived.constants[0] - 5.035).abs() < 0.01 && (derived.constants[2] - 0.946).abs() < 0.02, "{derived:?}");
}

fn concrete(tension: Option<f64>, poisson: f64, pressure_slope: f64) -> TargetMaterial {
    let (young, density, yield_stress) = (11.3e9, 2340.0, 130e6);
    TargetMaterial {
        young,
        poisson,
        density,
        yield_stress,
        curve: YieldCurve::Perfect,
        pressure_slope,
        tension,
        rate: None,
    }
}

/// An incompressible target at rest that cracks: columns carry Y c^2/r^2 from the plastic front c to the cracks at
/// c sqrt(Y/2T), where the elastic zone bears the tension T; what they shorten is what the cavity takes.
#[test]
fn cracks_at_rest_closed_form() {
    for tension in [5e6, 13e6, 40e6] {
        let (young, y) = (11.3e9, 130e6);
        let eta = f64::sqrt(y / (2.0 * tension));
        // Outside u = s r / 4 G with G = E/3 and s = 2 T; in the columns E du/dr = -Y c^2 / r^2.
        let displacement = 2.0 * tension * 3.0 / (4.0 * young) * eta + y / young * (1.0 - 1.0 / eta);
        let opened = 1.0 - (1.0 - displacement).powi(3);
        let exact = 1.0 - 2.0 / 3.0 * opened.ln();
        let got = point(&concrete(Some(tension), 0.5, 0.0), 0.0);
        println!("cracks: T = {tension:e}: {got:?} {exact}");
        assert!((got.stress / exact - 1.0).abs() < 1e-9, "{got:?} {exact}");
        assert!((got.cracked.expect("cracks") / got.plastic / eta - 1.0).abs() < 1e-9, "{got:?}");
    }
}

/// Tension that is never reached changes nothing; cracks weaken a target at rest, slow down with velocity against the plastic
/// front, and end where it overtakes them, without a jump that matters.
#[test]
fn cracks_end_with_tension_and_with_velocity() {
    for slope in [0.0, 0.67] {
        let [whole, strong, brittle] = [None, Some(60e6), Some(13e6)].map(|t| concrete(t, 0.22, slope));
        assert_eq!(point(&strong, 100.0), point(&whole, 100.0));
        assert!(point(&brittle, 0.0).stress < point(&whole, 0.0).stress);
        let ratio = |v: f64| point(&brittle, v).cracked.map(|c| c / point(&brittle, v).plastic);
        let ratios: Vec<Option<f64>> = (0..=20).map(|i| ratio(40.0 * f64::from(i))).collect();
        let (open, closed): (Vec<Option<f64>>, Vec<Option<f64>>) = ratios.iter().copied().partition(Option::is_some);
        assert!(open.len() > 5 && closed.len() > 5 && open.windows(2).all(|w| w[1] < w[0]), "{ratios:?}");
        let [brittle_fast, whole_fast] = [&brittle, &whole].map(|m| point(m, 800.0));
        assert!(brittle_fast.cracked.is_none() && (brittle_fast.stress / whole_fast.stress - 1.0).abs() < 1e-10);
        let jump =
            (1..800).map(|i| f64::from(i) - 0.5).map(|v| point(&brittle, v + 1.0).stress / point(&brittle, v).stress);
        let jump = jump.fold((f64::INFINITY, 0.0_f64), |m, r| (m.0.min(r), m.1.max(r)));
        println!("slope {slope}: pressures a metre a second apart grow by {jump:?}");
        assert!(jump.0 > 0.99 && jump.1 < 1.01, "{jump:?}");
    }
}

/// A strength that grows with pressure, incompressible and at rest: d s/d ln r = -2 tau with tau = (Y + k s)/(1 + 2k/3) has the
/// solution (s + Y/k) r^(2k/(1 + 2k/3)) = const from s = 2Y/3 at the front.
#[test]
fn strength_that_grows_with_pressure() {
    let (young, y, k) = (11.3e9_f64, 130e6_f64, 0.67);
    let radius = (1.5 * y / young).cbrt();
    let exact = (2.0 / 3.0 + 1.0 / k) * radius.powf(-2.0 * k / (1.0 + 2.0 * k / 3.0)) - 1.0 / k;
    let got = point(&concrete(None, 0.5, k), 0.0).stress;
    println!("Mohr-Coulomb at rest {got} {exact}");
    assert!((got / exact - 1.0).abs() < 1e-9, "{got} {exact}");
}

/// Wherever there is an answer it is a number that grows with velocity; elsewhere the reason is said.
#[test]
fn the_worst_places_have_an_answer_or_a_reason() {
    let curves = [
        YieldCurve::Perfect,
        YieldCurve::Power(0.4),
        YieldCurve::Power(1.0),
        YieldCurve::Table { rows: vec![[Y, 0.0], [0.5 * Y, 1.0]], extrapolates: false },
    ];
    let mut codes = std::collections::BTreeMap::new();
    for curve in curves {
        for poisson in [0.0, 0.2, 0.499_999, 0.5] {
            for strength in [1e-4, 1.0, 50.0] {
                let scale = |curve: &YieldCurve| match curve {
                    YieldCurve::Table { rows, extrapolates } => {
                        let rows = rows.iter().map(|r| [strength * r[0], r[1]]).collect();
                        YieldCurve::Table { rows, extrapolates: *extrapolates }
                    }
                    other => other.clone(),
                };
                let material = TargetMaterial { yield_stress: strength * Y, ..aluminium(scale(&curve), poisson) };
                let target = ScaledTarget::new(&material).expect("a target");
                let mut before = 0.0;
                for velocity in [0.0, 1e-6, 1.0, 100.0, 1000.0, 4000.0, 1e4, 1e6] {
                    match pressure(&target, velocity) {
                        Ok(p) => {
                            assert!(
                                p.stress.is_finite() && p.stress >= before * (1.0 - 1e-9),
                                "{material:?} {p:?} {before}"
                            );
                            assert!(p.plastic >= 1.0, "{p:?}");
                            before = p.stress;
                        }
                        Err(fault) => {
                            if let ResistanceError::Fast { fastest, .. } = fault {
                                let there = pressure(&target, fastest);
                                assert!(fastest < velocity && there.is_ok(), "{material:?} {fault:?} {there:?}");
                            }
                            *codes.entry(fault.code()).or_insert(0) += 1;
                        }
                    }
                }
            }
        }
    }
    println!("reasons: {codes:?}");
    assert!(codes.keys().all(|c| ["C002", "C004"].contains(c)) && codes.contains_key("C002"), "{codes:?}");
}

#[test]
fn targets_that_cannot_be_are_refused() {
    let good = aluminium(YieldCurve::Perfect, 1.0 / 3.0);
    let rows = |rows: &[[f64; 2]]| YieldCurve::Table { rows: rows.to_vec(), extrapolates: true };
    let bad = [
        TargetMaterial { young: 0.0, ..good.clone() },
        TargetMaterial { density: f64::NAN, ..good.clone() },
        TargetMaterial { yield_stress: -1.0, ..good.clone() },
        TargetMaterial { yield_stress: 60e9, ..good.clone() },
        TargetMaterial { poisson: 0.51, ..good.clone() },
        TargetMaterial { curve: YieldCurve::Power(-0.1), ..good.clone() },
        TargetMaterial { curve: YieldCurve::Power(1.5), ..good.clone() },
        TargetMaterial { curve: rows(&[]), ..good.clone() },
        TargetMaterial { curve: rows(&[[1.1 * Y, 0.0]]), ..good.clone() },
        TargetMaterial { curve: rows(&[[Y, 0.0], [Y, 0.0]]), ..good.clone() },
        TargetMaterial { curve: rows(&[[Y, 0.0], [f64::NAN, 0.1]]), ..good.clone() },
        TargetMaterial { curve: rows(&[[Y, 0.0], [0.5 * Y, 0.001]]), ..good.clone() },
        TargetMaterial { curve: rows(&[[Y, 0.0], [0.5 * Y, 1.0]]), ..good.clone() },
        TargetMaterial { pressure_slope: 3.0, ..good.clone() },
        TargetMaterial { pressure_slope: 0.5, curve: YieldCurve::Power(0.1), ..good.clone() },
        TargetMaterial { tension: Some(0.0), ..good.clone() },
        TargetMaterial {
            rate: Some(StrainRateEffect {
                factor: StrainRateFactor::Power { reference: 1.0, exponent: 0.0 },
                radius: 1.0,
            }),
            ..good.clone()
        },
    ];
    for material in bad {
        assert_eq!(ScaledTarget::new(&material).expect_err("no target").code(), "C001", "{material:?}");
    }
    let target = ScaledTarget::new(&good).expect("a target");
    for (range, points) in [([10.0, 5.0], 41), ([-1.0, 5.0], 41), ([0.0, f64::NAN], 41), ([0.0, 500.0], 2)] {
        let request = FitRequest { points, ..FitRequest::over(range) };
        assert_eq!(derive(&target, &request).expect_err("no range").code(), "C003");
    }
    assert_eq!(derive(&target, &FitRequest::over([0.0, 2e4])).expect_err("too fast").code(), "C002");
}

/// A rigid cone into soil whose resistance a card gives, or derives.
fn shot(cards: &str) -> String {
    format!(
        "*Node\n 1, 0., 0.\n 2, 0.5, 0.5\n*Node, nset=REF\n 99, 0., 0.\n*Element, type=RAX2, elset=HULL\n 1, 2, 1\n\
         *Element, type=MASS, elset=POINT\n 3, 99\n*Mass, elset=POINT\n 5000.,\n*Rigid Body, ref node=REF, elset=HULL\n\
         *Surface, name=NOSE\n HULL, SPOS\n{cards}*Target, name=BLOCK, front=0., direction=-1\n AL\n\
         *Initial Conditions, type=VELOCITY\n REF, 2, -600.\n*Step\n*Dynamic, Explicit\n , 1.e-3\n*Dsload, target=BLOCK\n NOSE, CAVITY\n\
         *Output, history, number interval=4\n*Node Output, nset=REF\n U2, V2\n*End Step\n"
    )
}

const PLASTIC: &str = "*Plastic\n 276.e6, 0.\n 310.e6, 0.1\n 330.e6, 1.\n";

fn derived_card(above: &str, card: &str) -> String {
    shot(&format!("*Material, name=AL\n{card}*Density\n 2710.,\n*Elastic\n 68.9e9, 0.3333\n{above}"))
}

/// `DERIVE` in a deck comes to what the card of the same constants comes to, bit by bit, wherever it stands in its material; and
/// the ledger says what was derived, over what range, and how well it fits.
#[test]
fn a_deck_derives_the_card_that_it_could_have() {
    let deck = derived_card(PLASTIC, "*Cavity Expansion, derive\n 0., 800.\n");
    let (model, diagnostics) = revolve::model::build(&revolve::deck::read_text("derived", &deck, &[]).0);
    assert!(!diagnostics.has_errors(), "{}", diagnostics.render(&model.origin.sources));
    let law = model.materials[0].cavity.expect("a resistance");
    let [a, b, c] = [law.a, law.b, law.c];
    let given = shot(&format!(
        "*Material, name=AL\n*Density\n 2710.,\n*Cavity Expansion, yield={:?}\n {a:?}, {b:?}, {c:?}\n",
        law.yield_stress
    ));
    let [derived, given] = [&deck, &given].map(|text| {
        let (outcome, memory) = crate::common::solid::run(text);
        (outcome.digest, format!("{:?}", memory.rows))
    });
    assert_eq!(derived, given);
    let rows = vec![[276e6, 0.0], [310e6, 0.1], [330e6, 1.0]];
    let same = fitted(&aluminium(YieldCurve::Table { rows, extrapolates: false }, 0.3333), 800.0, true);
    assert_eq!(same.constants, [a, b, c]);
    let ledger = crate::common::prepared(&deck, &[], &revolve::user::Routines::none()).plan.ledger;
    let row = ledger.effects.iter().find(|r| r.effect == "derived resistance").expect("a row");
    for word in [format!("A = {a}"), format!("C = {c}"), "velocities 0 to 800".into(), "residual".into()] {
        assert!(row.detail.contains(&word), "{} lacks {word}", row.detail);
    }
}

#[test]
fn decks_that_cannot_derive_say_why() {
    let card = "*Cavity Expansion, derive\n 0., 800.\n";
    let rated = format!("{PLASTIC}*Rate Dependent, type=power law\n 8.e5, 3.\n");
    for (deck, code) in [
        (derived_card("", card), "M101"),
        (shot(&format!("*Material, name=AL\n*Density\n 2710.,\n{PLASTIC}{card}")), "M101"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive\n 800., 0.\n"), "C003"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive\n 0., 20000.\n"), "C002"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive\n 0., 800., 2\n"), "C003"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive\n 0.\n"), "M102"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive, yield=1.\n 0., 800.\n"), "M103"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive, terms=4\n 0., 800.\n"), "M103"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive, weight=HEAVY\n 0., 800.\n"), "M103"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive, radius=-1.\n 0., 800.\n"), "M103"),
        (derived_card(PLASTIC, "*Cavity Expansion, derive, radius=1.\n 0., 800.\n"), "M101"),
        (derived_card("*Plastic\n 276.e6, 0., 20.\n 200.e6, 0., 200.\n", card), "M104"),
        (derived_card("*Plastic\n 60.e9, 0.\n", card), "C001"),
        (derived_card(&rated, card), "M185"),
    ] {
        let (model, diagnostics) = revolve::model::build(&revolve::deck::read_text("derived", &deck, &[]).0);
        let codes: Vec<&str> = diagnostics.iter().map(|d| d.code).collect();
        assert!(codes.contains(&code), "{code}: {}", diagnostics.render(&model.origin.sources));
        assert_eq!(diagnostics.has_errors(), code != "M185", "{code}");
    }
}

/// The pressure on a meshed cavity against the similarity solution, with hardening, at two velocities: three meshes show an order,
/// and Richardson's value lies within 0.1 % (0.02 %).
#[test]
fn a_meshed_cavity_presses_as_the_similar_one() {
    let material = aluminium(YieldCurve::Power(0.051), 1.0 / 3.0);
    let measured = revolve::study::expansion::measure(&material, &[500.0, 1000.0]).expect("runs");
    for m in &measured {
        let exact = point(&material, m.velocity).stress;
        let off = m.estimate.limit / exact - 1.0;
        println!(
            "{} m/s: {:?} limit {} order {:?} drift {:e}: {off:e} off {exact}",
            m.velocity, m.levels, m.estimate.limit, m.estimate.order, m.drift
        );
        assert!(off.abs() < 1e-3, "{m:?} {exact}");
        assert!(m.estimate.order.is_some_and(|order| order > 0.8), "{m:?}");
        assert!(m.levels.windows(2).all(|w| w[1] < w[0]) && m.drift < 2e-3 * exact, "{m:?}");
        assert!((m.estimate.limit - exact).abs() < 2.0 * m.uncertainty(), "{m:?} {exact}");
    }
    let brittle = TargetMaterial { tension: Some(1e6), ..material.clone() };
    let incompressible = TargetMaterial { poisson: 0.5, ..material };
    for refused in [brittle, incompressible] {
        assert!(revolve::study::expansion::measure(&refused, &[500.0]).is_err());
    }
}
