#!/bin/sh
# A sweep as an array of tasks under Slurm. Hand it in with the words of the sweep, once for as many parts as there are tasks:
#
#   sbatch --array=1-64 examples/slurm_array.sh input/ogive.inp --random 100000 --set V=600..900 \
#       --quantity "-1000*final(U2@REF)" --out shared/ogive
#
# Then make the table, or hear which cases are missing: revolve sweep with the same words and --gather.
#SBATCH --cpus-per-task=1
exec revolve sweep "$@" --cases "task/$SLURM_ARRAY_TASK_COUNT"
