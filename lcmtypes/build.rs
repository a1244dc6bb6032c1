//! From `types/*.lcm` to Rust: lcm-gen writes C, cc compiles it, bindgen reads its headers. All of it in OUT_DIR.
//!
//! LCM is looked for below `LCM_PREFIX` (include/, lib/, bin/lcm-gen), then by pkg-config, then in the
//! system's default places.
#![allow(
    clippy::panic,
    clippy::expect_used,
    reason = "a build script reports by panicking"
)]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const REMEDY: &str = "on Debian: apt-get install liblcm-dev liblcm-bin libclang-dev libglib2.0-dev pkg-config; \
     or set LCM_PREFIX to the directory of another LCM that holds include/, lib/ and bin/lcm-gen";

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    for name in ["LCM_PREFIX", "LIBCLANG_PATH"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=types");

    let names = type_names(Path::new("types"));
    let lcm = Lcm::find();
    generate(&lcm.generator, &names, &out);
    compile(&lcm.include, &names, &out);
    bind(&lcm.include, &names, &out);
    describe(&names, &out);
    // The tests generate Python types with the same lcm-gen.
    println!("cargo:rustc-env=LCM_GEN={}", lcm.generator.display());
}

/// The stems of `types/*.lcm`, sorted: `robot_state_t`, ...
fn type_names(directory: &Path) -> Vec<String> {
    let files = fs::read_dir(directory).expect("lcmtypes/types holds the .lcm files");
    let mut names: Vec<String> = files
        .map(|file| file.expect("lcmtypes/types is readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "lcm"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect();
    names.sort();
    names
}

/// Where LCM's headers and generator are; its library has been announced to cargo.
struct Lcm {
    include: Vec<PathBuf>,
    generator: PathBuf,
}

impl Lcm {
    fn find() -> Self {
        if let Some(prefix) = env::var_os("LCM_PREFIX").filter(|prefix| !prefix.is_empty()) {
            return Self::below(&PathBuf::from(prefix));
        }
        let include = match pkg_config::Config::new().probe("lcm") {
            Ok(library) => library.include_paths,
            Err(error) => {
                let header = Path::new("lcm/lcm.h");
                let places = ["/usr/include", "/usr/local/include"].map(PathBuf::from);
                let found = places.iter().any(|place| place.join(header).is_file());
                assert!(
                    found,
                    "LCM's headers are missing (package liblcm-dev); {REMEDY}\npkg-config says: {error}"
                );
                // pkg-config or libglib2.0-dev is missing; neither is needed to link.
                println!("cargo:rustc-link-lib=lcm");
                places.into()
            }
        };
        Self {
            include,
            generator: PathBuf::from("lcm-gen"),
        }
    }

    fn below(prefix: &Path) -> Self {
        let (include, generator) = (prefix.join("include"), prefix.join("bin/lcm-gen"));
        let library = ["lib", "lib64", "lib/x86_64-linux-gnu", "lib/aarch64-linux-gnu"]
            .map(|place| prefix.join(place))
            .into_iter()
            .find(|place| place.join("liblcm.a").is_file() || place.join("liblcm.so").is_file())
            .unwrap_or_else(|| {
                panic!(
                    "LCM_PREFIX={}: no lib/liblcm.so there; {REMEDY}",
                    prefix.display()
                )
            });
        for file in [include.join("lcm/lcm.h"), generator.clone()] {
            assert!(
                file.is_file(),
                "LCM_PREFIX: {} is missing; {REMEDY}",
                file.display()
            );
            println!("cargo:rerun-if-changed={}", file.display());
        }
        println!("cargo:rustc-link-search=native={}", library.display());
        if library.join("liblcm.a").is_file() {
            // Every version's shared library is called liblcm.so.1: only a static one is surely this one at run time.
            println!("cargo:rustc-link-lib=static=lcm");
            if let Err(error) = pkg_config::Config::new().probe("glib-2.0") {
                panic!("glib is missing (package libglib2.0-dev); {REMEDY}\npkg-config says: {error}");
            }
        } else {
            println!("cargo:rustc-link-lib=dylib=lcm");
            println!("cargo:rustc-link-arg=-Wl,-rpath,{}", library.display());
            println!(
                "cargo:warning=LCM_PREFIX holds a shared library only; run programs with LD_LIBRARY_PATH={}",
                library.display()
            );
        }
        Self {
            include: vec![include],
            generator,
        }
    }
}

/// `types/*.lcm` -> `touchdown_*.c`, `touchdown_*.h`.
fn generate(generator: &Path, names: &[String], out: &Path) {
    let status = Command::new(generator)
        .args(["-c", "--c-no-pubsub", "--c-cpath"])
        .arg(out)
        .arg("--c-hpath")
        .arg(out)
        .args(names.iter().map(|name| format!("types/{name}.lcm")))
        .status();
    match status {
        Ok(status) if status.success() => {}
        Ok(status) => panic!("{} failed on types/*.lcm: {status}", generator.display()),
        Err(error) => panic!(
            "can't run {} (package liblcm-bin): {error}; {REMEDY}",
            generator.display()
        ),
    }
}

fn compile(include: &[PathBuf], names: &[String], out: &Path) {
    cc::Build::new()
        .files(names.iter().map(|name| out.join(format!("touchdown_{name}.c"))))
        .include(out)
        .includes(include)
        .opt_level(2)
        .warnings(false)
        .compile("touchdown_types");
}

/// `types/*.lcm` -> `schema.rs`: what a program is told of the types' members (`src/schema.rs`).
fn describe(names: &[String], out: &Path) {
    let types: String = names.iter().map(|name| describe_type(name)).collect();
    let count = names.len();
    fs::write(
        out.join("schema.rs"),
        format!("pub(super) static TYPES: [Type; {count}] = [\n{types}];\n"),
    )
    .expect("OUT_DIR is writable");
}

fn describe_type(name: &str) -> String {
    let text = fs::read_to_string(format!("types/{name}.lcm")).expect("lcmtypes/types is readable");
    let (mut members, mut comment, mut about) = (String::new(), Vec::new(), String::new());
    for line in text.lines().map(str::trim) {
        match line.strip_prefix("//") {
            Some(words) => comment.push(words.trim()),
            None if line.starts_with("struct ") => about = std::mem::take(&mut comment).join(" "),
            // Comments of constants are theirs.
            None if line.is_empty() || ["const ", "package "].iter().any(|word| line.starts_with(word)) => {
                comment.clear()
            }
            None => {
                if let Some((kind, declared)) = line.strip_suffix(';').and_then(|line| line.split_once(' ')) {
                    let (member, dimensions) = dimensions(declared);
                    let kind =
                        kind_of(kind).unwrap_or_else(|| panic!("{name}.lcm: no rule for the type {kind}"));
                    let doc = std::mem::take(&mut comment).join(" ");
                    members += &format!(
                        "Member {{ name: {member:?}, kind: Kind::{kind}, dimensions: &{dimensions:?}, about: {doc:?} }},\n"
                    );
                }
            }
        }
    }
    format!("Type {{ name: {name:?}, about: {about:?}, members: &[\n{members}] }},\n")
}

fn kind_of(primitive: &str) -> Option<&'static str> {
    Some(match primitive {
        "boolean" => "Boolean",
        "byte" => "Byte",
        "int32_t" => "Int32",
        "int64_t" => "Int64",
        "double" => "Double",
        _ => return None,
    })
}

/// `name[8][6]` -> `name`, 8 and 6.
fn dimensions(declared: &str) -> (&str, Vec<usize>) {
    let (name, rest) = declared.split_at(declared.find('[').unwrap_or(declared.len()));
    let sizes = rest.split(['[', ']']).filter(|size| !size.is_empty());
    (
        name,
        sizes
            .map(|size| size.parse().expect("sizes are numbers"))
            .collect(),
    )
}

/// Headers -> `bindings.rs`, with one module of short names per type (`robot_state::encode`).
fn bind(include: &[PathBuf], names: &[String], out: &Path) {
    let mut header = String::from("#include <lcm/lcm.h>\n#include <lcm/eventlog.h>\n");
    for name in names {
        header += &format!("#include \"touchdown_{name}.h\"\n");
    }
    assert!(
        std::panic::catch_unwind(bindgen::clang_version).is_ok(),
        "libclang is missing (package libclang-dev); {REMEDY}"
    );
    let mut bindings = bindgen::Builder::default()
        .header_contents("touchdown.h", &header)
        .clang_arg(format!("-I{}", out.display()))
        .clang_args(include.iter().map(|place| format!("-I{}", place.display())))
        .allowlist_function("lcm_.*|fflush")
        .allowlist_function("touchdown_.*_(encode|decode|encoded_size)|__touchdown_.*_get_hash")
        .allowlist_var("(LCM|TOUCHDOWN)_.*")
        .opaque_type("_IO_FILE|FILE")
        .default_macro_constant_type(bindgen::MacroTypeVariation::Signed)
        .derive_default(true)
        .layout_tests(false)
        .generate_comments(false);
    for name in names {
        let (module, c) = (name.trim_end_matches("_t"), format!("touchdown_{name}"));
        bindings = bindings.raw_line(format!(
            "pub mod {module} {{ pub use super::{{{c} as Raw, {c}_encode as encode, {c}_decode as decode, \
             {c}_encoded_size as encoded_size, __{c}_get_hash as get_hash}}; }}"
        ));
    }
    bindings
        .generate()
        .unwrap_or_else(|error| panic!("bindgen can't read LCM's headers: {error}; {REMEDY}"))
        .write_to_file(out.join("bindings.rs"))
        .expect("OUT_DIR is writable");
}
