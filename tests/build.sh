# How tests are built, for scripts to read: all of them use one build.

# Clippy's driver takes the place of the compiler: what it compiles for the lints is what the tests run.
RUSTC_WORKSPACE_WRAPPER="$(command -v clippy-driver)"
# Nothing is built twice, so that what incremental builds keep would only cost time.
CARGO_INCREMENTAL="${CARGO_INCREMENTAL:-0}"
export RUSTC_WORKSPACE_WRAPPER CARGO_INCREMENTAL
