#!/bin/sh
# Installs the command `precomp` for one user on Linux or macOS, without a compiler.
#
#   PRECOMP_FROM   where the archives and SHA256SUMS lie: an address or a folder (default: the newest release)
#   PRECOMP_TO     folder for the command (default: ~/.local/bin)
#   PRECOMP_VERSION  version of the archive (default: the one that SHA256SUMS names)
set -eu
from=${PRECOMP_FROM:-https://github.com/precomp/precomp/releases/latest/download}
to=${PRECOMP_TO:-$HOME/.local/bin}

fail() { echo "precomp is not installed: $1" >&2; exit 1; }

case "$(uname -s)-$(uname -m)" in
  Linux-x86_64) target=x86_64-unknown-linux-gnu ;;
  Linux-aarch64 | Linux-arm64) target=aarch64-unknown-linux-gnu ;;
  Darwin-x86_64) target=x86_64-apple-darwin ;;
  Darwin-arm64) target=aarch64-apple-darwin ;;
  *) fail "there is no archive for $(uname -s) on $(uname -m); build it with 'cargo install --path .'" ;;
esac

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fetch() {
  case $from in
    http://* | https://*)
      if command -v curl > /dev/null; then curl -fsSL "$from/$1" -o "$work/$1"
      elif command -v wget > /dev/null; then wget -q "$from/$1" -O "$work/$1"
      else fail "neither curl nor wget is at hand"; fi ;;
    *) cp "$from/$1" "$work/$1" ;;
  esac || fail "$from/$1 cannot be read"
}

fetch SHA256SUMS
archive=$(sed -n "s/^[0-9a-f]* [ *]\(precomp-${PRECOMP_VERSION:-.*}-$target\.tar\.gz\)\$/\1/p" "$work/SHA256SUMS" | tail -n 1)
[ -n "$archive" ] || fail "$from names no archive for $target"
fetch "$archive"
grep " [ *]$archive\$" "$work/SHA256SUMS" > "$work/expected"
(cd "$work" && if command -v sha256sum > /dev/null; then sha256sum -c expected; else shasum -a 256 -c expected; fi) > /dev/null 2>&1 \
  || fail "the SHA-256 of $archive is not the one stated"
tar -xzf "$work/$archive" -C "$work"
mkdir -p "$to"
# A new file and a rename: a command that is running goes on with the old one.
cp "$work/${archive%.tar.gz}/precomp" "$to/.precomp.new"
chmod 755 "$to/.precomp.new"
mv "$to/.precomp.new" "$to/precomp"
"$to/precomp" --version || fail "it does not start on this system; build it with 'cargo install --path .'"
echo "installed in $to/precomp"
case ":$PATH:" in *":$to:"*) ;; *) echo "add it to the search path: export PATH=\"$to:\$PATH\"" ;; esac
