//! lcm-spy with our types: a jar of them, and the Java program that shows every channel.
//!
//! Debian's own script `lcm-spy` (1.3.1) asks Java for an option that Java 17 does not know, so the program is started
//! directly: with a class path of LCM, its charts and our types, and with IPv4, the multicast that LCM speaks.

use lcmtypes::{TYPE_FILES, fingerprints};
use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What asks the database of lcm-spy.
const CHECK: &str = include_str!("spy/Check.java");
/// The jar of our types.
const TYPES: &str = "touchdown-types.jar";

/// Why lcm-spy can't be had.
#[derive(Debug, thiserror::Error)]
pub enum SpyError {
    /// Something is not installed.
    #[error("{what} is missing; {remedy}")]
    Missing {
        /// What.
        what: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// A file can't be written or read.
    #[error("{path}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A tool has not done its work.
    #[error("{tool} has failed: {said}")]
    Failed {
        /// Which.
        tool: &'static str,
        /// What it said.
        said: String,
    },
}

const JDK: &str = "sudo apt-get install default-jdk (17 or later)";
const JARS: &str = "sudo apt-get install liblcm-java libjchart2d-java, or set LCM_PREFIX to an LCM with share/java/, such as \
                    that of Python's package lcm 1.5";

/// What lcm-spy consists of.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Jars {
    /// LCM's, and its charts'.
    own: [PathBuf; 2],
    /// What some versions of the charts ask for.
    more: Vec<PathBuf>,
}

/// lcm-spy, ready to be started.
#[derive(Clone, Debug)]
pub struct Spy {
    class_path: OsString,
    /// By channel: the class that decodes it, or none.
    pub types: Vec<(&'static str, Option<String>)>,
    /// Whether this Java can show windows here.
    pub windows: bool,
    /// The jar of our types.
    pub jar: PathBuf,
}

impl Jars {
    /// Below `LCM_PREFIX`, or where Debian has them.
    fn find() -> Result<Self, SpyError> {
        let prefix = env::var_os("LCM_PREFIX").filter(|prefix| !prefix.is_empty());
        let own = prefix.map(|prefix| Path::new(&prefix).join("share/java"));
        let others = ["/usr/share/java", "/usr/local/share/java"].map(PathBuf::from);
        Self::among(&own.into_iter().chain(others).collect::<Vec<_>>())
    }

    fn among(directories: &[PathBuf]) -> Result<Self, SpyError> {
        let missing = |what| SpyError::Missing { what, remedy: JARS };
        let lcm = directories.iter().map(|directory| directory.join("lcm.jar"));
        let lcm = lcm
            .into_iter()
            .find(|jar| jar.is_file())
            .ok_or(missing("lcm.jar"))?;
        let charts = jar(directories, "jchart2d").ok_or(missing("jchart2d.jar"))?;
        let more = ["xmlgraphics-commons", "jide-oss"].into_iter();
        Ok(Self {
            own: [lcm, charts],
            more: more.filter_map(|name| jar(directories, name)).collect(),
        })
    }

    fn class_path(&self, more: &[&Path]) -> OsString {
        let own = self.own.iter().map(|jar| jar.as_os_str());
        let all: Vec<&OsStr> = own.chain(more.iter().map(|path| path.as_os_str())).collect();
        all.join(OsStr::new(":"))
    }

    /// The manifest of a jar that asks for the others: on the class path itself lcm-spy would try to load each of their
    /// classes, and tell of those that it can't.
    fn manifest(&self) -> String {
        let urls = self
            .more
            .iter()
            .map(|jar| format!("file:{}", jar.display()).replace(' ', "%20"));
        // A line of its own for each, since a line has a limit.
        let urls = urls.collect::<Vec<_>>().join("\n  ");
        match urls.is_empty() {
            true => String::new(),
            false => format!("Class-Path: {urls}\n"),
        }
    }
}

/// `name.jar`, or `name` with a version.
fn jar(directories: &[PathBuf], name: &str) -> Option<PathBuf> {
    let fits = |path: &PathBuf| {
        let stem = path.file_name()?.to_str()?.strip_suffix(".jar")?;
        let version = stem.strip_prefix(name)?;
        (version.is_empty() || version.starts_with("-")).then_some(())
    };
    directories.iter().find_map(|directory| {
        let mut jars: Vec<_> = fs::read_dir(directory)
            .ok()?
            .flatten()
            .map(|file| file.path())
            .collect();
        jars.sort();
        jars.into_iter().find(|path| fits(path).is_some())
    })
}

impl Spy {
    /// Build the jar of our types in `directory`, and ask lcm-spy's database for each of them.
    pub fn prepare(directory: &Path) -> Result<Self, SpyError> {
        let jars = Jars::find()?;
        let (sources, classes) = (directory.join("java"), directory.join("classes"));
        for path in [&sources, &classes] {
            // What is left from before, of types that are no more.
            let _ = fs::remove_dir_all(path);
            fs::create_dir_all(path).map_err(at(path))?;
        }
        let mut generate = Command::new(lcm_gen());
        generate.arg("-j").arg("--jpath").arg(&sources);
        for (name, text) in TYPE_FILES {
            let file = sources.join(name);
            fs::write(&file, text).map_err(at(&file))?;
            generate.arg(file);
        }
        run("lcm-gen", "sudo apt-get install liblcm-bin", &mut generate)?;
        let check = sources.join("Check.java");
        fs::write(&check, CHECK).map_err(at(&check))?;
        let mut compile = Command::new("javac");
        compile
            .args(["-nowarn", "-encoding", "UTF-8", "-cp"])
            .arg(jars.class_path(&[]));
        compile.arg("-d").arg(&classes).arg(&check);
        for (name, _) in TYPE_FILES {
            let class = format!("{}.java", name.trim_end_matches(".lcm"));
            compile.arg(sources.join("touchdown").join(class));
        }
        run("javac", JDK, &mut compile)?;
        let jar = directory.join(TYPES);
        let manifest = directory.join("manifest");
        fs::write(&manifest, jars.manifest()).map_err(at(&manifest))?;
        let mut pack = Command::new("jar");
        pack.arg("cfm")
            .arg(&jar)
            .arg(&manifest)
            .arg("-C")
            .arg(&classes)
            .arg("touchdown");
        run("jar", JDK, &mut pack)?;
        let class_path = jars.class_path(&[&jar]);
        let mut ask = Command::new("java");
        ask.arg("-cp")
            .arg(jars.class_path(&[&jar, &classes]))
            .arg("Check");
        ask.args(fingerprints().map(|(_, fingerprint)| format!("{fingerprint:x}")));
        let said = run("java", JDK, &mut ask)?;
        let said = String::from_utf8_lossy(&said.stdout);
        let class = |fingerprint: u64| {
            let begins = format!("type {fingerprint:x} ");
            let class = said.lines().find_map(|line| line.strip_prefix(&begins));
            class.filter(|class| *class != "undecodable").map(str::to_owned)
        };
        Ok(Self {
            class_path,
            types: fingerprints()
                .map(|(channel, fingerprint)| (channel, class(fingerprint)))
                .collect(),
            windows: said.lines().any(|line| line == "windows true"),
            jar,
        })
    }

    /// What starts it on `url`.
    pub fn command(&self, url: &str) -> Command {
        let mut command = Command::new("java");
        command.args(["-Djava.net.preferIPv4Stack=true", "-cp"]);
        command.arg(&self.class_path).arg("lcm.spy.Spy");
        command.env("LCM_DEFAULT_URL", url);
        command
    }
}

/// As where the LCM is that was asked for.
fn lcm_gen() -> PathBuf {
    let prefix = env::var_os("LCM_PREFIX").filter(|prefix| !prefix.is_empty());
    let own = prefix.map(|prefix| Path::new(&prefix).join("bin/lcm-gen"));
    own.filter(|own| own.is_file())
        .unwrap_or_else(|| PathBuf::from("lcm-gen"))
}

fn at(path: &Path) -> impl Fn(io::Error) -> SpyError {
    move |source| SpyError::File {
        path: path.to_owned(),
        source,
    }
}

fn run(tool: &'static str, remedy: &'static str, command: &mut Command) -> Result<Output, SpyError> {
    let output = command.output().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => SpyError::Missing { what: tool, remedy },
        _ => SpyError::Failed {
            tool,
            said: error.to_string(),
        },
    })?;
    if output.status.success() {
        return Ok(output);
    }
    let said = [&output.stdout[..], &output.stderr].concat();
    Err(SpyError::Failed {
        tool,
        said: String::from_utf8_lossy(&said).trim().to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jars_are_found_with_and_without_versions() {
        let directory = tempfile::tempdir().unwrap();
        let place = |name: &str| fs::write(directory.path().join(name), "").unwrap();
        let found = || Jars::among(&[directory.path().join("none"), directory.path().to_owned()]);
        assert!(
            found()
                .unwrap_err()
                .to_string()
                .starts_with("lcm.jar is missing; sudo apt-get install")
        );
        place("lcm.jar");
        place("jchart2dx.jar");
        assert!(
            found()
                .unwrap_err()
                .to_string()
                .starts_with("jchart2d.jar is missing")
        );
        place("jchart2d-3.2.2.jar");
        place("jide-oss.jar");
        let jars = found().unwrap();
        let path = jars.class_path(&[Path::new("types.jar")]).into_string().unwrap();
        let names: Vec<_> = path
            .split(':')
            .map(|path| path.rsplit('/').next().unwrap())
            .collect();
        assert_eq!(names, ["lcm.jar", "jchart2d-3.2.2.jar", "types.jar"]);
        let manifest = jars.manifest();
        assert!(manifest.starts_with("Class-Path: file:/"), "{manifest}");
        assert!(manifest.ends_with("/jide-oss.jar\n"), "{manifest}");
    }
}
