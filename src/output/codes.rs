//! Diagnostic codes of checkpoints (`K…`), for `revolve explain`.
//! Never here: the checks.

use crate::deck::Code;

/// All codes of this room.
pub const CODES: &[Code] = &[
    Code {
        code: "K001",
        title: "damaged checkpoint",
        text: "`--resume` reads `<job>.checkpoint` in the folder of the results. It is no checkpoint, cut off, or changed: its checksum (SHA-256) is not that of its content. The program itself never leaves half a checkpoint behind.",
    },
    Code {
        code: "K002",
        title: "checkpoint of another version",
        text: "Versions may differ in what a state consists of and in the last bits of results: a run goes on with the version that it began with.",
    },
    Code {
        code: "K003",
        title: "checkpoint of another deck",
        text: "The text of the deck, of a file that it includes, or its mesh is not what it was when the run began. What the state then means is not known.",
    },
    Code {
        code: "K004",
        title: "checkpoint of other parameters",
        text: "The values of *PARAMETER, those of `--set` included, are not what they were. Give the same `--set` again.",
    },
    Code {
        code: "K005",
        title: "checkpoint of other user routines",
        text: "The files of `--user`, the compiler or its flags (`--check-user`) are not what they were. Give the same again.",
    },
    Code {
        code: "K006",
        title: "checkpoint that does not fit",
        text: "The content of the checkpoint has another shape than the plan of the deck. That should not happen with the same deck and version: please report it.",
    },
    Code {
        code: "K007",
        title: "a job is at work in the folder",
        text: "Another process writes results into the folder; frames of both would mix. The message names its job and its number. The lock is `.revolve-lock` in the folder; the system lets go of it when the process ends, also when it is killed, so one that is left over locks nothing.",
    },
    Code {
        code: "K008",
        title: "no name for a job",
        text: "A job has the name of its deck without the ending, and its files begin with it. A deck called `...inp` would name them `..`, which is the folder above.",
    },
    Code {
        code: "K009",
        title: "checkpoint that lacks memory of the routines",
        text: "SAVE, COMMON, modules and static variables of user routines are kept in a checkpoint and given back, as far as they mean the same in another process. What does not: an address (an ALLOCATABLE or POINTER with SAVE, memory of malloc, a FILE), a variable of which each thread has its own, a file that is open, a thread that still runs, the seed of random_number. The message names what was found. `--resume-anyway` goes on: where only a file, a thread or a seed is lost, the variables are as they were, else as in a new run; vexternaldb is called with lOp = 0 and kInc above 0, and can open and read what it needs.",
    },
    Code {
        code: "K010",
        title: "checkpoint of another precision",
        text: "The run went in double precision and is to go on in single, or the other way round. Give the `--precision` that it had.",
    },
    Code {
        code: "K101",
        title: "no checkpoint",
        text: "`--resume` found no `<job>.checkpoint` in the folder of the results, and the run starts at its beginning. A checkpoint is written if the deck has *RESTART, WRITE, with `--checkpoint-every`, and when SIGINT or SIGTERM ends a run; it is removed when the run is complete.",
    },
    Code {
        code: "K102",
        title: "not all of the routines' memory is kept",
        text: "A checkpoint does not hold all that the user's routines keep to themselves: K009 says what cannot be kept, and `--resume` refuses such a checkpoint. A routine can keep it by its own means: vexternaldb is told by lWriteRestart = 1 that the state of the increment that ends will be kept, and by lOp = 0 with kInc above 0 that a run goes on (`--resume-anyway`). Of routines that are types of Rust nothing is kept but what they are given to keep.",
    },
    Code {
        code: "K103",
        title: "frames are missing",
        text: "Frames that were written before the checkpoint are no longer in the folder, or a loss of power has left them empty. The run goes on; the series names them nevertheless.",
    },
];
