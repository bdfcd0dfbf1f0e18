//! Glass that splits light by wavelength.

mod fan;
mod plates;
mod same;
