//! Diagnostic codes of checkpoints and result folders (`K…`), for `revolve explain`.

use revolve_numerics::codes;

use revolve_diagnostics::DiagnosticCode;

/// Diagnostic codes of writing results.
pub const CODES: &[DiagnosticCode] = codes! {
    "K001" "damaged checkpoint" "`--resume` reads `<job>.checkpoint` in the folder of the results. The file is not a checkpoint, is incomplete, or has changed, so that its SHA-256 checksum does not match. The program writes checkpoints atomically and never leaves an incomplete one."
    "K002" "checkpoint of another version" "Versions may differ in the format of the state and in the last bits of results. Continue a run with the version that started it."
    "K003" "checkpoint of another deck" "The text of the deck, of a file that it includes, or its mesh has changed since the run began. The saved state cannot be interpreted with the new deck."
    "K004" "checkpoint of other parameters" "The values of *PARAMETER, including those of `--set`, differ from those of the run. Use the same `--set` again."
    "K005" "checkpoint of other user subroutines" "The files of `--user`, the compiler or its flags (`--check-user`) have changed. Use the same ones again."
    "K006" "checkpoint that does not fit" "The content of the checkpoint does not fit the deck. This is an error of the program if deck and version are the same: please report it."
    "K007" "folder in use by another job" "Another process writes results into the folder, and the frames of both jobs would mix. The message names its job and its process number. The lock file is `.revolve-lock` in the folder. The operating system releases the lock when the process ends, even if it is killed, so that a remaining file has no effect."
    "K008" "deck without a job name" "The job name is the file name of the deck without its suffix, and result files begin with it. A deck called `...inp` would give the name `..`, which is the parent folder."
    "K009" "checkpoint without some user memory" "A checkpoint contains SAVE, COMMON, module and static variables of user subroutines. It cannot contain data that is valid only within one process: addresses (an ALLOCATABLE or POINTER with SAVE, memory of malloc, a FILE), thread-local variables, open files, running threads, the seed of random_number. The message names what was found. `--resume-anyway` continues the run. If only a file, a thread or a seed is missing, the variables are restored, else they are as in a new run. vexternaldb is called with lOp = 0 and kInc above 0, and can open and read the data that it needs."
    "K011" "disk too small" "The frames, histories and the restart file of the run need more space than is free on the disk of the results folder. `revolve check` prints their number and size. The size of a frame is estimated as 0.4 times that without compression; `check` measures it in a short trial run. Write fewer frames or fewer variables, choose another folder with `--out`, use `--no-frames`, or start the run with `--force`."
    "K012" "results larger than permitted" "With `--untrusted` or REVOLVE_UNTRUSTED=1 the frames, histories and the restart file of a run may have at most 2 GB, counted without compression. Write fewer frames or fewer variables, or use `--no-frames`."
    "K101" "no checkpoint" "`--resume` found no `<job>.checkpoint` in the results folder, so the run starts from the beginning. A checkpoint is written if the deck contains *RESTART, WRITE, with `--checkpoint-every`, and when SIGINT or SIGTERM ends a run. It is removed when the run is complete."
    "K102" "user memory is missing in the checkpoint" "A checkpoint does not contain all memory of the user subroutines. K009 lists the data that cannot be saved, and `--resume` rejects such a checkpoint. A subroutine can save such data itself: vexternaldb receives lWriteRestart = 1 if a checkpoint follows the increment, and lOp = 0 with kInc above 0 if a run continues (`--resume-anyway`). For subroutines in Rust only data that they explicitly save is included."
    "K103" "frames are missing" "Frames that were written before the checkpoint are no longer in the folder, or are empty after a power failure. The run continues, and the series still lists these frames."
    "K104" "no checkpoint at the time limit" "At the time limit of a job, Slurm sends SIGTERM to the processes of its batch script, and SIGKILL after `KillWait` seconds (30 by default). A shell that runs the program as an ordinary command ends at SIGTERM. The job step then ends with the shell, and the program is killed at once. Start the program with `exec revolve run ...` or `srun revolve run ...`, or write checkpoints during the run with `--checkpoint-every 10m`. The note is omitted if the script handles SIGTERM (`trap`)."
};
