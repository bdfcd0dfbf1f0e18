#!/bin/sh
# Everything that must hold before a change goes in: format, lints, build, tests. Installs what the
# tests need first, and asks nothing. CONTRIBUTING.md says what takes how long.
#
# All steps use the dev profile. The tests build the command and the examples too; benches/ is
# checked by clippy alone, which saves linking it.
set -eu
cd "$(dirname "$0")/.."

sh install.sh --tests

# A minimal toolchain lacks these two.
for component in rustfmt clippy; do
    "cargo-${component#rust}" --version >/dev/null 2>&1 || rustup component add "$component"
done

# Nothing is built twice here, so that what incremental builds keep would only cost time.
export CARGO_INCREMENTAL="${CARGO_INCREMENTAL:-0}"

step() {
    echo "== $*"
    before=$(date +%s)
    "$@"
    echo "== $(($(date +%s) - before)) seconds"
}
step cargo fmt --all --check
step sh tests/break.sh check
step cargo clippy --locked --workspace --all-targets -- -D warnings
step cargo check --locked --lib --bins --no-default-features
step cargo test --locked --workspace
