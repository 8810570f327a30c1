//! Compiled routines that are kept between runs.
//!
//! Goal: nothing is loaded but what the files of today say, and nothing that another user could have put there.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::subroutines::{Desk, FILL, fortran, told, user_deck, vdload};

/// Files of the cache with this ending.
fn kept(desk: &Desk, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(desk.path("cache/revolve/user")).into_iter().flatten();
    let files = entries.map(|e| e.expect("an entry").path());
    files.filter(|path| path.extension().is_some_and(|e| e == ending)).collect()
}

/// How much the projectile is slowed, in units of the first pressure.
fn slowed(desk: &Desk, output: &Output) -> f64 {
    assert!(output.status.success(), "{}", told(output));
    desk.depth("ogive_user") + 569e-3
}

#[test]
fn whatever_the_compiler_reads_is_asked_again() {
    if !fortran() {
        return;
    }
    let law = |p: &str| format!("      parameter (p0 = {p})\n");
    let header = |p: &str| format!("#define p0 {p}\n");
    let module = |p: &str| format!("module law\nreal*8, parameter :: p0 = {p}\nend module\n");
    let fill = "      value = p0";
    let nested = "      include 'inc/one.inc'\n      value = p0";
    let by_name = format!("#define LAW \"two.h\"\n#include LAW\n{}", vdload(fill));
    let with_module = vdload(fill).replace("      include 'v", "      use law\n      include 'v");
    let c = "#include \"one.h\"\nvoid vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, \
             const double *amplitude,\n const double *x, const double *v, const double *d, const int *jltyp, const char *sname, \
             double *value, long n)\n{\n  for (int k = 0; k < *nblock; k++) value[k] = p0;\n}\n";
    type Text<'a> = &'a dyn Fn(&str) -> String;
    // What is compiled, and the file whose number changes.
    let cases: [(&str, &str, String, &str, Text<'_>); 5] = [
        ("through a folder searched", "load.f", vdload(nested), "two.inc", &law),
        ("through a macro", "load.f", by_name.clone(), "two.h", &header),
        ("through CPATH", "load.f", by_name.clone(), "cpath/two.h", &header),
        ("a header's header", "load.c", c.into(), "inc/deep.h", &|p| header(&p.replace('d', "e"))),
        ("a module file", "load.f", with_module, "law.f90", &module),
    ];
    for (name, file, source, inner, text) in cases {
        let desk = Desk::new();
        std::fs::create_dir_all(desk.path("inc")).expect("a folder");
        std::fs::create_dir_all(desk.path("cpath")).expect("a folder");
        desk.write("inc/one.inc", "      include 'two.inc'\n");
        desk.write("one.h", "#include \"inc/deep.h\"\n");
        let file = desk.write(file, &source);
        let cpath = [("CPATH", desk.path("cpath"))];
        let run = |pressure: &str| {
            let inner = desk.write(inner, &text(pressure));
            if inner.extension().is_some_and(|e| e == "f90") {
                let mut compiler = Command::new(std::env::var_os("FC").unwrap_or("gfortran".into()));
                let done = compiler.arg("-fsyntax-only").arg(&inner).current_dir(desk.path("")).status();
                assert!(done.is_ok_and(|s| s.success()), "{name}");
            }
            slowed(&desk, &desk.run_with(&cpath, &user_deck(), &[&file], &[]))
        };
        let (first, second) = (run("1.d8"), run("2.d8"));
        assert!((second / first - 2.0).abs() < 1e-6, "{name}: {first} and {second}");
        let entries = kept(&desk, "json").len();
        assert_eq!(run("2.d8"), second, "{name}");
        assert_eq!(kept(&desk, "json").len(), entries, "{name}: what is as it was is kept");
    }
    // A file that is found before the one that was read.
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("cpath")).expect("a folder");
    desk.write("cpath/two.h", &header("1.d8"));
    let file = desk.write("load.f", &by_name);
    let run = || slowed(&desk, &desk.run_with(&[("CPATH", desk.path("cpath"))], &user_deck(), &[&file], &[]));
    let first = run();
    desk.write("two.h", &header("2.d8"));
    assert!((run() / first - 2.0).abs() < 1e-6);
}

/// A run that goes on with another routine is another run.
#[test]
fn a_checkpoint_is_not_taken_up_with_another_inner_include() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("inc")).expect("a folder");
    desk.write("inc/one.inc", "      include 'two.inc'\n");
    desk.write("two.inc", "      parameter (p0 = 1.d8)\n");
    let stops = "      include 'inc/one.inc'\n      value = p0\n      if (totalTime .gt. 1.d-4) call xplb_exit";
    let file = desk.write("load.f", &vdload(stops));
    let run = |more: &[&str]| desk.run(&user_deck(), &[&file], more);
    assert_eq!(run(&["--checkpoint-every", "5"]).status.code(), Some(1));
    assert_eq!(run(&["--resume"]).status.code(), Some(1), "the same routine goes on, and halts again");
    desk.write("two.inc", "      parameter (p0 = 2.d8)\n");
    let output = run(&["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("K00"), "{}", told(&output));
}

#[test]
fn a_library_that_is_not_what_was_kept_is_never_loaded() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let file = desk.write("load.f", &vdload(FILL));
    let first = slowed(&desk, &desk.run(&user_deck(), &[&file], &[]));
    let [library] = &kept(&desk, "so")[..] else { panic!("one library") };
    let whole = std::fs::read(library).expect("a library");
    let other = desk.write("other.f", &vdload("      value = 3.d8"));
    slowed(&desk, &desk.run(&user_deck(), &[&other], &[]));
    let stranger = kept(&desk, "so").into_iter().find(|path| path != library).expect("another library");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let torn = whole[..whole.len() / 3].to_vec();
    let beside = library.with_extension("json");
    for (name, path, bytes) in [
        ("torn", library, torn),
        ("one bit", library, flipped),
        ("another's", library, std::fs::read(stranger).expect("a library")),
        ("no word", &beside, b"{".to_vec()),
    ] {
        std::fs::write(path, bytes).expect("a file");
        assert_eq!(slowed(&desk, &desk.run(&user_deck(), &[&file], &[])), first, "{name}");
        let text = std::fs::read_to_string(&beside).expect("a word");
        let told: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let now = revolve::output::checkpoint::hash([std::fs::read(library).expect("a library").as_slice()]);
        assert_eq!(told["library"], now.as_str(), "{name}: built again and kept");
    }
}

#[test]
fn a_folder_that_others_may_write_is_not_used() {
    if !fortran() {
        return;
    }
    for open in ["cache/revolve", "cache/revolve/user"] {
        let desk = Desk::new();
        let file = desk.write("load.f", &vdload(FILL));
        let first = slowed(&desk, &desk.run(&user_deck(), &[&file], &[]));
        let mode = |name: &str| desk.path(name).metadata().expect("a folder").permissions().mode() & 0o777;
        assert_eq!(mode("cache/revolve/user"), 0o700);
        // What stands there is good, but for the folder: had it been read, nothing would be written.
        for path in kept(&desk, "so") {
            std::fs::write(path, "of another").expect("a file");
        }
        std::fs::set_permissions(desk.path(open), std::fs::Permissions::from_mode(0o777)).expect("a mode");
        let loud = desk.command(&user_deck(), &[&file]).output().expect("it runs");
        assert_eq!(slowed(&desk, &loud), first);
        assert!(told(&loud).contains("U011") && told(&loud).contains("another user"), "{}", told(&loud));
        for path in kept(&desk, "so") {
            assert_eq!(std::fs::read(path).expect("a file"), b"of another", "{open}: nothing is kept there");
        }
    }
}

#[test]
fn without_a_home_nothing_is_kept_in_the_shared_folder() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let file = desk.write("load.f", &vdload(FILL));
    std::fs::create_dir(desk.path("shared")).expect("a folder");
    let mut command = desk.command(&user_deck(), &[&file]);
    command.env_remove("XDG_CACHE_HOME").env_remove("HOME").env("TMPDIR", desk.path("shared"));
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{}", told(&output));
    assert_eq!(std::fs::read_dir(desk.path("shared")).expect("a folder").count(), 0);
    assert!(!desk.path("cache").exists());
}

#[test]
fn what_was_not_used_for_longest_goes() {
    if !fortran() {
        return;
    }
    let desk = Desk::new();
    let run = |pressure: &str| {
        let file = desk.write("load.f", &vdload(&format!("      value = {pressure}")));
        slowed(&desk, &desk.run(&user_deck(), &[&file], &[]));
    };
    run("1.d8");
    let old = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    let put = |path: &Path| {
        std::fs::write(path, "{}").expect("a file");
        std::fs::File::open(path).and_then(|file| file.set_modified(old)).expect("a time");
    };
    for i in 0..70 {
        put(&desk.path(&format!("cache/revolve/user/{i}.json")));
        put(&desk.path(&format!("cache/revolve/user/{i}.so")));
    }
    run("2.d8");
    assert_eq!((kept(&desk, "json").len(), kept(&desk, "so").len()), (64, 64));
    let built = kept(&desk, "so").iter().filter(|p| p.metadata().is_ok_and(|m| m.len() > 2)).count();
    assert_eq!(built, 2, "the two used last stay");
}
