//! What user subroutines write: units of Fortran, own files, messages.
//!
//! Goal: it is complete when a run ends, halts, or the subroutine ends the process, also with `--isolate`.

use super::subroutines::{FILL, UserFolder, fortran, message_text, user_deck, vdload};
use crate::common::project;

/// Returns a VDLOAD that writes one line to each unit and a message, and then executes a statement.
fn writes_and(ends: &str) -> String {
    vdload(&format!(
        "{FILL}      if (totalTime .gt. 1.d-5 .and. last .eq. 0) then\n        last = 1\n        open(31, file='own.txt')\n        \
         write(31,*) 'line of an own file'\n        write(*,*) 'line of unit *'\n        write(6,*) 'line of unit 6'\n        \
         write(0,*) 'line of unit 0'\n        write(7,*) 'line of unit 7'\n        \
         call xplb_abqerr(-2, 'message of %I', 7, 0.d0, ' ')\n        {ends}\n      end if\n"
    ))
    .replace("      character*80 sname\n", "      character*80 sname\n      integer, save :: last = 0\n")
}

#[test]
fn written_lines_are_complete_however_the_run_ends() {
    if !fortran() {
        return;
    }
    for (ends, status) in [
        ("", 0),
        ("stop 'MY STOP TEXT'", 1),
        ("write(6,*) stops(1)", 1),
        ("call exit(3)", 1),
        ("open(101, file='absent.txt', status='old')", 1),
        ("read(31,*) i", 1),
        ("value(1) = sqrt(-totalTime)", 1),
    ] {
        for isolate in [&[][..], &["--isolate"]] {
            let user_dir = UserFolder::new();
            let helper = "      integer function stops(i)\n      stop 'within a WRITE statement'\n      end\n";
            let text =
                writes_and(ends).replace("      integer, save", "      integer stops\n      integer, save") + helper;
            // A regular file, to which gfortran writes in blocks.
            let terminal = std::fs::File::create(user_dir.path("printed")).expect("a file");
            let mut command = user_dir.command(&user_deck(), &[&user_dir.write("load.f", &text)]);
            let output = command.arg("--quiet").args(isolate).stdout(terminal).output().expect("the program runs");
            let printed = std::fs::read_to_string(user_dir.path("printed")).expect("a file");
            let messages = message_text(&output);
            let case = format!("{ends} {isolate:?}:\n{printed}\n{messages}");
            assert_eq!(output.status.code(), Some(status), "{case}");
            assert!(printed.contains("line of unit *\n line of unit 6\n"), "{case}");
            assert!(messages.contains("line of unit 0\n") && messages.contains("message of 7"), "{case}");
            for (file, line) in [("own.txt", " line of an own file\n"), ("fort.7", " line of unit 7\n")] {
                assert_eq!(std::fs::read_to_string(user_dir.path(file)).expect("a file"), line, "{case}");
            }
        }
    }
}

/// VEXTERNALDB writes at the start and end of the analysis and of its step.
#[test]
fn isolated_report_file_is_complete() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let text = "      subroutine vexternaldb(lOp, i_Array, niArray, r_Array, nrArray)\n      include 'vaba_param.inc'\n      \
                dimension i_Array(niArray), r_Array(nrArray)\n      if (lOp .eq. 0) open(unit=31, file='report.txt')\n      \
                if (lOp .ne. 2 .and. lOp .ne. 3 .and. lOp .ne. 4) write(31,*) 'lOp', lOp\n      end\n";
    let files = [user_dir.write("report.f", text), project("input/vumat_hardening.f90")];
    let deck = project("input/taylor_vumat.inp");
    let output = user_dir.run(&deck, &[&files[0], &files[1]], &["--isolate"]);
    assert!(output.status.success(), "{}", message_text(&output));
    let report = std::fs::read_to_string(user_dir.path("report.txt")).expect("a file");
    let moments: Vec<&str> = report.lines().filter_map(|line| line.split_whitespace().last()).collect();
    assert_eq!(moments, ["0", "1", "5", "6"]);
}
