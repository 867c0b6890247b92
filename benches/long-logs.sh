#!/bin/sh
# Time and memory of `measure`, `predict` and `train` on logs of 1 and 10 hours at 1 kHz, as CSV: HOURS="1 10" by default, FOLDER for the logs
# (0.28 GB an hour), which are removed.
set -eu
cd "$(dirname "$0")/.."
cargo build --release
cargo build --release -p precomp-datasets --example long_log
precomp=$PWD/target/release/precomp
folder=$(mktemp -d "${FOLDER:-/tmp}/long-logs-XXXXXX")
trap 'rm -rf "$folder"' EXIT
took() {
    name=$1
    shift
    /usr/bin/time -f "$name: %e s, %M kB" "$@" > "$folder/out.txt" 2> "$folder/err.txt" || { cat "$folder/err.txt"; exit 1; }
    tail -n 1 "$folder/err.txt"
}
for hours in ${HOURS:-1 10}; do
    target/release/examples/long_log "$hours" "$folder/log.csv"
    took "train, $hours h" "$precomp" train "$folder/log.csv" -o "$folder/m.model"
    took "measure, $hours h" "$precomp" measure "$folder/log.csv"
    took "measure -m, $hours h" "$precomp" measure "$folder/log.csv" -m "$folder/m.model"
    took "predict, $hours h" "$precomp" predict "$folder/log.csv" -m "$folder/m.model"
    took "predict -o, $hours h" "$precomp" predict "$folder/log.csv" -m "$folder/m.model" -o "$folder/forecast.parquet"
    rm -f "$folder"/log.csv "$folder"/forecast.parquet
done
