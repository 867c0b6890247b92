#!/usr/bin/env bash
# What `diagnose --controller linuxcnc` suggests, tried: LinuxCNC runs the excitation, takes the suggested FF1, FF2 and BACKLASH as they are, and
# runs motion that the diagnosis did not see. Then a program is compensated on the machine with its new settings.
#
#   tests/linuxcnc/tuning.sh    (about six minutes)
#
# Exits with 77 where LinuxCNC is not installed or does not start, with 1 where the following error falls by less than 80 % or compensation
# gains nothing.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
precomp=${PRECOMP:-$here/../../target/release/precomp}
command -v linuxcnc > /dev/null || { echo "LinuxCNC is not installed (package linuxcnc-uspace): skipped"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
printf 'G21 G90 G64 P0.001 Q0\nG1 X1 F600\nM2\n' > probe.ngc
timeout 120 "$here"/run.sh probe.ngc probe.log || { echo "LinuxCNC does not run here: skipped"; exit 77; }

# Runs the programs of a folder; its logs lie beside them.
record() {
  local jobs=() program
  for program in "$1"/*.nc; do jobs+=("$program" "${program%.nc}-$2.log"); done
  "$here"/run.sh "${jobs[@]}"
}
"$precomp" excite --machine "$here"/sim.toml --seconds 30 --seed 1 -o seen > /dev/null
"$precomp" excite --machine "$here"/sim.toml --seconds 20 --seed 2 -o unseen > /dev/null
record seen before
record unseen before
"$precomp" diagnose seen/*-before.log --sensor table --controller linuxcnc -o suggestion.ini > /dev/null
cat suggestion.ini
export SETTINGS=$work/suggestion.ini
record seen after
record unseen after

"$precomp" train seen/*-after.log --machine "$here"/sim.toml -o machine.model > /dev/null
cp "$here"/parts/circle.ngc .
"$precomp" compensate circle.ngc -m machine.model --work-offset 0,0,0 -o circle-c.ngc > /dev/null
"$here"/run.sh circle.ngc circle.log circle-c.ngc circle-c.log
for run in circle circle-c; do
  "$precomp" measure $run.log --desired circle.ngc --machine "$here"/sim.toml --json $run.json > /dev/null
done
python3 - << 'PYTHON'
import glob, json, math, sys

def following_um(pattern):
    """RMS of command less table position, by axis, in µm."""
    sums, count = [0.0] * 3, 0
    for name in glob.glob(pattern):
        for line in open(name):
            fields = line.split()
            if len(fields) == 6:
                row = [float(field) for field in fields]
                sums = [total + (row[2 * i] - row[2 * i + 1]) ** 2 for i, total in enumerate(sums)]
                count += 1
    return [1e3 * math.sqrt(total / count) for total in sums]

before, after = following_um("unseen/*-before.log"), following_um("unseen/*-after.log")
short = False
for axis, old, new in zip("xyz", before, after):
    print(f"{axis}: following error {old:.2f} -> {new:.2f} um RMS ({100 * (new / old - 1):+.1f} %)")
    short |= new > 0.2 * old
raw, cut = (json.load(open(f"{name}.json"))["contour_um"]["rms"] for name in ("circle", "circle-c"))
print(f"circle on the new settings: {raw:.3f} -> {cut:.3f} um RMS compensated")
sys.exit(short or cut > 0.8 * raw)
PYTHON
