//! What the tests of the command share.

use std::process::Command;

/// Exit code, stdout and stderr of `touchdown` with `arguments`, separated by spaces.
pub(crate) fn touchdown(arguments: &str) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_touchdown"))
        .args(arguments.split_ascii_whitespace())
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}
