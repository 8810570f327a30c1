//! Styles of existing user files: headers, Cray pointers, persistent arrays, mutexes, MPI with one process, helpers
//! with any name, subroutines for three dimensions, unused subroutines with undefined symbols.
//!
//! Goal: files accepted by the compile command of ABAQUS are accepted, and unsupported ones are rejected by name. Needs
//! gfortran; without it these tests are left out, except in CI.

use std::path::PathBuf;

use revolve::job;
use revolve::user::Routines;
use revolve::user::compile::compile;

use crate::common::{self, RecordedOutput};
use crate::material::{last, moving, taylor};

/// Writes files into a new folder and compiles the first.
fn opened(files: &[(&str, &str)]) -> Result<Routines, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.path().join(name)).collect();
    for (path, (_, text)) in paths.iter().zip(files) {
        std::fs::write(path, text).expect("a file");
    }
    let rendered = |found: revolve::deck::Diagnostics| found.render(&revolve::deck::Sources::default());
    let compiled = compile(&paths[..1], false).map_err(rendered)?;
    compiled.open().map_err(|d| format!("{} {} {}", d.code, d.message, d.help.unwrap_or_default()))
}

/// Returns an elastic VUMAT in fixed form with additional lines before and inside its loop; `info` and `step` are the
/// names of its seventh and tenth arguments.
fn vumat((block, info, step): (&str, &str, &str), head: &str, declared: &str, inside: &str) -> String {
    format!(
        "{head}      subroutine vumat({block}, ndir, nshr, nstatev, nfieldv,\n     1 nprops, {info}, stepTime, totalTime, {step}, \
         cmname, coordMp,\n     2 charLength, props, density, strainInc, relSpinInc, tempOld,\n     3 stretchOld, defgradOld, \
         fieldOld, stressOld, stateOld,\n     4 enerInternOld, enerInelasOld, tempNew, stretchNew,\n     5 defgradNew, fieldNew, \
         stressNew, stateNew, enerInternNew,\n     6 enerInelasNew)\n{declared}      do k = 1, nblock\n        tr = \
         strainInc(k,1) + strainInc(k,2) + strainInc(k,3)\n        do j = 1, ndir + nshr\n          stressNew(k,j) = \
         stressOld(k,j) + props(2)*strainInc(k,j)\n        end do\n        do j = 1, ndir\n          stressNew(k,j) = \
         stressNew(k,j) + props(1)*tr\n        end do\n{inside}      end do\n      return\n      end\n"
    )
}

const PLAIN: (&str, &str, &str) = ("nblock", "lanneal", "dt");

const DECLARED: &str = "      include 'vaba_param.inc'\n      character*80 cmname\n      dimension props(nprops), \
                        stressOld(nblock,ndir+nshr),\n     1 stressNew(nblock,ndir+nshr), strainInc(nblock,ndir+nshr),\n     \
                        2 stateOld(nblock,nstatev), stateNew(nblock,nstatev),\n     3 density(nblock)\n";

const LAW: &str = "*User Material, constants=2\n 500., 800.\n*Depvar\n 2,\n";

/// Returns a sheared tube whose elements with the user material have the numbers 1 to 4.
fn tube(outputs: &str) -> String {
    moving(|[r, z]| [0.1 * z, 0.1 * r], LAW, outputs)
}

/// Runs the tube with these files; returns the final value of the first state variable of element 1.
fn state(files: &[(&str, &str)]) -> f64 {
    let routines = opened(files).unwrap_or_else(|rendered| panic!("{rendered}\n{}", files[0].1));
    let text = tube(" S, SDV\n");
    let mut memory = RecordedOutput::default();
    let (outcome, _) = job::run_into(&common::prepared(&text, &[], &routines), &mut memory);
    assert_eq!(outcome.halt, None, "{}", files[0].1);
    last(&text, &routines, &memory, "SDV1@ONE")
}

fn fortran() -> bool {
    common::fortran("user files as they are about")
}

#[test]
fn element_numbers_are_passed_in_block_and_pointer() {
    if !fortran() {
        return;
    }
    let arrays =
        DECLARED.replace("      character", "      dimension jblock(*), jInfoArray(*), dtArray(*)\n      character");
    let arrays = arrays.replace("cmname\n", "cmname\n      pointer (ptr, jElem)\n      dimension jElem(*)\n");
    let declared = arrays.replace("(nblock", "(jblock(1)")
        + "      nblock = jblock(1)\n      ptr = loc(jInfoArray(jInfoArray(6)))\n      dt = dtArray(1)\n";
    let inside = "        stateNew(k,1) = 100*jblock(4+k) + jElem(k) + jInfoArray(1)\n";
    let text = vumat(("jblock", "jInfoArray", "dtArray"), "", &declared, inside);
    assert_eq!(state(&[("law.f", &text)]), 101.0);
}

#[test]
fn unassigned_state_variables_keep_their_value() {
    if !fortran() {
        return;
    }
    let text = vumat(PLAIN, "", DECLARED, "        if (stepTime .gt. 0.) stateNew(k,1) = stateOld(k,1) + 1.\n");
    assert_eq!(state(&[("law.for", &text)]), 1000.0);
}

/// Typical for rubber: the subroutine has no special case for time zero, and its stress depends on the stretch only.
#[test]
fn stress_from_stretch_is_valid_at_time_zero() {
    if !fortran() {
        return;
    }
    let declared = DECLARED.replace("      character", "      dimension stretchNew(nblock,ndir+nshr)\n      character");
    let inside = "        do j = 1, ndir + nshr\n          one = 0.d0\n          if (j .le. ndir) one = 1.d0\n          stressNew(k,j) \
                  = props(2)*(stretchNew(k,j) - one)\n        end do\n";
    let routines = opened(&[("law.f", &vumat(PLAIN, "", &declared, inside))]).expect("it compiles");
    let text = tube(" S\n");
    let mut memory = RecordedOutput::default();
    let (outcome, _) = job::run_into(&common::prepared(&text, &[], &routines), &mut memory);
    assert_eq!(outcome.halt, None);
    // Velocities of 0.1 for a time of 1: the deformation gradient is symmetric, the stretch itself, with 0.1 off the
    // diagonal; rounding of 1000 increments.
    let shear = last(&text, &routines, &memory, "S12@ONE");
    assert!((shear - 80.0).abs() < 1e-9, "{shear}");
}

/// Typical triaxiality at zero stress, a NaN that ABAQUS/Explicit accepts.
#[test]
fn nan_state_variables_are_reported_and_kept() {
    if !fortran() {
        return;
    }
    let inside = "        stateNew(k,1) = 7.d0\n        zero = 0.d0*tr\n        stateNew(k,2) = zero/zero\n";
    let routines = opened(&[("law.f", &vumat(PLAIN, "", DECLARED, inside))]).expect("it compiles");
    let text = tube(" S, SDV\n");
    let mut memory = RecordedOutput::default();
    let (outcome, _) = job::run_into(&common::prepared(&text, &[], &routines), &mut memory);
    assert_eq!(outcome.halt, None);
    assert_eq!(last(&text, &routines, &memory, "SDV1@ONE"), 7.0);
    assert!(last(&text, &routines, &memory, "SDV2@ONE").is_nan());
    let message_text = revolve::user::host::take_messages();
    assert!(
        message_text.len() == 1 && message_text[0].text.contains("stateNew(k, 2) = NaN") && message_text[0].times == 1,
        "{message_text:?}"
    );
}

/// Constructs that other compilers accept.
#[test]
fn logicals_and_dec_extensions_compile() {
    if !fortran() {
        return;
    }
    let declared = DECLARED.to_owned()
        + "      structure /pair/\n        real*8 a, b\n      end structure\n      record /pair/ two\n      logical done\n      \
           two.a = 3.d0\n      done = .false.\n      do while (done == .false.)\n        done = .true.\n      end do\nD     two.a = \
           4.d0\n";
    assert_eq!(state(&[("law.f", &vumat(PLAIN, "", &declared, "        stateNew(k,1) = two.a\n"))]), 3.0);
}

#[test]
fn persistent_arrays_mutexes_and_mpi_are_available() {
    if !fortran() {
        return;
    }
    let declared = DECLARED.to_owned()
        + "#include <SMAAspUserSubroutines.hdr>\n      include 'mpif.h'\n      integer numbers(10)\n      real*8 reals(10)\n      \
           pointer (ptrn, numbers)\n      pointer (ptrr, reals)\n      if (stepTime .eq. 0.) then\n        ptrn = \
           SMAIntArrayCreate(1, 10, 5)\n        ptrr = SMAFloatArrayCreate(7, 10, 0.25)\n      end if\n      call MutexInit(1)\n      \
           call MutexLock(1)\n      ptrn = SMAIntArrayAccess(1)\n      ptrr = SMAFloatArrayAccess(7)\n      numbers(2) = \
           numbers(2) + 1\n      call MutexUnlock(1)\n      call MPI_Comm_size(MPI_COMM_WORLD, isize, ierr)\n      call \
           MPI_Allreduce(reals(3), total, 1, MPI_DOUBLE_PRECISION,\n     1 MPI_SUM, MPI_COMM_WORLD, ierr)\n";
    let inside = "        stateNew(k,1) = numbers(2) + total + isize\n     1 + SMAIntArraySize(1) + getNumThreads() + \
                  get_thread_id()\n";
    let text = vumat(PLAIN, "", &declared, inside);
    // Called once at time zero and in each of 1000 increments: 5 + 1001 + 0.25 + 1 + 10 + 1 + 0.
    assert_eq!(state(&[("law.f", &text)]), 1018.25);
    // The header at the top of the file, a common style.
    let below = text.replace("#include <SMAAspUserSubroutines.hdr>\n", "");
    assert_eq!(state(&[("law.f", &("#include <SMAAspUserSubroutines.hdr>\n".to_owned() + &below))]), 1018.25);
}

#[test]
fn includes_in_any_case_and_empty_arguments_compile() {
    if !fortran() {
        return;
    }
    let declared = DECLARED.replace("'vaba_param.inc'", "'..\\Vaba_Param_DP.INC'");
    let inside = "        stateNew(k,1) = seven()\n        if (tr .gt. 1.) call xplb_abqerr(-3,'too far (%I)',k,,)\n        if (tr \
                  .gt. 1.) call xplb_abqerr(1,'far',\n     1  ,,)\n";
    let text = vumat(PLAIN, "#include 'Helper.f'\n", &declared, inside);
    let helper = "      real*8 function seven()\n      seven = 7.d0\n      end\n";
    // The function has the type of implicit reals.
    assert_eq!(state(&[("law.f", &text), ("helper.f", helper)]), 7.0);
    let message_text = text.replace(".gt. 1.) call xplb_abqerr(-3", ".gt. -1.) call xplb_abqerr(-3");
    let routines = opened(&[("law.f", &message_text), ("helper.f", helper)]).expect("it compiles");
    let halt = common::run(&tube(" S\n"), &[], &routines).0.halt.expect("a halt");
    assert!(halt.message().contains("too far (1)"), "{halt:?}");
}

#[test]
fn free_form_modules_saved_data_and_helpers_run() {
    if !fortran() {
        return;
    }
    // A helper with the name of another ABAQUS subroutine but other arguments.
    let helper = "      subroutine vuhard(syield, hard, eqplas, table, n)\n      include 'vaba_param.inc'\n      dimension \
                  table(2,n)\n      syield = table(1,n)\n      hard = 0.d0\n      end\n      subroutine vsprinc(a)\n      real*8 a\n      \
                  a = 3.d0\n      end\n";
    let declared = DECLARED.to_owned()
        + "      dimension table(2,1)\n      integer calls\n      save calls\n      data calls /0/\n      table(1,1) = 2.d0\n      calls = \
           calls + 1\n      call vuhard(syield, hard, 0.d0, table, 1)\n      call vsprinc(three)\n";
    let inside = "        stateNew(k,1) = calls + syield + three\n";
    assert_eq!(state(&[("law.f", &(vumat(PLAIN, "", &declared, inside) + helper))]), 1001.0 + 2.0 + 3.0);
    let free = "module constants\n  implicit none\n  real(8), parameter :: one = 1.d0\nend module\n\
        subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &\n\
        charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, stressOld, stateOld, &\n\
        enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, \
        enerInelasNew)\n  use constants\n  implicit none\n  integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, \
        lanneal\n  real(8), intent(in) :: stepTime, totalTime, dt\n  character(len=80), intent(in) :: cmname\n  real(8) :: \
        coordMp(nblock,*), charLength(nblock), props(nprops), density(nblock), strainInc(nblock,ndir+nshr), &\n    \
        relSpinInc(nblock,nshr), tempOld(nblock), stretchOld(nblock,ndir+nshr), defgradOld(nblock,ndir+nshr+nshr), &\n    \
        fieldOld(nblock,nfieldv), stressOld(nblock,ndir+nshr), stateOld(nblock,nstatev), enerInternOld(nblock), &\n    \
        enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock,ndir+nshr), defgradNew(nblock,ndir+nshr+nshr), &\n    \
        fieldNew(nblock,nfieldv), stressNew(nblock,ndir+nshr), stateNew(nblock,nstatev), enerInternNew(nblock), \
        enerInelasNew(nblock)\n  stressNew = stressOld + props(2)*strainInc\n  stressNew(:,1:3) = stressNew(:,1:3) + \
        props(1)*spread(sum(strainInc(:,1:3), 2), 2, 3)\n  stateNew(:,1) = one + len_trim(cmname)\nend subroutine\n";
    assert_eq!(state(&[("law.f90", free)]), 2.0);
}

/// Files for the single precision executable of ABAQUS declare `real` or `real*4` arguments. They are compiled in double
/// precision: the state is a third to 1e-15. `cmname` need not be declared.
#[test]
fn single_precision_is_promoted() {
    if !fortran() {
        return;
    }
    let inside = "        stateNew(k,1) = 1./3.\n";
    for kind in ["real", "real*4"] {
        let own = format!("      implicit {kind} (a-h,o-z)\n");
        let declared = DECLARED.replace("      include 'vaba_param.inc'\n      character*80 cmname\n", &own);
        assert_eq!(state(&[("law.f", &vumat(PLAIN, "", &declared, inside))]), 1.0 / 3.0, "{kind}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("law.f");
    let declared = DECLARED.replace("      include 'vaba_param.inc'\n", "      implicit real (a-h,o-z)\n");
    std::fs::write(&path, vumat(PLAIN, "", &declared, inside)).expect("a file");
    // The second compilation may be from the cache, which keeps the note.
    for _ in 0..2 {
        let compiled = compile(std::slice::from_ref(&path), false).unwrap_or_else(|_| panic!("it compiles"));
        assert_eq!(compiled.notes.iter().filter(|note| note.code == "U014").count(), 1);
    }
}

#[test]
fn three_dimensional_subroutine_is_reported() {
    if !fortran() {
        return;
    }
    let three = vumat(PLAIN, "", DECLARED, "").replace("do j = 1, ndir + nshr", "do j = 1, 6");
    for text in [tube(" S\n"), taylor(LAW, "S")] {
        let routines = opened(&[("law.f", &three)]).expect("it compiles");
        let halt = common::run(&text, &[], &routines).0.halt.expect("a halt");
        assert!(halt.message().contains("uses 6 components, an axisymmetric solid has 4"), "{halt:?}");
    }
}

#[test]
fn undefined_symbols_of_unused_routines_are_accepted() {
    if !fortran() {
        return;
    }
    let inside = "        stateNew(k,1) = 1.\n";
    let hole = "      subroutine vusdfld(a)\n      real*8 a\n      call nowhere(a)\n      end\n";
    let text = vumat(PLAIN, "", DECLARED, inside) + hole;
    assert_eq!(state(&[("law.f", &text)]), 1.0);
    let called = vumat(PLAIN, "", DECLARED, "        call nowhere(tr)\n");
    let rendered = opened(&[("law.f", &called)]).err().expect("it is rejected");
    assert!(
        rendered.contains("U005") && rendered.contains("vumat calls `nowhere`, which is not defined"),
        "{rendered}"
    );
}

#[test]
fn unused_subroutines_are_reported_by_name() {
    if !fortran() {
        return;
    }
    let more = "      subroutine vuinter\n      end\n";
    let routines = opened(&[("law.f", &(vumat(PLAIN, "", DECLARED, "") + more))]).expect("it compiles");
    let plain = moving(|[_, z]| [0.0, z], "*Elastic\n 1., 0.3\n", " S\n");
    let prepared = job::prepare_text("test.inp", &plain, &[], &routines);
    let notes: Vec<&str> =
        prepared.diagnostics.iter().filter(|d| d.code == "U009").map(|d| d.message.as_str()).collect();
    assert!(notes[0].contains("`vumat`") && notes[0].contains("*USER MATERIAL"), "{notes:?}");
    assert!(notes[1].contains("`vuinter`") && notes[1].contains("does not support it"), "{notes:?}");
    // A file with another subroutine is reported with its name.
    let rendered = opened(&[("other.f", "      subroutine umat(a)\n      end\n")]).err().expect("it is rejected");
    assert!(rendered.contains("U006") && rendered.contains("other.f") && rendered.contains("umat"), "{rendered}");
    assert!(!rendered.contains(".cache") && !rendered.contains(".so"), "{rendered}");
    // A file with another subroutine in addition to the requested one.
    let routines = opened(&[("law.f", &vumat(PLAIN, "", DECLARED, ""))]).expect("it compiles");
    let loaded = plain.replace("*End Step", "*Dsload\n I1, PNU\n*End Step");
    let prepared = job::prepare_text("test.inp", &loaded, &[], &routines);
    let rendered = prepared.diagnostics.render(&prepared.deck.sources);
    assert!(rendered.contains("P004") && rendered.contains("do not define it"), "{rendered}");
}

/// Users often pass all their files, including those that the first one includes.
#[test]
fn included_user_file_is_compiled_once() {
    if !fortran() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let [law, inner] = ["law.f", "inner.f"].map(|name| folder.path().join(name));
    let text =
        "      include 'inner.f'\n".to_owned() + &vumat(PLAIN, "", DECLARED, "        stateNew(k,1) = twice(3.d0)\n");
    std::fs::write(&law, text.replace("      do k = 1, nblock", "      real*8 twice\n      do k = 1, nblock"))
        .expect("a file");
    let helper = "      real*8 function twice(x)\n      real*8 x\n      twice = 2*x\n      end\n";
    std::fs::write(&inner, helper).expect("a file");
    for files in [[law.clone(), inner.clone()], [inner, law]] {
        let compiled =
            compile(&files, false).unwrap_or_else(|d| panic!("{}", d.render(&revolve::deck::Sources::default())));
        let message_text: Vec<_> =
            compiled.notes.iter().filter(|n| n.code == "U010").map(|n| n.message.clone()).collect();
        assert!(message_text.len() == 1 && message_text[0].contains("inner.f` is included by"), "{message_text:?}");
        assert!(compiled.open().is_ok());
    }
}
