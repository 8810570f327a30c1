//! Topics of `revolve explain` that no table has: element types, functions of quantities, units, files.

/// A topic: the words that it is asked by, and what is to be said.
pub(super) struct Topic {
    pub words: &'static [&'static str],
    pub text: &'static str,
}

/// All topics.
pub(super) const TOPICS: &[Topic] = &[
    Topic {
        words: &["CAX4R", "CAX4RT"],
        text: "CAX4R: four-node axisymmetric quadrilateral, one integration point, nodes counter-clockwise in (r, z).\n\
               Degrees of freedom 1 (r) and 2 (z). *SOLID SECTION gives the material, *SECTION CONTROLS the hourglass control.\n\
               CAX4RT has temperatures at its nodes, too (degree of freedom 11), for *DYNAMIC TEMPERATURE-DISPLACEMENT.\n\
               With a *RIGID BODY that names it the element does not deform.\n",
    },
    Topic {
        words: &["CAX3", "CAX3T"],
        text: "CAX3: three-node axisymmetric triangle with constant strain; where materials flow plastically its change of volume is\n\
               averaged over the nodes around, so that it does not lock (docs/theory.md). CAX3T has temperatures at its nodes, too.\n",
    },
    Topic {
        words: &["CAX6M"],
        text: "CAX6M: six-node axisymmetric triangle, modified, three integration points. Nodes: the corners counter-clockwise in\n\
               (r, z), then the middles of the sides 1-2, 2-3 and 3-1. Faces S1, S2 and S3 are these sides, each two straight parts\n\
               that meet at the middle. It does not lock and needs no hourglass control (docs/theory.md); output is the mean of its\n\
               points. Not for *DYNAMIC TEMPERATURE-DISPLACEMENT and not for routines of the user at points.\n",
    },
    Topic {
        words: &["RAX2"],
        text: "RAX2: two-node axisymmetric rigid element, a facet of a body of revolution, for *RIGID BODY. Its positive side (SPOS)\n\
               lies to the left of the way from the first node to the second. Mass by DENSITY and thickness of *RIGID BODY, or a\n\
               point mass (TYPE=MASS) on the reference node. Loads act on its sides: P, PNU (vdload), CAVITY.\n",
    },
    Topic {
        words: &["SAX1"],
        text: "SAX1: two-node axisymmetric shell with *SHELL SECTION; degrees of freedom 1 (r), 2 (z), 6 (rotation).\n",
    },
    Topic {
        words: &["MASS", "SPRINGA", "SPRING1", "DASHPOTA", "DASHPOT1"],
        text: "TYPE=MASS with *MASS puts a point mass on a node; SPRINGA and DASHPOTA join two nodes, SPRING1 and DASHPOT1 a node\n\
               and the ground, with *SPRING and *DASHPOT.\n",
    },
    Topic {
        words: &[
            "C3D8R", "C3D4", "C3D6", "C3D10M", "S4R", "S3R", "CPE4R", "CPS4R", "CAX4", "CAX8R", "CAX6MT", "CAX3H",
            "B31", "T3D2", "R3D4",
        ],
        text: "This element type is not computed: the code is axisymmetric, and of its elements CAX4R, CAX4RT, CAX3, CAX3T, CAX6M,\n\
               SAX1 and RAX2 are; a deck with others is refused with the line (docs/abaqus.md).\n",
    },
    Topic {
        words: &["final", "min", "max", "time_min", "time_max", "at", "mean", "norm", "quantity", "quantities"],
        text: "A quantity (--quantity of run, sweep and study) is an expression over history columns, such as -1000*final(U2@REF):\n\
               \x20 final(C)           the last value of column C\n\
               \x20 min(C), max(C)     the smallest and largest value; time_min(C), time_max(C) when\n\
               \x20 at(C, t)           the value at time t, between rows by a straight line\n\
               \x20 mean(C, t1, t2)    the mean over a time\n\
               \x20 norm(VAR, EXPR)    rms error of a field against EXPR of r, z, r0, z0, t (study); norm(VAR) against the finest mesh\n\
               with + - * / **, parentheses and the functions of *PARAMETER. `revolve check` lists the columns that a deck has.\n",
    },
    Topic {
        words: &["units", "unit", "kg", "MPa", "mm"],
        text: "The program computes in the deck's units and converts nothing: any consistent system will do.\n\
               \x20 m, kg, s:    N, Pa, J     steel 7850, 2.1e11\n\
               \x20 mm, t, s:    N, MPa, mJ   steel 7.85e-9, 2.1e5\n\
               \x20 mm, kg, ms:  kN, GPa, J   steel 7.85e-6, 210\n\
               \x20 mm, g, ms:   N, MPa, mJ   steel 7.85e-3, 2.1e5\n\
               \x20 cm, g, us:   1e7 N, Mbar  steel 7.85, 2.1\n\
               *UNITS names them for reports, pictures and tables. `check` warns where density and modulus fit no system (P119).\n\
               Masses, forces and energies are those of the full ring, 2 pi included.\n",
    },
    Topic {
        words: &["files", "results", "output", "pvd", "vtu", "sta", "paraview"],
        text: "A run writes into out/<deck>/ (--out DIR):\n\
               \x20 <job>.pvd, <job>_0000.vtu …  frames for ParaView: open the .pvd\n\
               \x20 <job>_history.csv            histories, a column each\n\
               \x20 <job>.sta                    how far it is: increments, energies, frames\n\
               \x20 <job>.json                   summary: status, warnings, energies, ledger, times\n\
               \x20 <job>.checkpoint             a state to go on from with --resume\n\
               `revolve report DIR` makes one HTML page of them, `revolve chart DIR --column NAME` a picture.\n",
    },
    Topic {
        words: &["threads", "cores", "instructions", "speed"],
        text: "--threads N (default: all cores) and --instructions scalar|avx2|avx512 (default: the best there is) change the time a run\n\
               takes and no bit of its results. Threads pay from a thousand elements on (docs/performance.md).\n",
    },
    Topic {
        words: &["resume", "checkpoint", "restart"],
        text: "*RESTART, WRITE in the deck, --checkpoint-every 10s, or Ctrl-C keep the state; `revolve run DECK --resume` goes on from it\n\
               to the same bits (docs/restart.md).\n",
    },
];
