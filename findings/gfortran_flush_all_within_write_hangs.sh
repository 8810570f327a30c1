#!/usr/bin/env bash
# gfortran 12.2 (must be installed; the version is printed): a function that logs to its own unit and ends with `call flush()`
#   (all units, an extension), used in the list of a PRINT.
# Guess: the log is on disk, and the value is printed: the function writes to another unit than PRINT, as Fortran 2003 allows,
#   and to flush is no input or output.
# Happens: the program waits for ever, without a message and without computing: unit 6 is locked by the PRINT of the same
#   thread, and the run-time library waits for it. `flush(10)`, the unit of the log, works; so does LLVM Flang with both.
# Hurt: anyone who adds a log with a flush to a function, and any host program that flushes all units
#   (_gfortran_flush_i4(NULL)) after a routine was left within a WRITE: the job hangs in the queue until its time limit.
set -euo pipefail
command -v gfortran > /dev/null || { echo "gfortran is not installed"; exit 2; }
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
program() {
    cat > p.f90 <<F
module m
contains
  integer function logged(i)
    integer, intent(in) :: i
    write(10,*) 'log'
    $1
    logged = i
  end function
end module
program p
  use m
  open(10, file='log.txt')
  print *, logged(7)
end program
F
    gfortran -O2 p.f90 -o p
    if timeout 10 ./p > printed; then tr -d ' \n' < printed; else echo "status$?"; fi
}
all=$(program 'call flush()'); one=$(program 'flush(10)')
gfortran --version | head -1
echo "flush of all units: $all, of unit 10: $one (status 124: ended by timeout after 10 s)"
[ "$all $one" = "status124 7" ]
