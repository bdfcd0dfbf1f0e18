//! Renders that are compared: error against time for many settings, and the settings that are
//! best for a time.

pub mod advise;
#[doc(hidden)]
pub mod chart;
#[doc(hidden)]
pub mod machine;
pub mod measure;
