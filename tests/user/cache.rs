//! The cache of compiled user subroutines.
//!
//! Goal: a library is loaded only if it was compiled from the present files, and never if another user could have
//! written it.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::subroutines::{FILL, UserFolder, fortran, message_text, user_deck, vdload};

/// Returns the files of the cache with an extension.
fn kept(user_dir: &UserFolder, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(user_dir.path("cache/revolve/user")).into_iter().flatten();
    let files = entries.map(|e| e.expect("an entry").path());
    files.filter(|path| path.extension().is_some_and(|e| e == ending)).collect()
}

/// Returns the loss of velocity of the projectile, in units of that for the first pressure.
fn slowed(user_dir: &UserFolder, output: &Output) -> f64 {
    assert!(output.status.success(), "{}", message_text(output));
    user_dir.depth("ogive_user") + 569e-3
}

#[test]
fn changed_includes_cause_recompilation() {
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
    type ContentFunction<'a> = &'a dyn Fn(&str) -> String;
    // The compiled file, and the file whose value changes.
    let cases: [(&str, &str, String, &str, ContentFunction<'_>); 5] = [
        ("through a folder searched", "load.f", vdload(nested), "two.inc", &law),
        ("through a macro", "load.f", by_name.clone(), "two.h", &header),
        ("through CPATH", "load.f", by_name.clone(), "cpath/two.h", &header),
        ("a header's header", "load.c", c.into(), "inc/deep.h", &|p| header(&p.replace('d', "e"))),
        ("a module file", "load.f", with_module, "law.f90", &module),
    ];
    for (name, file, source, inner, text) in cases {
        let user_dir = UserFolder::new();
        std::fs::create_dir_all(user_dir.path("inc")).expect("a folder");
        std::fs::create_dir_all(user_dir.path("cpath")).expect("a folder");
        user_dir.write("inc/one.inc", "      include 'two.inc'\n");
        user_dir.write("one.h", "#include \"inc/deep.h\"\n");
        let file = user_dir.write(file, &source);
        let cpath = [("CPATH", user_dir.path("cpath"))];
        let run = |pressure: &str| {
            let inner = user_dir.write(inner, &text(pressure));
            if inner.extension().is_some_and(|e| e == "f90") {
                let mut compiler = Command::new(std::env::var_os("FC").unwrap_or("gfortran".into()));
                let done = compiler.arg("-fsyntax-only").arg(&inner).current_dir(user_dir.path("")).status();
                assert!(done.is_ok_and(|s| s.success()), "{name}");
            }
            slowed(&user_dir, &user_dir.run_with(&cpath, &user_deck(), &[&file], &[]))
        };
        let (first, second) = (run("1.d8"), run("2.d8"));
        assert!((second / first - 2.0).abs() < 1e-6, "{name}: {first} and {second}");
        let entries = kept(&user_dir, "json").len();
        assert_eq!(run("2.d8"), second, "{name}");
        assert_eq!(kept(&user_dir, "json").len(), entries, "{name}: nothing is compiled again");
    }
    // A new file that precedes the original one in the search path.
    let user_dir = UserFolder::new();
    std::fs::create_dir_all(user_dir.path("cpath")).expect("a folder");
    user_dir.write("cpath/two.h", &header("1.d8"));
    let file = user_dir.write("load.f", &by_name);
    let run =
        || slowed(&user_dir, &user_dir.run_with(&[("CPATH", user_dir.path("cpath"))], &user_deck(), &[&file], &[]));
    let first = run();
    user_dir.write("two.h", &header("2.d8"));
    assert!((run() / first - 2.0).abs() < 1e-6);
}

/// A run cannot be resumed with another user subroutine.
#[test]
fn checkpoint_is_rejected_after_a_changed_include() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    std::fs::create_dir_all(user_dir.path("inc")).expect("a folder");
    user_dir.write("inc/one.inc", "      include 'two.inc'\n");
    user_dir.write("two.inc", "      parameter (p0 = 1.d8)\n");
    let stops = "      include 'inc/one.inc'\n      value = p0\n      if (totalTime .gt. 1.d-4) call xplb_exit";
    let file = user_dir.write("load.f", &vdload(stops));
    let run = |more: &[&str]| user_dir.run(&user_deck(), &[&file], more);
    assert_eq!(run(&["--checkpoint-every", "5"]).status.code(), Some(1));
    assert_eq!(run(&["--resume"]).status.code(), Some(1), "the same subroutine resumes, and halts again");
    user_dir.write("two.inc", "      parameter (p0 = 2.d8)\n");
    let output = run(&["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", message_text(&output));
    assert!(message_text(&output).contains("K00"), "{}", message_text(&output));
}

#[test]
fn modified_library_is_never_loaded() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(FILL));
    let first = slowed(&user_dir, &user_dir.run(&user_deck(), &[&file], &[]));
    let [library] = &kept(&user_dir, "so")[..] else { panic!("one library") };
    let whole = std::fs::read(library).expect("a library");
    let other = user_dir.write("other.f", &vdload("      value = 3.d8"));
    slowed(&user_dir, &user_dir.run(&user_deck(), &[&other], &[]));
    let other_library = kept(&user_dir, "so").into_iter().find(|path| path != library).expect("another library");
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    let truncated = whole[..whole.len() / 3].to_vec();
    let record = library.with_extension("json");
    for (name, path, bytes) in [
        ("torn", library, truncated),
        ("one bit", library, flipped),
        ("another's", library, std::fs::read(other_library).expect("a library")),
        ("no record", &record, b"{".to_vec()),
    ] {
        std::fs::write(path, bytes).expect("a file");
        assert_eq!(slowed(&user_dir, &user_dir.run(&user_deck(), &[&file], &[])), first, "{name}");
        let text = std::fs::read_to_string(&record).expect("a record");
        let message_text: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let now = revolve::output::checkpoint::hash([std::fs::read(library).expect("a library").as_slice()]);
        assert_eq!(message_text["library"], now.as_str(), "{name}: compiled again and stored");
    }
}

#[test]
fn cache_folder_writable_by_others_is_not_used() {
    if !fortran() {
        return;
    }
    for open in ["cache/revolve", "cache/revolve/user"] {
        let user_dir = UserFolder::new();
        let file = user_dir.write("load.f", &vdload(FILL));
        let first = slowed(&user_dir, &user_dir.run(&user_deck(), &[&file], &[]));
        let mode = |name: &str| user_dir.path(name).metadata().expect("a folder").permissions().mode() & 0o777;
        assert_eq!(mode("cache/revolve/user"), 0o700);
        // Invalid libraries in the writable folder: if it were used, they would be replaced.
        for path in kept(&user_dir, "so") {
            std::fs::write(path, "of another").expect("a file");
        }
        std::fs::set_permissions(user_dir.path(open), std::fs::Permissions::from_mode(0o777)).expect("a mode");
        let loud = user_dir.command(&user_deck(), &[&file]).output().expect("it runs");
        assert_eq!(slowed(&user_dir, &loud), first);
        assert!(
            message_text(&loud).contains("U011") && message_text(&loud).contains("another user"),
            "{}",
            message_text(&loud)
        );
        for path in kept(&user_dir, "so") {
            assert_eq!(std::fs::read(path).expect("a file"), b"of another", "{open}: nothing is stored there");
        }
    }
}

#[test]
fn without_a_home_the_shared_folder_is_not_used() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(FILL));
    std::fs::create_dir(user_dir.path("shared")).expect("a folder");
    let mut command = user_dir.command(&user_deck(), &[&file]);
    command.env_remove("XDG_CACHE_HOME").env_remove("HOME").env("TMPDIR", user_dir.path("shared"));
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{}", message_text(&output));
    assert_eq!(std::fs::read_dir(user_dir.path("shared")).expect("a folder").count(), 0);
    assert!(!user_dir.path("cache").exists());
}

#[test]
fn least_recently_used_libraries_are_deleted() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let run = |pressure: &str| {
        let file = user_dir.write("load.f", &vdload(&format!("      value = {pressure}")));
        slowed(&user_dir, &user_dir.run(&user_deck(), &[&file], &[]));
    };
    run("1.d8");
    let old = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    let put = |path: &Path| {
        std::fs::write(path, "{}").expect("a file");
        std::fs::File::open(path).and_then(|file| file.set_modified(old)).expect("a time");
    };
    for i in 0..70 {
        put(&user_dir.path(&format!("cache/revolve/user/{i}.json")));
        put(&user_dir.path(&format!("cache/revolve/user/{i}.so")));
    }
    run("2.d8");
    assert_eq!((kept(&user_dir, "json").len(), kept(&user_dir, "so").len()), (64, 64));
    let built = kept(&user_dir, "so").iter().filter(|p| p.metadata().is_ok_and(|m| m.len() > 2)).count();
    assert_eq!(built, 2, "the two used last remain");
}
