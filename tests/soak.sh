#!/usr/bin/env bash
# Continuous checking, as each night: tests/soak.sh N [SEED] [OPTIONS]. Runs N random scenes and judges each by its exit
# status, messages and energies. Prints tables in Markdown; failures are saved as decks in target/soak/failures.
#   --kills K        kills sweep, study, limit, identify and scatter K times in all, and runs them again
#   --growth         measures how run time grows with the number of cards
#   --fuzz SECONDS   runs each fuzz target for this time (tests/fuzz/run.sh, needs a C++ compiler)
#   --program FILE   checks this program in place of the release build
# Further options are those of tests/soak/soak.py. Exit status 1 if anything failed.
set -euo pipefail
cd "$(dirname "$0")/.."
program="" fuzz=0 arguments=()
while [ $# -gt 0 ]; do
    case $1 in
        --fuzz) fuzz=$2 && shift 2 ;;
        --program) program=$2 && shift 2 ;;
        *) arguments+=("$1") && shift ;;
    esac
done
[ ${#arguments[@]} -gt 0 ] || { sed -n '2,8s/^# //p' "$0" >&2 && exit 2; }
if [ -z "$program" ]; then
    cargo build --release --locked --bin revolve
    program=${CARGO_TARGET_DIR:-target}/release/revolve
fi
status=0
nice -n 19 "${PYTHON:-python3}" tests/soak/soak.py "${arguments[@]}" --program "$program" --out target/soak || status=1
if [ "$fuzz" != 0 ]; then
    tests/fuzz/run.sh "$fuzz" || status=1
fi
exit $status
