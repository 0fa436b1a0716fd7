#!/usr/bin/env bash
# Submits a data set in parts, and prints the number of the array job:
#
#     OUT=/shared/my-set examples/slurm/submit.sh 100 scenes/leaf.toml scenes/trunk.toml --reaches 50000 --seed 1
#
# The first argument is the number of parts; the others are those of `underbrush generate`. Options for sbatch, such as
# the partition, can be given as environment variables (SBATCH_PARTITION and so on).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
export PARTS=${1:?give the number of parts first, then the arguments of underbrush generate}
shift
OUT=${OUT:?set OUT to a folder on storage that all nodes share}
# Without a slash at the end, which would put the logs into the set.
export OUT=${OUT%/}
# Not in OUT: that folder holds nothing but the data set.
mkdir -p "$OUT.log"
exec sbatch --parsable --array="1-$PARTS" --output="$OUT.log/part-%a.txt" "$here/generate.sbatch" "$@"
