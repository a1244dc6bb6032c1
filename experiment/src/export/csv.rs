//! One table for each channel.

use super::{ExportError, messages};
use crate::log::Log;
use lcmtypes::schema::Value;
use std::collections::BTreeMap;
use std::fs::{File, create_dir_all};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Write `CHANNEL.csv` into `directory` for each channel: the time in the log (us), then all members, arrays element by
/// element. Returns the files.
pub fn write_csv(log: &Log, directory: &Path) -> Result<Vec<PathBuf>, ExportError> {
    create_dir_all(directory).map_err(|error| ExportError::new(directory, error))?;
    let mut files: BTreeMap<&str, (PathBuf, BufWriter<File>)> = BTreeMap::new();
    for (entry, this, values) in messages(log) {
        let path = directory.join(format!("{}.csv", entry.channel));
        let failed = |error: io::Error| ExportError::new(&path, error);
        if !files.contains_key(entry.channel.as_str()) {
            let mut file = BufWriter::new(File::create(&path).map_err(failed)?);
            let header: Vec<_> = this.elements().collect();
            writeln!(file, "log_time_us,{}", header.join(",")).map_err(failed)?;
            files.insert(&entry.channel, (path.clone(), file));
        }
        if let Some((_, file)) = files.get_mut(entry.channel.as_str()) {
            line(file, entry.utime, &values).map_err(failed)?;
        }
    }
    let mut written = Vec::new();
    for (path, mut file) in files.into_values() {
        file.flush().map_err(|error| ExportError::new(&path, error))?;
        written.push(path);
    }
    Ok(written)
}

fn line(file: &mut impl Write, utime: i64, values: &[Value]) -> io::Result<()> {
    write!(file, "{utime}")?;
    for value in values {
        match value {
            Value::Boolean(flag) => write!(file, ",{}", u8::from(*flag))?,
            Value::Integer(number) => write!(file, ",{number}")?,
            // All digits: what is read again is the same number.
            Value::Double(number) => write!(file, ",{number:?}")?,
        }
    }
    writeln!(file)
}
