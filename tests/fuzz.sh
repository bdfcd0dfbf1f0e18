#!/bin/sh
# Fuzzes each parser of foreign files for a while; the first input that crashes one ends it.
#
#   sh tests/fuzz.sh [SECONDS [TARGET..]]     60 seconds of each target, if nothing is said
#
# Needs a nightly toolchain, and cargo-fuzz (`cargo install cargo-fuzz`). Inputs that were found
# to be worth keeping are in tests/fuzz/corpus/, crashes in tests/fuzz/artifacts/.
set -eu
cd "$(dirname "$0")/.."

seconds=${1:-60}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- scene ply measured spectrum image checkpoint merge

for target; do
    seeds=tests/fuzz/seeds/$target
    if [ "$target" = scene ]; then seeds=scenes; fi
    mkdir -p "tests/fuzz/corpus/$target" "$seeds"
    echo "== $target"
    # An input that takes a minute or 2 GB of memory counts as a crash. The limit of time has
    # room for sanitizers on a busy machine: without them, all inputs take seconds.
    cargo +nightly fuzz run --fuzz-dir tests/fuzz "$target" "tests/fuzz/corpus/$target" "$seeds" -- \
        -max_total_time="$seconds" -timeout=60 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1
done
