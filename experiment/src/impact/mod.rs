//! The impact of a tool on an object: what is asked, what is answered, and against what it is measured.
//!
//! The equations are [`controller::impact`]'s; here are the library of materials and shapes, the scenario as a
//! question, table, figure and the comparison with a simulated run.

pub mod figure;
pub mod library;
pub mod report;
pub mod scenario;
pub mod simulated;
mod text;

pub use library::{Library, LibraryError};
pub use report::{Question, Report, TransientQuestion};
pub use text::Text;
