//! Expressions of `*PARAMETER`, of `--set`, and of quantities of studies and sweeps.
use revolve::deck::expression::Expression;
use revolve::job;
use revolve::study::grid::CaseGrid;
use revolve::study::quantity::Quantity;
use revolve::study::target::ErrorTarget;
use revolve::user::Routines;

/// Reads the data as an expression; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
    if let Ok(expression) = Expression::parse(first) {
        let _ = expression.evaluate(&|_| Some(2.0), &|_, _| None);
    }
    let _ = (Quantity::parse(first), ErrorTarget::parse(first));
    if let Ok(grid) = CaseGrid::parse(&[first.to_owned()]) {
        let _ = (grid.count() > 0).then(|| grid.combination(0));
    }
    let deck = format!("*Parameter\n{text}\n*Node\n 1, <a>, <b>\n <c>, 1., 1.\n");
    let overrides = [("a".to_owned(), first.to_owned()), ("b".to_owned(), rest.to_owned())];
    for overrides in [&[][..], &overrides[..]] {
        let prepared = job::prepare_text("fuzz.inp", &deck, overrides, &Routines::none());
        let _ = prepared.diagnostics.render(&prepared.deck.sources);
    }
}
