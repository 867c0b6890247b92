#!/usr/bin/env bash
# Builds the packages of this system and installs each as a user would.
set -euo pipefail
cd "$(dirname "$0")/.."
# The interpreter of .ci/python, for which the crates are compiled already.
[ -x target/python/bin/python ] && export PYTHON=$PWD/target/python/bin/python
packaging/build.sh target/packages
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(target/release/precomp --version)

PRECOMP_FROM=target/packages PRECOMP_TO=$work/bin packaging/install.sh > "$work/said"
[ "$("$work/bin/precomp" --version)" = "$version" ]
grep -q "add it to the search path" "$work/said"
"$work/bin/precomp" init --axes xy --velocity 100 --acceleration 1000 --period 2 -o "$work/mill.toml" > /dev/null

# An archive that was altered on the way is refused, and what was installed stays.
cp -r target/packages "$work/altered"
for archive in "$work"/altered/precomp-*.tar.gz; do echo >> "$archive"; done
if PRECOMP_FROM=$work/altered PRECOMP_TO=$work/bin packaging/install.sh > /dev/null 2> "$work/said"; then
  echo "an altered archive was installed" >&2
  exit 1
fi
grep -q "SHA-256" "$work/said"
[ "$("$work/bin/precomp" --version)" = "$version" ]

if command -v dpkg-deb > /dev/null; then
  dpkg-deb --extract target/packages/precomp_*.deb "$work/root"
  [ "$("$work/root/usr/bin/precomp" --version)" = "$version" ]
fi
if ls target/packages/precomp-*.whl > /dev/null 2>&1; then
  python3 -m venv "$work/venv"
  "$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check target/packages/precomp-*.whl
  [ "$("$work/venv/bin/precomp" --version)" = "$version" ]
fi
echo "packages: installed and started"
