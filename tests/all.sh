#!/usr/bin/env bash
# All checks of the project: format, lints, tests, documentation. Says at the end what was left out.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --check
cargo clippy --release --all-targets --locked -- -D warnings
cargo test --release --locked 2>&1 | tee target/tests.log
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --locked --quiet
if grep -q '^left out:' target/tests.log; then
    echo "Some tests left something out:"
    grep '^left out:' target/tests.log | sort -u
else
    echo "Nothing was left out."
fi
