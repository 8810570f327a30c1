#!/usr/bin/env bash
# Run time of the library in the release profile (one codegen unit a crate) compared with 16 units, and with a crate that uses the
# library in the default release profile of cargo: the copper bar of 2000 elements on one thread, programs in alternation, medians
# of nine runs. Fails if a ratio exceeds 1.03. Builds two more times (about six minutes).
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --quiet --release --locked
cargo build --quiet --release --locked --config profile.release.codegen-units=16 --target-dir target/sixteen-units
cargo build --quiet --release --manifest-path tests/benches/library_user/Cargo.toml --target-dir target/library-user
run() { # NAME COMMAND...: adds the seconds of one run to NAME's list
    local name=$1 start end
    shift
    start=$(date +%s%N)
    "$@" >/dev/null
    end=$(date +%s%N)
    echo $(((end - start) / 1000)) >>"$times/$name"
}
times=$(mktemp -d)
trap 'rm -rf "$times"' EXIT
bar=(input/taylor_copper.inp --set nr=20 --set nz=100 --threads 1 --no-frames --out "$times/out")
for _ in 1 2 3 4 5 6 7 8 9; do
    run one target/release/revolve run "${bar[@]}"
    run sixteen target/sixteen-units/release/revolve run "${bar[@]}"
    run library env RAYON_NUM_THREADS=1 target/library-user/release/library_user
done
median() { sort -n "$times/$1" | sed -n 5p; }
awk -v one="$(median one)" -v sixteen="$(median sixteen)" -v library="$(median library)" 'BEGIN {
    printf "one unit %.2f s; sixteen units %.3f times that; a crate that uses the library %.3f times\n", one / 1e6, sixteen / one, library / one
    exit sixteen > 1.03 * one || library > 1.03 * one
}'
