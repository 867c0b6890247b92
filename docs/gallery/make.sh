#!/usr/bin/env bash
# Draws the pictures of docs/gallery.md, and with --readme that at the top of README.md: simulated machines with one known fault each are
# excited, diagnosed and reported on, and the reports are opened in Chromium.
#
#   cargo build --release && docs/gallery/make.sh [--readme]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../..
precomp=${PRECOMP:-$root/target/release/precomp}
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
run() { "$precomp" "$@" --quiet || { echo "precomp $*" >&2; exit 1; }; }

# A sound machine: `ballscrew` with nearly complete feed-forward, equal loops, little friction, no backlash, no cogging.
sed -E -e 's/feed_forward = [0-9.]+/feed_forward = 0.95/' -e 's/position_gain_1_s = [0-9.]+/position_gain_1_s = 100.0/' \
  -e 's/coulomb_n = [0-9.]+, static_n = [0-9.]+/coulomb_n = 40.0, static_n = 52.0/' -e 's/backlash_half_width_um = [0-9.]+/backlash_half_width_um = 0.0/' \
  -e 's/^(cogging|waves|screw_waves) = .*/\1 = []/' -e 's/^name = "ballscrew"/name = "sound"/' "$root/machine/machines/ballscrew.toml" > sound.toml
# Of each fault: the machine with its y axis changed.
y() { awk -v from="$1" -v to="$2" '/^name = "y"/ { y = 1 } /^name = "z"/ { y = 0 } y { sub(from, to) } { print }' sound.toml; }
y 'position_gain_1_s = 100.0, feed_forward = 0.95' 'position_gain_1_s = 80.0, feed_forward = 0.9' > mismatch.toml
sed -E 's/feed_forward = 0.95/feed_forward = 0.0/' sound.toml > feed-forward.toml
y 'coulomb_n = 40.0, static_n = 52.0' 'coulomb_n = 600.0, static_n = 780.0' > friction.toml
{ echo 'sensor = "table"'; y 'backlash_half_width_um = 0.0' 'backlash_half_width_um = 6.0'; } > backlash.toml
sed -E 's/^cogging = .*/cogging = [{ amplitude_n_m = 0.4, per_turn = 4.0, phase_rad = 0.0 }]/' sound.toml > ripple.toml

for machine in sound mismatch feed-forward friction backlash ripple; do
  run excite --machine $machine.toml --seconds 30 -o $machine
  logs=()
  for reference in $machine/*.csv; do
    logs+=("$machine-$(basename "$reference")")
    run simulate "$reference" --machine $machine.toml -o "${logs[-1]}" --seed ${#logs[@]}
  done
  run diagnose "${logs[@]}" --machine $machine.toml --report $machine.html --json $machine.json
done
run simulate curve:circle --feed 30 --machine backlash.toml -o circle.csv
run measure circle.csv --desired curve:circle --feed 30 --machine backlash.toml --report backlash-circle.html
if [ "${1:-}" = --readme ]; then
  run demo --out demo
  cp demo/report.html readme.html
fi
node "$here/shots.mjs" "$chromium" "$work" "$here"
