//! Run time of the lists that a deck can hold: bodies, pairs, held nodes, loads, sets, outputs, ties, steps, materials.
//!
//! Goal: four times the entries take about four times the instructions, in `check` and in a short run with its files. Source:
//! instructions counted by valgrind, less those of a deck with one entry; a loop over all entries for each entry makes the
//! ratio 16. Tolerance: 5, and 5.1 for pairs of bodies in `check`.

use std::path::{Path, PathBuf};

use super::instruction_counts::{CountedJob, CountedTask, can_count, instructions_of_each};
use crate::common::solid::grid;

/// Largest ratio of the instructions of four times the entries to those of the entries.
const LARGEST_RATIO: f64 = 5.0;
/// The same in `check` of bodies in general contact, where each pair of surfaces has a name and a law (5.0).
const LARGEST_RATIO_OF_PAIRS: f64 = 5.1;
/// Number of counted jobs of a list.
const JOBS: usize = 6;
/// Cells of the grid along r.
const CELLS: usize = 20;

/// Returns a set of one node.
fn node_set(i: usize) -> String {
    format!("*Nset, nset=N{i}\n {i},\n")
}

/// A body with many entries of one kind.
struct DeckList {
    name: &'static str,
    /// Number of entries; the larger deck has four times as many.
    count: usize,
    model: fn(usize) -> String,
    step: fn(usize) -> String,
    /// Cards of the step after the entries.
    end: &'static str,
}

impl DeckList {
    /// A list of conditions of nodes or elements of the grid.
    const fn of_grid(name: &'static str, model: fn(usize) -> String, step: fn(usize) -> String) -> DeckList {
        DeckList { name, count: 20, model, step, end: "" }
    }

    /// A list of bodies, or of what costs as much.
    const fn of_bodies(name: &'static str, model: fn(usize) -> String, end: &'static str) -> DeckList {
        DeckList { name, count: 8, model, step: nothing, end }
    }

    const fn with_end(self, end: &'static str) -> DeckList {
        DeckList { end, ..self }
    }

    /// Returns a deck with a number of entries on a grid for four times the count.
    fn deck(&self, entries: usize) -> String {
        let rows = 5;
        let mut text = grid(CELLS, rows, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64]);
        let mut conditions: String = (1..=entries).map(self.step).collect();
        let solves = conditions.contains("*Film") || conditions.contains(", 11");
        if solves {
            text = text.replace("CAX4R,", "CAX4RT,");
        }
        text += &(1..=entries).map(self.model).collect::<String>();
        if !text.contains("*Solid Section, elset=E1,") {
            text += "*Solid Section, elset=SOLID, material=M\n";
        } else {
            text += &format!("*Elset, elset=LEFT, generate\n {}, {}, 1\n", entries + 1, CELLS * rows);
            text += "*Solid Section, elset=LEFT, material=M\n";
        }
        text += "*Material, name=M\n*Density\n 7850.,\n*Elastic\n 2.1e11, 0.3\n*Conductivity\n 45.,\n*Specific Heat\n 460.,\n";
        let procedure = if solves { "*Dynamic Temperature-displacement, Explicit" } else { "*Dynamic, Explicit" };
        if !conditions.contains("*Step") {
            conditions =
                format!("*Step\n{procedure}\n , 2.e-7\n*Boundary\n 1, 1, 1\n{conditions}{}*End Step\n", self.end);
        }
        text + &conditions
    }
}

fn nothing(_: usize) -> String {
    String::new()
}

/// Returns a square body above the grid and above those before, with two surfaces.
fn body(i: usize) -> String {
    let (first, z) = (100_000 + 4 * i, 0.02 + 2e-3 * i as f64);
    let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
    format!(
        "*Node\n {a}, .001, {z}\n {b}, .002, {z}\n {c}, .002, {top}\n {d}, .001, {top}\n\
         *Element, type=CAX4R, elset=P{i}\n {first}, {a}, {b}, {c}, {d}\n*Solid Section, elset=P{i}, material=M\n\
         *Surface, name=LOW{i}\n P{i}, S1\n*Surface, name=TOP{i}\n P{i}, S3\n",
        top = z + 1e-3
    )
}

/// Returns two bodies of which one is on the other, tied.
fn tied(i: usize) -> String {
    let [low, high] = [body(2 * i), body(2 * i + 1).replace(&format!("{}", 0.02 + 2e-3 * (2 * i + 1) as f64), "Z")];
    let z = 0.02 + 2e-3 * (2 * i) as f64 + 1e-3;
    let high = high
        .replace(", Z", &format!(", {z}"))
        .replace(&format!(", {}\n", 0.02 + 2e-3 * (2 * i + 1) as f64 + 1e-3), &format!(", {}\n", z + 1e-3));
    format!("{low}{high}*Tie, name=T{i}\n LOW{}, TOP{}\n", 2 * i + 1, 2 * i)
}

fn rigid_body(i: usize) -> String {
    let (node, z) = (100_000 + 4 * i, 2 * i);
    let [a, b, c] = [node, node + 1, node + 2];
    format!(
        "*Node\n {a}, 1., {z}.\n {b}, 2., {z}.\n {c}, 0., {z}.\n*Element, type=RAX2, elset=P{i}\n {node}, {a}, {b}\n\
         *Rigid Body, ref node={c}, elset=P{i}\n*Element, type=MASS, elset=Q{i}\n {b}, {c}\n*Mass, elset=Q{i}\n 1.,\n"
    )
}

const GENERAL: &str = "*Contact\n*Contact Inclusions, all exterior\n";
const REACTIONS: &str = "*Output, field, number interval=1\n*Node Output\n U, RF\n";
const HISTORY: &str = "*Output, history, number interval=2\n";

const LISTS: [DeckList; 31] = [
    DeckList::of_bodies("bodies", body, ""),
    DeckList::of_bodies("bodies in general contact", body, GENERAL),
    DeckList::of_bodies(
        "held bodies in general contact, with reactions",
        body,
        "*Boundary\n ALL, 2, 2\n*Contact\n*Contact Inclusions, all exterior\n*Output, field, number interval=1\n*Node Output\n U, RF\n",
    ),
    DeckList {
        name: "contact pairs",
        count: 6,
        model: |i| body(2 * i) + &body(2 * i + 1) + &format!("*Surface Interaction, name=I{i}\n"),
        step: |i| format!("*Contact Pair, interaction=I{i}\n TOP{}, LOW{}\n", 2 * i, 2 * i + 1),
        end: "*Output, history, number interval=2\n*Contact Output\n CFN, CAREA\n",
    },
    DeckList::of_bodies("ties", tied, ""),
    DeckList::of_bodies("rigid bodies", rigid_body, ""),
    DeckList::of_bodies(
        "couplings",
        |i| {
            let node = 100_000 + i;
            format!(
                "*Node\n {node}, 0., {i}.\n*Surface, type=NODE, name=S{i}\n {}, 1.\n\
                 *Coupling, constraint name=C{i}, ref node={node}, surface=S{i}\n*Kinematic\n 2, 2\n",
                i + 21
            )
        },
        "",
    ),
    DeckList::of_grid("held nodes, a row each, with reactions", nothing, |i| {
        let head = if i == 1 { "*Boundary\n" } else { "" };
        format!("{head} {}, 2, 2\n", i + 1)
    })
    .with_end(REACTIONS),
    DeckList::of_grid("moved nodes, a card each, with reactions", nothing, |i| {
        format!("*Boundary, type=VELOCITY\n {}, 1, 1, {i}.\n", i + 1)
    })
    .with_end(REACTIONS),
    DeckList::of_grid(
        "equations, with reactions",
        |i| format!("*Equation\n 2\n {0}, 2, 1., {0}, 1, -1.\n", i + 1),
        |i| format!("*Boundary\n {}, 1, 1\n", i + 1),
    )
    .with_end(REACTIONS),
    DeckList::of_grid("concentrated loads", nothing, |i| format!("*Cload\n {i}, 2, 1.\n")),
    DeckList::of_grid("pressures", nothing, |i| format!("*Dload\n {i}, P1, 1.\n")),
    DeckList::of_grid(
        "pressures on surfaces",
        |i| format!("*Surface, name=F{i}\n {i}, S1\n"),
        |i| format!("*Dsload\n F{i}, P, 1.\n"),
    ),
    DeckList::of_grid(
        "amplitudes",
        |i| format!("*Amplitude, name=A{i}\n 0., 0., 2.e-7, 1.\n"),
        |i| format!("*Cload, amplitude=A{i}\n {i}, 2, 1.\n"),
    ),
    DeckList::of_grid(
        "rows of an amplitude",
        |i| if i == 1 { "*Amplitude, name=A\n 1.e-9, 1.\n".into() } else { format!(" {i}.e-9, {}.\n", i % 7) },
        |i| if i == 1 { "*Cload, amplitude=A\n 5, 2, 1.\n".into() } else { String::new() },
    ),
    DeckList::of_grid("films", nothing, |i| format!("*Film\n {i}, F1, 20., 10.\n")),
    DeckList::of_grid("held temperatures, with reactions", nothing, |i| format!("*Boundary\n {i}, 11, 11, 20.\n"))
        .with_end("*Output, field, number interval=1\n*Node Output\n NT, RFL\n"),
    DeckList::of_grid("heat fluxes", nothing, |i| format!("*Cflux\n {i}, 11, 20.\n")),
    DeckList::of_grid("node sets and element sets", |i| node_set(i) + &format!("*Elset, elset=S{i}\n {i},\n"), nothing),
    DeckList::of_grid("surfaces", |i| format!("*Surface, name=F{i}\n {i}, S1\n"), nothing),
    DeckList::of_grid("histories of node sets", node_set, |i| {
        format!("{}*Node Output, nset=N{i}\n U2\n", if i == 1 { HISTORY } else { "" })
    }),
    DeckList::of_grid("histories of reactions", node_set, |i| {
        let head = if i == 1 { "*Boundary\n ALL, 2, 2\n*Output, history, number interval=2\n" } else { "" };
        format!("{head}*Node Output, nset=N{i}\n RF2\n")
    }),
    DeckList::of_grid(
        "histories of element sets",
        |i| format!("*Elset, elset=S{i}\n {i},\n"),
        |i| format!("{}*Element Output, elset=S{i}\n MISES\n", if i == 1 { HISTORY } else { "" }),
    ),
    DeckList::of_grid("field output of node sets", node_set, |i| {
        let head = if i == 1 { "*Output, field, number interval=1\n" } else { "" };
        format!("{head}*Node Output, nset=N{i}\n U\n")
    }),
    DeckList {
        name: "steps",
        count: 4,
        model: nothing,
        step: |i| format!("*Step\n*Dynamic, Explicit\n , 1.e-8\n*Cload\n {i}, 2, 1.\n*End Step\n"),
        end: "",
    },
    DeckList::of_grid(
        "materials and sections",
        |i| {
            format!(
                "*Elset, elset=E{i}\n {i},\n*Material, name=X{i}\n*Density\n 7850.,\n*Elastic\n 2.1e11, 0.3\n\
                 *Solid Section, elset=E{i}, material=X{i}\n"
            )
        },
        nothing,
    ),
    DeckList::of_grid(
        "springs",
        |i| {
            format!(
                "*Element, type=SPRINGA, elset=G{i}\n {}, {i}, {}\n*Spring, elset=G{i}\n\n 1.e3\n",
                100_000 + i,
                i + 1
            )
        },
        nothing,
    ),
    DeckList::of_grid(
        "point masses",
        |i| format!("*Element, type=MASS, elset=G{i}\n {}, {i}\n*Mass, elset=G{i}\n 1.e-3\n", 100_000 + i),
        nothing,
    ),
    DeckList::of_grid("initial velocities", |i| format!("*Initial Conditions, type=VELOCITY\n {i}, 2, 1.\n"), nothing),
    DeckList::of_grid(
        "erosion",
        |i| format!("*Elset, elset=S{i}\n {i},\n*Erosion, elset=S{i}, distortion=0.0{}\n", i % 9 + 1),
        nothing,
    ),
    DeckList::of_grid(
        "mass scaling",
        |i| format!("*Elset, elset=S{i}\n {i},\n"),
        |i| format!("*Fixed Mass Scaling, elset=S{i}, factor=1.{}\n", i % 9 + 1),
    ),
];

/// Decks of a list that are measured.
struct MeasuredDecks {
    one: PathBuf,
    some: PathBuf,
    many: PathBuf,
}

impl MeasuredDecks {
    /// Writes the decks of a list.
    fn write(folder: &Path, number: usize, list: &DeckList) -> MeasuredDecks {
        let write = |entries: usize| {
            let path = folder.join(format!("list_{number}_{entries}.inp"));
            std::fs::write(&path, list.deck(entries)).expect("the deck is written");
            path
        };
        MeasuredDecks { one: write(1), some: write(list.count), many: write(4 * list.count) }
    }

    /// Returns the jobs of a list: checks, then runs.
    fn jobs(self) -> [CountedJob; JOBS] {
        let check = |deck: &PathBuf| CountedJob { deck: deck.clone(), task: CountedTask::Check };
        let run = |deck: &PathBuf| CountedJob { deck: deck.clone(), task: CountedTask::Run };
        let MeasuredDecks { one, some, many } = &self;
        [check(one), check(some), check(many), run(one), run(some), run(many)]
    }
}

/// Returns the ratio of the instructions of four times the entries to those of the entries.
fn growth(list: &DeckList, counts: &[f64]) -> f64 {
    let [one, some, many] = *counts else { panic!("{counts:?}") };
    println!("{}: {:.2} and {:.2} million instructions", list.name, 1e-6 * (some - one), 1e-6 * (many - one));
    let entries = |count: usize| (count - 1) as f64;
    let per_entry = [(some - one) / entries(list.count), (many - one) / entries(4 * list.count)];
    4.0 * per_entry[1] / per_entry[0]
}

#[test]
fn instructions_are_proportional_to_the_entries_of_each_list() {
    if !can_count() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let decks = LISTS.iter().enumerate().map(|(i, list)| MeasuredDecks::write(folder.path(), i, list));
    let mut jobs: Vec<CountedJob> = decks.flat_map(MeasuredDecks::jobs).collect();
    // Jobs before the others fill the tables that the process keeps.
    let first = [CountedTask::Check, CountedTask::Run].map(|task| CountedJob { deck: jobs[0].deck.clone(), task });
    jobs.splice(0..0, first);
    let counts = &instructions_of_each(folder.path(), &jobs)[2..];
    let mut faults = Vec::new();
    for (list, counts) in LISTS.iter().zip(counts.chunks(JOBS)) {
        let [check, run] = [&counts[..JOBS / 2], &counts[JOBS / 2..]].map(|counts| growth(list, counts));
        println!("{}: growth of check {check:.2}, of run {run:.2}", list.name);
        let has_pairs = list.end.contains("all exterior");
        let largest_of_check = if has_pairs { LARGEST_RATIO_OF_PAIRS } else { LARGEST_RATIO };
        if !((0.0..=largest_of_check).contains(&check) && (0.0..=LARGEST_RATIO).contains(&run)) {
            faults.push((list.name, check, run));
        }
    }
    assert!(faults.is_empty(), "quadratic: {faults:?}");
}
