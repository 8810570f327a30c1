#!/usr/bin/env bash
# Mutation testing of numerics and solver: tests/mutants.sh COUNT SEED changes COUNT random places of the code, one at a time,
# and runs the tests. Prints the caught and the missed changes; target/mutants/mutants.out has the outputs. Installs
# cargo-mutants into target/mutants if it is missing. Each change needs a build of several minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
count=${1:-15} seed=${2:-0} version=27.1.0
tools="$PWD/target/mutants"
export PATH="$tools/bin:$PATH"
cargo mutants --version 2>/dev/null | grep -q " $version$" ||
    cargo install cargo-mutants --version "$version" --locked --root "$tools"
# Quick builds with the same results.
export CARGO_PROFILE_RELEASE_INCREMENTAL=true CARGO_PROFILE_RELEASE_CODEGEN_UNITS=64 CARGO_PROFILE_RELEASE_OPT_LEVEL=1
export CARGO_PROFILE_RELEASE_PACKAGE_REVOLVE_ANALYSIS_CODEGEN_UNITS=64 CARGO_PROFILE_RELEASE_DEBUG=0 REVOLVE_INSTALL=no
export RUSTC_WRAPPER="$PWD/tests/rustc.sh"
places=(--package revolve-numerics --package revolve-solver)
total=$(cargo mutants --list "${places[@]}" 2>/dev/null | wc -l)
shards=$((total / count))
# Every place belongs to one shard; a shard has places of all files.
status=0
cargo mutants "${places[@]}" --in-place --no-shuffle --sharding round-robin --shard "$((seed % shards))/$shards" \
    --test-workspace true --profile release --baseline skip --timeout 1800 --build-timeout 1800 --output "$tools" \
    -- --workspace --exclude revolve-python --features parquet --locked --lib --test deck --test verification || status=$?
echo "caught $(wc -l <"$tools/mutants.out/caught.txt"), missed $(wc -l <"$tools/mutants.out/missed.txt") of shard $((seed % shards)) of $shards"
cat "$tools/mutants.out/missed.txt"
# 2: missed changes, 3: a timeout, which counts as caught.
[ "$status" = 0 ] || [ "$status" = 2 ] || [ "$status" = 3 ]
