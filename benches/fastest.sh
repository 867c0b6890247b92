#!/usr/bin/env bash
# Cycle time at equal error, on simulated machines: programs run uncompensated, compensated, and with the feeds of `--fastest`.
# The tolerance is 0.8 × the measured MAX of the uncompensated run; feeds may be twice those of the program. Errors are measured.
#   benches/fastest.sh "ballscrew random:1" PROGRAM[@X,Y,Z]...      # @: the work offset, inside the travel of the excitation
set -euo pipefail
machines=$1
shift
precomp=${PRECOMP:-$PWD/target/release/precomp}
[ -n "${PRECOMP:-}" ] || cargo build --release --locked --quiet
exceed=${EXCEED:-100} seconds=${SECONDS_OF_LOG:-120}

figure() { # FILE KEY: the first number with this key
  sed -n "s/.*\"$2\": \(-\{0,1\}[0-9.e-]*\),\{0,1\}$/\1/p" "$1" | head -1
}
run() { # NAME PROGRAM: seconds, RMS and MAX of a run, against the original
  "$precomp" simulate "$2" --machine "$machine" --against "$program" --work-offset "$offset" --decimal-point unit --seed 900 -o "$1.csv" --json "$1.json" > /dev/null
}
row() { # NAME FILE
  printf '%-14s %-28s %-16s %9.2f %9.3f %9.3f\n' "$machine" "$(basename "$program")" "$1" \
    "$(figure "$2" seconds)" "$(figure "$2" rms)" "$(figure "$2" max)"
}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
arguments=("$@")
for i in "${!arguments[@]}"; do
  path=${arguments[$i]%@*}
  arguments[$i]=$(realpath "$path")${arguments[$i]#"$path"}
done
printf '%-14s %-28s %-16s %9s %9s %9s\n' machine program run s 'RMS µm' 'MAX µm'
for machine in $machines; do
  cd "$folder"
  rm -rf ./*
  "$precomp" excite --machine "$machine" --seconds "$seconds" -o excitation > /dev/null
  seed=500 logs=()
  for reference in excitation/*.csv; do
    seed=$((seed + 1))
    "$precomp" simulate "$reference" --machine "$machine" --seed "$seed" -o "log-$(basename "$reference")" > /dev/null
    logs+=("log-$(basename "$reference")")
  done
  "$precomp" train "${logs[@]}" --machine "$machine" -o machine.model > /dev/null
  for argument in "${arguments[@]}"; do
    program=${argument%@*} offset=0,0,0
    [ "$program" = "$argument" ] || offset=${argument#*@}
    compensate=("$precomp" compensate "$program" -m machine.model --work-offset "$offset" --decimal-point unit)
    run raw "$program"
    row uncompensated raw.json
    "${compensate[@]}" -o same.nc > /dev/null 2>&1
    run same same.nc
    row compensated same.json
    tolerance=$(awk -v max="$(figure raw.json max)" 'BEGIN { print 0.8 * max }')
    started=$(date +%s)
    "${compensate[@]}" -o fast.nc --tolerance "${tolerance}um" --fastest --may-exceed-feed "$exceed" --json feeds.json > /dev/null 2>&1
    run fast fast.nc
    row "fastest" fast.json
    echo "  cycle $(awk -v a="$(figure fast.json seconds)" -v b="$(figure raw.json seconds)" 'BEGIN { printf "%+.1f %%", 100 * (a / b - 1) }')," \
      "without a tolerance $(figure feeds.json allowed) s, at the machine's limits $(figure feeds.json machine) s; search $(($(date +%s) - started)) s"
  done
done
