//! LCM event logs: what stands beside one.

pub mod sidecar;
