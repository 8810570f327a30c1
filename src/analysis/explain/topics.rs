//! Topics of `revolve explain` other than keywords, variables and codes: element types, functions of quantities, units,
//! files.

/// A topic with its search words and its text.
pub(super) struct HelpTopic {
    pub words: &'static [&'static str],
    pub text: &'static str,
}

/// Topics of `revolve explain`, in the order of the search.
pub(super) const TOPICS: &[HelpTopic] = &[
    HelpTopic {
        words: &["CAX4R", "CAX4RT"],
        text: "CAX4R: four-node axisymmetric quadrilateral, one integration point, nodes counter-clockwise in (r, z).\n\
               Degrees of freedom 1 (r) and 2 (z). *SOLID SECTION gives the material, *SECTION CONTROLS the hourglass control.\n\
               CAX4RT also has nodal temperatures (degree of freedom 11), for *DYNAMIC TEMPERATURE-DISPLACEMENT.\n\
               Elements of a *RIGID BODY do not deform.\n",
    },
    HelpTopic {
        words: &["CAX3", "CAX3T"],
        text: "CAX3: three-node axisymmetric triangle with constant strain. In plastic materials the volume change is averaged over the\n\
               surrounding nodes to avoid volumetric locking (docs/theory/elements.md). CAX3T also has nodal temperatures.\n",
    },
    HelpTopic {
        words: &["CAX6M"],
        text: "CAX6M: six-node axisymmetric triangle, modified, three integration points. Nodes: the corners counter-clockwise in\n\
               (r, z), then the midside nodes of 1-2, 2-3 and 3-1. Faces S1, S2 and S3 are these sides, each with two straight parts\n\
               that meet at the middle node. It has no volumetric locking and no hourglass modes (docs/theory/elements.md).\n\
               Output is the mean of its integration points. User subroutines are called at each of them. Unsupported in\n\
               *DYNAMIC TEMPERATURE-DISPLACEMENT.\n",
    },
    HelpTopic {
        words: &["RAX2"],
        text: "RAX2: two-node axisymmetric rigid element, a facet of a body of revolution, for *RIGID BODY. Its positive side (SPOS)\n\
               is to the left of the direction from the first to the second node. Mass from DENSITY and thickness of *RIGID BODY, or a\n\
               point mass (TYPE=MASS) at the reference node. Loads act on its sides: P, PNU (vdload), CAVITY.\n",
    },
    HelpTopic {
        words: &["SAX1"],
        text: "SAX1: two-node axisymmetric shell with *SHELL SECTION, also with layers and offset nodes; degrees of freedom 1 (r), 2 (z), 6 (rotation).\n",
    },
    HelpTopic {
        words: &["COHAX4"],
        text: "COHAX4: four-node axisymmetric cohesive element with *COHESIVE SECTION. Nodes 1 and 2 are the bottom face, 4 and 3 the\n\
               nodes of the top face opposite to them; the faces may coincide. Two integration points at the ends of the mid-surface.\n\
               Material: *ELASTIC, TYPE=TRACTION or COUPLED TRACTION; *DAMAGE INITIATION with MAXS, QUADS, MAXE or QUADE; *DAMAGE\n\
               EVOLUTION; *DAMAGE STABILIZATION. Output: S22 and S12 (tractions), E22 and E12, SDEG, MAXSCRT, ..., STATUS. Faces S1\n\
               and S3 can be tied (docs/theory/cohesive.md).\n",
    },
    HelpTopic {
        words: &["MASS", "SPRINGA", "SPRING1", "DASHPOTA", "DASHPOT1"],
        text: "TYPE=MASS with *MASS adds a point mass to a node; SPRINGA and DASHPOTA connect two nodes, SPRING1 and DASHPOT1 a node\n\
               and the ground, with *SPRING and *DASHPOT.\n",
    },
    HelpTopic {
        words: &["CINAX4", "infinite element", "quiet boundary"],
        text: "CINAX4: four-node infinite element. Its first two nodes are those of a free face of CAX4R or CAX3 elements, the others\n\
               are outside. It absorbs pressure and shear waves that reach the face, with the density and the moduli of the material\n\
               of its *SOLID SECTION. It has no stiffness, mass or output (docs/theory/loads.md).\n",
    },
    HelpTopic {
        words: &[
            "C3D8R", "C3D4", "C3D6", "C3D10M", "S4R", "S3R", "CPE4R", "CPS4R", "CAX4", "CAX8R", "CAX6MT", "CAX3H",
            "B31", "T3D2", "R3D4",
        ],
        text: "This element type is unsupported: the code is axisymmetric and supports CAX4R, CAX4RT, CAX3, CAX3T, CAX6M,\n\
               SAX1, COHAX4 and RAX2. Other element types are reported as errors with their line (docs/abaqus.md).\n",
    },
    HelpTopic {
        words: &[
            "final",
            "min",
            "max",
            "time_min",
            "time_max",
            "at",
            "mean",
            "norm",
            "outline",
            "quantity",
            "quantities",
        ],
        text: "A quantity (--quantity of run, sweep and study) is an expression over history columns, such as -1000*final(U2@REF):\n\
               \x20 final(C)           the last value of column C\n\
               \x20 min(C), max(C)     the smallest and largest value; time_min(C), time_max(C) when\n\
               \x20 at(C, t)           the value at time t, by linear interpolation\n\
               \x20 mean(C, t1, t2)    the time average from t1 to t2\n\
               \x20 norm(VAR, EXPR)    relative L2 error of a field against EXPR of r, z, r0, z0, t\n\
               \x20 norm(VAR)          relative L2 error of a field against the finest level of a study\n\
               \x20 outline(z)         the largest final radius of the deformable elements at the height z\n\
               with + - * / **, parentheses and the functions of *PARAMETER. `revolve check` lists the columns that a deck has.\n",
    },
    HelpTopic {
        words: &["materials", "library"],
        text: "Ready materials in input/materials of the source archive, in m, kg, s, Pa and K, with the source of each constant in\n\
               comments. In a deck: *INCLUDE, INPUT=path/steel_4340.inp, then the name in *SOLID SECTION. A deck whose *UNITS\n\
               are others gets the warning P119. A file that ends with _failure.inp has the failure cards of its material.\n\
               \x20 copper_ofhc.inp          COPPER_OFHC        1 to 1e5 per s, 223 to 1000 K\n\
               \x20     Johnson-Cook 1983, annealed; *EOS; failure file\n\
               \x20 copper_half_hard.inp     COPPER_STEINBERG   above 1e5 per s, 300 K\n\
               \x20     Steinberg 1996, half hard, table; *EOS\n\
               \x20 iron_armco.inp           IRON_ARMCO         1 to 1e5 per s, 223 to 1000 K\n\
               \x20     Johnson-Cook 1983; failure file\n\
               \x20 steel_4340.inp           STEEL_4340         1 to 1e4 per s, 293 to 1000 K\n\
               \x20     Johnson-Cook 1985, Rc 30; failure file\n\
               \x20 steel_weldox_460e.inp    STEEL_WELDOX_460E  1e-4 to 1e4 per s, 293 to 1000 K\n\
               \x20     Børvik and others 1999, 2001; failure file\n\
               \x20 aluminium_2024_t351.inp  AL2024_T351        1 to 1e4 per s, 293 to 600 K\n\
               \x20     Johnson-Cook 1983; *EOS; failure file\n\
               \x20 aluminium_5083_h116.inp  AL5083_H116        1e-3 to 1e3 per s, 293 to 700 K\n\
               \x20     Clausen and others 2004; failure file\n\
               \x20 aluminium_6061_t6.inp    AL6061_T6          1e-3 to 1e4 per s, 293 to 700 K\n\
               \x20     Lesuer, Kay and LeBlanc 2001; *EOS\n\
               \x20 aluminium_6082_t651.inp  AL6082_T651        to 1e3 per s, 293 K\n\
               \x20     Forrestal and others 2014, table\n\
               \x20 aluminium_7075_t651.inp  AL7075_T651        1e-4 to 1e3 per s, 293 to 523 K\n\
               \x20     Brar, Joshi and Harris 2009; *EOS; failure file\n\
               \x20 titanium_6al4v.inp       TI6AL4V            1e-3 to 1e4 per s, 293 to 900 K\n\
               \x20     Lesuer 2000; *EOS\n\
               \x20 titanium_6al4v_1985.inp  TI6AL4V_1985       1e-3 to 1e4 per s, 293 to 900 K\n\
               \x20     Johnson 1985; *EOS\n\
               \x20 tungsten_alloy.inp       TUNGSTEN_ALLOY     1 to 1e4 per s, 293 to 1000 K\n\
               \x20     Johnson-Cook 1983; *EOS\n\
               \x20 concrete.inp             CONCRETE           13 to 110 MPa, 270 to 1100 m/s\n\
               \x20     resistance on a nose (Forrestal and others 1994, 1996)\n\
               \x20 concrete_48mpa_hjc.inp   CONCRETE_HJC       fc 48 MPa, rates above 1 per s\n\
               \x20     Holmquist-Johnson-Cook 1993, for meshes\n\
               \x20 concrete_c30_cdp.inp     CONCRETE_C30       fck 20 to 50 MPa, rates below 1 per s\n\
               \x20     damaged plasticity, tables of the Model Code 2010\n\
               \x20 alumina_jh2.inp          ABQ_JH2_ALUMINA    to 5 % compression\n\
               \x20     Johnson-Holmquist 2, 1994\n\
               \x20 boron_carbide_jh2.inp    ABQ_JH2_B4C        not stated\n\
               \x20     Johnson-Holmquist 2, 1999\n\
               \x20 silicon_carbide_jh2.inp  ABQ_JH2_SIC        not stated\n\
               \x20     Johnson-Holmquist 2, 2002\n\
               \x20 float_glass_jh2.inp      ABQ_JH2_GLASS      not stated\n\
               \x20     Johnson-Holmquist 2, 1995\n\
               \x20 aluminium_6016_t4_sheet.inp  AL6016_T4_SHEET  plastic strain to 1, quasi-static\n\
               \x20     Hill, Habraken and others 2022, table\n\
               \x20 steel_gtn.inp            STEEL_GTN          not stated\n\
               \x20     Gurson, Reusch and others 2003; with failure\n\
               \x20 porous_aluminium_palpha.inp  ALUMINIUM_POROUS  not stated\n\
               \x20     P-alpha, Jutzi and others 2008; *EOS, no strength\n\
               docs/materials.md compares their stress-strain curves and says which constants were confirmed.\n",
    },
    HelpTopic {
        words: &["units", "unit", "kg", "MPa", "mm"],
        text: "The program uses the units of the deck without conversion: any consistent system of units is possible.\n\
               \x20 m, kg, s:    N, Pa, J     steel 7850, 2.1e11\n\
               \x20 mm, t, s:    N, MPa, mJ   steel 7.85e-9, 2.1e5\n\
               \x20 mm, kg, ms:  kN, GPa, J   steel 7.85e-6, 210\n\
               \x20 mm, g, ms:   N, MPa, mJ   steel 7.85e-3, 2.1e5\n\
               \x20 cm, g, us:   1e7 N, Mbar  steel 7.85, 2.1\n\
               *UNITS gives their names for reports, pictures and tables. `check` warns if density and modulus fit no system (P119).\n\
               Masses, forces and energies refer to the full ring (360 degrees).\n",
    },
    HelpTopic {
        words: &["files", "results", "output", "pvd", "vtu", "sta", "paraview"],
        text: "A run writes into out/<deck>/ (--out DIR):\n\
               \x20 <job>.pvd, <job>_0000.vtu …  frames for ParaView: open the .pvd\n\
               \x20 <job>_history.csv            histories, one per column\n\
               \x20 <job>.sta                    progress: increments, energies, frames\n\
               \x20 <job>.setup                  ledger and materials until the end of the run\n\
               \x20 <job>.json                   summary: status, warnings, energies, ledger, run time\n\
               \x20 <job>.checkpoint             state for a restart with --resume\n\
               `revolve report DIR` writes them as one HTML page, `revolve chart DIR --column NAME` draws a picture.\n",
    },
    HelpTopic {
        words: &["threads", "cores", "instructions", "speed"],
        text: "--threads N (default: all cores) and --instructions scalar|avx2|avx512 (default: the best of the machine) change the\n\
               run time; results are bit-identical. Several threads are faster from about 1000 elements (docs/performance.md).\n",
    },
    HelpTopic {
        words: &["resume", "checkpoint", "restart"],
        text: "*RESTART, WRITE in the deck, --checkpoint-every 10s, and Ctrl-C write a checkpoint; `revolve run DECK --resume`\n\
               continues from it with bit-identical results (docs/restart.md).\n",
    },
];
