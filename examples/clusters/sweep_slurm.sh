#!/bin/bash
# A sweep as a Slurm job array: sbatch sweep_slurm.sh OUT ARGUMENTS OF `sandbox sweep`...
# OUT is a folder that every node sees. A job that was requeued continues after its last run. At the end, on any node:
#     sandbox merge OUT/[0-9]* --out OUT/all
#SBATCH --job-name=sandbox-sweep
#SBATCH --array=1-100
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=1G
#SBATCH --time=01:00:00
#SBATCH --requeue
set -euo pipefail

out=$1
shift
exec sandbox sweep "$@" --threads 1 --resume --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    --out "$out/$SLURM_ARRAY_TASK_ID"
