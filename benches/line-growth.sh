#!/usr/bin/env bash
# Lines in and out, and cycle time, of `precomp compensate` on every program of a folder; the medians of those that are compensated.
#   benches/line-growth.sh ../shared/data/gcode
# Programs that take longer than SECONDS_EACH (120) are named and left out.
set -euo pipefail
folder=$(realpath "$1")
cargo build --release --locked --quiet
precomp=$PWD/target/release/precomp
cd "$(mktemp -d)"

"$precomp" excite --machine ballscrew --seconds 20 -o excitation > /dev/null
seed=500 logs=()
for reference in excitation/*.csv; do
  seed=$((seed + 1))
  log=log-$(basename "$reference")
  "$precomp" simulate "$reference" --machine ballscrew --seed "$seed" -o "$log" > /dev/null
  logs+=("$log")
done
"$precomp" train "${logs[@]}" --machine ballscrew -o machine.model > /dev/null 2>&1

: > growth
for program in "$folder"/*; do
  name=$(basename "$program")
  if ! timeout "${SECONDS_EACH:-120}" "$precomp" compensate "$program" -m machine.model -o out.nc > said 2>&1; then
    echo "$name: no result"
    continue
  fi
  lines=$(sed -n 's/.*; \([0-9]*\) lines in, \([0-9]*\) out.*/\1 \2/p' said)
  cycle=$(sed -n 's/.*cycle time:.*(\([^)]*\)).*/\1/p' said)
  read -r before after <<< "$lines"
  if [ "$before" = "$after" ]; then
    echo "$name: unchanged"
    continue
  fi
  growth=$(awk "BEGIN { printf \"%.2f\", $after / $before }")
  echo "$name: $before lines, $after out, $growth times, cycle ${cycle:-the same}"
  echo "$growth" >> growth
done
sort -n growth | awk '{ at[NR] = $1 } END { printf "median growth %.2f, largest %.2f, of %d programs\n", (at[int((NR + 1) / 2)] + at[int(NR / 2) + 1]) / 2, at[NR], NR }'
