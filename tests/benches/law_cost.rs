//! Run time of material laws, compared with von Mises plasticity with linear hardening and with a plain scalar loop of
//! it.
//!
//! Scene: copper Taylor bar of 2 000 elements until the end of plastic flow, one thread.

use revolve::job;
use revolve::user::Routines;

use super::plain_solid::PlainBar;
use crate::common;

const ROUNDS: usize = 3;
const JOHNSON_COOK: &str = "*Plastic, hardening=JOHNSON COOK\n 90.e6, 292.e6, 0.31, 1.09, 1083., 20.\n";
const RATE: &str = "*Rate Dependent, type=JOHNSON COOK\n 0.025, 1.\n";
const HEAT: &str = "*Specific Heat\n 383.,\n*Inelastic Heat Fraction\n 0.9,\n";
const ROWS: &str = "*Plastic\n 400.e6, 0.\n 500.e6, 1.\n 900.e6, 5.\n";

/// Elastic constants of copper.
const COPPER: &str = "*Elastic\n 117.e9, 0.35\n";
/// Hardening of laws of soil.
const COHESION: &str = "*Drucker Prager Hardening\n 400.e6, 0.\n 500.e6, 1.\n";
/// Laws whose strength depends on pressure, damage, porosity or direction, with the stiffness of copper.
const OF_PRESSURE: [(&str, &str); 8] = [
    ("Drucker-Prager, linear", "*Drucker Prager\n 20., 1., 0.\n"),
    ("Drucker-Prager, K = 0.85", "*Drucker Prager\n 20., 0.85, 0.\n"),
    ("Drucker-Prager, hyperbolic", "*Drucker Prager, shear criterion=HYPERBOLIC\n 20., 100.e6, 0.\n"),
    ("cap", "*Cap Plasticity\n 400.e6, 20., 0.4, 0., 0.03\n*Cap Hardening\n 400.e6, 0.\n 4000.e6, 0.1\n"),
    (
        "damaged concrete",
        "*Concrete Damaged Plasticity\n 20., 0.1, 1.16, 0.667\n*Concrete Compression Hardening\n 400.e6, 0.\n 500.e6, 1.\n\
         *Concrete Tension Stiffening\n 200.e6, 0.\n 150.e6, 1.\n",
    ),
    ("Hill", "*Plastic\n 400.e6, 0.\n 500.e6, 1.\n*Potential\n 1., 1.05, 0.95, 1.1, 1., 1.\n"),
    (
        "porous metal",
        "*Plastic\n 400.e6, 0.\n 500.e6, 1.\n*Porous Metal Plasticity, relative density=0.98\n 1.5, 1., 2.25\n",
    ),
    ("spall", "*Plastic\n 400.e6, 0.\n 500.e6, 1.\n*Tensile Failure, element deletion=NO\n 2.e9,\n"),
];
/// Laws without the stiffness of copper, or with an equation of state.
const OTHERS: [(&str, &str); 8] = [
    (
        "USUP, linear hardening",
        "*Eos, type=USUP\n 3940., 1.489, 2.\n*Elastic, type=SHEAR\n 43.e9,\n*Plastic\n 400.e6, 0.\n 500.e6, 1.\n",
    ),
    (
        "TABULAR equation, linear hardening",
        "*Eos, type=TABULAR\n 0., 0., 0.\n 100.e9, 1., -0.5\n 400.e9, 1.5, -1.\n*Elastic, type=SHEAR\n 43.e9,\n*Plastic\n 400.e6, 0.\n 500.e6, 1.\n",
    ),
    (
        "P-alpha, linear hardening",
        "*Eos, type=USUP\n 3940., 1.489, 2.\n*Eos Compaction\n 3000., 0.1, 100.e6, 900.e6\n*Elastic, type=SHEAR\n 43.e9,\n*Plastic\n 400.e6, 0.\n 500.e6, 1.\n",
    ),
    ("NEO HOOKE", "*Hyperelastic, neo hooke\n 20.e9, 1.5e-11\n"),
    ("MOONEY-RIVLIN", "*Hyperelastic, mooney-rivlin\n 15.e9, 5.e9, 1.5e-11\n"),
    ("YEOH", "*Hyperelastic, yeoh\n 20.e9, -1.e9, 1.e9, 1.5e-11\n"),
    ("OGDEN of two terms", "*Hyperelastic, ogden, n=2\n 30.e9, 2., 10.e9, -2., 1.5e-11, 0.\n"),
    (
        "crushable foam",
        "*Elastic\n 117.e9, 0.\n*Crushable Foam, hardening=ISOTROPIC\n 1., 0.\n*Crushable Foam Hardening\n 2.e9, 0.\n 20.e9, 1.\n",
    ),
];

/// Returns nanoseconds per element and increment with a law, the best of several runs.
fn law_nanoseconds(law: &str) -> f64 {
    let text = common::bar_with_law(law);
    let settings = [("nr", "20"), ("nz", "100")].map(|(n, v)| (n.to_owned(), v.to_owned()));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let once = || {
            let prepared = job::prepare_text("taylor.inp", &text, &settings, &Routines::none());
            assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
            let (outcome, _) = job::run_in_memory(&prepared);
            assert!(outcome.halt.is_none(), "{law}: {:?}", outcome.halt);
            outcome.seconds * 1e9 / (outcome.increments as f64 * 2000.0)
        };
        (0..ROUNDS).map(|_| once()).fold(f64::INFINITY, f64::min)
    })
}

/// Returns the same for the plain loop.
fn plain_nanoseconds() -> f64 {
    let once = || {
        let mut bar = PlainBar::new(20, 100);
        let begin = std::time::Instant::now();
        bar.run(2000, std::hint::black_box(1e-9));
        begin.elapsed().as_secs_f64() * 1e9 / (2000.0 * 2000.0)
    };
    (0..ROUNDS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

pub fn run() {
    let laws = [
        ("straight hardening", ROWS.to_owned()),
        ("elastic", String::new()),
        ("kinematic", "*Plastic, hardening=KINEMATIC\n 400.e6, 0.\n 500.e6, 1.\n".to_owned()),
        ("table of 3 rows with increasing slope", "*Plastic\n 400.e6, 0.\n 410.e6, 0.1\n 500.e6, 1.\n".to_owned()),
        ("tables at 2 temperatures, heat", format!("{}{HEAT}", temperature_tables())),
        ("Johnson-Cook", JOHNSON_COOK.to_owned()),
        ("Johnson-Cook, rate", format!("{JOHNSON_COOK}{RATE}")),
        ("Johnson-Cook, rate, heat", format!("{JOHNSON_COOK}{RATE}{HEAT}")),
        ("Cowper-Symonds", format!("{ROWS}*Rate Dependent\n 1.e5, 4.\n")),
        ("ratios by rate", format!("{ROWS}*Rate Dependent, type=YIELD RATIO\n 1., 0.\n 1.2, 1.e3\n 1.5, 1.e6\n")),
        ("Johnson-Cook, rate, heat, failure", format!("{JOHNSON_COOK}{RATE}{HEAT}{}", failure_card())),
    ];
    let (mut straight, loops) = (f64::NAN, plain_nanoseconds());
    println!(
        "nanoseconds per element and increment, best of {ROUNDS} (over linear hardening; over the plain loop, {loops:.1})"
    );
    let of_copper = laws.map(|(name, law)| (name, format!("{COPPER}{law}")));
    let of_pressure = OF_PRESSURE.map(|(name, law)| {
        let hardening = if law.starts_with("*Drucker") { COHESION } else { "" };
        (name, format!("{COPPER}{law}{hardening}"))
    });
    let others = OTHERS.map(|(name, law)| (name, law.to_owned()));
    for (name, law) in of_copper.into_iter().chain(of_pressure).chain(others) {
        let cost = law_nanoseconds(&law);
        if straight.is_nan() {
            straight = cost;
        }
        println!("{name}: {cost:.1} ({:.2}; {:.2})", cost / straight, cost / loops);
    }
}

fn temperature_tables() -> String {
    let at = |factor: f64, t: f64| format!(" {}, 0., {t}\n {}, 1., {t}\n", 400e6 * factor, 500e6 * factor);
    format!("*Plastic\n{}{}", at(1.0, 20.0), at(0.5, 500.0))
}

/// Returns the Johnson-Cook failure strain of copper with strains that are never reached.
fn failure_card() -> &'static str {
    "*Shear Failure, type=JOHNSON COOK\n 5.4, 48.9, -3.03, 0.014, 1.12\n"
}
