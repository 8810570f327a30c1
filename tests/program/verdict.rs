//! Verdicts of runs: decks that are right are never suspect, and decks that are wrong in one place are never ok.
//!
//! Goal: a script can trust the word. Source of the right word: each wrong deck is a right one with one known mistake (units,
//! contact, increments, hourglass control, mass scaling, constants beyond their range).

use serde_json::Value;

use crate::common::{project, revolve};

/// A deck of `input/` with changes of its text and settings.
struct Case {
    /// Name below `input`.
    deck: &'static str,
    changes: &'static [(&'static str, &'static str)],
    settings: &'static [&'static str],
    /// Code of the reason that the run must give; empty for right decks.
    code: &'static str,
}

/// Returns a deck without changes.
const fn right(deck: &'static str, settings: &'static [&'static str]) -> Case {
    Case { deck, changes: &[], settings, code: "" }
}

/// Returns a deck with one mistake.
const fn wrong(
    deck: &'static str,
    changes: &'static [(&'static str, &'static str)],
    settings: &'static [&'static str],
    code: &'static str,
) -> Case {
    Case { deck, changes, settings, code }
}

const TAYLOR_BARS: &str = "validation/taylor_bars";

/// The Taylor bar of `taylor_copper.inp` with the ready material.
const READY: &[(&str, &str)] = &[
    (
        "*Material, name=COPPER\n*Density\n 8930.\n*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 500.e6, 1.\n 600.e6, 2.\n \
         900.e6, 5.\n",
        "*Include, input=materials/copper_ofhc.inp\n*Initial Conditions, type=TEMPERATURE\n BAR, <T0>\n",
    ),
    ("material=COPPER", "material=COPPER_OFHC"),
    ("*Dynamic, Explicit", "*Dynamic, Explicit, adiabatic"),
    ("nr = 10", "nr = 5"),
    ("nz = 50", "nz = 25\nT0 = 298."),
];

const RIGHT: &[Case] = &[
    right("taylor_copper", &["nr=6", "nz=30"]),
    right("taylor_copper", &["nr=6", "nz=30", "speed=130"]),
    Case { changes: READY, ..right("taylor_copper", &["speed=130"]) },
    Case { changes: READY, ..right("taylor_copper", &["speed=190"]) },
    right("indentation", &[]),
    right("plate_6061", &[]),
    right("ogive", &["friction=0.1"]),
    right("ogive", &[]),
    right("ogive", &["V=1000"]),
    right("rod_plate_deletion", &[]),
    right("ogive", &["V=733", "mass=0.0193", "friction=0.047"]),
    right("rod_plate_deletion", &["speed=437e3", "mu=0.07"]),
    right("punch_rubber", &["speed=1.7e3", "mu=0.22", "nr=24", "nz=12"]),
    right("tube_crush", &["wall=1.9", "length=47", "nz=74", "mu=0.16"]),
    // Most of their plastic strain is beyond the tested rates; the extrapolation changes the flow stress by 0.7 to 4.3 %.
    right(TAYLOR_BARS, &["file='aluminium_7075_t651.inp'", "material='AL7075_T651'", "V=231", "d=9.3e-3", "nr=5"]),
    right(TAYLOR_BARS, &["file='tungsten_alloy.inp'", "material='TUNGSTEN_ALLOY'", "V=173", "d=6.1e-3", "nr=5"]),
    right(TAYLOR_BARS, &["file='aluminium_2024_t351.inp'", "material='AL2024_T351'", "V=187", "nr=5"]),
    right(TAYLOR_BARS, &["file='titanium_6al4v.inp'", "material='TI6AL4V'", "V=214", "d=5.3e-3", "nr=5"]),
    right(TAYLOR_BARS, &["file='steel_weldox_460e.inp'", "material='STEEL_WELDOX_460E'", "V=167", "nr=5"]),
    // 288 K is below the lower limit of many ranges.
    right(TAYLOR_BARS, &["file='steel_4340.inp'", "material='STEEL_4340'", "V=203", "T0=288", "nr=5"]),
];

const WRONG: &[Case] = &[
    wrong("taylor_copper", &[(" 8930.", " 8930.e-9"), ("80.e-6", "80.e-9")], &[], "P119"),
    wrong("taylor_copper", &[("117.e9", "117.e3")], &[], "P119"),
    wrong(
        "taylor_copper",
        &[("400.e6", "400."), ("500.e6", "500."), ("600.e6", "600."), ("900.e6", "900."), ("80.e-6", "8.e-6")],
        &[],
        "P140",
    ),
    wrong("taylor_copper", &[("*Dynamic, Explicit\n ", "*Dynamic, Explicit, direct user control\n 6.e-8")], &[], "R2"),
    wrong(
        "taylor_copper",
        &[("*Boundary\n FOOT", "*Fixed Mass Scaling, factor=100.\n*Boundary\n FOOT")],
        &["nr=6", "nz=30"],
        "R316",
    ),
    wrong("taylor_copper", &[("*Boundary\n FOOT, 2, 2\n", "")], &["nr=6", "nz=30"], "P109"),
    wrong("taylor_copper", READY, &["speed=190", "T0=1235"], "R324"),
    wrong("ogive", &[("Y = 276.e6", "Y = 276.")], &[], "P140"),
    wrong("ogive", &[("rho = 2710.", "rho = 2.71e-6")], &[], "P140"),
    wrong(TAYLOR_BARS, &[], &["file='iron_armco.inp'", "material='IRON_ARMCO'", "V=161", "T0=1150", "nr=5"], "R324"),
    wrong(TAYLOR_BARS, &[], &["file='aluminium_2024_t351.inp'", "material='AL2024_T351'", "V=143", "T0=690"], "R324"),
    wrong(
        TAYLOR_BARS,
        &[],
        &["file='aluminium_5083_h116.inp'", "material='AL5083_H116'", "V=870", "length=11e-3"],
        "R324",
    ),
    wrong("ogive", &[], &["V=733", "Y=276e3"], "P140"),
    wrong(
        "rod_plate_deletion",
        &[("*Contact Inclusions, all exterior\n*Contact Property Assignment\n , , DRY\n", ""), ("*Contact\n", "")],
        &["speed=437e3"],
        "R311",
    ),
    wrong(
        "punch_rubber",
        &[("*Dynamic, Explicit", "*Fixed Mass Scaling, factor=900.\n*Dynamic, Explicit")],
        &["nr=24", "nz=12"],
        "R316",
    ),
    wrong(
        "tube_crush",
        &[
            ("material=ALUMINIUM", "material=ALUMINIUM, controls=STIFF"),
            ("*Material, name", "*Section Controls, name=STIFF, hourglass=STIFFNESS\n 60.,\n*Material, name"),
        ],
        &["length=47", "nz=39", "nr=2"],
        "R302",
    ),
    // Contact: no pair at all, and a press that moves away. Method: a tuned hourglass factor, friction.
    wrong("punch_rubber", &[("*Contact Pair, interaction=DRY\n PAD, PUNCH\n PAD,\n", "")], &["nr=8", "nz=4"], "P151"),
    wrong("tube_crush", &[("v = -speed", "v = speed")], &["nr=2", "nz=30", "time=4.e-4"], "R328"),
    wrong("tube_crush", &[], &["nr=2", "nz=30", "time=4.e-4", "mu=3"], "P143"),
    wrong(
        "taylor_copper",
        &[
            ("material=COPPER", "material=COPPER, controls=STIFF"),
            ("*Material, name", "*Section Controls, name=STIFF, hourglass=STIFFNESS\n 30.,\n*Material, name"),
        ],
        &["nr=6", "nz=30"],
        "P143",
    ),
    // Constants: modulus of another metal, engineering stress, strains in percent, slope of a Hugoniot.
    wrong("taylor_copper", &[("117.e9", "11.7e9")], &["nr=6", "nz=30"], "P140"),
    wrong("taylor_copper", &[("600.e6, 2.\n 900.e6, 5.", "480.e6, 2.\n 400.e6, 5.")], &["nr=6", "nz=30"], "P140"),
    wrong(
        "taylor_copper",
        &[("500.e6, 1.", "410.e6, 10."), ("6, 2.", "6, 20."), ("6, 5.", "6, 50.")],
        &["nr=6", "nz=30"],
        "P140",
    ),
    wrong("porous_piston", &[("1.34, 2.", "0.134, 2.")], &["n=50"], "P140"),
    // Loads: a velocity of another unit, an amplitude in other units of time.
    wrong("taylor_copper", &[], &["nr=6", "nz=30", "speed=2e-4"], "R329"),
    wrong("soil_blast", &[("<decay>, 0., 1., 0.", "<decay>, 0.")], &["h=0.1", "rise=10", "decay=40"], "P156"),
    // The element size of a mesh is not known to be too large, but no uncertainty is known.
    wrong("taylor_copper", &[], &["nr=2", "nz=8"], "R323"),
];

/// Runs a case. Returns the verdict and the codes of its reasons; `refused` for a deck that is not run.
fn judge(case: &Case, folder: &std::path::Path) -> (String, Vec<String>) {
    let mut text = std::fs::read_to_string(project(&format!("input/{}.inp", case.deck))).expect("a deck");
    for (from, to) in case.changes {
        assert!(text.contains(from), "{}: {from}", case.deck);
        text = text.replace(from, to);
    }
    let materials = format!("input={}/", project("input/materials").display());
    text = text.replace("input=../materials/", &materials).replace("input=materials/", &materials);
    let deck = folder.join("case.inp");
    std::fs::write(&deck, text).expect("a deck");
    let (deck, out) = (deck.display().to_string(), folder.join("out").display().to_string());
    let mut words = vec!["run", &deck, "--no-frames", "--json", "--out", &out];
    case.settings.iter().for_each(|setting| words.extend(["--set", setting]));
    let ran = revolve(&words);
    let Ok(summary) = serde_json::from_slice::<Value>(&ran.stdout) else { return ("refused".into(), Vec::new()) };
    let reasons = summary["verdict_reasons"].as_array().expect("a list");
    let codes = reasons.iter().map(|reason| reason["code"].as_str().unwrap_or_default().to_owned());
    (summary["verdict"].as_str().expect("a word").to_owned(), codes.collect())
}

#[test]
fn right_decks_are_not_suspect() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in RIGHT {
        let (verdict, codes) = judge(case, folder.path());
        assert!(["ok", "unverified"].contains(&&*verdict), "{} {:?}: {verdict} {codes:?}", case.deck, case.settings);
    }
}

#[test]
fn wrong_decks_are_not_ok() {
    let folder = tempfile::tempdir().expect("a folder");
    for case in WRONG {
        let (verdict, codes) = judge(case, folder.path());
        let is_found = codes.iter().any(|code| code.starts_with(case.code));
        let is_doubted = if case.code == "R323" { verdict == "unverified" } else { verdict != "unverified" };
        let what = format!("{} {:?} {:?}: {verdict} {codes:?}", case.deck, case.changes, case.settings);
        assert!(verdict != "ok" && is_doubted && is_found, "{what}");
    }
}

/// A rigid shot has no mesh error, so it can be ok. With a mesh the word needs an estimate of the error, and a bound that the
/// estimate misses keeps it.
#[test]
fn uncertainty_decides_between_ok_and_unverified() {
    let folder = tempfile::tempdir().expect("a folder");
    let rigid = judge(&right("ogive", &[]), folder.path());
    assert_eq!((&*rigid.0, rigid.1.len()), ("ok", 0));
    let deck = project("input/taylor_copper.inp").display().to_string();
    let out = folder.path().join("bar").display().to_string();
    let words =
        ["run", &deck, "--no-frames", "--json", "--out", &out, "--uncertainty", "--quantity", "final(COOR2@TIP)"];
    let ran = revolve(&words);
    let printed: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    let file = std::fs::read(folder.path().join("bar/taylor_copper.json")).expect("a summary");
    let written: Value = serde_json::from_slice(&file).expect("JSON");
    assert_eq!(printed["verdict"], written["verdict"]);
    let quantity = &printed["certificate"]["quantities"][0];
    let part = |name: &str| quantity[name].as_f64().unwrap_or(0.0);
    let total = part("mesh") + part("increment") + part("noise");
    let is_known = quantity["mesh"].is_f64() && total <= 0.1 * quantity["value"].as_f64().expect("a value").abs();
    assert_eq!(printed["verdict"] == "ok", is_known, "{}", printed["verdict_reasons"]);
}

/// The exit status tells a script that a verdict is worse than required.
#[test]
fn a_required_verdict_sets_the_exit_status() {
    let folder = tempfile::tempdir().expect("a folder");
    let status = |deck: &str, worst: &str| {
        let (deck, out) = (project(deck).display().to_string(), folder.path().display().to_string());
        revolve(&["run", &deck, "--no-frames", "--quiet", "--out", &out, "--require", worst]).status.code()
    };
    assert_eq!(status("input/ogive.inp", "ok"), Some(0));
    assert_eq!(status("input/taylor_copper.inp", "unverified"), Some(0));
    assert_eq!(status("input/taylor_copper.inp", "ok"), Some(3));
    assert_eq!(status("input/taylor_copper.inp", "good"), Some(2));
}

/// One element stretched at a constant velocity, strain `e` = 0 to 0.5: the plastic strain is ln(1 + e) less the elastic strain
/// of 0.001, its rate 1000/(1 + e) per s.
fn stretched(range: &str, folder: &std::path::Path) -> std::process::Output {
    let text = std::fs::read_to_string(project("input/materials/one_element.inp")).expect("a deck");
    let material = "*Material, name=COPPER_OFHC\n*Density\n 8960.\n*Elastic\n 100.e9, 0.3\n*Plastic\n 100.e6, 0.\n\
                    *Specific Heat\n 383.\n*Inelastic Heat Fraction\n 0.9\n*Material Range\n";
    let text = text.replace("*Include, input=<file>\n", &format!("{material}{range}"));
    let deck = folder.join("stretched.inp");
    std::fs::write(&deck, text).expect("a deck");
    let (deck, out) = (deck.display().to_string(), folder.join("out").display().to_string());
    revolve(&["run", &deck, "--no-frames", "--json", "--out", &out, "--set", "size=1.e-4"])
}

/// Shares beyond a range are those of the closed form, and are in the ledger.
#[test]
fn shares_beyond_a_range_match_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = stretched(" STRAIN RATE, , 800.\n PLASTIC STRAIN, , 0.2\n TEMPERATURE, 290., 1000.\n", folder.path());
    let summary: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    let share = |index: usize| summary["ranges"][index]["share"].as_f64().expect("a share");
    // The rate is above 800 while 1 + e < 1.25; the plastic strain is above 0.2 where e > exp(0.201) - 1.
    let expected = [1.25_f64.ln() / 1.5_f64.ln(), (1.5 - 0.201_f64.exp()) / 0.5, 0.0];
    for (index, expected) in expected.into_iter().enumerate() {
        assert!((share(index) - expected).abs() < 0.01, "{index}: {} against {expected}", share(index));
    }
    let reasons: Vec<&str> =
        summary["verdict_reasons"].as_array().into_iter().flatten().filter_map(|r| r["code"].as_str()).collect();
    // The flow stress is extrapolated by 0.05 % only.
    assert_eq!((summary["verdict"].as_str(), &reasons[..]), (Some("suspect"), &["R324", "R323"][..]));
    assert!(summary["ledger"].to_string().contains("% of mass and time beyond plastic strain"));
}

/// The mean change of the flow stress by extrapolation is that of the closed form: with x = ln(1 + e), the rate is
/// 1000 exp(-x) per s, uniform over the plastic strain, and exceeds the limit while x < ln(1000/limit).
#[test]
fn change_of_flow_stress_matches_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = 1.5_f64.ln();
    let change = |cards: &str, limit: f64| {
        let ran = stretched(&format!(" STRAIN RATE, , {limit}\n{cards}"), folder.path());
        let summary: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
        (summary["ranges"][0]["change"].as_f64().expect("a change"), summary["verdict"].to_string())
    };
    // A law without rates: 0.015 ln(rate/limit). Over the whole range the mean of ln(1000/limit) - x is that at the middle.
    let (found, verdict) = change("", 10.0);
    let expected = 0.015 * (100_f64.ln() - 0.5 * whole);
    assert!((found / expected - 1.0).abs() < 0.01 && verdict.contains("suspect"), "{found} {expected} {verdict}");
    let (found, verdict) = change("", 100.0);
    let expected = 0.015 * (10_f64.ln() - 0.5 * whole);
    assert!((found / expected - 1.0).abs() < 0.01 && verdict.contains("unverified"), "{found} {expected} {verdict}");
    // Johnson and Cook's law with C = 0.1: C ln(rate/limit) over 1 + C ln(limit).
    let (found, verdict) = change("*Rate Dependent, type=JOHNSON COOK\n 0.1, 1.\n", 100.0);
    let expected = 0.1 * (10_f64.ln() - 0.5 * whole) / (1.0 + 0.1 * 100_f64.ln());
    assert!((found / expected - 1.0).abs() < 0.01 && verdict.contains("suspect"), "{found} {expected} {verdict}");
}

/// Within its range the material gives no reason, and an empty or reversed range is an error.
#[test]
fn ranges_are_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = stretched(" STRAIN RATE, 1., 1.e4\n TEMPERATURE, , 1000.\n", folder.path());
    let summary: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
    assert_eq!(summary["verdict"], "unverified");
    for range in [" TEMPERATURE,,\n", " TEMPERATURE, 300., 200.\n", " COLOUR, 1., 2.\n"] {
        assert_eq!(stretched(range, folder.path()).status.code(), Some(2), "{range}");
    }
}

/// Wrong shots of rigid projectiles at targets without a mesh: lengths, mass and velocity of other units, a target that is not
/// reached, and a step that ends in the target.
#[test]
fn wrong_rigid_shots_are_not_ok() {
    let folder = tempfile::tempdir().expect("a folder");
    let shots = [
        (right("ogive", &["a=3.555"]), "P140"),
        (right("ogive", &["mass=21"]), "P140"),
        (right("ogive", &["V=569e3"]), "P105"),
        (right("ogive", &["front=-5"]), "R326"),
        (right("ogive", &["V=4000"]), "P155"),
        (Case { changes: &[("z1 = -V", "z1 = V")], ..right("ogive", &[]) }, "P155"),
        (Case { changes: &[("NOSE, SNEG", "NOSE, SPOS")], ..right("ogive", &[]) }, "R326"),
    ];
    for (shot, code) in shots {
        let (verdict, codes) = judge(&shot, folder.path());
        assert!(verdict == "suspect" && codes.iter().any(|c| c == code), "{:?}: {verdict} {codes:?}", shot.settings);
    }
    let short = Case { changes: &[(" , 1.e-3", " , 2.e-5")], ..right("ogive", &[]) };
    assert_eq!(judge(&short, folder.path()), ("unverified".to_owned(), vec!["R315".to_owned()]));
}

/// Two blocks of elements, the second one on the first one, with the nodes 5 and 6 at the places of 4 and 3.
const BLOCKS: &str = "*Node
 1, 0., 0.\n 2, 0.01, 0.\n 3, 0.01, 0.01\n 4, 0., 0.01\n 5, 0., 0.01\n 6, 0.01, 0.01\n 7, 0.01, 0.02\n 8, 0., 0.02
*Node, nset=CHARGE\n 9, 0., 0.5
*Element, type=CAX4R, elset=LOWER\n 1, 1, 2, 3, 4
*Element, type=CAX4R, elset=UPPER\n 2, UPPERNODES, 7, 8
*Solid Section, elset=LOWER, material=STEEL
*Solid Section, elset=UPPER, material=STEEL
*Material, name=STEEL\n*Density\n 7850.,\n*Elastic\n 2.1e11, 0.3
*Surface, name=FACE\n UPPER, SIDE
*Incident Wave Interaction Property, name=BLAST, type=AIR BLAST\n*Conwep Charge Property\n 1., 1.
*Step\n*Dynamic, Explicit\n , 1.e-5
*Incident Wave Interaction, property=BLAST, conwep\n FACE, CHARGE, 0.
*End Step
";

/// Faces at the same place need common nodes, and a blast hits the faces towards its charge.
#[test]
fn unjoined_faces_and_blasts_from_behind_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = folder.path().join("blocks.inp");
    let check = |nodes: &str, side: &str| {
        std::fs::write(&deck, BLOCKS.replace("UPPERNODES", nodes).replace("SIDE", side)).expect("a deck");
        String::from_utf8_lossy(&revolve(&["check", &deck.display().to_string()]).stderr).into_owned()
    };
    let joined = check("4, 3", "S3");
    assert!(!joined.contains("P152") && !joined.contains("P154"), "{joined}");
    let unjoined = check("5, 6", "S3");
    assert!(unjoined.contains("P152") && !unjoined.contains("P154"), "{unjoined}");
    let behind = check("4, 3", "S1");
    assert!(behind.contains("P154"), "{behind}");
}

/// A cylinder of TNT. The detonation starts within the step, and the constants give the speed on the card.
const EXPLOSIVE: &str = "*Node\n 1, 0., 0.\n 2, 0.01, 0.\n 3, 0.01, 0.01\n 4, 0., 0.01
*Element, type=CAX4R, elset=TNT\n 1, 1, 2, 3, 4
*Solid Section, elset=TNT, material=TNT
*Material, name=TNT\n*Density\n 1630.,\n*Eos, type=JWL\n 6930., 371.2e9, 3.231e9, 0.3, 4.15, 0.95, 4.29e6
*Detonation Point\n 0., 0., 0., 0.
*Step\n*Dynamic, Explicit\n , 1.e-6\n*End Step
";

#[test]
fn explosives_that_cannot_detonate_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = folder.path().join("tnt.inp");
    let check = |from: &str, to: &str| {
        assert!(EXPLOSIVE.contains(from), "{from}");
        std::fs::write(&deck, EXPLOSIVE.replace(from, to)).expect("a deck");
        String::from_utf8_lossy(&revolve(&["check", &deck.display().to_string()]).stderr).into_owned()
    };
    let right = check("TNT", "TNT");
    assert!(!right.contains("P153") && !right.contains("P140"), "{right}");
    assert!(check("0., 0., 0., 0.", "0., 0., 0., 1.").contains("P153"));
    for (from, to) in [("0.3, 4.15", "3., 4.15"), ("4.15, 0.95", "0.95, 4.15"), ("371.2e9, 3.231e9", "371.2, 3.231")] {
        let found = check(from, to);
        assert!(found.contains("P140"), "{to}: {found}");
    }
}
