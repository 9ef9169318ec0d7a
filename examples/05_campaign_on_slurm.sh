#!/bin/bash
# SPDX-License-Identifier: MIT
# A campaign as a job array of SLURM; page: docs/clusters.md
#   sbatch --array=0-99 05_campaign_on_slurm.sh my_campaign.toml 1000000 /shared/flown
#SBATCH --cpus-per-task=4
#SBATCH --time=01:00:00
#SBATCH --requeue
set -euo pipefail
campaign=$1 runs=$2 out=$3
chunk=${CHUNK:-1000}                        # runs a part
tasks=${SLURM_ARRAY_TASK_COUNT:-1}          # SLURM sets these
task=${SLURM_ARRAY_TASK_ID:-0}

chunks=$(((runs + chunk - 1) / chunk))
first=$((task * chunks / tasks))
end=$(((task + 1) * chunks / tasks))
((first < end)) || exit 0                   # more tasks than chunks
gyrostat campaign "$campaign" --runs "$runs" --chunk "$chunk" --chunks "$first:$end" \
  --jobs "${SLURM_CPUS_PER_TASK:-1}" --out "$out"
