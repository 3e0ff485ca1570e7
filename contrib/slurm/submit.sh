#!/bin/sh
# Renders a scene on a Slurm cluster: one job of an array for each shard, and one that merges them. README.md explains it.
#
#   submit.sh SCENE PARTS IMAGE [OPTIONS OF `rt-cli render`]
#
# Set RT_CLI if rt-cli is not on the nodes' PATH, and SBATCH_* variables or SBATCH_OPTIONS for accounts, partitions and limits.
set -eu

usage="usage: submit.sh SCENE PARTS IMAGE [options of rt-cli render]"
scene=${1:?$usage} parts=${2:?$usage} image=${3:?$usage}
shift 3
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
folder=$image.parts
mkdir -p "$folder"

# SBATCH_OPTIONS is a list of words.
# shellcheck disable=SC2086
array=$(sbatch --parsable --array="1-$parts" --output="$folder/%a.log" ${SBATCH_OPTIONS:-} \
    "$here/part.sbatch" "$scene" "$folder" "$@")
# shellcheck disable=SC2086
merge=$(sbatch --parsable --dependency="afterok:${array%%;*}" --kill-on-invalid-dep=yes --output="$folder/merge.log" \
    ${SBATCH_OPTIONS:-} "$here/merge.sbatch" "$folder" "$image" "$parts")
echo "parts: job ${array%%;*}, image: job ${merge%%;*}"
