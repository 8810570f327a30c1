//! Diagnostic codes of user routines (`U…`), for `revolve explain`.
//! Never here: the checks.

use crate::deck::Code;

/// All codes of this folder.
pub const CODES: &[Code] = codes! {
    "U001" "user file cannot be read" "`--user` takes Fortran (.f .for .f90 .F .F90), C (.c) or a ready shared library (.so)."
    "U002" "no compiler" "Fortran needs gfortran, C needs cc. On Debian or Ubuntu: apt install gfortran; on Fedora: dnf install gcc-gfortran. The variables FC and CC name others."
    "U003" "user file does not compile" "The compiler's own words follow. Fixed and free form have both been tried."
    "U004" "wrong arguments" "The subroutine's arguments are not those that it will be called with: their number, or integers and reals of another size. `include 'vaba_param.inc'` makes reals double precision, as they must be."
    "U005" "shared library cannot be loaded" "Most often it calls a routine that nothing defines. Revolve itself provides xplb_exit, xplb_abqerr, vgetjobname, vgetoutdir, vgetnumcpus, vgetrank, vgetinternal, vgetpartinfo, vgetvrm, vsprinc, vsprind, the sensor functions, the arrays of SMAAspUserSubroutines.hdr, mutexes, and MPI of one process; LAPACK is linked where the machine has it. What only an uncalled routine calls may be missing."
    "U006" "no known user routine" "The files define none of vdload, vuamp, vdisp, vumat, vuhard, vusdfld, vucharlength, vexternaldb."
    "U009" "routine that is never called" "The files hold a routine that nothing in this scene calls: the card that asks for it is missing, or it is one that Revolve does not have."
    "U010" "file that another one includes" "Two files were given, and one includes the other: it is compiled once, with that."
    "U007" "text past column 72" "In fixed form, text past column 72 is read as code, as ABAQUS's own compile command does; make sure that it is no sequence number."
    "U008" "third coordinate" "The source reads curCoords(k,3) or the like. An axisymmetric model has two coordinates, r and z. Where a run really computes with a third one, it halts and says so; a reading guarded by `if (ndim .gt. 2)` is fine."
    "U012" "routine that cannot be isolated" "`--isolate` runs the user's routines in a process of their own, over memory that it shares with the run. VUSDFLD asks the run for values while it is called, which is not done over there: files that hold it are refused. Without `--isolate` all routines run in the process of the run."
    "U013" "compiled user subroutines are not available" "Fortran, C and shared libraries need Linux with the GNU C library on x86-64 or aarch64. On macOS, on Windows and in the static musl binary everything else works, user subroutines in Rust and Python included."
    "U011" "cache that is not used" "Compiled routines are kept in `$XDG_CACHE_HOME/revolve/user` or `~/.cache/revolve/user`, and loaded into the program in a later run. That folder or the one above it belongs to another user, or others may write into it, or it cannot be made: nothing of it is loaded, and the routines are compiled for each run in a folder that goes with it. `chmod go-w` on both folders, or another XDG_CACHE_HOME, makes it good."
};
