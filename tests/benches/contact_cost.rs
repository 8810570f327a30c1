//! Run time of contact: share of a run, and nanoseconds per facet in contact.
//!
//! Scene: two plastic blocks of 100 x 100 and 107 x 107 elements in contact over their whole faces, one thread, with
//! and without friction.

use revolve::job;
use revolve::user::Routines;

const ROUNDS: usize = 3;

/// Returns a block of n x n elements over 10 mm with lower edge at `low` and labels from `first` on.
fn block(name: &str, n: usize, first: usize, low: f64, material: &str) -> String {
    let (row, high) = (n + 1, low + 10.0);
    let last = first + n;
    let top = first + n * row;
    format!(
        "*Node\n {first}, 0., {low}\n {last}, 10., {low}\n {top}, 0., {high}\n {}, 10., {high}\n\
         *Ngen, nset={name}LOW\n {first}, {last}\n*Ngen, nset={name}HIGH\n {top}, {}\n\
         *Nfill, nset={name}\n {name}LOW, {name}HIGH, {n}, {row}\n\
         *Element, type=CAX4R\n {first}, {first}, {}, {}, {}\n\
         *Elgen, elset={name}\n {first}, {n}, 1, 1, {n}, {row}, {n}\n\
         *Solid Section, elset={name}, material={name}\n*Material, name={name}\n{material}\
         *Surface, name=ON{name}\n {name}\n",
        top + n,
        top + n,
        first + 1,
        first + row + 1,
        first + row
    )
}

fn contact_deck(friction: f64) -> String {
    let steel = "*Density\n 7.85e-9\n*Elastic\n 207.e3, 0.3\n*Plastic\n 400., 0.\n 800., 0.2\n";
    let soft = "*Density\n 2.71e-9\n*Elastic\n 69.e3, 0.33\n*Plastic\n 200., 0.\n 400., 0.2\n";
    block("A", 100, 1, 0.0, steel)
        + &block("B", 107, 100_001, -10.0, soft)
        + &format!(
            "*Initial Conditions, type=VELOCITY\n A, 2, -50.e3\n*Surface Interaction, name=DRY\n*Friction\n {friction},\n\
             *Step\n*Dynamic, Explicit\n , 6.e-6\n*Contact Pair, interaction=DRY\n ONA, ONB\n\
             *Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n"
        )
}

pub fn run() {
    println!(
        "share of contact in a run of 21 449 elements, nanoseconds per facet in contact and increment, best of {ROUNDS}"
    );
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for friction in [0.0, 0.1] {
        let once = || {
            let prepared = job::prepare_text("blocks.inp", &contact_deck(friction), &[], &Routines::none());
            assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
            let (outcome, _) = job::run_in_memory(&prepared);
            let rows = prepared.plan.ledger.effects.iter().zip(&outcome.effect_seconds);
            let contact: f64 = rows.filter(|(row, _)| row.effect.starts_with("contact")).map(|(_, s)| s).sum();
            (contact / (outcome.seconds - contact), contact * 1e9 / (outcome.increments as f64 * 107.0))
        };
        let best = (0..ROUNDS).map(|_| pool.install(once)).min_by(|a, b| a.0.total_cmp(&b.0)).expect("runs");
        println!("friction {friction}: {:.1} % of the rest, {:.0} ns", 100.0 * best.0, best.1);
    }
}
