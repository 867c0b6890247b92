#!/usr/bin/env bash
# Eight runs of a program on a simulated machine, each learned from by `precomp refine`: RMS and MAX by run.
#   benches/refine-runs.sh ballscrew benches/pocket.nc
set -euo pipefail
machine=$1 program=$(realpath "$2") runs=${3:-8}
cargo build --release --locked --quiet
precomp=$PWD/target/release/precomp
cd "$(mktemp -d)"

"$precomp" excite --machine "$machine" --seconds 120 -o excitation > /dev/null
seed=500 logs=()
for reference in excitation/*.csv; do
  seed=$((seed + 1))
  log=log-$(basename "$reference")
  "$precomp" simulate "$reference" --machine "$machine" --seed "$seed" -o "$log" > /dev/null
  logs+=("$log")
done
"$precomp" train "${logs[@]}" --machine "$machine" -o machine.model > /dev/null

"$precomp" compensate "$program" -m machine.model -o run1.nc > /dev/null
logs=() programs=()
for run in $(seq 1 "$runs"); do
  "$precomp" simulate "run$run.nc" --machine "$machine" --against "$program" --seed $((900 + run)) -o "run$run.csv" \
    | sed "s/.*; contour error/run $run: contour error/; s/; log in.*//"
  logs+=("run$run.csv") programs+=("run$run.nc")
  if [ "$run" -lt "$runs" ]; then
    "$precomp" refine "$program" -m machine.model --log "${logs[@]}" --ran "${programs[@]}" -o "run$((run + 1)).nc" 2> /dev/null | tail -1
  fi
done
