//! What comes with the program, and what users add.

use super::*;

#[test]
fn what_comes_with_the_program_is_valid_and_has_sources() {
    let library = Library::built_in().unwrap();
    assert!(library.materials.len() >= 10 && library.shapes.len() >= 4);
    let materials = library.materials.values().map(|entry| &entry.source);
    let shapes = library.shapes.values().map(|entry| &entry.source);
    assert!(materials.chain(shapes).all(|source| source.len() > 20));
}

/// Each against the textbook form of its own source.
#[test]
fn the_shapes_are_the_published_ones() {
    let library = Library::built_in().unwrap();
    let force = |shape: &str, dimension: f64, h: f64| {
        library
            .shape(shape)
            .unwrap()
            .law(dimension, 1e9)
            .unwrap()
            .force_n(h)
    };
    let pi = std::f64::consts::PI;
    let h = 2e-5_f64;
    let close =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    close(force("flat-punch", 0.008, h), 2.0 * 0.008 * 1e9 * h);
    close(
        force("sphere", 0.008, h),
        4.0 / 3.0 * 1e9 * 0.008_f64.sqrt() * h * h.sqrt(),
    );
    close(force("cone", 1.0, h), 2.0 / pi * 1e9 * libm::tan(1.0) * h * h);
    let round_of_the_same_area = (0.02_f64 * 0.02 / pi).sqrt();
    close(
        force("square-punch", 0.02, h),
        1.012 * force("flat-punch", round_of_the_same_area, h),
    );
}

#[test]
fn your_own_come_in_addition_and_first() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("own.toml");
    let own = "[materials.steel]\nyoungs_modulus_pa = 1e11\npoisson_ratio = 0\nsource = \"mine\"\n\
               [shapes.pin]\ndimension = \"radius_m\"\nexponent = 1.2\nfactor = 2.1\nsource = \"measured\"\n";
    std::fs::write(&path, own).unwrap();
    let library = Library::with_file(&path).unwrap();
    assert_eq!(library.material("steel").unwrap().youngs_modulus_pa, 1e11);
    assert_eq!(
        library.materials["glass"],
        Library::built_in().unwrap().materials["glass"]
    );
    assert_eq!(library.shape("pin").unwrap().exponent, 1.2);
}

#[test]
fn what_is_no_library_is_refused_with_its_place() {
    let message = |text: &str| Library::parse("own.toml", text).unwrap_err().to_string();
    let found = message("[materials.gum]\nyoungs_modulus = 1e6\npoisson_ratio = 0.5\nsource = \"\"\n");
    assert!(
        found.starts_with("own.toml:2:1: unknown field `youngs_modulus`, expected one of "),
        "{found}"
    );
    let found = message("[materials.gum]\nyoungs_modulus_pa = 1e6\npoisson_ratio = 0.6\nsource = \"\"\n");
    assert!(
        found.starts_with("material \"gum\" of own.toml: Poisson's ratio is 0.6, outside 0 to 0.5; "),
        "{found}"
    );
    let found = message("[shapes.pin]\ndimension = \"width_m\"\nexponent = 1\nfactor = 2\nsource = \"\"\n");
    assert!(
        found.starts_with("own.toml:2:13: unknown variant `width_m`, expected one of `radius_m`"),
        "{found}"
    );
    let library = Library::built_in().unwrap();
    let found = library.material("stel").unwrap_err().to_string();
    assert!(
        found.starts_with("unknown material \"stel\"; known are acrylic-glass, aluminium, "),
        "{found}"
    );
}
