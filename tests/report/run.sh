#!/usr/bin/env bash
# The report pages of several commands, opened in Chromium: nothing on the console, no network request, figures painted and linked.
#
#   tests/report/run.sh [SCREENSHOTS]    with a folder: writes pictures of the pages there
#
# Exits with 77 where Chromium or Node is not installed or Chromium does not start, with 1 where a check fails.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
precomp=${PRECOMP:-$here/../../target/release/precomp}
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[ -n "$chromium" ] || { echo "Chromium is not installed (package chromium): the pages are not opened"; exit 77; }
command -v node > /dev/null || { echo "Node is not installed (package nodejs): the pages are not opened"; exit 77; }
pictures=${1:+$(cd "$1" && pwd)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
timeout 30 "$chromium" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update \
  --disable-sync --user-data-dir="$work/probe" --dump-dom about:blank > /dev/null 2>&1 || { echo "Chromium does not run here: skipped"; exit 77; }

cat > part.nc << 'PART'
%
O0001 (BRACKET </script><b>)
N10 G21 G90 G17 G40 G49 G80
N20 T1 M6
N30 G0 G54 X-30. Y-20. S8000 M3
N40 G0 Z5. (ABOVE)
N50 G1 Z-1. F900 M8
N60 G1 X30. F2400
N70 G3 X30. Y20. I0. J20. (</script><b>)
N80 G1 X-30.
N90 G3 X-30. Y-20. Z-3. J-20.
N100 G2 I10. J10.
N110 G0 Z5. M9
N140 M30
%
PART
run() { "$precomp" "$@" > said.txt 2>&1 || { cat said.txt; exit 1; }; }
run excite --seconds 12 -o excitation
logs=()
for reference in excitation/*.csv; do
  logs+=("$(basename "$reference")")
  run simulate "$reference" -o "${logs[-1]}" --seed $((50000 + ${#logs[@]}))
done
run train "${logs[@]}" --machine ballscrew --predictor linear -o machine.model --report model.html
run diagnose "${logs[@]}" --machine ballscrew --controller linuxcnc -o suggestion.ini --report diagnosis.html
run compensate part.nc -m machine.model -o out.nc --effort fast --report part.html
run simulate curve:circle -o circle.csv
run measure circle.csv --desired curve:circle --machine ballscrew --report circle.html
run simulate curve:saddle --machine bc -o saddle.csv
run measure saddle.csv --machine bc --report five-axis.html
run compare curve:circle -m machine.model --gain 0.8 --low-pass 100 --runs 3 --report comparison.html
# A million samples: loops with an error that has a spectrum of its own, and a peak.
awk 'BEGIN {
  print "t,x_ref,x_act,y_ref,y_act"
  for (k = 0; k < 1000000; k++) {
    t = 0.001 * k; a = 2 * t + 0.3 * sin(0.05 * t); r = 40 + 15 * sin(0.31 * t)
    x = r * cos(a); y = r * sin(a); e = 0.003 * sin(7 * a) + 0.001 * sin(251 * t) + (k == 654321 ? 0.05 : 0)
    printf "%.3f,%.6f,%.6f,%.6f,%.6f\n", t, x, x + e * cos(a), y, y + e * sin(a)
  }
}' > large.csv
run measure large.csv --report large.html
node "$here"/check.mjs "$chromium" "$work" "$pictures"
