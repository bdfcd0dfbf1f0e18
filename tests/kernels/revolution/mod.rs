//! Bodies of revolution against an oracle.

mod closed_form;
mod emitter;
mod failures;
mod isolate;
mod lab;
mod line;
mod oracle;
mod place;
mod profiles;
mod rays;
mod surface;
mod survey;
mod tally;
mod wide;
