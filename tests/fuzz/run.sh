#!/usr/bin/env bash
# Fuzzes each target: tests/fuzz/run.sh SECONDS [TARGET...]. Needs a C++ compiler for libFuzzer, but no nightly Rust.
# Failing inputs are written to target/fuzz/found/TARGET, inputs with new coverage to target/fuzz/learnt/TARGET.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:?seconds for each target}
shift
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(decks parameters meshes checkpoints references results)
cover="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters"
cover="$cover -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
# With --target, build scripts are not instrumented.
host=$(rustc -vV | sed -n 's/^host: //p')
RUSTFLAGS="$cover" cargo build --release --target "$host" --target-dir target/fuzz --manifest-path tests/fuzz/Cargo.toml
status=0
for name in "${targets[@]}"; do
    learnt=target/fuzz/learnt/$name found=target/fuzz/found/$name
    mkdir -p "$learnt" "$found"
    seeds=(tests/fuzz/corpus/"$name")
    [ "$name" != decks ] || seeds+=(input input/gauntlet tests/decks/good tests/decks/bad)
    nice -n 19 "target/fuzz/$host/release/$name" "$learnt" "${seeds[@]}" -artifact_prefix="$found/" \
        -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -max_len=16384 -print_final_stats=1 || status=1
done
exit $status
