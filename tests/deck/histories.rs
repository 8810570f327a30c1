//! Statistics over sets and expressions as history output.
//!
//! Goal: STATISTICS have the values computed from the members' columns; expressions have their value in each row,
//! wherever histories are read; errors in either are reported with their place when the deck is read.

use crate::common::solid::{grid, material};
use crate::common::{RecordedOutput, prepared};
use revolve::job;
use revolve::model::{NodeSetId, OutputExpression, OutputRegion, OutputRequest};
use revolve::solve;
use revolve::study::quantity::{FinishedRun, Quantity};
use revolve::user::Routines;
use revolve::variables::Variable;
use revolve::variables::statistic::Statistic;

/// Returns a block of 2 by 2 elements that flies against its fixed foot; its elements fail one after the other. Node
/// numbers are not in the order of definition.
fn block(requests: &str) -> String {
    let grid = grid(2, 2, false, |i, j| [1.0 + i as f64 * (1.0 + 0.3 * j as f64), j as f64]);
    let (first, rest) = grid.split_once(" 1, ").expect("the first node");
    let (line, rest) = rest.split_once('\n').expect("a line");
    let (others, elements) = rest.split_once("*Element").expect("elements");
    first.to_owned()
        + others
        + &format!(" 1, {line}\n*Element{elements}")
        + &material(1000.0, 0.3, 2.0, "*Plastic\n 1., 0.\n 2., 1.\n*Shear Failure\n 0.04,\n")
        + "*Elset, elset=FIRST\n 1,\n*Nset, nset=TIP\n 9,\n*Nset, nset=FOOT\n 1,\n*Initial Conditions, type=VELOCITY\n ALL, 2, -1.\n\
           *Step, name=One\n*Dynamic, Explicit\n , 0.06\n*Boundary\n J0, 2, 2\n"
        + requests
        + "*End Step\n*Step, name=Two\n*Dynamic, Explicit\n , 0.02\n*End Step\n"
}

/// Returns columns and rows of a run.
fn run(requests: &str) -> (Vec<String>, RecordedOutput) {
    let prepared = prepared(&block(requests), &[], &Routines::none());
    let mut memory = RecordedOutput::default();
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    assert_eq!(outcome.halt, None);
    (prepared.plan.columns.iter().map(|c| c.name.clone()).collect(), memory)
}

/// Returns the values of a column.
fn column(columns: &[String], memory: &RecordedOutput, name: &str) -> Vec<f64> {
    let at = columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no {name} among {columns:?}"));
    memory.rows.iter().map(|row| row.1[at]).collect()
}

#[test]
fn statistics_match_member_columns() {
    let all = "statistics=\"MIN, max MEAN, SUM\"";
    let (columns, memory) = run(&format!(
        "*Output, history, number interval=12\n*Element Output, elset=SOLID\n MISES, EVOL, STATUS\n\
         *Element Output, elset=SOLID, {all}\n MISES, EVOL, STATUS\n*Node Output, nset=J1\n U\n*Node Output, nset=J1, {all}\n U\n"
    ));
    let column = |name: String| column(&columns, &memory, &name);
    let of = |variable: &str, members: &[&str]| {
        members.iter().map(|m| column(format!("{variable}@{m}"))).collect::<Vec<_>>()
    };
    let status = of("STATUS", &["1", "2", "3", "4"]);
    let there = |row: usize, e: usize| status[e][row] == 1.0;
    let volume = of("EVOL", &["1", "2", "3", "4"]);
    let rows = memory.rows.len();
    let mut partly = 0;
    for (variable, set, members) in [
        ("MISES", "SOLID", &["1", "2", "3", "4"][..]),
        ("EVOL", "SOLID", &["1", "2", "3", "4"]),
        ("STATUS", "SOLID", &["1", "2", "3", "4"]),
        ("U1", "J1", &["7", "8", "9"]),
        ("U2", "J1", &["7", "8", "9"]),
    ] {
        let each = of(variable, members);
        let found = ["MIN", "MAX", "MEAN", "SUM"].map(|s| column(format!("{variable}_{s}@{set}")));
        for row in 0..rows {
            let counts = |e: &usize| variable == "STATUS" || set == "J1" || there(row, *e);
            let counted: Vec<usize> = (0..members.len()).filter(counts).collect();
            partly += usize::from(counted.len() < members.len() && !counted.is_empty());
            let weight = |e: usize| if variable == "MISES" { volume[e][row] } else { 1.0 };
            let sum: f64 = counted.iter().map(|&e| each[e][row]).sum();
            let weighted: f64 = counted.iter().map(|&e| weight(e) * each[e][row]).sum();
            let mean = weighted / counted.iter().map(|&e| weight(e)).sum::<f64>();
            let least = counted.iter().map(|&e| each[e][row]).fold(f64::NAN, f64::min);
            let most = counted.iter().map(|&e| each[e][row]).fold(f64::NAN, f64::max);
            for (found, expected) in found.iter().zip([least, most, mean, sum]) {
                let same =
                    (found[row] - expected).abs() <= 1e-14 * expected.abs() || found[row].is_nan() && expected.is_nan();
                assert!(same, "{variable} in row {row}: {} and not {expected}", found[row]);
            }
        }
    }
    assert!(partly > 0, "elements are deleted");
}

#[test]
fn rigid_body_reaction_is_counted_once() {
    let rigid = "*Node, nset=REF\n 90, 0., 9.\n*Node, nset=WALLS\n 91, 1., 9.\n 92, 2., 9.\n*Nset, nset=WALLS\n 90,\n\
                 *Element, type=RAX2, elset=WALL\n 90, 90, 91\n 91, 91, 92\n*Rigid Body, ref node=REF, elset=WALL\n\
                 *Element, type=MASS, elset=M\n 93, 90\n*Mass, elset=M\n 1.,\n*Surface, name=FACE\n WALL, SPOS\n";
    let cards = "*Boundary\n REF, 2, 2\n*Dsload\n FACE, P, 3.\n*Output, history, frequency=10\n*Node Output, nset=REF\n RF2\n\
                 *Node Output, nset=WALLS, statistics=SUM\n RF2, COORD\n";
    let deck = block(cards).replacen("*Step", &format!("{rigid}*Step"), 1);
    let prepared = prepared(&deck, &[], &Routines::none());
    let mut memory = RecordedOutput::default();
    solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    let columns: Vec<String> = prepared.plan.columns.iter().map(|c| c.name.clone()).collect();
    let value = |name: &str| column(&columns, &memory, name)[1];
    assert!((value("RF2@REF").abs() / (3.0 * 4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12, "{}", value("RF2@REF"));
    assert_eq!(value("RF2_SUM@WALLS"), value("RF2@REF"));
    assert_eq!(value("COOR2_SUM@WALLS"), 27.0);
}

#[test]
fn members_are_ordered_by_number() {
    let (columns, _) = run("*Output, history\n*Node Output, nset=ALL\n U2\n");
    assert_eq!(columns, (1..=9).map(|n| format!("U2@{n}")).collect::<Vec<_>>());
}

const SHORTENING: &str = "*Output, history, number interval=20\n*Node Output, nset=TIP\n U2\n*Node Output, nset=FOOT\n U2\n\
                          *Node Output, nset=J1, statistics=MEAN\n U2\n*Energy Output\n ALLKE\n";

#[test]
fn expressions_are_evaluated_in_each_row() {
    let (columns, memory) = run(&format!(
        "{SHORTENING}*Output Expression\n shortening = -1000*(U2@TIP - u2@FOOT)\n*Incrementation Output\n DT\n\
         *Output Expression\n Slope = max(SHORTENING, 0)/(1000*time)\n LOG=log(U2_MEAN@J1)\n"
    ));
    assert_eq!(columns[columns.len() - 3..], ["SHORTENING", "SLOPE", "LOG"]);
    let column = |name: &str| column(&columns, &memory, name);
    let (tip, foot, found) = (column("U2@TIP"), column("U2@FOOT"), column("SHORTENING"));
    let (slope, log) = (column("SLOPE"), column("LOG"));
    for (i, (time, _)) in memory.rows.iter().enumerate() {
        assert_eq!(found[i], -1000.0 * (tip[i] - foot[i]));
        // A division by zero and the logarithm of a negative number give no value.
        assert!(slope[i] == found[i].max(0.0) / (1000.0 * time) || *time == 0.0 && slope[i].is_nan());
        assert!(i == 0 || log[i].is_nan());
    }
    assert!(found[found.len() - 1] > 10.0 && slope[1] > 0.0, "{found:?}");
}

/// Expressions apply to all steps, are available to quantities, and are listed in the ledger with their text.
#[test]
fn expressions_are_available_as_columns() {
    let deck = block(SHORTENING).replacen(
        "*Step",
        "*Parameter\n k = 1000\n*Output Expression\n SHORTENING = -<k>*(U2@TIP - U2@FOOT)\n*Step",
        1,
    );
    let prepared = prepared(&deck, &[], &Routines::none());
    let row = prepared.plan.ledger.effects.iter().find(|e| e.effect == "history expression").expect("a row");
    assert_eq!(row.detail, "SHORTENING = -1000*(U2@TIP - U2@FOOT)");
    let quantity = Quantity::parse("at(SHORTENING, 0.01) + 0*final(shortening)").expect("a quantity");
    quantity.check(&prepared.plan).expect("its columns are there");
    let mut history = quantity.history(&prepared.plan);
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut history);
    let own = Quantity::parse("-1000*(at(U2@TIP, 0.01) - at(U2@FOOT, 0.01))").expect("a quantity");
    let [found, expected] =
        [&quantity, &own].map(|q| q.number(FinishedRun { history: &history, end: None }).expect("a number"));
    assert!((found / expected - 1.0).abs() < 1e-12 && outcome.halt.is_none(), "{found} {expected}");
}

/// Names as ABAQUS/CAE writes them, with hyphens and periods.
#[test]
fn instance_names_with_hyphens_and_points_are_read() {
    let part = format!(
        "*Part, name=BAR\n{}*End Part\n",
        grid(1, 1, false, |i, j| [i as f64, j as f64]) + "*Solid Section, elset=SOLID, material=M\n"
    );
    let deck = part
        + "*Assembly, name=A\n*Instance, name=BAR-1, part=BAR\n*End Instance\n*Instance, name=BAR-1-2, part=BAR\n 3., 0., 0.\n*End Instance\n\
           *Nset, nset=PAIR, instance=BAR-1\n 3, 4\n*End Assembly\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.\n\
           *Initial Conditions, type=VELOCITY\n PAIR, 2, 0.1\n*Step\n*Dynamic, Explicit\n , 0.1\n*Output, history, frequency=1\n\
           *Node Output, nset=PAIR\n U2\n*Node Output, nset=BAR-1-2.J1\n U2\n\
           *Output Expression\n D = U2@BAR-1.4-1.5*U2@BAR-1-2.4\n*End Step\n";
    let prepared = prepared(&deck, &[], &Routines::none());
    let mut memory = RecordedOutput::default();
    solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    let columns: Vec<String> = prepared.plan.columns.iter().map(|c| c.name.clone()).collect();
    let [d, a, b] = ["D", "U2@BAR-1.4", "U2@BAR-1-2.4"].map(|name| column(&columns, &memory, name));
    assert!(d.iter().zip(a.iter().zip(&b)).all(|(d, (a, b))| *d == a - 1.5 * b) && a[1] > 0.0);
}

fn findings(requests: &str) -> String {
    let prepared = job::prepare_text("test.inp", &block(requests), &Vec::new(), &Routines::none());
    prepared.diagnostics.render(&prepared.deck.sources)
}

#[test]
fn errors_are_reported_with_their_place() {
    let expression = |line: &str| findings(&format!("{SHORTENING}*Output Expression\n {line}\n"));
    for (line, message_text) in [
        (
            "S = 2*(U2@TOP - U2@FOOT)",
            &["error[P075]: history column `U2@TOP` does not exist", "did you mean U2@TIP?", "^^^^^^"][..],
        ),
        ("S = 2*(U2@TIP", &["P075", "missing closing parenthesis"]),
        ("S = sqroot(U2@TIP)", &["P075", "did you mean `sqrt`"]),
        ("S = ", &["P075", "the expression ends"]),
        ("2*U2@TIP", &["M171", "no equals sign"]),
        ("U2@X = U2@TIP", &["M171", "a name consists"]),
        ("ALLKE = U2@TIP", &["P076", "already used"]),
        ("time = U2@TIP", &["P076", "reserved"]),
        ("A = B\n B = ALLKE", &["P075", "history column `B` does not exist"]),
        ("A = ALLKE\n A = ALLKE", &["P076"]),
    ] {
        let found = expression(line);
        assert!(message_text.iter().all(|t| found.contains(t)), "{line}: {found}");
    }
    let requested = "error[M103]";
    for (requests, message_text) in [
        ("*Output, history\n*Node Output, nset=J1, statistics=MEDIAN\n U2\n", "MIN, MAX, MEAN or SUM"),
        ("*Output, history\n*Node Output, nset=J1, statistics=\"MIN, MEDIAN\"\n U2\n", "MIN, MAX, MEAN or SUM"),
        ("*Output, field\n*Node Output, nset=J1, statistics=MIN\n U\n", "requires *OUTPUT, HISTORY and a set"),
        ("*Output, history\n*Element Output, statistics=MIN\n S\n", "requires *OUTPUT, HISTORY and a set"),
    ] {
        let found = findings(requests);
        assert!(found.contains(requested) && found.contains(message_text), "{requests}: {found}");
    }
}

/// The same model built in Rust, without a deck.
#[test]
fn models_in_rust_have_statistics_and_expressions() {
    let (deck, _) =
        revolve::deck::read_text("test.inp", &block("*Output, history\n*Energy Output\n ALLKE\n"), &Vec::new());
    let (mut model, _) = revolve::model::build(&deck);
    let joint = NodeSetId::new(model.node_sets.get_index_of("J1").expect("the set"));
    let statistics =
        OutputRequest::history(OutputRegion::Nodes(joint), [Variable::Displacement]).with_statistics(&[Statistic::Max]);
    model.steps[0].outputs.push(statistics);
    model.output.expressions.push(OutputExpression::new("twice", "2*U2_MAX@J1"));
    let prepared = job::prepare_model(&model, &Routines::none());
    let names: Vec<&str> = prepared.plan.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["ALLKE", "U1_MAX@J1", "U2_MAX@J1", "TWICE"]);
    model.output.expressions[0].text = "2*U2@J1".into();
    assert!(job::prepare_model(&model, &Routines::none()).diagnostics.iter().any(|d| d.code == "P075"));
}
