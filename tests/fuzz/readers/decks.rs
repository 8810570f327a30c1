//! Decks up to the plan; what is accepted and small runs for an increment.
use revolve::job;
use revolve::user::Routines;

/// Elements and nodes of what runs.
const SMALL: usize = 2000;

/// Reads it; nothing may panic, hang or grow.
pub fn read(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    // Numbers that count by the million are slow by right.
    let runs = text.split(|c: char| !c.is_ascii_digit());
    if runs.filter_map(|run| run.parse::<u64>().ok()).any(|n| (30_000..30_000_000).contains(&n)) {
        return;
    }
    let prepared = job::prepare_text("fuzz.inp", &text, &[], &Routines::none());
    let said = prepared.diagnostics.render(&prepared.deck.sources);
    let refused = prepared.diagnostics.has_errors();
    assert!(!refused || !said.is_empty());
    let _ = prepared.plan.ledger.render(false);
    let mesh = &prepared.plan.mesh;
    if !refused && mesh.points.len() + mesh.elements.len() < SMALL {
        let _ = super::one_increment(&prepared, None);
    }
}
