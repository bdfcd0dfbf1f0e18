#!/bin/sh
# Everything that must hold before a change goes in: format, lints, build, tests.
# Installs what the tests need first, and asks nothing.
#
# The dev profile, throughout: it compiles the GLSL compiler once for all four steps,
# in the least time, and the tests spend theirs on the device.
set -eu
cd "$(dirname "$0")/.."

sh install.sh --tests

# A minimal toolchain lacks these two.
for component in rustfmt clippy; do
    "cargo-${component#rust}" --version >/dev/null 2>&1 || rustup component add "$component"
done

step() {
    echo "== $*"
    "$@"
}
step cargo fmt --all --check
step cargo clippy --locked --workspace --all-targets -- -D warnings
step cargo check --locked --no-default-features
step cargo build --locked --workspace --all-targets
step cargo test --locked --workspace
