//! Decks up to the plan; small valid decks also run for one increment.
use revolve::job;
use revolve::user::Routines;

/// Largest number of elements and nodes of a deck that is run.
const SMALL: usize = 2000;

/// Reads the data as a deck; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    // Decks with counts in the millions may be slow.
    let runs = text.split(|c: char| !c.is_ascii_digit());
    if runs.filter_map(|run| run.parse::<u64>().ok()).any(|n| (30_000..30_000_000).contains(&n)) {
        return;
    }
    let prepared = job::prepare_text("fuzz.inp", &text, &[], &Routines::none());
    let rendered = prepared.diagnostics.render(&prepared.deck.sources);
    let refused = prepared.diagnostics.has_errors();
    assert!(!refused || !rendered.is_empty());
    let _ = prepared.plan.ledger.render(false);
    let mesh = &prepared.plan.mesh;
    if !refused && mesh.points.len() + mesh.elements.len() < SMALL {
        let _ = super::one_increment(&prepared, None);
    }
}
