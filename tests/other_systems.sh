#!/usr/bin/env bash
# The tests that do not need Linux: all but those of compiled user subroutines, and of the program as a process.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo test --release --workspace --exclude revolve-python --locked --lib --test deck --test verification --test gauntlet --test corpus --test editor "$@"
