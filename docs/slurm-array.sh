#!/bin/sh
# One task of an array that shares the iterations of a render:
#
#   sbatch --array=0-7 docs/slurm-array.sh SCENE FOLDER ITERATIONS [OPTION...]
#
# ITERATIONS are those of all tasks together; each OPTION goes to goblet render. A task leaves
# FOLDER/INDEX.checkpoint, and goes on from there if it is there already: after preemption,
# and to add iterations. SHARD=3/8 in the environment renders one part alone. GOBLET is the
# command, if it is not on the path.
#
#SBATCH --job-name=goblet
#SBATCH --requeue
#SBATCH --open-mode=append
# A minute before the time limit, to save what there is.
#SBATCH --signal=B:TERM@60
set -eu

if [ $# -lt 3 ]; then
    echo "usage: sbatch --array=0-N slurm-array.sh SCENE FOLDER ITERATIONS [OPTION...]" >&2
    exit 2
fi
scene=$1 folder=$2 iterations=$3
shift 3

shard=${SHARD:-auto}
# As goblet finds it for auto: Slurm's, or AWS Batch's.
index=${SLURM_ARRAY_TASK_ID:-${AWS_BATCH_JOB_ARRAY_INDEX:-}}
if [ "$shard" != auto ]; then index=${shard%/*}; fi
if [ -z "$index" ]; then
    echo "slurm-array.sh: neither in an array nor is SHARD set" >&2
    exit 2
fi

checkpoint=$folder/$index.checkpoint
if [ -e "$checkpoint" ]; then
    set -- --resume "$checkpoint" "$@"
fi
mkdir -p "$folder"
# exec, so that Slurm's signals reach goblet.
exec "${GOBLET:-goblet}" render "$scene" --quiet --radius-schedule global \
    --iterations "$iterations" --shard "$shard" --checkpoint "$checkpoint" "$@"
