//! Where a run puts its files: runs with the same directory do not disturb each other.

use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A fresh directory inside that for the results: what is not finished is there, and vanishes with it.
#[derive(Debug)]
pub struct Workplace {
    out: PathBuf,
    own: TempDir,
    finished: Vec<String>,
}

impl Workplace {
    /// A place of its own inside `out`, which is created if need be.
    pub fn new(out: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(out)?;
        Ok(Self {
            out: out.to_owned(),
            own: tempfile::Builder::new().prefix(".run-").tempdir_in(out)?,
            finished: Vec::new(),
        })
    }

    /// The fresh directory.
    pub fn path(&self) -> &Path {
        self.own.path()
    }

    /// Have the file `name` written in it by `write`; it is a result once that is done.
    pub fn result<E>(&mut self, name: String, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
        write(&self.own.path().join(&name))?;
        self.finished.push(name);
        Ok(())
    }

    /// Move all results to where the user looks for them, each whole: of runs that end together, the last one's.
    pub fn publish(self) -> io::Result<()> {
        self.finished
            .iter()
            .try_for_each(|name| std::fs::rename(self.own.path().join(name), self.out.join(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn only_finished_files_come_out() {
        let parent = tempfile::tempdir().unwrap();
        let out = parent.path().join("a/b");
        let mut places = [Workplace::new(&out).unwrap(), Workplace::new(&out).unwrap()];
        for (place, text) in places.iter_mut().zip(["one", "two"]) {
            place
                .result("force.svg".to_owned(), |path| fs::write(path, text))
                .unwrap();
            fs::write(place.path().join("robot-sim.lcmlog"), "").unwrap();
            let refused = place.result("pd.csv".to_owned(), |path| {
                fs::write(path, "half").and(Err(io::Error::other("disk full")))
            });
            assert!(refused.is_err());
        }
        for place in places {
            place.publish().unwrap();
        }
        assert_eq!(names(&out), ["force.svg"]);
        assert_eq!(fs::read_to_string(out.join("force.svg")).unwrap(), "two");
    }
}
