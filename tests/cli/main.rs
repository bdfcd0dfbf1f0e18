//! The command as people run it: each test starts `goblet` in a folder of its own.

mod advise;
mod aov;
mod browser;
mod compare;
mod dispersion;
mod display_server;
mod exporters;
#[cfg(unix)]
mod files;
#[cfg(target_os = "linux")]
mod gpu;
#[cfg(target_os = "linux")]
mod hostile;
mod info;
mod manual;
#[cfg(unix)]
mod pictures;
mod pipes;
mod render;
mod report;
#[path = "../support/mod.rs"]
mod support;
#[cfg(target_os = "linux")]
mod terminal;
mod tessellate;
#[cfg(unix)]
mod workflow;
