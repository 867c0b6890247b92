#!/usr/bin/env bash
# What is handed out for the system that it runs on, in FOLDER (default target/packages): an archive with the command, a Debian package where
# dpkg-deb is at hand, a wheel where pip is, and their SHA-256. Run it on each system and processor: nothing is cross-compiled.
#
#   packaging/build.sh [FOLDER] [--features LIST]      PYTHON: the interpreter that builds the wheel (default: python3)
set -euo pipefail
cd "$(dirname "$0")/.."
folder=target/packages features=()
while [ $# -gt 0 ]; do
  case $1 in
    --features) features=(--features "$2"); shift 2 ;;
    -*) echo "unknown option $1; usage: packaging/build.sh [FOLDER] [--features LIST]" >&2; exit 2 ;;
    *) folder=$1; shift ;;
  esac
done
most_bytes=$((30 * 1000 * 1000))

cargo build --release --locked --package precomp "${features[@]}"
version=$(cargo pkgid --package precomp | sed 's/.*[#@]//')
target=$(rustc -vV | sed -n 's/^host: //p')
built=${CARGO_TARGET_DIR:-target}/release/precomp
name=precomp-$version-$target
# The same bytes from the same commit.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rm -f "$folder"/precomp[-_]* "$folder"/SHA256SUMS

mkdir "$work/$name"
case $target in
  *windows*) cp "$built.exe" "$work/$name/precomp.exe" ;;
  *) cp "$built" "$work/$name/precomp" && strip "$work/$name/precomp" ;;
esac
cp README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$work/$name/"
case $target in
  *windows*) (cd "$work" && 7z a -bso0 "$folder/$name.zip" "$name") ;;
  *linux*)
    tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -cf - "$name" | gzip -9n > "$folder/$name.tar.gz" ;;
  *) tar -C "$work" -czf "$folder/$name.tar.gz" "$name" ;;
esac

if command -v dpkg-deb > /dev/null; then
  root=$work/deb
  install -D -m 755 "$work/$name/precomp" "$root/usr/bin/precomp"
  install -D -m 644 README.md "$root/usr/share/doc/precomp/README.md"
  install -D -m 644 CHANGELOG.md "$root/usr/share/doc/precomp/changelog"
  { echo "This program may be used under either of two licences."; echo; cat LICENSE-MIT; echo; cat LICENSE-APACHE; } > "$work/copyright"
  install -D -m 644 "$work/copyright" "$root/usr/share/doc/precomp/copyright"
  # The newest symbol of the C library that the command needs says on how old a system it runs.
  glibc=$(objdump -T "$work/$name/precomp" | grep -o 'GLIBC_[0-9.]*' | sed 's/GLIBC_//' | sort -uV | tail -1)
  mkdir "$root/DEBIAN"
  cat > "$root/DEBIAN/control" <<CONTROL
Package: precomp
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: precomp authors <authors@precomp.invalid>
Depends: libc6 (>= $glibc), libgcc-s1
Section: science
Priority: optional
Installed-Size: $(du -sk "$root/usr" | cut -f1)
Description: pre-compensates CNC part programs before their first run
 Learns from a log of commanded and actual positions how each axis lags,
 sticks and snaps back, and shifts the points of part programs against it.
CONTROL
  dpkg-deb --root-owner-group --build "$root" "$folder/precomp_${version}_$(dpkg --print-architecture).deb" > /dev/null
fi

python=${PYTHON:-python3}
if command -v "$python" > /dev/null && "$python" -m pip --version > /dev/null 2>&1; then
  "$python" -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir "$folder" ./python
fi

cd "$folder"
files=(precomp[-_]*)
if command -v sha256sum > /dev/null; then sha256sum "${files[@]}" > SHA256SUMS; else shasum -a 256 "${files[@]}" > SHA256SUMS; fi
for file in "${files[@]}"; do
  bytes=$(wc -c < "$file")
  echo "$file: $((bytes / 100000 / 10)).$((bytes / 100000 % 10)) MB"
  if [ "$bytes" -gt "$most_bytes" ]; then echo "$file is larger than 30 MB" >&2; exit 1; fi
done
