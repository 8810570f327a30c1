//! The internal state of user subroutines after a restart.
//!
//! Goal: a resumed run has the bits of an uninterrupted one, or is rejected with the names of the state that cannot be
//! saved. Source: the uninterrupted run. Tolerance: none. The pressure of each subroutine depends on its internal
//! state.

use std::path::{Path, PathBuf};

use super::subroutines::{UserFolder, fortran, message_text, user_deck, vdload};

/// Statement that ends a run halfway unless an environment variable is set.
const END_FORTRAN: &str =
    "      call get_environment_variable('GO', status=igo)\n      if (totalTime .gt. 1.d-4 .and. igo .ne. 0) stop\n";
const END_C: &str = "if (*tt > 1e-4 && !getenv(\"GO\")) xplb_exit_();";

/// Writes a load in C with internal state.
fn load(user_dir: &UserFolder, name: &str, before: &str, remembered: &str) -> PathBuf {
    let text = format!(
        "#include <stdlib.h>\n#include <stdio.h>\nvoid xplb_exit_(void);\n{before}\n\
         void vdload_(const int *nblock, const int *ndim, const double *st, const double *tt, const double *amplitude,\n \
         const double *x, const double *v, const double *d, const int *jltyp, const char *sname, double *value, long n)\n{{\n  \
         {END_C}\n  double remembered;\n  {remembered}\n  for (int k = 0; k < *nblock; k++) value[k] = 1e8 + 1e5*remembered;\n}}\n"
    );
    user_dir.write(&format!("{name}.c"), &text)
}

fn go() -> [(&'static str, PathBuf); 1] {
    [("GO", PathBuf::from("1"))]
}

fn digest(user_dir: &UserFolder) -> String {
    user_dir.summary("ogive_user")["digest"].as_str().expect("a digest").to_owned()
}

/// Asserts that an interrupted and resumed run has the bits of the whole run, without a warning about lost state.
fn assert_resumes(files: impl Fn(&UserFolder) -> PathBuf) {
    let user_dir = UserFolder::new();
    let file = files(&user_dir);
    let whole = user_dir.run_with(&go(), &user_deck(), &[&file], &[]);
    assert!(whole.status.success(), "{}", message_text(&whole));
    let expected = digest(&user_dir);
    let every = ["--checkpoint-every", "5"];
    let output = user_dir.run(&user_deck(), &[&file], &every);
    assert_eq!(output.status.code(), Some(1), "{}", message_text(&output));
    let output = user_dir.run_with(&go(), &user_deck(), &[&file], &["--resume"]);
    assert!(output.status.success(), "{}", message_text(&output));
    let summary = user_dir.summary("ogive_user");
    assert!(summary["timing"]["resumed_at"].as_u64() > Some(0), "{summary}");
    assert_eq!(digest(&user_dir), expected, "{}", file.display());
    assert!(!summary["diagnostics"].to_string().contains("K102"), "{summary}");
}

#[test]
fn save_common_and_modules_are_restored() {
    if !fortran() {
        return;
    }
    assert_resumes(|user_dir| {
        let module =
            "      module law\n        real*8 :: total = 1.d0\n        integer*2 :: seen(5) = 7\n      end module\n";
        let body = format!(
            "      common /state/ before(1000), mark\n      character*8 word\n      integer*1 small\n      save kept, word, small\n      \
             data kept /3/, word /'begins'/, small /1/\n{END_FORTRAN}      kept = kept + 1\n      small = int(mod(kept, 100), 1)\n      \
             total = total + velocity(1,2)*1.d-3\n      seen(mod(kept,5)+1) = int(mod(kept, 1000), 2)\n      \
             before(mod(kept,1000)+1) = kept*0.125d0\n      mark = mark + 1\n      write(word, '(i8)') kept\n      \
             read(word, '(i8)') iback\n      do k = 1, nblock\n        \
             value(k) = 1.d8 + 1.d5*(kept + small + iback + mark + sum(seen) + sum(before)) + total\n      end do\n"
        );
        let routine = vdload(&body).replacen("sname, value)\n", "sname, value)\n      use law\n", 1);
        user_dir.write("keeps.f", &(module.to_owned() + &routine))
    });
}

#[test]
fn static_variables_and_host_arrays_are_restored() {
    assert_resumes(|user_dir| {
        let before =
            "static double sum = 2; static struct { char mark; short count; float part[3]; } all = {'x', 4, {1}};";
        let remembered = "sum += v[0]; all.count++; all.part[all.count % 3] += 0.5f; all.mark = 'a' + all.count % 26;\n  \
                          remembered = sum + all.count + all.part[0] + all.part[1] + all.mark;";
        load(user_dir, "keeps", before, remembered)
    });
    assert_resumes(|user_dir| {
        let before = "double *smafloatarraycreatedp_(const int *, const int *, const double *);";
        let remembered = "int id = 4, size = 70; double start = 1.5;\n  double *all = smafloatarraycreatedp_(&id, &size, &start);\n  \
                          all[3] += 1; all[69] += all[3]; remembered = all[69];";
        load(user_dir, "arrays", before, remembered)
    });
}

/// Changes of memory by the call at the start of the resumed analysis are reverted.
#[test]
fn first_call_after_resume_resets_nothing() {
    assert_resumes(|user_dir| {
        let before = "static int count, begins;\n\
             void vexternaldb_(const int *lop, int *i, const int *ni, double *r, const int *nr)\n\
             { if (*lop == 0) { count = 100; begins++; } if (*lop == 4) count += 2; }";
        load(user_dir, "events", before, "count++; remembered = count + 10*begins;")
    });
}

/// Asserts that a run whose state is incomplete is rejected with the given words, and resumed if the user accepts the
/// loss.
fn is_refused(user_dir: &UserFolder, file: &Path, words: &[&str]) {
    let output = user_dir.run(&user_deck(), &[file], &["--checkpoint-every", "5"]);
    assert_eq!(output.status.code(), Some(1), "{}", message_text(&output));
    let noted = || user_dir.summary("ogive_user")["diagnostics"].to_string();
    assert!(noted().contains("K102"), "{}: {}", file.display(), noted());
    let output = user_dir.run_with(&go(), &user_deck(), &[file], &["--resume"]);
    assert_eq!(output.status.code(), Some(2), "{}", message_text(&output));
    for word in ["K009", "--resume-anyway"].iter().chain(words) {
        assert!(message_text(&output).contains(word), "`{word}` in\n{}", message_text(&output));
    }
    let output = user_dir.run_with(&go(), &user_deck(), &[file], &["--resume-anyway"]);
    assert!(output.status.success() && message_text(&output).contains("K102"), "{}", message_text(&output));
    let summary = user_dir.summary("ogive_user");
    assert!(summary["timing"]["resumed_at"].as_u64() > Some(0) && noted().contains("K102"), "{summary}");
    for word in words {
        assert!(noted().contains(word), "`{word}` in {}", noted());
    }
}

#[test]
fn process_specific_state_is_named() {
    for (name, before, remembered, words) in [
        (
            "address",
            "static double *table;",
            "if (!table) table = calloc(9, 8); remembered = table[1] += 1;",
            "`table`",
        ),
        ("itself", "static int all[9], *volatile last;", "last = all + 2; remembered = *last += 1;", "`last`"),
        (
            "packed",
            "static volatile struct __attribute__((packed)) { int first; char *text; } odd;",
            "odd.first++; odd.text = (char *)tt; remembered = odd.first;",
            "`odd`, byte 4,",
        ),
        ("thread", "static __thread int own = 4;", "remembered = own++;", "`own`"),
        ("seed", "", "remembered = rand() % 100;", "`rand`"),
        (
            "file",
            "#include <fcntl.h>\nstatic int file = -1, count;",
            "if (file < 0) file = open(\"/etc/hostname\", O_RDONLY); remembered = count++;",
            "/etc/hostname is open",
        ),
    ] {
        let user_dir = UserFolder::new();
        let file = load(&user_dir, name, before, remembered);
        let source = if ["thread", "address", "itself", "packed", "seed"].contains(&name) {
            format!("{name}.c")
        } else {
            String::new()
        };
        is_refused(&user_dir, &file, &[words, &source]);
    }
}

#[test]
fn allocated_arrays_and_open_units_are_named() {
    if !fortran() {
        return;
    }
    let user_dir = UserFolder::new();
    let module = "      module law\n        real*8, allocatable :: table(:)\n      end module\n";
    let body = format!(
        "{END_FORTRAN}      if (.not. allocated(table)) then\n        allocate(table(9))\n        table = 0\n      end if\n      \
         table(2) = table(2) + 1\n      value(1:nblock) = 1.d8 + 1.d5*table(2)\n"
    );
    let routine = vdload(&body).replacen("sname, value)\n", "sname, value)\n      use law\n", 1);
    is_refused(
        &user_dir,
        &user_dir.write("law.f", &(module.to_owned() + &routine)),
        &["`table` of module `law`", "law.f"],
    );
    let user_dir = UserFolder::new();
    let body = format!(
        "      save nth\n      data nth /0/\n{END_FORTRAN}      nth = nth + 1\n      if (nth .eq. 1) open(31, file='told.txt')\n      \
         write(31, *) nth\n      value(1:nblock) = 1.d8 + 1.d5*nth\n"
    );
    let file = user_dir.write("writes.f", &vdload(&body));
    is_refused(&user_dir, &file, &["told.txt is open"]);
}

/// If only a file is lost, all variables are still restored.
#[test]
fn lost_file_does_not_affect_variables() {
    let user_dir = UserFolder::new();
    let before = "static int count;\n#include <fcntl.h>\n\
        void vexternaldb_(const int *lop, int *i, const int *ni, double *r, const int *nr)\n\
        { if (*lop == 0) open(\"/etc/hostname\", O_RDONLY); }";
    let file = load(&user_dir, "logs", before, "remembered = count++;");
    let whole = user_dir.run_with(&go(), &user_deck(), &[&file], &[]);
    assert!(whole.status.success(), "{}", message_text(&whole));
    let expected = digest(&user_dir);
    is_refused(&user_dir, &file, &["/etc/hostname is open"]);
    assert_eq!(digest(&user_dir), expected);
}
