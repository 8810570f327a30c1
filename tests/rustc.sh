#!/usr/bin/env bash
# RUSTC_WRAPPER of all.sh: compiles the programs of tests without optimization, which takes a quarter of the time. The libraries,
# the program and the wheel are compiled as without it, so that Cargo does not build them again. Unit tests are in the program
# of their library and run slower; their longer run is a third of the build that it saves.
set -euo pipefail
for word in "$@"; do
    if [ "$word" = --test ]; then
        exec "$@" -C opt-level=0 -C debug-assertions=off -C overflow-checks=off
    fi
done
exec "$@"
