//! Maps of stability and performance: every law over two axes of the plant, thousands of runs in process.
//!
//! A sweep is a TOML file ([`Definition`]): laws, contact phases, and maps of two [`Axis`] each. Its runs have an order,
//! in which they are written to `runs.csv` however many threads there are: the file is the same with one and with N, and
//! what an interrupted sweep has written is the beginning of it, from which the next one goes on.

mod axis;
mod cells;
mod definition;
mod error;
mod figure;
mod runs;

pub use axis::Axis;
pub use cells::{Cell, Cells, Verdict, cells_csv, verdicts};
pub use definition::{Definition, MapDefinition, Values, names};
pub use error::SweepError;
pub use figure::map_figure;
pub use runs::{HEADER, Outcome, Plan, Run, State};
