#!/usr/bin/env bash
# Draws the pictures of docs/gallery.md: runs the commands that the page prints, in their order. REVOLVE is the program.
# Usage: make.sh [FOLDER]; without a folder the pictures of the page are replaced.
set -euo pipefail
folder=$(realpath "${1:-$(dirname "$0")}")
cd "$(dirname "$0")/../.."
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
revolve() { "${REVOLVE:-target/release/revolve}" "$@"; }
commands=$(sed -n 's/^    \(\(revolve\|cp\) .*\)/\1/p' docs/gallery.md)
commands=${commands//docs\/gallery\//$folder/}
eval "${commands//out\/gallery/$results}"
