//! Renders as wholes: stops, checkpoints, shards, and that every variant of the estimator converges.

mod activities;
mod auto;
mod checkpoint;
#[cfg(unix)]
mod cluster;
#[path = "../support/mod.rs"]
mod support;
mod variants;
