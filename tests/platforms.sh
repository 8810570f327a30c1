#!/usr/bin/env bash
# Compiles the program for Windows, macOS and static Linux without linking it; rustup fetches their libraries (3 x 30 MB).
set -euo pipefail
cd "$(dirname "$0")/.."
for target in x86_64-pc-windows-gnu aarch64-apple-darwin x86_64-unknown-linux-musl; do
    rustup target add "$target"
    RUSTFLAGS="-D warnings" cargo check --locked --lib --bins --target "$target"
done
