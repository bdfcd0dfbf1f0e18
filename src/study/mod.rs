//! Renders that are compared: error against time for many settings, and the settings that are
//! best for a time.

pub mod advise;
pub mod chart;
pub mod machine;
pub mod measure;
