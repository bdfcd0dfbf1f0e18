//! Comparisons of renders: the error of many settings against time, and the best settings for a time.

pub mod advise;
pub mod chart;
pub mod flip;
pub mod machine;
pub mod measure;
