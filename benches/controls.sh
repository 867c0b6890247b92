#!/bin/sh
# First runs of four programs on controls drawn at random, five structures in turn, on the mechanics of `ballscrew`: uncompensated, planned by the
# machine's limits alone, from a recording of the part, and by the control learned from the control test and one run of excitation. Contour error
# RMS of the run in µm, and its cycle against the uncompensated one.
#   benches/controls.sh [SEED...]      1 2 3 4 5 by default; three minutes a control on two cores
set -eu
cd "$(dirname "$0")/.."
pocket=$PWD/benches/pocket.nc machine=$PWD/machine/machines/ballscrew.toml
precomp=${PRECOMP:-$PWD/target/release/precomp}
[ -n "${PRECOMP:-}" ] || cargo build --release --locked --quiet
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cp "$pocket" pocket.nc
python3 - <<'PY'
import math, random
head, end = "G21 G90 G17 G94\nG0 X{:.4f} Y{:.4f} Z2.\nG4 P0.2\nG1 Z0. F900\n", "G4 P0.2\nG0 Z2.\nM30\n"
# Rows of short lines over a curved surface.
with open("finishing.nc", "w") as out:
    out.write(head.format(-12, -3) + "F2400\n")
    for row in range(4):
        for k in range(1, 61):
            x = (-12 + 0.4 * k) * (1 if row % 2 == 0 else -1)
            y = -3 + 2 * row
            out.write(f"X{x:.4f} Y{y:.4f} Z{1.2 * math.sin(0.4 * x) * math.cos(0.5 * y):.4f}\n")
        if row < 3:
            out.write(f"Y{-1 + 2 * row:.4f}\n")
    out.write(end)
# A contour with sharp and blunt corners.
with open("contour.nc", "w") as out:
    out.write(head.format(-15, -10) + "F3600\nX15.\nX18. Y-4.\nX10. Y2.\nX16. Y10.\nX3.\nG3 X-3. Y10. I-3.\nG1 X-9. Y4.\nX-15.\nX-11. Y0.\nX-15. Y-10.\n" + end)
# Small loops of lines of all lengths, as of an engraved text.
with open("engraving.nc", "w") as out:
    draw = random.Random(3)
    out.write(head.format(-14, 0) + "F1500\n")
    for letter in range(7):
        x0 = -14 + 4 * letter
        for k in range(1, 25):
            a = 2 * math.pi * k / 24
            out.write(f"X{x0 + 1.5 * (1 - math.cos(a)) + draw.uniform(-0.05, 0.05):.3f} Y{2.5 * math.sin(a) * (1 + 0.3 * math.cos(3 * a)):.3f}\n")
        out.write(f"X{x0 + 4:.3f} Y0.\n")
    out.write(end)
PY
drawn() { # SEED: the machine behind a control, and its structure
    python3 - "$1" "$machine" <<'PY'
import random, sys
seed = int(sys.argv[1])
draw, text = random.Random(77000 + seed), open(sys.argv[2]).read()
acceleration = draw.uniform(250, 750)
replaced = {"acceleration_mm_s2 = 800.0": f"acceleration_mm_s2 = {acceleration:.0f}.0", "centripetal_mm_s2 = 565.0": f"centripetal_mm_s2 = {acceleration * draw.uniform(0.4, 1.0):.0f}.0"}
rise_ms, kind = draw.uniform(8, 40), (seed - 1) % 5
jerk = "1e10" if kind in (0, 1, 3) else f"{2e3 * acceleration / rise_ms:.0f}.0"
replaced["jerk_mm_s3 = 80000.0"] = f"jerk_mm_s3 = {jerk}\nsmoothing_ms = 0.0" if kind in (0, 1, 3) else f"jerk_mm_s3 = {jerk}"
blend, jump, deviation = (f"corners = {{ {key} = {draw.uniform(*span):.4f} }}\n" for key, span in
    (("blend_mm", (0.005, 0.04)), ("speed_jump_mm_s", (3, 15)), ("junction_deviation_mm", (0.005, 0.04))))
window, constant, lines = 2 * round(draw.uniform(4, 18)), draw.uniform(4, 20), draw.randrange(8, 24)
name, control = [
    ("average of every axis, blends", f"{blend}filters_ms = [{window}.0, 0.0]\n"),
    ("steps of acceleration, junction deviation, look-ahead", f"{deviation}look_ahead_lines = {lines}\n"),
    ("limited jerk, speed jump", jump),
    ("first-order lag of every axis, blends", f"{blend}time_constant_ms = {constant:.1f}\n"),
    ("limited jerk and an average of every axis, speed jump", f"{jump}filters_ms = [{window}.0, 0.0]\n"),
][kind]
for old, new in replaced.items():
    if "smoothing_ms" in new:  # a key of [path] alone
        text = text.replace(old, new, 1).replace(old, new.split("\n")[0])
    else:
        text = text.replace(old, new)
open("control.toml", "w").write(text.replace("[kinematics]", "[control]\n" + control + "\n[kinematics]"))
print(name)
PY
}
figure() { # FILE KEY: the first number with this key
    sed -n "s/.*\"$2\": \(-\{0,1\}[0-9.e-]*\),\{0,1\}$/\1/p" "$1" | head -1
}
run() { # PROGRAM: contour error RMS (µm) of its run against the part, and its time (s)
    "$precomp" simulate "$1" --machine control.toml --against "$program.nc" --seed 900 -o run.csv --json run.json > /dev/null
    echo "$(figure run.json rms) $(figure run.json seconds)"
}
compensate() { # OUT OPTIONS...
    out=$1
    shift
    "$precomp" compensate "$program.nc" -o "$out" "$@" > said.txt 2>&1 || { cat said.txt >&2; exit 1; }
}
echo "| control | program | uncompensated | by limits | recorded | learned |"
echo "|---|---|---|---|---|---|"
[ $# -gt 0 ] || set -- 1 2 3 4 5
for seed in "$@"; do
    name=$(drawn "$seed")
    rm -rf excitation ./*.csv
    "$precomp" excite --machine ballscrew --seconds 40 -o excitation > /dev/null
    logs=''
    noise=$((1000 * seed))
    for reference in excitation/*.csv; do
        noise=$((noise + 1)) log=stream-$(basename "$reference")
        "$precomp" simulate "$reference" --machine ballscrew -o "$log" --seed "$noise" > /dev/null
        logs="$logs $log"
    done
    for path in excitation/control-test.nc excitation/01-*.nc; do
        noise=$((noise + 1)) log=$(basename "$path" .nc).csv
        "$precomp" simulate "$path" --machine control.toml -o "$log" --seed "$noise" > /dev/null
        logs="$logs $log"
    done
    # shellcheck disable=SC2086
    "$precomp" train $logs --programs excitation/control-test.nc excitation/01-*.nc -o own.model > train.txt 2>&1 || { cat train.txt >&2; exit 1; }
    for program in pocket finishing contour engraving; do
        "$precomp" simulate "$program.nc" --machine control.toml -o recorded.csv --seed 800 > /dev/null
        compensate limits.nc -m own.model --machine ballscrew
        compensate recorded.nc -m own.model --machine ballscrew --reference recorded.csv
        compensate learned.nc -m own.model
        echo "$(run "$program.nc") $(run limits.nc) $(run recorded.nc) $(run learned.nc)" | awk -v control="$seed: $name" -v program="$program" \
            'function longer(s) { return sprintf("%+.1f %%", 100 * (s / $2 - 1)) }
            { printf "| %s | %s | %.2f | %.2f (%s) | %.2f (%s) | %.2f (%s) |\n", control, program, $1, $3, longer($4), $5, longer($6), $7, longer($8) }'
    done
done
