#!/usr/bin/env bash
# Compares what the program makes on this processor with what it makes on an emulated one without FMA and AVX: reaches, a
# data set, models of each kind and their verdicts. Libraries choose their instructions by processor at run time, so no
# environment variable can stand for one. Needs qemu-x86_64 (package qemu-user). It takes some minutes.
#
#     tests/other_processor.sh target/release/underbrush
set -euo pipefail
program=$(realpath "$1")
scenes=$(realpath "$(dirname "$0")/../scenes")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
make() {
    mkdir "$folder/$1" && cd "$folder/$1" && shift
    "$@" reach "$scenes/trunk.toml" --seed 1 --out reach.parquet
    "$@" generate "$scenes/engineered/leaf-row.toml" "$scenes/engineered/trunk-post.toml" --reaches 2 --seed 1 --out set
    for classifier in hmm nearest-neighbours naive-bayes echo-state-network logistic trees mini-rocket touch; do
        "$@" train set --classifier "$classifier" --out "$classifier.json"
        "$@" classify "$classifier.json" reach.parquet --online > "$classifier.verdicts"
    done
}
make own "$program" > /dev/null
make emulated qemu-x86_64 -cpu Nehalem "$program" > /dev/null
diff -r "$folder/own" "$folder/emulated"
echo "$(find "$folder/own" -type f | wc -l) files are the same"
