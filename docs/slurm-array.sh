#!/bin/sh
# One task of an array that shares the iterations of a render:
#
#   sbatch --array=0-7 docs/slurm-array.sh SCENE FOLDER ITERATIONS [OPTION...]
#
# ITERATIONS is the number of iterations of all tasks together. Each OPTION is passed to goblet
# render. A task writes FOLDER/INDEX.checkpoint and continues from that file if it exists: after
# preemption, and to add iterations. SHARD=3/8 in the environment renders one part alone. GOBLET is
# the command, if goblet is not on the path.
#
#SBATCH --job-name=goblet
#SBATCH --requeue
#SBATCH --open-mode=append
# The signal comes a minute before the time limit: time to save a checkpoint.
#SBATCH --signal=B:TERM@60
set -eu

if [ $# -lt 3 ]; then
    echo "usage: sbatch --array=0-N slurm-array.sh SCENE FOLDER ITERATIONS [OPTION...]" >&2
    exit 2
fi
scene=$1 folder=$2 iterations=$3
shift 3

shard=${SHARD:-auto}
# The index that goblet uses for auto: from Slurm or from AWS Batch.
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
