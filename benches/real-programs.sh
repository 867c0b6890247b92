#!/bin/sh
# Every program of a folder (default: ../shared/data/gcode) through `compensate` with a model of 20 s of ballscrew: cycle, time, multiple of
# real time and peak memory, as a table. SETTINGS are given to every run.
set -eu
cd "$(dirname "$0")/.."
programs=$(cd "${1:-../shared/data/gcode}" && pwd)
. benches/short-model.sh
echo "| program | lines | cycle s | time s | × real time | memory MB |"
echo "|---|---|---|---|---|---|"
for program in "$programs"/*; do
    [ -f "$program" ] || continue
    name=$(basename "$program")
    status=0
    # shellcheck disable=SC2086
    /usr/bin/time -f "%e %M" -o took.txt timeout 600 "$precomp" compensate "$program" -m m.model -o out.nc --work-offset 0,0,0 \
        --decimal-point unit ${SETTINGS:-} > out.txt 2>&1 || status=$?
    if [ "$status" -ne 0 ]; then
        echo "| $name | | | | | $(grep -m 1 '^error' out.txt | cut -c 1-80) |"
        continue
    fi
    python3 - "$name" "$program" <<'EOF'
import re, sys
seconds, memory = open("took.txt").read().split()[-2:]
found = re.search(r"cycle time: ([0-9.]+)", open("out.txt").read())
cycle = float(found.group(1)) if found else 0.0
lines = open(sys.argv[2], "rb").read().count(b"\n")
print(f"| {sys.argv[1]} | {lines} | {cycle:.0f} | {float(seconds):.1f} | {cycle / float(seconds):.0f} | {int(memory) / 1000:.0f} |")
EOF
done
