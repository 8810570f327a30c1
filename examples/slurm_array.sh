#!/bin/sh
# A sweep as a Slurm array: one part for each task. Submit it with the arguments of the sweep:
#
#   sbatch --array=1-64 examples/slurm_array.sh input/ogive.inp --random 100000 --set V=600..900 \
#       --quantity "-1000*final(U2@REF)" --out shared/ogive
#
# Then combine the parts, or list missing cases: revolve sweep with the same arguments and --gather.
#SBATCH --cpus-per-task=1
exec revolve sweep "$@" --cases "task/$SLURM_ARRAY_TASK_COUNT"
