//! Comparisons of renders: the error of many settings against time, and the best settings for a time.

pub mod advise;
#[doc(hidden)]
pub mod chart;
#[doc(hidden)]
pub mod machine;
pub mod measure;
