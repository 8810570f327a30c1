#!/usr/bin/env bash
# Builds the extension and runs its tests: types, grammar, snippets, commands, package. Needs Node.js 20 or newer, npm and its
# registry, and the program (REVOLVE, else the release build). Without Node.js or the registry it prints "left out" and ends
# with status 0, except in CI.
set -euo pipefail
cd "$(dirname "$0")"
leave_out() {
    if [ -n "${CI:-}" ]; then
        echo "error: in CI the extension for VS Code must be tested: $1" >&2
        exit 1
    fi
    echo "left out: the extension for VS Code ($1)"
    exit 0
}
export REVOLVE="${REVOLVE:-$PWD/../../target/release/revolve}"
"$REVOLVE" --version >/dev/null || { echo "error: REVOLVE must name the program, found $REVOLVE" >&2; exit 1; }
node -e 'process.exit(parseInt(process.versions.node) >= 20 ? 0 : 1)' 2>/dev/null || leave_out "no Node.js 20 or newer"
command -v npm >/dev/null || leave_out "no npm"
# The copy of the lock file says what is installed; scripts of packages do not run.
installed=node_modules/.installed-lock.json
if ! cmp -s package-lock.json "$installed"; then
    npm ci --ignore-scripts --no-audit --no-fund --prefer-offline || leave_out "npm ci failed"
    cp package-lock.json "$installed"
fi
npm run --silent types
npm run --silent snippets -- --check
npm run --silent test:grammar
npm run --silent package
npm run --silent test:extension
