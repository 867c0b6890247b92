# Sourced by the scripts beside it: builds the command as $precomp, goes into a folder that is removed at the end, and trains m.model there on 20 s of ballscrew.
cargo build --release
precomp=$PWD/target/release/precomp
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$precomp" excite --machine ballscrew --seconds 20 -o excitation > /dev/null
for reference in excitation/*.csv; do
    "$precomp" simulate "$reference" --machine ballscrew -o "log-$(basename "$reference")" > /dev/null
done
"$precomp" train log-*.csv --machine ballscrew -o m.model > /dev/null 2>&1
