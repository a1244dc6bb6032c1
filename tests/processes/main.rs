//! Multi-process tests over real LCM, in one binary.

mod bits;
mod failures;
mod runs;
