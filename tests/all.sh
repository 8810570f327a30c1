#!/usr/bin/env bash
# All checks of the project: format, lints, tests, documentation. Says at the end what was left out.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --check
cargo fmt --check --manifest-path src/python/Cargo.toml
cargo clippy --profile quick --all-targets --locked -- -D warnings
cargo clippy --no-default-features --locked -- -D warnings
cargo clippy --manifest-path src/python/Cargo.toml --target-dir target/wheel --locked -- -D warnings
cargo test --profile quick --locked -- --show-output 2>&1 | tee target/tests.log
RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --locked --quiet
grep -E "^on this machine:" target/tests.log | sort -u || true
if grep -qE "^(left out|skipped):" target/tests.log; then
    echo "Some tests left something out:"
    grep -E "^(left out|skipped):" target/tests.log | sort -u
else
    echo "Nothing was left out."
fi
