#!/usr/bin/env bash
# ansys-dyna-core 0.12.1 (PyDyna) writes an LS-DYNA deck from a mesh whose labels have nine digits.
# Guess: a label that does not fit into the eight columns of *NODE and *ELEMENT_SHELL is an error, or makes the deck LONG=Y.
# Happens: the first eight digits are written, without error or warning: nodes 100000001 to 100000004 all become 10000000, the
#   deck is read back with four nodes of one label and an element of one node. *SET_NODE_LIST has ten columns and keeps the
#   labels, so that its members no longer exist. With the format "long" all labels are right.
# Hurt: who converts meshes with labels by instance or part (100000001, 200000001, ...), as preprocessors of ABAQUS write them.
set -euo pipefail
t=$(mktemp -d); trap 'rm -rf "$t"' EXIT; cd "$t"
python3 -m venv v; v/bin/pip install -q ansys-dyna-core==0.12.1
v/bin/python -W error::UserWarning - <<'P'
import importlib.metadata, sys
import pandas as pd
from ansys.dyna.core import Deck, keywords
from ansys.dyna.core.lib.format_type import format_type
labels = [100000001, 100000002, 100000003, 100000004]
deck = Deck()
nodes = keywords.Node(); nodes.nodes = pd.DataFrame({"nid": labels, "x": [0.0, 1, 1, 0], "y": [0.0, 0, 1, 1], "z": [0.0] * 4})
shell = keywords.ElementShell(); shell.elements = pd.DataFrame({"eid": [1], "pid": [1], **{f"n{i + 1}": [n] for i, n in enumerate(labels)}})
members = keywords.SetNodeList(sid=1); members.nodes = labels[:2]
for keyword in (nodes, shell, members): deck.append(keyword)
def read_back(text):
    other = Deck(); other.loads(text)
    by_name = {k.keyword: k for k in other.keywords}
    return [int(n) for n in by_name["NODE"].nodes["nid"]], [int(by_name["ELEMENT"].elements[f"n{i}"].iloc[0]) for i in range(1, 5)]
short = deck.write(); print("ansys-dyna-core", importlib.metadata.version("ansys-dyna-core")); print(short)
deck.format = format_type.long
after, long = read_back(short), read_back(deck.write())
print("read back:", *after); print("with the long format:", *long)
sys.exit(not (after == ([10000000] * 4, [10000000] * 4) and "100000001 100000002" in short and long == (labels, labels)))
P
