#!/bin/sh
# Prints README's tables of first runs against iterative learning control: ten noise seeds, three machines, unseen curves, as references and as
# G-code programs. Takes about ten minutes of two idle cores.
# usage: benches/readme-tables.sh [SEEDS] [MACHINE…]
set -eu
cd "$(dirname "$0")/.."
seeds=${1:-10}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- ballscrew maxwell worn
cargo build --release
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for machine in "$@"; do
    echo "== $machine"
    target/release/precomp demo --machine "$machine" --seeds "$seeds" --out "$out/$machine"
done
