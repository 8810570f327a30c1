#!/usr/bin/env bash
# Draws the pictures of docs again by the commands that their pages print.
# Usage: pictures.sh [FOLDER [PAGE...]]
#   FOLDER  receives the pictures by their paths in docs; without it, those of docs are replaced
#   PAGE    pages of docs; without them all pages are drawn, which takes about 20 minutes
# REVOLVE is the program, REVOLVE_PYTHON a Python with pyvista and matplotlib (target/python after tests/setup.sh).
# All commands of a tutorial are run; of other pages, the blocks that name a picture of docs. Pictures of the editor
# (docs/tutorials/editor-*.png) and of machines (docs/accuracy/work_precision_*.svg) are not drawn.
set -euo pipefail
project=$(realpath "$(dirname "$0")/..")
folder=$(realpath -m "${1:-$project/docs}")
shift $(($# < 1 ? 0 : 1))
slow=(accuracy.md fidelity.md oblique.md tutorial.md validation.md)
tutorials=$(cd "$project/docs" && grep -lE '\]\([a-z_-]+\.png\)' tutorials/*.md | grep -v editor)
[ $# -gt 0 ] || set -- gallery.md searches.md adaptive-meshes.md $tutorials "${slow[@]}"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$project"/{docs,input,examples} "$work"
cd "$work"
export REVOLVE="${REVOLVE:-$project/target/release/revolve}"
[[ $REVOLVE = /* ]] || REVOLVE=$project/$REVOLVE
export PYTHON="${REVOLVE_PYTHON:-$project/target/python/bin/python}"
# Status 1: results with a warning.
revolve() { "$REVOLVE" "$@" >/dev/null || [ $? = 1 ]; }
python() { "$PYTHON" "$@"; }
cargo() { command cargo "$@" --manifest-path "$project/Cargo.toml"; }

# Writes the files that a page gives after "File `NAME`".
write_files() {
    awk '/^File `/ { split($0, part, "`"); name = part[2]; next }
         name && /^    / { print substr($0, 5) >name; written = 1; next }
         name && written { close(name); name = ""; written = 0 }' "$1"
}

# Prints the commands of a page.
commands() {
    awk -v all="$2" '
        function flush() { if (all || block ~ /docs\/[a-z0-9_\/*-]*\.png/) printf "%s", block; block = "" }
        /^     *(revolve|cp|python|cargo|docs\/[a-z\/.]*) / { block = block $0 "\n"; next }
        /^    /  { next }
        { flush() }
        END { flush() }' "$1"
}

# Draws the page of a report, as a browser shows it.
report() {
    revolve run input/ogive_steel.inp --quiet
    revolve report out/ogive_steel --quiet
    chromium --headless --no-sandbox --hide-scrollbars --window-size=1200,1180 --virtual-time-budget=5000 \
        --screenshot=docs/report.png "file://$PWD/out/ogive_steel/report.html" 2>/dev/null
}

find docs -name '*.png' | xargs touch -d 2000-01-01
for page in "$@"; do
    all=""
    [[ $page != tutorials/* ]] || all=yes
    write_files "docs/$page"
    eval "$(commands "docs/$page" "$all")"
    # The commands of a tutorial do not write into docs.
    [ -z "$all" ] || for picture in $(grep -oE '\]\([a-z_-]+\.png\)' "docs/$page" | tr -d ']()'); do
        cp "$(find . -path ./docs -prune -o -name "$picture" -print | head -n 1)" "docs/tutorials/$picture"
    done
    [ "$page" != tutorial.md ] || report
done
find docs -name '*.png' -newermt 2001-01-01 | while read -r picture; do
    install -D -m 644 "$picture" "$folder/${picture#docs/}"
done
