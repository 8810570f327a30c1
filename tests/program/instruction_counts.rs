//! Instructions per increment of scenes, counted by valgrind. Unlike times they do not depend on the load of the machine,
//! so a change of the run time of an effect is found by a test.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use revolve::job::{self, Instructions};
use revolve::output::JobFiles;
use revolve::user::Routines;

use crate::common;

/// Allowed relative change of a count.
const TOLERANCE: f64 = 0.01;
/// Table of the counts.
const TABLE: &str = "tests/program/instruction_counts.txt";

/// Elastic constants of copper.
const ELASTIC: &str = "*Elastic\n 117.e9, 0.35\n";
const HARDENING: &str = "*Plastic\n 400.e6, 0.\n 500.e6, 1.\n";
const JOHNSON_COOK: &str = "*Plastic, hardening=JOHNSON COOK\n 90.e6, 292.e6, 0.31, 1.09, 1083., 20.\n\
    *Rate Dependent, type=JOHNSON COOK\n 0.025, 1.\n*Specific Heat\n 383.,\n*Inelastic Heat Fraction\n 0.9,\n";
const DAMAGE: &str =
    "*Damage Initiation, criterion=DUCTILE\n 0.5, 0., 0.\n*Damage Evolution, type=DISPLACEMENT\n 1.e-3,\n";
const USUP: &str =
    "*Eos, type=USUP\n 3940., 1.489, 2.\n*Elastic, type=SHEAR\n 43.e9,\n*Plastic\n 400.e6, 0.\n 500.e6, 1.\n";
/// Without shear modulus, subzonal pressures control the hourglass patterns.
const LIQUID: &str = "*Eos, type=USUP\n 3940., 1.489, 2.\n";
const RUBBER: &str = "*Hyperelastic, neo hooke\n 20.e9, 1.5e-11\n";
const FOAM: &str = "*Elastic\n 117.e9, 0.\n*Crushable Foam, hardening=ISOTROPIC\n 1., 0.\n*Crushable Foam Hardening\n 2.e9, 0.\n 20.e9, 1.\n";

/// A circular plate of steel under pressure.
const SHELLS: &str = "*Heading\n*Node, nset=AXIS\n 1, 0., 0.\n*Node, nset=RIM\n 201, 0.2, 0.\n*Ngen\n 1, 201, 1\n\
    *Element, type=SAX1, elset=PLATE\n 1, 1, 2\n*Elgen, elset=PLATE\n 1, 200, 1, 1\n*Shell Section, elset=PLATE, material=STEEL\n \
    2.e-3,\n*Material, name=STEEL\n*Density\n 7850.,\n*Elastic\n 200.e9, 0.3\n*Plastic\n 300.e6, 0.\n 500.e6, 0.5\n\
    *Step, name=Blast\n*Dynamic, Explicit\n , <duration>\n*Boundary\n AXIS, 1, 1\n AXIS, 6, 6\n RIM, ENCASTRE\n*Dload\n PLATE, P, 5.e6\n\
    *Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n";

/// A scene: its deck, and two durations of its step.
struct Scene {
    name: &'static str,
    deck: String,
    durations: [&'static str; 2],
}

impl Scene {
    /// Uses a fixed increment, where few increments would otherwise suffice.
    fn with_increment(mut self, increment: &str) -> Scene {
        self.deck = self.deck.replace("*Dynamic, Explicit\n", "*Dynamic, Explicit, direct user control\n");
        self.deck = self.deck.replace(" , <duration>", &format!(" {increment}, <duration>"));
        self
    }
}

/// Returns the copper bar with a law for each scene, and scenes of contact, shells and cavity expansion.
fn scenes() -> Vec<Scene> {
    let bar = |name, law: String| {
        let deck = common::bar_with_law(&(law + "*Remesh, automatic=NO\n")).replace(" , 80.e-6", " , <duration>");
        Scene { name, deck, durations: ["4.e-6", "20.e-6"] }
    };
    let input = |name, file: &str, line: &str, durations| {
        let deck = std::fs::read_to_string(common::project(file)).expect("the deck");
        assert_eq!(deck.matches(line).count(), 1, "{file}");
        Scene { name, deck: common::with_one_row(&deck.replace(line, " , <duration>\n")), durations }
    };
    let enhanced = "hourglass=ENHANCED";
    let mut controlled = bar("ENHANCED hourglass control", format!("{ELASTIC}{HARDENING}"));
    let (section, controls) = ("material=COPPER\n", format!("*Section Controls, name=C, {enhanced}\n"));
    controlled.deck = controlled.deck.replacen(section, &format!("material=COPPER, controls=C\n{controls}"), 1);
    vec![
        bar("elasticity", ELASTIC.into()),
        bar("linear hardening", format!("{ELASTIC}{HARDENING}")),
        bar("Johnson-Cook, rate, adiabatic", format!("{ELASTIC}{JOHNSON_COOK}")),
        bar("ductile damage", format!("{ELASTIC}{HARDENING}{DAMAGE}")),
        bar("USUP equation of state", USUP.into()),
        bar("liquid, subzonal pressures", LIQUID.into()),
        bar("neo-Hooke", RUBBER.into()),
        bar("crushable foam", FOAM.into()),
        controlled,
        input("contact, friction, heat", "input/press_fit.inp", " , <time>\n", ["1.e-4", "4.e-4"]),
        Scene { name: "shells", deck: SHELLS.into(), durations: ["0.1e-3", "0.5e-3"] },
        input("cavity expansion", "input/ogive.inp", " , 1.e-3\n", ["0.2e-3", "1.e-3"]).with_increment("1.e-8"),
    ]
}

/// A deck that is checked or run in a process whose instructions are counted.
pub struct CountedJob {
    pub deck: PathBuf,
    pub task: CountedTask,
}

/// What is done with a deck.
#[derive(Clone, Copy, PartialEq)]
pub enum CountedTask {
    /// It is checked without a trial run, whose length depends on the clock if the machine is slow.
    Check,
    /// It is run into files, with AVX2.
    Run,
    /// The same with scalar code.
    RunScalar,
}

impl CountedTask {
    /// Tasks and their words in the list of the jobs.
    const WORDS: [(CountedTask, &str); 3] =
        [(CountedTask::Check, "check"), (CountedTask::Run, "run"), (CountedTask::RunScalar, "run-scalar")];
}

/// Names the file with the jobs of [`counted_jobs`].
const JOBS: &str = "REVOLVE_COUNTED_JOBS";

/// Returns the instructions of each job. All jobs are done in one process: valgrind translates the program once, which takes
/// longer than a small job.
pub fn instructions_of_each(folder: &Path, jobs: &[CountedJob]) -> Vec<f64> {
    let (list, counts) = (folder.join("jobs.txt"), folder.join("job_counts"));
    let word = |job: &CountedJob| CountedTask::WORDS.iter().find(|(task, _)| *task == job.task).expect("a word").1;
    let lines = jobs.iter().map(|job| format!("{} {}\n", word(job), job.deck.display()));
    std::fs::write(&list, lines.collect::<String>()).expect("the list is written");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--dump-line=no", "--dump-after=*end_of_counted_job*"])
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .arg(std::env::current_exe().expect("the program of the tests"))
        .args(["instruction_counts::counted_jobs", "--exact", "--ignored", "--test-threads=1"])
        .env(JOBS, &list)
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("valgrind runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    let count = |number: usize| {
        let text = std::fs::read_to_string(format!("{}.{number}", counts.display())).expect("counts of a job");
        let total = text.lines().find_map(|line| line.strip_prefix("summary: ")).expect("a sum");
        total.trim().parse().expect("a number")
    };
    // The first interval ends where the first job begins.
    (2..jobs.len() + 2).map(count).collect()
}

/// Ends an interval of the counts.
#[inline(never)]
fn end_of_counted_job() {
    std::hint::black_box(());
}

/// The jobs of [`instructions_of_each`].
#[test]
#[ignore = "tests that count instructions start it in valgrind"]
fn counted_jobs() {
    let Some(list) = std::env::var_os(JOBS) else { return };
    let list = std::fs::read_to_string(list).expect("a list");
    let out = tempfile::tempdir().expect("a folder");
    end_of_counted_job();
    for (word, deck) in list.lines().filter_map(|line| line.split_once(' ')) {
        let (task, _) = CountedTask::WORDS.iter().find(|(_, other)| *other == word).expect("a task");
        let instructions = match task {
            CountedTask::Check => None,
            CountedTask::Run => Some(Instructions::Avx2),
            CountedTask::RunScalar => Some(Instructions::Scalar),
        };
        if let Some(instructions) = instructions {
            let mut prepared = job::prepare(Path::new(deck), &[], &Routines::none());
            prepared.use_instructions(instructions).expect("the machine has AVX2");
            let files = JobFiles { folder: out.path().to_owned(), name: "job".into() };
            let summary = job::run_to_files(&prepared, &files, &mut |_| {}).expect("files");
            assert_eq!(summary.status, "completed", "{deck}");
        } else {
            let status = revolve::command_line(["revolve", "check", "--no-look", deck].map(OsString::from));
            assert_eq!(status.0, 0, "{deck}");
        }
        end_of_counted_job();
    }
}

/// Returns the number of increments of a deck.
fn increments(folder: &Path, deck: &Path) -> f64 {
    let prepared = job::prepare(deck, &[], &Routines::none());
    let files = JobFiles { folder: folder.to_owned(), name: "scene".into() };
    let summary = job::run_to_files(&prepared, &files, &mut |_| {}).expect("files");
    summary.steps[0].increments as f64
}

/// Returns the instructions per increment of each scene, with AVX2 and scalar: start and end of a run cancel in the difference
/// of two durations.
fn per_increment(folder: &Path, scenes: &[Scene]) -> Vec<[f64; 2]> {
    let write = |number: usize, scene: &Scene| {
        let [short, long] = [0, 1].map(|end| {
            let deck = folder.join(format!("scene_{number}_{end}.inp"));
            std::fs::write(&deck, scene.deck.replace("<duration>", scene.durations[end])).expect("the deck is written");
            deck
        });
        [short, long]
    };
    let decks: Vec<_> = scenes.iter().enumerate().map(|(number, scene)| write(number, scene)).collect();
    let of_scene = |[short, long]: &[PathBuf; 2]| {
        let job = |deck: &PathBuf, task| CountedJob { deck: deck.clone(), task };
        let (vectors, scalar) = (CountedTask::Run, CountedTask::RunScalar);
        // The first run fills the tables that the process keeps.
        [job(short, vectors), job(short, vectors), job(long, vectors), job(short, scalar), job(long, scalar)]
    };
    let jobs: Vec<_> = decks.iter().flat_map(of_scene).collect();
    let counts = instructions_of_each(folder, &jobs);
    let per_increment = |(decks, counts): (&[PathBuf; 2], &[f64])| {
        let [short, long] = decks.each_ref().map(|deck| increments(folder, deck));
        assert!(long >= short + 50.0, "{}: {short} and {long} increments", decks[1].display());
        [1, 3].map(|first| (counts[first + 1] - counts[first]) / (long - short))
    };
    decks.iter().zip(counts.chunks(5)).map(per_increment).collect()
}

/// Returns whether instructions can be counted; otherwise the test prints that it was left out. CI requires valgrind.
pub fn can_count() -> bool {
    let found = Command::new("valgrind").arg("--version").output().is_ok_and(|o| o.status.success());
    assert!(found || std::env::var_os("CI").is_none(), "in CI valgrind must be installed");
    #[cfg(target_arch = "x86_64")]
    let suitable = std::arch::is_x86_feature_detected!("avx2") && !cfg!(debug_assertions);
    #[cfg(not(target_arch = "x86_64"))]
    let suitable = false;
    if !found || !suitable {
        println!("left out: counts of instructions (valgrind, AVX2 and the release profile are required)");
    }
    found && suitable
}

/// A change of the counts by more than 1 % is explained in the commit that updates the table.
#[test]
fn instructions_per_increment_are_those_of_the_table() {
    if !can_count() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = scenes();
    let rows = scenes.iter().zip(per_increment(folder.path(), &scenes)).flat_map(|(scene, [vectors, scalar])| {
        [(scene.name.to_owned(), vectors), (format!("{}, scalar", scene.name), scalar)]
    });
    let found: Vec<(String, f64)> = rows.collect();
    let (path, mut table) = (common::project(TABLE), String::new());
    found.iter().for_each(|(name, count)| writeln!(table, "{name}: {count:.0}").expect("text"));
    if std::env::var_os("REVOLVE_BLESS").is_some() {
        std::fs::write(&path, &table).expect("the table is written");
    }
    let pinned = std::fs::read_to_string(path).expect("the table");
    let pinned: BTreeMap<&str, f64> = pinned
        .lines()
        .filter_map(|line| line.split_once(": "))
        .map(|(name, count)| (name, count.parse().expect("a count")))
        .collect();
    assert_eq!(pinned.len(), found.len(), "run again with REVOLVE_BLESS=1");
    let changed: Vec<_> =
        found.iter().filter(|(name, count)| (count / pinned[name.as_str()] - 1.0).abs() > TOLERANCE).collect();
    assert!(changed.is_empty(), "pinned: {pinned:?}\nchanged: {changed:?}\nwith REVOLVE_BLESS=1 the table is updated");
}
