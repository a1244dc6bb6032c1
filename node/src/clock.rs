//! The only place that reads a clock (DESIGN: invariant 1).

use std::time::Instant;

/// Now, on the monotonic clock.
#[expect(clippy::disallowed_methods, reason = "the one place where time enters")]
pub fn now() -> Instant {
    Instant::now()
}
