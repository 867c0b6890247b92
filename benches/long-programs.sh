#!/bin/sh
# Finishing rows of 0.2 mm lines through `compensate` with a model of 20 s of ballscrew, by effort and as a whole: cycle, time, multiple of real time
# and peak memory, as a table. LINES="30000" by default; MILLIONS=2 adds two million lines with `fast`.
set -eu
cd "$(dirname "$0")/.."
. benches/short-model.sh
rows() {
    python3 - "$1" > "$2" <<'EOF'
import math, sys
print("G21 G90 G17 G94\nG0 X-50.0 Y-50.0 Z5.0\nG1 Z0.0 F1000\nF3000")
lines, y, forward, rows = int(sys.argv[1]), -50.0, True, 0
for line in range(lines):
    step = line % 501
    if step == 500:
        y, forward, rows = (y + 0.2 if y < 50 else -50.0), not forward, rows + 1
    else:
        x = -50 + 0.2 * (step + 1) if forward else 50 - 0.2 * (step + 1)
    print(f"G1 X{x:.4f} Y{y:.4f} Z{1.5 * math.sin(0.21 * x) * math.cos(0.17 * y):.4f}")
print("G0 Z5.0\nM30")
EOF
}
took() {
    lines=$1
    name=$2
    shift 2
    /usr/bin/time -f "%e %M" -o took.txt "$precomp" compensate rows.nc -m m.model -o out.nc --work-offset 0,0,0 "$@" > out.txt 2> err.txt || { cat err.txt; exit 1; }
    python3 - "$lines" "$name" <<'EOF'
import re, sys
seconds, memory = open("took.txt").read().split()[-2:]
cycle = float(re.search(r"cycle time: ([0-9.]+)", open("out.txt").read()).group(1))
print(f"| {int(sys.argv[1]):,} | {cycle:.0f} s | {sys.argv[2]} | {float(seconds):.1f} s | {cycle / float(seconds):.0f} | {int(memory) / 1000:.0f} MB |")
EOF
}
measured() {
    "$precomp" simulate "$1" --machine ballscrew --against rows.nc --work-offset 0,0,0 --seed 901 -o run.csv | sed -n "s/.*\(contour error.*\); log.*/$2: \1/p"
}
echo "| lines | cycle | effort | time | × real time | memory |"
echo "|---|---|---|---|---|---|"
lines=${LINES:-30000}
rows "$lines" rows.nc
for effort in fast normal best; do
    took "$lines" $effort --effort $effort
    cp out.nc "$effort.nc"
done
took "$lines" "normal, as a whole" --report whole.html
cp out.nc whole.nc
measured rows.nc uncompensated
for run in fast normal best whole; do measured "$run.nc" "$run"; done
if [ -n "${MILLIONS:-}" ]; then
    lines=$((MILLIONS * 1000000))
    rows "$lines" rows.nc
    took "$lines" fast --effort fast
fi
