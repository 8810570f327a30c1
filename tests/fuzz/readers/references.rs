//! Tables of `--compare`, and the sheet and chart that show them.
use revolve::output::csv;
use revolve::study::compare::ReferenceTable;
use revolve::study::grid::CaseGrid;
use revolve::study::quantity::Quantity;
use revolve::study::sweep;

/// Reads the data as a table; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    let path = super::folder().join("reference.csv");
    std::fs::write(&path, data).expect("a file");
    let Ok(reference) = ReferenceTable::read(&path) else { return };
    let grid = CaseGrid::parse(&["V=1,2".to_owned()]).expect("a grid");
    let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
    let _ = sweep::comparable(&grid, &path, &reference);
    let parameters = vec![vec!["1".to_owned()], vec!["2".to_owned()]];
    let results = sweep::SweepResults { parameters, values: vec![Ok(vec![3.0]), Ok(vec![4.0])], warnings: Vec::new() };
    let table = sweep::table(&grid, &quantities, &results, Some(&reference)).table;
    for line in table.csv().lines() {
        assert_eq!(csv::fields(line).len(), table.header.len(), "{line}");
    }
    let _ = sweep::chart("fuzz", &grid, &quantities, &results, Some(&reference)).svg();
}
