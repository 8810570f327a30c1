//! Compilers of user subroutines: their errors, single precision, compilers other than gfortran, several libraries.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::subroutines::{FILL, UserFolder, fortran, message_text, user_deck, vdload};
use crate::common::project;

/// A power with a sign, of which gfortran warns.
const WARNED: &str = "      b = 2.d0**-0.5\n";

/// The first error is the first line of the compiler's output, however many warnings there are.
#[test]
fn errors_are_not_hidden_by_warnings() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let text = vdload(&(WARNED.repeat(40) + "      value(1) = undeclared%x\n"));
    let output = user_dir.run(&user_deck(), &[&user_dir.write("load.f", &text)], &[]);
    let message = message_text(&output);
    assert!(message.contains("U003") && message.contains("Error:"), "{message}");
    assert!(!message.contains("Warning") && message.lines().count() < 15, "{message}");
}

/// Functions of a file in single precision are compiled in double precision: in the first case gfortran reports an error,
/// in the others it silently passes eight bytes to an argument of four.
#[test]
fn single_precision_functions_are_promoted() {
    if !fortran() {
        return;
    }
    let depth = |helper: &str, call: &str| {
        let user_dir = UserFolder::new();
        let text = vdload(&format!("      value = 1.d8*{call}\n")) + helper;
        let output = user_dir.run(&user_deck(), &[&user_dir.write("load.f", &text)], &["--set", "V=569"]);
        assert!(output.status.success(), "{helper}: {}", message_text(&output));
        user_dir.depth("ogive_user")
    };
    let expected = depth("", "(1.d0/3.d0)");
    for helper in [
        "      real function f(x)\n      real x\n      f = 1./x\n      end\n",
        "      real*8 function f(x)\n      real x\n      f = 1./x\n      end\n",
        "      function f(x)\n      real*8 f\n      real*4 x\n      f = 1./x\n      end\n",
    ] {
        assert_eq!(depth(helper, "f(3.d0 + 0.d0*stepTime)"), expected, "{helper}");
    }
    let double = "      real*8 function f(x)\n      real*8 x\n      f = 1.d0/x\n      end\n";
    assert_eq!(depth(double, "f(3.)"), expected);
}

/// A program with another name is identified by its version text.
#[test]
fn unknown_compiler_is_reported_with_the_way_to_use_it() {
    let user_dir = UserFolder::new();
    let script = user_dir.write("ifx", "#!/bin/sh\necho 'ifx (IFX) 2024.2.0'\n");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).expect("permissions");
    let file = user_dir.write("load.f", &vdload(FILL));
    let output = user_dir.run_with(&[("FC", script)], &user_deck(), &[&file], &[]);
    let message = message_text(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for word in ["U002", "options", "-shared -fPIC -o user.so", "--user user.so"] {
        assert!(message.contains(word), "`{word}` in\n{message}");
    }
}

/// Returns the LLVM Flang of this machine, if there is one.
fn flang() -> Option<PathBuf> {
    let names = ["flang-new", "flang-new-19", "flang-20", "flang-21", "flang-22", "flang"];
    let is_new = |name: &&&str| {
        let version = Command::new(name).arg("--version").output().map(|o| o.stdout).unwrap_or_default();
        String::from_utf8_lossy(&version).contains("flang")
    };
    let found = names.iter().find(is_new).map(PathBuf::from);
    if found.is_none() {
        println!("left out: Flang (not installed)");
    }
    found
}

#[test]
fn flang_gives_the_digests_of_gfortran() {
    let Some(flang) = flang().filter(|_| fortran()) else { return };
    for (deck, routine) in [
        ("ogive_user", "vdload_cavity.f"),
        ("ogive_user", "vdload_table.f90"),
        ("ogive_user", "vdload_state.f"),
        ("taylor_vumat", "vumat_hardening.f90"),
    ] {
        let files = [project(&format!("input/{deck}.inp")), project(&format!("input/{routine}"))];
        let digest = |compiler: &Path| {
            let user_dir = UserFolder::new();
            let output = user_dir.run_with(&[("FC", compiler.to_owned())], &files[0], &[&files[1]], &[]);
            assert!(output.status.success(), "{routine}: {}", message_text(&output));
            user_dir.summary(deck)["digest"].as_str().expect("a digest").to_owned()
        };
        assert_eq!(digest(&flang), digest(Path::new("gfortran")), "{routine}");
    }
}

/// Errors before and during a run of a subroutine that Flang compiled.
#[test]
fn flang_errors_are_located() {
    let Some(flang) = flang() else { return };
    let late = |what: &str| format!("{FILL}      if (totalTime .gt. 1.d-5) then\n        {what}\n      end if");
    for (text, status, words) in [
        (vdload(FILL).replace("dirCos, jltyp, sname", "dirCos, sname"), 2, ["U004", "missing: jltyp"]),
        (vdload("      value(1 = 2"), 2, ["U003", "error:"]),
        (vdload("      call helper(value)"), 1, ["helper", "not defined"]),
        (vdload(&late("stop 'table exhausted'")), 1, ["STOP table exhausted", "increment"]),
        (vdload(&late("stop 7")), 1, ["STOP 7", "increment"]),
        (vdload(&late("error stop")), 1, ["ERROR STOP", "increment"]),
        (vdload(&late("call exit(3)")), 1, ["exit(3)", "increment"]),
        (vdload(&late("call xplb_exit")), 1, ["xplb_exit", "increment"]),
        (vdload(&late("value(2) = sqrt(-totalTime)")), 1, ["point 2", "NaN"]),
        (vdload(&late("open(9, file='absent.txt', status='old')")), 1, ["vdload", "increment"]),
    ] {
        let user_dir = UserFolder::new();
        let output =
            user_dir.run_with(&[("FC", flang.clone())], &user_deck(), &[&user_dir.write("load.f", &text)], &[]);
        let message = message_text(&output);
        assert_eq!(output.status.code(), Some(status), "{text}\n{message}");
        for word in words {
            assert!(message.contains(word), "`{word}` in\n{message}");
        }
    }
    let user_dir = UserFolder::new();
    let file = user_dir.write("load.f", &vdload(FILL));
    let output = user_dir.run_with(&[("FC", flang)], &user_deck(), &[&file], &["--check-user"]);
    assert!(message_text(&output).contains("--check-user requires gfortran"), "{}", message_text(&output));
}

/// What a subroutine of Flang wrote is complete, and its single precision functions are promoted.
#[test]
fn flang_writes_and_promotes_as_gfortran() {
    let Some(flang) = flang() else { return };
    for isolate in [&[][..], &["--isolate"]] {
        let user_dir = UserFolder::new();
        let text = vdload(
            "      value = 1.d8*f(3.d0)\n      if (totalTime .gt. 1.d-5) then\n        open(31, file='own.txt')\n        \
             write(31,*) value(1)\n        write(6,*) 'line of unit 6'\n        stop 'here'\n      end if\n",
        ) + "      real function f(x)\n      real x\n      f = 1./x\n      end\n";
        let file = user_dir.write("load.f", &text);
        let output = user_dir.run_with(&[("FC", flang.clone())], &user_deck(), &[&file], isolate);
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.code() == Some(1) && printed.contains("line of unit 6"), "{}", message_text(&output));
        let own = std::fs::read_to_string(user_dir.path("own.txt")).expect("a file");
        assert_eq!(own.trim().parse::<f64>(), Ok(1e8 / 3.0), "{isolate:?}");
    }
}

/// Two libraries have their own copy of a COMMON block, of which a note informs; sources given together share it.
#[test]
fn common_block_of_two_libraries_is_noted() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let external = "      subroutine vexternaldb(lOp, i_Array, niArray, r_Array, nrArray)\n      include 'vaba_param.inc'\n      \
                    dimension i_Array(niArray), r_Array(nrArray)\n      common /consts/ level\n      real*8 level\n      \
                    if (lOp .eq. 0) level = 2.d8\n      end\n";
    let load = vdload("      value = level\n").replace(
        "      character*80 sname\n",
        "      real*8 level\n      common /consts/ level\n      character*80 sname\n",
    );
    user_dir.write("vaba_param.inc", "      implicit real*8 (a-h,o-z)\n");
    let sources = [user_dir.write("external.f", external), user_dir.write("load.f", &load)];
    let libraries = sources.each_ref().map(|source| {
        let library = source.with_extension("so");
        let built = Command::new("gfortran").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(source).status();
        assert!(built.is_ok_and(|status| status.success()));
        library
    });
    let pressure = |files: &[PathBuf; 2]| {
        let mut command = user_dir.command(&user_deck(), &[&files[0], &files[1]]);
        let output = command.output().expect("the program runs");
        (user_dir.depth("ogive_user"), message_text(&output) + &String::from_utf8_lossy(&output.stdout))
    };
    let (separate, words) = pressure(&libraries);
    assert!(words.contains("U015") && words.contains("COMMON /consts/ is in `"), "{words}");
    let (together, words) = pressure(&sources);
    assert!(!words.contains("U015") && together != separate, "{separate} {together} {words}");
}
