//! The keyword table compared with the program: each parameter and field that is used changes the results, each
//! unsupported one is rejected with the reason, each ignored one is listed in the ledger.
//!
//! Goal: no input is parsed and silently ignored. Source: the table itself; `words/pairs.txt` has for each used entry
//! two decks that differ only in this entry.

mod scenes;
mod together;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use self::scenes::pairs;
use crate::common::{self, RecordedOutput};
use revolve::deck::keywords::{DataShape, InputRule, InputUsage, Keyword, KeywordTier, keywords};
use revolve::deck::value::{FLAG, ValueKind};
use revolve::deck::{self, Card, DataLine, Deck};
use revolve::job::{self, PreparedJob};
use revolve::solve;
use revolve::user::{
    AmplitudeAnswer, AmplitudeCall, EnergyAnswer, EnergyCall, EosLaw, EosResponse, FieldAnswer, FieldCall,
    FrictionCall, HardeningAnswer, HardeningCall, LengthCall, LoadFailure, LoadPoints, MaterialAnswer, MaterialCall,
    MotionCall, NodalFieldCall, Routines, UserAmplitude, UserEnergy, UserFields, UserFriction, UserHardening,
    UserLengths, UserLoad, UserMaterial, UserMotion, UserNodalFields,
};

/// Returns every entry of the table with its name, `KEYWORD, PARAMETER` or `KEYWORD, field`.
fn entries() -> Vec<(String, &'static Keyword, &'static InputRule)> {
    let mut all = Vec::new();
    for keyword in keywords().filter(|k| k.tier == KeywordTier::Used) {
        let fields = keyword.data.iter().flat_map(|d| d.shape.rules());
        for rule in keyword.parameters.iter().chain(fields) {
            all.push((format!("{}, {}", keyword.name, rule.name), keyword, rule));
        }
    }
    all
}

/// User subroutines whose answers depend on all their arguments.
struct TestSubroutines;

impl UserLoad for TestSubroutines {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(2.0 * points.amplitude);
        Ok(())
    }
}

/// Linear in the density, with the bulk modulus and the density without pressure as constants.
impl EosLaw for TestSubroutines {
    fn respond(&self, constants: &[f64], density: f64, energy: f64) -> EosResponse {
        let [bulk, reference] = [0, 1].map(|i| constants.get(i).copied().unwrap_or(1.0));
        EosResponse {
            pressure: bulk * (density / reference - 1.0) + density * energy,
            sound_speed: (bulk / reference).sqrt(),
        }
    }
}

impl UserMotion for TestSubroutines {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        Ok(0.3 * call.now.total_time)
    }
}

impl UserAmplitude for TestSubroutines {
    fn amplitude(&mut self, call: &mut AmplitudeCall<'_>) -> Result<AmplitudeAnswer, LoadFailure> {
        let value = call.properties[0] * call.variables.len() as f64;
        Ok(AmplitudeAnswer { value, ..AmplitudeAnswer::default() })
    }
}

/// Elastic stress with one modulus; sets the first state variable, and the second, which deletes the element, to zero.
impl UserMaterial for TestSubroutines {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        for (i, stress) in answer.stress.iter_mut().enumerate() {
            *stress = call.stress[i] + call.properties[0] * (1.0 + call.properties[1]) * call.strain[i];
        }
        answer.state.fill(call.variables as f64);
        if call.now.total_time > 0.2 && call.variables > 1 {
            answer.state[call.count..2 * call.count].fill(0.0);
        }
        Ok(())
    }
}

/// Yield stress from two constants, the number of constants, and the state and field variables.
impl UserHardening for TestSubroutines {
    fn yield_stress(&mut self, call: &HardeningCall<'_>, answer: &mut HardeningAnswer<'_>) -> Result<(), LoadFailure> {
        let (first, second) = (call.properties.first().unwrap_or(&1.0), call.properties.get(1).unwrap_or(&1.0));
        for i in 0..call.count {
            let more = call.state.get(i).unwrap_or(&0.0)
                + call.field[1].get((call.fields.max(1) - 1) * call.count + i).unwrap_or(&0.0);
            answer.stress[i] = first + second * call.strain[i] + 0.1 * call.properties.len() as f64 + 0.1 * more;
        }
        Ok(())
    }
}

/// Sets the first field variable to the first constant.
impl UserFields for TestSubroutines {
    fn fields(&mut self, call: &FieldCall<'_>, answer: &mut FieldAnswer<'_>) -> Result<(), LoadFailure> {
        let value = call.properties.first().unwrap_or(&1.0) + call.properties.len() as f64;
        answer.field[..call.count].fill(value);
        Ok(())
    }
}

/// Returns Coulomb friction with the sum of the constants plus a tenth of the number of state variables.
impl UserFriction for TestSubroutines {
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], _: &mut [f64]) -> Result<(), LoadFailure> {
        let coefficient = call.properties.iter().sum::<f64>() + 0.1 * call.variables as f64;
        for (point, force) in forces.chunks_mut(2).enumerate() {
            force[0] = -(coefficient * call.normal[point]).min(call.stick[point]);
        }
        Ok(())
    }
}

/// Neo-Hooke with the constants C10 and bulk modulus.
impl UserEnergy for TestSubroutines {
    fn energy(&mut self, call: &EnergyCall<'_>, answer: &mut EnergyAnswer<'_>) -> Result<(), LoadFailure> {
        let n = call.count;
        answer.first[..n].fill(call.properties[0]);
        answer.second[5 * n..6 * n].fill(call.properties[1]);
        for point in 0..n {
            answer.first[2 * n + point] = call.properties[1] * (call.invariants[2 * n + point] - 1.0);
        }
        Ok(())
    }
}

/// Sets variables to half of their number.
impl UserNodalFields for TestSubroutines {
    fn nodal_fields(&mut self, call: &NodalFieldCall<'_>, values: &mut [f64]) -> Result<(), LoadFailure> {
        let value = |at: usize| 0.5 * (call.variables[0] + at / call.nodes.len()) as f64;
        values.iter_mut().enumerate().for_each(|(at, result)| *result = value(at));
        Ok(())
    }
}

/// Returns the default length times the first constant.
impl UserLengths for TestSubroutines {
    fn lengths(&mut self, call: &LengthCall<'_>, lengths: &mut [f64]) -> Result<(), LoadFailure> {
        lengths.iter_mut().for_each(|length| *length *= call.properties.first().unwrap_or(&1.0));
        Ok(())
    }
}

/// Returns the user subroutines of the tests.
fn test_subroutines() -> Routines {
    let routines = Routines::none()
        .with_load(TestSubroutines)
        .with_motion(TestSubroutines)
        .with_amplitude(TestSubroutines)
        .with_material(TestSubroutines)
        .with_eos("METAL", TestSubroutines);
    let routines = routines.with_hardening(TestSubroutines).with_fields(TestSubroutines).with_lengths(TestSubroutines);
    routines.with_nodal_fields(TestSubroutines).with_friction(TestSubroutines).with_energy(TestSubroutines)
}

/// Prepares a deck in a folder.
fn prepare(folder: &Path, text: &str, routines: &Routines) -> PreparedJob {
    job::prepare_text(&folder.join("pair.inp").display().to_string(), text, &[], routines)
}

/// Returns all results of a deck with the subroutines of the tests, without the places of diagnostics and ledger rows.
fn results(folder: &Path, text: &str) -> String {
    results_of(&prepare(folder, text, &test_subroutines()))
}

fn results_of(prepared: &PreparedJob) -> String {
    let mut message_text = String::new();
    for finding in prepared.diagnostics.iter() {
        writeln!(message_text, "{} {} {:?}", finding.code, finding.message, finding.help).expect("text");
    }
    if prepared.diagnostics.has_errors() {
        return message_text;
    }
    writeln!(message_text, "{:?} {:?}", prepared.title, prepared.units).expect("text");
    for row in &prepared.plan.ledger.effects {
        writeln!(message_text, "{} {} {} {}", row.effect, row.count, row.unit, row.detail).expect("text");
    }
    for step in &prepared.plan.steps {
        writeln!(message_text, "{:?}", step.outputs.restart).expect("text");
    }
    writeln!(message_text, "{:?}", prepared.plan.columns).expect("text");
    let mut memory = RecordedOutput::default();
    let (outcome, _) = solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
    writeln!(message_text, "{} {:?} {:?} {:?}", outcome.digest, outcome.halt, outcome.steps, outcome.warnings)
        .expect("text");
    writeln!(message_text, "{:?} {:?}", memory.rows, memory.frames).expect("text");
    message_text
}

/// Writes the files that the pairs refer to.
fn files(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file");
    for (name, value) in [("a", "1."), ("b", "1.5")] {
        write(&format!("{name}.inc"), &format!("*Initial Conditions, type=VELOCITY\n MID, 2, {value}\n"));
        write(&format!("{name}.node"), &format!(" 9, 2., {value}\n"));
        write(&format!("{name}.field"), &format!(" TOP, {value}\n"));
        write(&format!("{name}.start"), &format!(" TOP, 2, {value}\n"));
        write(&format!("{name}.equation"), &format!(" 2\n 7, 2, {value}, 8, 2, -1.\n"));
        write(&format!("{name}.amplitude"), &format!(" 0., 0., 1., {value}\n"));
    }
    write("a.points", " 0.1, 0.3\n");
    write("b.points", " 0.1, 0.4\n");
    write("a.mpc", " TIE, 7, 8\n");
    write("b.mpc", " TIE, 7, 5\n");
    write("a.element", " 4, 5, 6, 9, 8\n");
    write("b.element", " 4, 5, 6, 9, 7\n");
    let array = |name: &str, kind: &str, parts: &str, values: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{parts}\" format=\"ascii\">{values}</DataArray>"
        )
    };
    let mesh = |width: &str| {
        format!(
            "<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid>\
         <Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData/><CellData>{}</CellData><Points>{}</Points><Cells>{}{}{}</Cells></Piece>\
         </UnstructuredGrid></VTKFile>",
            array("ELSET_M", "Int64", "1", "1"),
            array("Points", "Float64", "3", &format!("5 0 0 {width} 0 0 {width} 1 0 5 1 0")),
            array("connectivity", "Int64", "1", "0 1 2 3"),
            array("offsets", "Int64", "1", "4"),
            array("types", "UInt8", "1", "9"),
        )
    };
    write("a.vtu", &mesh("6"));
    write("b.vtu", &mesh("7"));
}

/// Returns the entries in which two decks differ.
fn differences(a: &Deck, b: &Deck) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let cards = |deck: &Deck| deck.cards.iter().map(|c| c.keyword.name).collect::<Vec<_>>();
    assert_eq!(cards(a), cards(b), "the decks have the same cards");
    let (sources_a, sources_b) = (&a.sources, &b.sources);
    for (a, b) in a.cards.iter().zip(&b.cards) {
        let values = |card: &Card| -> BTreeMap<&str, Option<String>> {
            card.parameters.iter().map(|p| (p.name, p.value.as_ref().map(|w| w.text.clone()))).collect()
        };
        let (of_a, of_b) = (values(a), values(b));
        let names = of_a.keys().chain(of_b.keys()).filter(|name| of_a.get(*name) != of_b.get(*name));
        found.extend(names.map(|name| format!("{}, {name}", a.keyword.name)));
        let mut before = 0;
        let [lines_a, lines_b] =
            [(a, sources_a), (b, sources_b)].map(|(card, sources)| card.data(sources).collect::<Vec<_>>());
        for i in 0..lines_a.len().max(lines_b.len()) {
            let field = |lines: &[Cow<'_, DataLine>], k: usize| {
                lines.get(i).and_then(|l| l.field(k)).map_or(String::new(), |w| w.text.clone())
            };
            let count = [&lines_a, &lines_b].iter().filter_map(|l| l.get(i)).map(|l| l.fields.len()).max().unwrap_or(0);
            for k in (0..count).filter(|&k| field(&lines_a, k) != field(&lines_b, k)) {
                let rule = a.shape().field(i, k, before).or(b.shape().field(i, k, before)).map_or("?", |r| r.name);
                found.insert(format!("{}, {rule}", a.keyword.name));
            }
            if matches!(a.shape(), DataShape::Stream(_)) {
                before += count;
            }
        }
    }
    found
}

#[test]
fn used_entries_change_results() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let mut tried = BTreeSet::new();
    let mut faults = Vec::new();
    for pair in pairs() {
        let [a, b] = pair.texts.each_ref().map(|text| results(folder.path(), text));
        if a == b {
            faults.push(format!(
                "{}: nothing changes:\n{}",
                pair.name,
                a.lines().take(3).collect::<Vec<_>>().join("\n")
            ));
        }
        let [deck_a, deck_b] = pair
            .texts
            .each_ref()
            .map(|t| deck::read_text(&folder.path().join("pair.inp").display().to_string(), t, &[]).0);
        // The values of *INCLUDE and *PARAMETER, and the contents of INPUT= files, appear in later cards.
        let elsewhere =
            pair.name.starts_with("INCLUDE") || pair.name.starts_with("PARAMETER") || pair.name.ends_with(", INPUT");
        let differ = differences(&deck_a, &deck_b);
        if !elsewhere && differ != BTreeSet::from([pair.name.clone()]) {
            faults.push(format!("{}: the pair differs in {differ:?}", pair.name));
        }
        tried.insert(pair.name);
    }
    let read: BTreeSet<String> =
        entries().into_iter().filter(|(.., rule)| rule.usage == InputUsage::Read).map(|(name, ..)| name).collect();
    faults.extend(read.difference(&tried).map(|name| format!("{name}: is read, and no pair shows it")));
    faults.extend(tried.difference(&read).map(|name| format!("{name}: a pair of what is not read")));
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// A flag with YES is the flag, with NO it is not given: for each flag in the decks of the pairs.
#[test]
fn flags_accept_yes_and_no() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let flags: BTreeSet<String> =
        entries().into_iter().filter(|(.., rule)| rule.value == FLAG).map(|(name, ..)| name).collect();
    let mut tried = BTreeSet::new();
    for pair in pairs().into_iter().filter(|pair| flags.contains(&pair.name)) {
        for text in &pair.texts {
            let (deck, _) = deck::read_text("pair.inp", text, &[]);
            let (keyword, flag) = pair.name.split_once(", ").expect("a parameter");
            let cards = deck.cards.iter().filter(|card| card.keyword.name == keyword);
            let Some(at) = cards.filter_map(|card| card.parameter(flag)).next() else { continue };
            let end = at.value.as_ref().map_or(at.span.end, |word| word.span.end) as usize;
            let (before, after) = (&text[..at.span.start as usize], &text[end..]);
            let name = text[at.span.start as usize..end].split('=').next().unwrap_or_default();
            let given = |value: &str| results(folder.path(), &format!("{before}{name}{value}{after}"));
            let comma = before.rfind(',').expect("a comma before the flag");
            assert_eq!(given("=YES"), given(""), "{}=YES", pair.name);
            assert_eq!(
                given("=NO"),
                results(folder.path(), &format!("{}{after}", &before[..comma])),
                "{}=NO",
                pair.name
            );
            tried.insert(pair.name.clone());
        }
    }
    let untried: Vec<&String> = flags.difference(&tried).collect();
    assert!(untried.is_empty(), "{untried:?}");
}

/// Parameters that need a value are errors without one.
#[test]
fn parameters_without_their_value_are_rejected() {
    for (name, keyword, rule) in entries() {
        let is_parameter = keyword.parameters.iter().any(|r| std::ptr::eq(r, rule));
        let is_include = keyword.name == "INCLUDE";
        if !is_parameter || is_include || rule.usage != InputUsage::Read || rule.value.bare.is_some() {
            continue;
        }
        let found = rendered(&format!("*{}, {}\n", keyword.name, rule.name));
        assert!(found.iter().any(|(code, _)| code == "M103" || code == "M101"), "{name}: {found:?}");
    }
}

/// A value that no parameter or field accepts.
const STRANGE: &str = "77";

/// Returns the codes and help texts of the diagnostics of one card.
fn rendered(text: &str) -> Vec<(String, String)> {
    let (deck, mut diagnostics) = deck::read_text("card.inp", text, &[]);
    let (_, found) = revolve::model::build(&deck);
    diagnostics.append(found);
    diagnostics.iter().map(|d| (d.code.to_owned(), d.help.clone().unwrap_or_default())).collect()
}

/// Returns the card with a value in one field; `None` for rules of parameters.
fn with_field(keyword: &Keyword, rule: &InputRule, value: &str) -> Option<String> {
    for data in keyword.data {
        let DataShape::Lines(lines, _) = &data.shape else { continue };
        for (i, line) in lines.iter().enumerate() {
            let Some(k) = line.iter().position(|r| std::ptr::eq(r, rule)) else { continue };
            let when = data.when.map_or(String::new(), |(name, values)| match values {
                [] => format!(", {name}"),
                [value, ..] => format!(", {name}={value}"),
            });
            let above = "1,\n".repeat(i);
            return Some(format!("*{}{when}\n{above}{}{value}\n", keyword.name, ",".repeat(k)));
        }
    }
    None
}

#[test]
fn unsupported_entries_are_rejected_with_a_reason() {
    for (name, keyword, rule) in entries() {
        let (accepted, why) = match rule.usage {
            InputUsage::Refused(why) => (&[][..], why),
            InputUsage::Only(values, why) => (values, why),
            _ => continue,
        };
        let of_text = keyword.parameters.iter().any(|r| std::ptr::eq(r, rule));
        let card = |value: &str| match of_text {
            true => format!("*{}, {}={value}\n", keyword.name, rule.name),
            false => with_field(keyword, rule, value).expect("a field"),
        };
        let refused = |text: &str| rendered(text).iter().any(|(_, help)| help == why);
        assert!(refused(&card(STRANGE)), "{name}: {:?}", rendered(&card(STRANGE)));
        for value in accepted {
            assert!(!refused(&card(value)), "{name}={value}: {:?}", rendered(&card(value)));
        }
    }
}

/// Returns a number outside the valid range, if there is one.
fn out_of_range(rule: &InputRule) -> Option<f64> {
    let checked = matches!(rule.value.kind, ValueKind::Number | ValueKind::Integer);
    [-1000.0, 1e6, 0.0].into_iter().find(|number| checked && !rule.value.allows(*number))
}

#[test]
fn values_out_of_range_are_rejected_with_the_range() {
    let mut tried = 0;
    for (name, keyword, rule) in entries() {
        let Some(number) = out_of_range(rule) else { continue };
        let parameter = keyword.parameters.iter().any(|r| std::ptr::eq(r, rule));
        let text = match parameter {
            true => Some(format!("*{}, {}={number}\n", keyword.name, rule.name)),
            false => with_field(keyword, rule, &format!("{number}")),
        };
        let Some(text) = text else { continue };
        let (deck, mut diagnostics) = deck::read_text("card.inp", &text, &[]);
        diagnostics.append(revolve::model::build(&deck).1);
        if diagnostics.iter().any(|d| d.message.contains("requires a value")) {
            continue;
        }
        let range = format!("must be {}, found {number}", rule.value.allowed());
        assert!(diagnostics.iter().any(|d| d.code == "M103" && d.message.contains(&range)), "{name}: {diagnostics:?}");
        tried += 1;
    }
    assert!(tried > 80, "{tried}");
}

#[test]
fn ignored_entries_are_listed_in_the_ledger() {
    for (name, keyword, rule) in entries() {
        let InputUsage::Inert(note) = rule.usage else { continue };
        let text = match keyword.parameters.iter().any(|r| std::ptr::eq(r, rule)) {
            true => format!("*{}, {}=1\n", keyword.name, rule.name),
            false => with_field(keyword, rule, "1").unwrap_or_else(|| format!("*{}\nwords\n", keyword.name)),
        };
        let (deck, _) = deck::read_text("card.inp", &text, &[]);
        let (model, _) = revolve::model::build(&deck);
        let plan = revolve::plan::compile(&model, &Routines::none()).plan;
        let message_text = plan.ledger.unused.iter().find(|u| u.what == format!("*{name}"));
        assert_eq!(message_text.map(|u| u.why.as_str()), Some(note), "{text}: {:?}", plan.ledger.unused);
    }
    for keyword in keywords() {
        let KeywordTier::Inert(why) = keyword.tier else { continue };
        let (deck, _) = deck::read_text("card.inp", &format!("*{}\n", keyword.name), &[]);
        let (model, _) = revolve::model::build(&deck);
        assert!(model.origin.inert.iter().any(|i| i.keyword == keyword.name && i.why == why), "{}", keyword.name);
    }
}

const RATE: &str = "*Rate Dependent, type=power law\n 40., 5.";

/// Initial temperatures, field variables and rate dependence are listed as unused if no material depends on them.
#[test]
fn input_that_nothing_reads_is_listed() {
    let text = std::fs::read_to_string(common::project("tests/deck/words/solid.inp")).expect("a deck");
    let text = text.replace("**model", "*Initial Conditions, type=FIELD, variable=1\n ALL, 0.5");
    let unused = |to: &str| {
        let (deck, _) = deck::read_text("solid.inp", &text.replace(" 100., 0.3\n", to), &[]);
        let plan = revolve::plan::compile(&revolve::model::build(&deck).0, &Routines::none()).plan;
        ["TYPE=TEMPERATURE", "TYPE=FIELD"].map(|what| plan.ledger.unused.iter().any(|u| u.what.ends_with(what)))
    };
    let (deck, _) = deck::read_text("solid.inp", &text.replace("*Plastic\n 0.5, 0.\n 2., 1.", RATE), &[]);
    let plan = revolve::plan::compile(&revolve::model::build(&deck).0, &Routines::none()).plan;
    assert!(plan.ledger.unused.iter().any(|u| u.what == "*RATE DEPENDENT"));
    assert_eq!(unused(" 100., 0.3\n"), [true, true]);
    assert_eq!(unused(" 100., 0.3, 0.\n 90., 0.3, 100.\n"), [false, true]);
    let of_field = "*Elastic, dependencies=1\n 100., 0.3, , 0.\n 90., 0.3, , 1.\n";
    let (deck, _) = deck::read_text("solid.inp", &text.replace("*Elastic\n 100., 0.3\n", of_field), &[]);
    let plan = revolve::plan::compile(&revolve::model::build(&deck).0, &Routines::none()).plan;
    assert!(!plan.ledger.unused.iter().any(|u| u.what.ends_with("TYPE=FIELD")));
}

/// Surplus values, surplus lines, a second card, a decimal comma, incomplete data lines.
#[test]
fn surplus_and_repeated_input_is_reported() {
    let solid = std::fs::read_to_string(common::project("tests/deck/words/solid.inp")).expect("a deck");
    for (from, to, code) in [
        ("100., 0.3", "100., 0.3, 20., 7.", "M161"),
        ("0.5, 0.\n 2., 1.", "0.5, 0., 2., 1.", "M161"),
        (" 4, 5, 6, 9, 8", " 4, 5, 6, 9, 8, 7", "M161"),
        ("TOP, 2, -1.", "TOP, 2, -1., 3.", "M161"),
        ("**model", "**model\n*Equation\n 2, 7\n 7, 1, 1., 8, 1, -1.", "M161"),
        ("FACE, P, 1.", "FACE, P, 1., 5", "M161"),
        ("*Density\n 1.,", "*Density\n 1,5", "M163"),
        (", 0.5\n", ", 0.5\n , 0.6\n", "M162"),
        ("**model", "**model\n*Node\n 9, 2., 2.", "M164"),
        ("**model", "**model\n*Node\n 9, 1.2, 1.2", "M123"),
        ("**material", "*Density\n 1.,", "M160"),
        ("**model", "**model\n*Material, name=metal", "M160"),
        ("**step", "*Dynamic, Explicit\n , 0.5", "M160"),
        ("**model", "**model\n*Surface, name=FACE\n LOWER, S3", "M160"),
        ("**model", "**model\n*Friction\n 0.1", "M105"),
        ("**material", "*Solid Section, elset=UPPER, material=METAL", "M165"),
        ("**model", "**model\n*Nset, nset=LONG, generate\n 7, 12, 1", "M166"),
        (" BOTTOM, 2, 2", " BOTTOM, YSYMM, 7.", "M161"),
        ("number interval=2", "number interval=2, frequency=3", "M167"),
        ("*Output, field", "*Output, field, history", "M167"),
        ("**model", "**model\n*Amplitude, name=A, begin=1.\n 0., 0., 1., 1.", "M167"),
        ("*End Step\n", "*End Step\n*Boundary\n TOP, 2, 2\n", "M105"),
        ("*End Step\n", "*End Step\n*Contact\n*Contact Inclusions, all exterior\n", "M105"),
        ("**step", "**step\n*Contact", "M154"),
        ("type=CAX4R, elset=BODY", "type=RAX2, elset=BODY", "M180"),
        ("material=METAL", "material=METAL, controls=NONE", "M116"),
        ("*Dsload", "*Dsload, friction=0.1", "M104"),
        ("*Dsload\n FACE, P, 1.", "*Dload\n UPPER, P3, 1., 2.", "M161"),
        (" 9, 2., 2.", " 9, 2., 2., 1.", "M104"),
        ("*Elastic\n 100., 0.3", "*Elastic, dependencies=1\n 100., 0.3, , 0., 7.\n 90., 0.3, , 1.", "M161"),
        ("*Plastic\n 0.5, 0.\n 2., 1.", "*Plastic, dependencies=1\n 0.5, 0., , 0., 7.\n 2., 1., , 0.", "M161"),
        (" TOP, 2, -1.\n", " TOP, 2, -1.\n TOP, 2, -2.\n", "M160"),
        (" ALL, 20.\n", " ALL, 20.\n*Initial Conditions, type=TEMPERATURE\n ALL, 30.\n", "M160"),
        ("*Nset, nset=MID", "*Nset, nset=MID, instance=NONE", "M115"),
        (
            "**model",
            "**model\n*Surface Interaction, name=I\n*Gap Conductance\n 1., 0.\n 0., 1.\n*Gap Conductance\n 2., 0.\n 0., 1.",
            "M160",
        ),
        (
            "**model",
            "**model\n*Rigid Surface, type=SEGMENTS, name=W\n START, 0., -1.\n LINE, 1., -1.\n*Rigid Surface, type=SEGMENTS, name=W\n START, 0., -1.\n LINE, 2., -1.",
            "M160",
        ),
    ] {
        assert!(solid.contains(from), "{from}");
        let codes: Vec<String> = rendered(&solid.replacen(from, to, 1)).into_iter().map(|c| c.0).collect();
        assert!(codes.iter().any(|c| c == code), "{to}: {codes:?}, not {code}");
    }
    assert!(rendered(&solid).is_empty(), "{:?}", rendered(&solid));
}

/// Returns what the ledger of a deck lists as unused, without places.
fn unused_input(text: &str) -> Vec<String> {
    let (deck, _) = deck::read_text("pair.inp", text, &[]);
    let plan = revolve::plan::compile(&revolve::model::build(&deck).0, &Routines::none()).plan;
    plan.ledger.unused.iter().map(|card| format!("{}: {}", card.what, card.why)).collect()
}

/// Returns the text of a card with its data lines.
fn block<'t>(text: &'t str, deck: &Deck, index: usize) -> &'t str {
    let line = |at: u32| text[..at as usize].rfind('\n').map_or(0, |newline| newline + 1);
    let start = line(deck.cards[index].span.start);
    let end = deck.cards.get(index + 1).map_or(text.len(), |next| line(next.span.start));
    &text[start..end]
}

/// Two cards with different values are both in effect, or there is a message: in neither order does only the first, or only
/// the second, determine all results and messages.
#[test]
fn a_second_card_is_never_ignored_silently() {
    let folder = tempfile::tempdir().expect("a folder");
    files(folder.path());
    let (mut faults, mut count) = (Vec::new(), 0);
    for pair in pairs() {
        let keyword = pair.name.split(", ").next().expect("a keyword");
        // It applies to the nodes that follow.
        if keyword == "SYSTEM" {
            continue;
        }
        let decks = pair.texts.each_ref().map(|text| deck::read_text("pair.inp", text, &[]).0);
        let blocks = [0, 1].map(|of| {
            let of_keyword = (0..decks[of].cards.len()).filter(|&c| decks[of].cards[c].keyword.name == keyword);
            of_keyword.map(|card| block(&pair.texts[of], &decks[of], card)).collect::<Vec<_>>()
        });
        let Some((first, second)) = blocks[0].iter().zip(&blocks[1]).find(|(a, b)| a != b) else { continue };
        let told = |text: &str| (results(folder.path(), text), unused_input(text));
        let [alone, other] = pair.texts.each_ref().map(|text| told(text));
        let together = |blocks: String| told(&pair.texts[0].replacen(first, &blocks, 1));
        let both = [together(format!("{first}{second}")), together(format!("{second}{first}"))];
        count += 1;
        for (which, of_order) in [("first", [&other, &alone]), ("second", [&alone, &other])] {
            if both.each_ref() == of_order {
                faults.push(format!("{}: the {which} of two cards has no effect without a message", pair.name));
            }
        }
    }
    println!("{count} cards given twice");
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// Cards and parameters that nothing in a deck uses are listed with the reason.
#[test]
fn input_that_nothing_uses_is_listed() {
    let base = std::fs::read_to_string(common::project("tests/deck/words/solid.inp")).expect("a deck");
    let with = |mark: &str, lines: &str| base.replacen(&format!("**{mark}\n"), &format!("**{mark}\n{lines}\n"), 1);
    for (text, what) in [
        (with("model", "*Amplitude, name=A9\n 0., 0., 1., 1."), "*AMPLITUDE"),
        (with("model", "*Section Controls, name=S9, hourglass=STIFFNESS"), "*SECTION CONTROLS"),
        (with("model", "*Surface Interaction, name=I9"), "*SURFACE INTERACTION"),
        (with("model", "*Time Points, name=T9\n 0.1,"), "*TIME POINTS"),
        (with("model", "*Contact Clearance, name=C9, clearance=0.1"), "*CONTACT CLEARANCE"),
        (with("model", "*Adaptive Mesh Controls, name=M9"), "*ADAPTIVE MESH CONTROLS"),
        (
            with("model", "*Incident Wave Interaction Property, name=W9, type=AIR BLAST"),
            "*INCIDENT WAVE INTERACTION PROPERTY",
        ),
        (with("model", "*Physical Constants, absolute zero=-273."), "*PHYSICAL CONSTANTS, ABSOLUTE ZERO"),
        (with("material", "*Characteristic Length"), "*CHARACTERISTIC LENGTH"),
        (with("step", "*Output, field"), "*OUTPUT"),
        (base.replacen("*Dynamic, Explicit", "*Dynamic, Explicit, global=NO", 1), "*DYNAMIC, GLOBAL"),
    ] {
        let (deck, found) = deck::read_text("card.inp", &text, &[]);
        assert!(!found.has_errors(), "{}\n{text}", found.render(&deck.sources));
        let (model, found) = revolve::model::build(&deck);
        assert!(!found.has_errors(), "{}", found.render(&deck.sources));
        let plan = revolve::plan::compile(&model, &Routines::none()).plan;
        assert!(plan.ledger.unused.iter().any(|card| card.what == what), "{what}: {:?}", plan.ledger.unused);
    }
}
