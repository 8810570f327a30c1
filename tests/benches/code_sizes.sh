#!/usr/bin/env bash
# Size of the machine code of each composition of element and material laws in the program, kB, largest first, with the number of
# functions; then the size of each crate. Builds once more, with symbols that name their types.
set -euo pipefail
cd "$(dirname "$0")/../.."
RUSTFLAGS="-C symbol-mangling-version=v0" cargo build --quiet --release --locked --target-dir target/sizes
nm --print-size --size-sort --demangle target/sizes/release/revolve | python3 -c '
import collections, re, sys

compositions, crates = collections.defaultdict(list), collections.defaultdict(list)
for line in sys.stdin:
    parts = line.rstrip().split(" ", 3)
    if len(parts) < 4 or parts[2] not in "tT":
        continue
    size, name = int(parts[1], 16), parts[3]
    plain = re.sub(r"\b(?:\w+::)+", "", name)
    group = re.search(r"(?:QuadGroup|SixNodeTriangles)<(?:[^<>]|<(?:[^<>]|<[^<>]*>)*>)*>", plain)
    if group:
        compositions[group[0]].append(size)
    crate = re.match(r"[<&]*(?:dyn )?(?:<)?(\w+)::", name)
    crates[crate[1] if crate else "other"].append(size)
for title, sizes in [("composition", compositions), ("crate", crates)]:
    print(f"{title}: {len(sizes)}")
    for name, list_ in sorted(sizes.items(), key=lambda item: -sum(item[1]))[:40]:
        print(f"{sum(list_) / 1e3:9.1f} kB {len(list_):5d}  {name}")
'
