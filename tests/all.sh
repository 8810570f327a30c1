#!/usr/bin/env bash
# All checks of the project: format, spelling, tests, lints, documentation. Installs first what they need (setup.sh), and
# lists at the end the checks that were left out.
# The tests of the program wait much, for processes and clocks; the other tests run at the same time.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/setup.sh
if [ -n "${CI:-}" ] && [ -n "$unavailable" ]; then
    echo "$unavailable"
    exit 1
fi
cargo fmt --all --check
cargo clippy --release --workspace --all-targets --locked -- -D warnings
cargo clippy --release --no-default-features --locked -- -D warnings
spelling=""
if "${REVOLVE_TYPOS:-typos}" --version >/dev/null 2>&1; then
    "${REVOLVE_TYPOS:-typos}" --config tests/typos.toml
else
    spelling="left out: spelling, typos is not installed"
fi
# The programs of tests are compiled without optimization, the libraries that they call with it.
export RUSTC_WRAPPER="${RUSTC_WRAPPER:-$PWD/tests/rustc.sh}"
# With the features of the Python package, whose wheel is built from the same library.
tests=(cargo test --release --workspace --exclude revolve-python --features parquet --locked)
"${tests[@]}" --no-run
"${tests[@]}" --doc 2>&1 | tee target/tests.log
# They also build the wheel: the other tests begin first, and find what they need complete. The group ends as a whole. A test
# that waits for ever is ended, so that its name is printed.
set -m
{ sleep 10; exec timeout 50m "${tests[@]}" --test program -- --show-output; } >target/program.log 2>&1 &
program=$!
set +m
trap 'kill -- "-$program" 2>/dev/null || true' EXIT
others=(--lib)
for folder in tests/*/main.rs; do
    name=$(basename "$(dirname "$folder")")
    [ "$name" = program ] || others+=(--test "$name")
done
"${tests[@]}" "${others[@]}" -- --show-output 2>&1 | tee -a target/tests.log
# The extension for VS Code, whose snippets and messages are checked with the program that the tests have built.
REVOLVE="${CARGO_TARGET_DIR:-$PWD/target}/release/revolve" editors/vscode/test.sh 2>&1 | tee -a target/tests.log
passed=0
wait "$program" || passed=$?
trap - EXIT
tee -a target/tests.log <target/program.log
if [ "$passed" != 0 ]; then
    [ "$passed" != 124 ] || echo "The tests of the program were ended after 50 minutes; tests without an end:"
    grep -oP "^test \K\S+(?= has been running for over 60 seconds)" target/program.log |
        while read -r name; do grep -q "^test $name \.\.\. " target/program.log || echo "    $name"; done || true
    exit "$passed"
fi
[ -z "$spelling" ] || echo "$spelling" >>target/tests.log
printf %s "$unavailable" >>target/tests.log
RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --exclude revolve-python --no-deps --locked --quiet
grep -E "^on this machine:" target/tests.log | sort -u || true
if grep -qE "^(left out|skipped):" target/tests.log; then
    echo "Some tests left something out:"
    grep -E "^(left out|skipped):" target/tests.log | sort -u
else
    echo "Nothing was left out."
fi
