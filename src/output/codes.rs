//! Diagnostic codes of checkpoints (`K…`), for `revolve explain`.
//! Never here: the checks.

use crate::deck::Code;

/// All codes of this folder.
pub const CODES: &[Code] = codes! {
    "K001" "damaged checkpoint" "`--resume` reads `<job>.checkpoint` in the folder of the results. It is no checkpoint, cut off, or changed: its checksum (SHA-256) is not that of its content. The program itself never leaves half a checkpoint behind."
    "K002" "checkpoint of another version" "Versions may differ in what a state consists of and in the last bits of results: a run goes on with the version that it began with."
    "K003" "checkpoint of another deck" "The text of the deck, of a file that it includes, or its mesh is not what it was when the run began. What the state then means is not known."
    "K004" "checkpoint of other parameters" "The values of *PARAMETER, those of `--set` included, are not what they were. Give the same `--set` again."
    "K005" "checkpoint of other user routines" "The files of `--user`, the compiler or its flags (`--check-user`) are not what they were. Give the same again."
    "K006" "checkpoint that does not fit" "The content of the checkpoint has another shape than the plan of the deck. That should not happen with the same deck and version: please report it."
    "K007" "a job is at work in the folder" "Another process writes results into the folder; frames of both would mix. The message names its job and its number. The lock is `.revolve-lock` in the folder; the system lets go of it when the process ends, also when it is killed, so one that is left over locks nothing."
    "K008" "no name for a job" "A job has the name of its deck without the ending, and its files begin with it. A deck called `...inp` would name them `..`, which is the folder above."
    "K009" "checkpoint that lacks memory of the routines" "SAVE, COMMON, modules and static variables of user routines are kept in a checkpoint and given back, as far as they mean the same in another process. What does not: an address (an ALLOCATABLE or POINTER with SAVE, memory of malloc, a FILE), a variable of which each thread has its own, a file that is open, a thread that still runs, the seed of random_number. The message names what was found. `--resume-anyway` goes on: where only a file, a thread or a seed is lost, the variables are as they were, else as in a new run; vexternaldb is called with lOp = 0 and kInc above 0, and can open and read what it needs."
    "K010" "checkpoint of another precision" "The run went in double precision and is to go on in single, or the other way round. Give the `--precision` that it had."
    "K101" "no checkpoint" "`--resume` found no `<job>.checkpoint` in the folder of the results, and the run starts at its beginning. A checkpoint is written if the deck has *RESTART, WRITE, with `--checkpoint-every`, and when SIGINT or SIGTERM ends a run; it is removed when the run is complete."
    "K102" "not all of the routines' memory is kept" "A checkpoint does not hold all that the user's routines keep to themselves: K009 says what cannot be kept, and `--resume` refuses such a checkpoint. A routine can keep it by its own means: vexternaldb is told by lWriteRestart = 1 that the state of the increment that ends will be kept, and by lOp = 0 with kInc above 0 that a run goes on (`--resume-anyway`). Of routines that are types of Rust nothing is kept but what they are given to keep."
    "K103" "frames are missing" "Frames that were written before the checkpoint are no longer in the folder, or a loss of power has left them empty. The run goes on; the series names them nevertheless."
};
