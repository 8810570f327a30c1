#!/usr/bin/env bash
# Mutation tests of the numerics and the solver: random changes of functions (cargo-mutants), each of which a test must detect.
# mutants.sh NUMBER [FOLDER]: that many mutants (default 300) of both crates; reports in FOLDER (default target/mutants). Each
# mutant must fail the unit tests of its crate, or else the verification tests. Lists those that no test detects. The
# status is 1 if fewer than 90 % are detected. MUTANTS_PACKAGES="revolve-numerics" limits the crates, MUTANTS_SEED selects
# other mutants (default: the number of the week), MUTANTS_STAGES=unit leaves the verification tests out.
set -euo pipefail
cd "$(dirname "$0")/.."
number=${1:-300}
folder=${2:-target/mutants}
version=25.3.1
tool="$PWD/target/tools/bin/cargo-mutants"
if command -v cargo-mutants >/dev/null; then
    tool=$(command -v cargo-mutants)
elif [ ! -x "$tool" ]; then
    cargo install cargo-mutants --version "$version" --locked --root target/tools
fi
read -ra packages <<<"${MUTANTS_PACKAGES:-revolve-numerics revolve-solver}"
seed=${MUTANTS_SEED:-$(date +%G%V)}
stages=${MUTANTS_STAGES:-unit verification}
mkdir -p "$folder"
# Quick to build again; the bits are those of the release.
export CARGO_PROFILE_RELEASE_INCREMENTAL=true CARGO_PROFILE_RELEASE_CODEGEN_UNITS=64 CARGO_PROFILE_RELEASE_OPT_LEVEL=1
# A source of random bytes for shuf that depends on the seed only.
random_bytes() { local block=0; while printf '%s %s' "$seed" "$block" | sha256sum; do block=$((block + 1)); done 2>/dev/null; }
select=()
for package in "${packages[@]}"; do select+=(--package "$package"); done
"$tool" mutants "${select[@]}" --list >"$folder/all.txt"
shuf --random-source=<(random_bytes) -n "$number" "$folder/all.txt" >"$folder/chosen.txt"
echo "$(wc -l <"$folder/chosen.txt") of $(wc -l <"$folder/all.txt") mutants, seed $seed"

# Names are literal: each character that has a meaning in a regular expression is escaped.
patterns() { sed -E 's/[][(){}.*+?^$|\\]/\\&/g; s/^/^/; s/$/$/' "$1"; }
# stage NAME LIST CARGO-ARGUMENTS...: writes the mutants of the list that survive to NAME/mutants.out/missed.txt.
stage() {
    local name=$1 list=$2
    shift 2
    local regexes=() arguments=()
    # For builds as well: without them, all tests of the package would be built.
    for argument in "$@"; do arguments+=("--cargo-arg=$argument"); done
    while IFS= read -r pattern; do regexes+=(--re "$pattern"); done < <(patterns "$list")
    rm -rf "${folder:?}/$name"
    # Status 2: some mutants survive; 3: some time out.
    "$tool" mutants "${select[@]}" "${regexes[@]}" --in-place --baseline skip --timeout 600 --build-timeout 1800 \
        --profile release --no-shuffle --output "$folder/$name" "${test_options[@]}" "${arguments[@]}" || [ $? -le 3 ]
}
test_options=()
# In place: a copy of the folder would build everything again. Changes that are not committed could be lost.
git diff --quiet -- src || { echo "error: commit or discard changes in src first" >&2; exit 2; }
stage unit "$folder/chosen.txt" --lib
survivors="$folder/unit/mutants.out/missed.txt"
if [[ "$stages" == *verification* ]] && [ -s "$survivors" ]; then
    test_options=(--test-package revolve)
    stage verification "$survivors" --features parquet --test verification
    survivors="$folder/verification/mutants.out/missed.txt"
fi
unviable=$(cat "$folder"/unit/mutants.out/unviable.txt | wc -l)
missed=$(wc -l <"$survivors")
valid=$(($(wc -l <"$folder/chosen.txt") - unviable))
echo "$((valid - missed)) of $valid mutants detected, $unviable do not compile; not detected:"
cat "$survivors"
[ "$((10 * missed))" -le "$valid" ]
