#!/bin/sh
# Everything that must hold before a change goes in: format, lints, build, tests. Installs what the
# tests need first, and asks nothing. CONTRIBUTING.md says what takes how long.
#
# All steps use the dev profile. Clippy's driver takes the place of the compiler: what it compiles for the
# lints is what the tests run, so that nothing is built once for each.
set -eu
cd "$(dirname "$0")/.."

sh install.sh --tests

# A minimal toolchain lacks these two.
for component in rustfmt clippy; do
    "cargo-${component#rust}" --version >/dev/null 2>&1 || rustup component add "$component"
done

# Nothing is built twice here, so that what incremental builds keep would only cost time.
export CARGO_INCREMENTAL="${CARGO_INCREMENTAL:-0}"
# A failed test names its line without them too.
export CARGO_PROFILE_DEV_DEBUG=false

step() {
    echo "== $*"
    before=$(date +%s)
    "$@"
    echo "== $(($(date +%s) - before)) seconds"
}

export RUSTC_WORKSPACE_WRAPPER="$(command -v clippy-driver)"

# Builds and lints everything, benches included. A warning is an error.
build() {
    log=$(mktemp)
    { cargo test --locked --workspace --all-targets --no-run 2>&1 || touch "$log.failed"; } | tee "$log"
    if [ -e "$log.failed" ] || grep -q '^warning' "$log"; then
        echo "run.sh: the build has failed or has warnings" >&2
        exit 1
    fi
    rm "$log"
}

step cargo fmt --all --check
step sh tests/break.sh check
step build
step cargo test --locked --workspace
