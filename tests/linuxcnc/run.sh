#!/usr/bin/env bash
# Runs programs on a LinuxCNC without a screen and logs commanded and table positions: run.sh PROGRAM LOG [PROGRAM LOG …]
# A log is halsampler's text; the file LOG.columns beside it names the columns and the period. SETTINGS=FILE: an INI file whose values take the
# place of those of sim.ini.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here"/sim.ini "$here"/sim.hal "$here"/driver.py "$work"
if [ -n "${SETTINGS:-}" ]; then
  awk -F ' *= *' '/^\[/ { section = $0 } NR == FNR { if (!/^#/ && NF == 2) value[section, $1] = $2; next }
    (section, $1) in value { $0 = $1 " = " value[section, $1] } { print }' "$SETTINGS" "$here"/sim.ini > "$work"/sim.ini
fi
touch "$work"/sim.tbl
joint=0
for drive in x:100 y:95 z:105; do
  sed "s/@J@/$joint/g; s/@A@/${drive%%:*}/g; s/@KP@/${drive##*:}/g" "$here"/drive.hal.in > "$work/drive$joint.hal"
  joint=$((joint + 1))
done
while [ $# -ge 2 ]; do
  printf '%s\t%s\n' "$(realpath "$1")" "$(realpath -m "$2")" >> "$work"/jobs
  printf 'period = 1 ms\nx_ref = 1:mm\nx_act = 2:mm\ny_ref = 3:mm\ny_act = 4:mm\nz_ref = 5:mm\nz_act = 6:mm\n' > "$2.columns"
  shift 2
done
chmod -R a+rwX "$work"
export PRECOMP_JOBS="$work/jobs" RTAPI_FIFO_PATH="$work/rtapi_fifo" RTAPI_UID="${RTAPI_UID:-$(id -u nobody)}"
cd "$work"
linuxcnc -r "$work"/sim.ini < /dev/null > "$work"/out 2>&1 || { cat "$work"/out >&2; exit 1; }
grep -iE "error|not within|LinuxCNC:" "$work"/out >&2 && exit 1 || true
