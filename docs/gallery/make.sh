#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md anew: runs the commands that the page prints, in their order. REVOLVE is the program.
set -euo pipefail
cd "$(dirname "$0")/../.."
revolve() { "${REVOLVE:-target/release/revolve}" "$@"; }
sed -n 's/^    \(\(revolve\|cp\) .*\)/\1/p' docs/gallery.md > target/gallery.sh
. target/gallery.sh
