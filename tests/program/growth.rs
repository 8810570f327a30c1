//! Large decks: excessive ones are rejected before memory is allocated, others are read in time proportional to their
//! size.
//!
//! Goal: twice the cards take twice the work, for any card; all cards together have one limit. Source: counted
//! allocations of reading and planning; a loop over all names for each name allocates four times as much. Tolerance: an
//! exponent of 1.2.

use std::fmt::Write as _;

use revolve::job::{self, PreparedJob};
use revolve::user::Routines;

use crate::common::solid::grid;

/// A body of `n` elements with many cards of one kind.
struct RepeatedCards {
    name: &'static str,
    sections: bool,
    model: fn(usize) -> String,
    step: fn(usize) -> String,
}

const BODY: &str = "*Solid Section, elset=SOLID, material=M\n";
const METAL: &str = "*Density\n 7850.,\n*Elastic\n 2.1e11, 0.3\n";
const STEP: &str = "*Step\n*Dynamic, Explicit\n , 1.e-9\n*Boundary\n 1, 2, 2\n";

const DECKS: [RepeatedCards; 16] = [
    RepeatedCards {
        name: "*CLOAD, one card",
        sections: false,
        model: |_| String::new(),
        step: |i| if i == 1 { "*Cload\n 1, 2, 1.\n".into() } else { format!(" {i}, 2, 1.\n") },
    },
    RepeatedCards {
        name: "*CLOAD, a card each",
        sections: false,
        model: |_| String::new(),
        step: |i| format!("*Cload\n {i}, 2, 1.\n"),
    },
    RepeatedCards {
        name: "*DLOAD",
        sections: false,
        model: |_| String::new(),
        step: |i| format!("*Dload\n {i}, P1, 1.\n"),
    },
    RepeatedCards {
        name: "*BOUNDARY",
        sections: false,
        model: |_| String::new(),
        step: |i| format!("*Boundary, type=VELOCITY\n {}, 1, 1, 1.\n", i + 1),
    },
    RepeatedCards {
        name: "unknown sets among many",
        sections: false,
        model: |i| format!("*Nset, nset=N{i}\n {i},\n"),
        step: |i| format!("*Boundary\n A_NAME_FAR_FROM_ALL_{i}, 1, 1\n"),
    },
    RepeatedCards {
        name: "sets",
        sections: false,
        model: |i| format!("*Nset, nset=N{i}\n {i},\n*Elset, elset=E{i}\n {i},\n"),
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "surfaces",
        sections: false,
        model: |i| format!("*Surface, name=F{i}\n {i}, S1\n"),
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "amplitudes",
        sections: false,
        model: |i| format!("*Amplitude, name=A{i}\n 0., 0., 1., 1.\n"),
        step: |i| format!("*Cload, amplitude=A{i}\n {i}, 2, 1.\n"),
    },
    RepeatedCards {
        name: "initial velocities",
        sections: false,
        model: |i| format!("*Initial Conditions, type=VELOCITY\n {i}, 2, 1.\n"),
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "materials",
        sections: false,
        model: |i| format!("*Material, name=X{i}\n{METAL}"),
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "materials and sections",
        sections: true,
        model: |i| {
            format!(
                "*Elset, elset=E{i}\n {i},\n*Material, name=X{i}\n{METAL}*Solid Section, elset=E{i}, material=X{i}\n"
            )
        },
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "sections and controls",
        sections: true,
        model: |i| {
            format!(
                "*Elset, elset=E{i}\n {i},\n*Section Controls, name=C{i}, hourglass=VISCOUS\n*Solid Section, elset=E{i}, material=M, controls=C{i}\n"
            )
        },
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "unknown materials among many",
        sections: true,
        model: |i| {
            format!(
                "*Elset, elset=E{i}\n {i},\n*Material, name=X{i}\n{METAL}*Solid Section, elset=E{i}, material=Y{i}\n"
            )
        },
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "separate bodies",
        sections: false,
        model: |i| {
            let (node, z) = (100_000 + 4 * i, 2 * i);
            let [a, b, c, d] = [node, node + 1, node + 2, node + 3];
            format!(
                "*Node\n {a}, 1., {z}.\n {b}, 2., {z}.\n {c}, 2., {z}.5\n {d}, 1., {z}.5\n\
                 *Element, type=CAX4R, elset=P{i}\n {node}, {a}, {b}, {c}, {d}\n*Solid Section, elset=P{i}, material=M\n"
            )
        },
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "rigid bodies",
        sections: false,
        model: |i| {
            let (node, z) = (100_000 + 4 * i, 2 * i);
            let [a, b, c] = [node, node + 1, node + 2];
            format!(
                "*Node\n {a}, 1., {z}.\n {b}, 2., {z}.\n {c}, 0., {z}.\n*Element, type=RAX2, elset=P{i}\n {node}, {a}, {b}\n\
                 *Rigid Body, ref node={c}, elset=P{i}\n*Element, type=MASS, elset=Q{i}\n {b}, {c}\n*Mass, elset=Q{i}\n 1.,\n"
            )
        },
        step: |_| String::new(),
    },
    RepeatedCards {
        name: "point masses",
        sections: false,
        model: |i| format!("*Element, type=MASS, elset=P{i}\n {}, {i}\n*Mass, elset=P{i}\n 1.,\n", 100_000 + i),
        step: |_| String::new(),
    },
];

impl RepeatedCards {
    fn text(&self, rows: usize) -> String {
        let n = 20 * rows;
        let mut text = grid(20, rows, false, |i, j| [1e-3 * i as f64, 1e-3 * j as f64]) + "*Material, name=M\n" + METAL;
        if !self.sections {
            text += BODY;
        }
        (1..=n).for_each(|i| text += &(self.model)(i));
        text += STEP;
        (1..=n).for_each(|i| text += &(self.step)(i));
        text + "*End Step\n"
    }
}

fn read(text: &str) -> PreparedJob {
    job::prepare_text("deck.inp", text, &[], &Routines::none())
}

#[test]
fn work_is_proportional_to_the_number_of_cards() {
    for deck in &DECKS {
        let count = |rows: usize| {
            let text = deck.text(rows);
            let counted = allocation_counter::measure(|| drop(read(&text)));
            [counted.count_total as f64, counted.bytes_total as f64]
        };
        count(2);
        let (one, two) = (count(40), count(80));
        let growth = [two[0] / one[0], two[1] / one[1]];
        println!(
            "{}: {:.0} allocations, {:.1} MB; twice the cards: {growth:.2?} times",
            deck.name,
            one[0],
            1e-6 * one[1]
        );
        assert!(growth.iter().all(|g| *g < 2.3), "{}: {growth:?}", deck.name);
    }
}

/// Numbers allowed for each card but not for all together: rejected with the card, before memory is allocated.
#[test]
fn all_cards_share_one_limit() {
    let many = |head: &str, row: &str| {
        let mut text = grid(100, 100, false, |i, j| [i as f64, j as f64]);
        text += head;
        for i in 0..6000 {
            writeln!(text, "{}", row.replace('#', &i.to_string())).expect("text");
        }
        text
    };
    let elements = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 1., 1.\n 4, 0., 1.\n*Element, type=CAX4R\n 1, 1, 2, 3, 4\n";
    for (text, code) in [
        (many("", "*Nset, nset=N#\n ALL,"), "M125"),
        (many("*Boundary\n", " ALL, 1, 1"), "M125"),
        (many("", "*Elset, elset=E#, generate\n 1, 10000, 1"), "M125"),
        (format!("{elements}*Elgen\n 1, 30000000, 0, 1\n"), "M125"),
        (format!("{elements}*Elgen\n 1, 5000000, 0, 0\n"), "M103"),
    ] {
        let mut found = Vec::new();
        let counted = allocation_counter::measure(|| {
            let prepared = read(&text);
            found = prepared.diagnostics.findings(&prepared.deck.sources);
        });
        let shown = &text[text.len() - 80..];
        println!("{code}: {:.0} MB at most", 1e-6 * counted.bytes_max as f64);
        assert!(found.iter().any(|f| f.code == code), "{shown}: {found:?}");
        assert!(counted.bytes_max < 1_000_000_000, "{shown}: {} bytes", counted.bytes_max);
    }
}
