#!/bin/sh
# The tests of run.sh in their long form: surveys of more rays, more seeds, slopes over more
# decades, more mutated scenes, a hundred million photons. Then all tests of kernels and all references
# on a second driver, what the compiler of a graphics card makes of kernels, the library with one feature
# or none, and fuzzing, if a nightly toolchain and cargo-fuzz are there. Run it whole before a larger change is called done.
#
#   sh tests/full.sh
set -eu
cd "$(dirname "$0")/.."
export GOBLET_TESTS=full

sh tests/run.sh
sh tests/drivers.sh
sh tests/registers.sh
for features in "" cli study view; do
    cargo check --locked --lib --no-default-features --features "$features"
done
if cargo +nightly fuzz --version >/dev/null 2>&1; then
    sh tests/fuzz.sh
else
    echo "full.sh: no fuzzing without a nightly toolchain and cargo-fuzz" >&2
fi
