//! Diagnostic codes of user subroutines (`U…`), with the texts of `revolve explain`.

use revolve_numerics::codes;

use revolve_diagnostics::DiagnosticCode;

/// Diagnostic codes of user subroutines.
pub const CODES: &[DiagnosticCode] = codes! {
    "U001" "user file cannot be read" "`--user` takes Fortran (.f .for .f90 .F .F90), C (.c) or a ready shared library (.so)."
    "U002" "no compiler" "Fortran needs gfortran or flang, C needs cc. On Debian or Ubuntu: apt install gfortran; on Fedora: dnf install gcc-gfortran. Other compilers can be set in the environment variables FC and CC. A Fortran compiler with other options must make a shared library, which is then given to `--user`: for example `ifx -shared -fPIC -O2 -o user.so vumat.f`."
    "U003" "user file does not compile" "The errors of the compiler follow, without its warnings. Both fixed and free form were tried."
    "U004" "wrong arguments" "The subroutine's arguments differ from those of the call in their number, or in the size of integers or reals. Reals must be double precision; `include 'vaba_param.inc'` declares them so."
    "U005" "shared library cannot be loaded" "Usually the library calls a function that is not defined. Revolve provides xplb_exit, xplb_abqerr, vgetjobname, vgetoutdir, vgetnumcpus, vgetrank, vgetinternal, vgetpartinfo, vgetvrm, vsprinc, vsprind, the sensor functions, the arrays of SMAAspUserSubroutines.hdr, mutexes, and MPI of one process; LAPACK is linked if it is installed. Functions that are called only by unused subroutines may be undefined."
    "U006" "no known user subroutine" "The files define none of vdload, vuamp, vdisp, vumat, vuanisohyper_inv, vuhard, vusdfld, vufield, vfriction, vucharlength, vexternaldb."
    "U009" "user subroutine that is never called" "The files define a subroutine that this model never calls: the keyword that requests it is missing, or Revolve does not support the subroutine."
    "U010" "file included by another one" "Two files were given, and one includes the other. The included file is compiled once, as part of the other."
    "U007" "text past column 72" "In fixed form, text past column 72 is read as code, as by the ABAQUS compile command. Check that it is not a sequence number."
    "U008" "third coordinate" "The source reads curCoords(k,3) or a similar element. An axisymmetric model has two coordinates, r and z. A run that computes with the third one halts with a message; a read guarded by `if (ndim .gt. 2)` is allowed."
    "U012" "user subroutine that cannot be isolated" "`--isolate` runs user subroutines in a separate process, which shares memory with the run. VUSDFLD requests values from the run during a call, which the separate process does not support, so files that define it are rejected. Without `--isolate` all user subroutines run in the process of the run."
    "U013" "compiled user subroutines are not available" "Fortran, C and shared libraries require Linux with the GNU C library on x86-64 or aarch64. On macOS, on Windows and in the static musl binary all other features work, including user subroutines in Rust and Python."
    "U014" "subroutine in single precision" "The file declares arguments in single precision (`real`, `real*4`), as for the single precision executable of ABAQUS/Explicit, or a function of the file is called with arguments or a result of the other precision. Revolve passes double precision, so the whole file is compiled with all single precision promoted to double precision."
    "U015" "COMMON block in several libraries" "Two of the given libraries define the same COMMON block or module. Each library is loaded with its own variables, so that a value which a subroutine of one library sets is not seen by the other. Pass the sources together, which are compiled to one library, or link all objects to one library."
    "U011" "cache that is not used" "Compiled user subroutines are stored in `$XDG_CACHE_HOME/revolve/user` or `~/.cache/revolve/user` and loaded by later runs. The warning means that this folder or its parent is owned by another user, is writable by others, or cannot be created. The cache is then ignored, and the subroutines are compiled for each run in a temporary folder. To use the cache, run `chmod go-w` on both folders, or set another XDG_CACHE_HOME."
};
