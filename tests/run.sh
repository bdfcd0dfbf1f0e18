#!/bin/sh
# Everything that must hold before a change goes in: format, lints, build, tests. Installs what the
# tests need first, and asks nothing. CONTRIBUTING.md says what takes how long.
set -eu
cd "$(dirname "$0")/.."

sh install.sh --tests

# A minimal toolchain lacks these two.
for component in rustfmt clippy; do
    "cargo-${component#rust}" --version >/dev/null 2>&1 || rustup component add "$component"
done

. tests/build.sh

step() {
    echo "== $*"
    before=$(date +%s)
    "$@"
    echo "== $(($(date +%s) - before)) seconds"
}

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
