//! The picture of the crates in `docs/crates.svg`, drawn from their manifests: a row a floor, an arrow for every crate that another one uses.
//!
//! `UPDATE=1 cargo test --release --test crates_picture` draws it anew.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const WIDTH: f64 = 860.0;
const BOX: (f64, f64) = (132.0, 44.0);
const ROW: f64 = 96.0;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(folder: &Path) -> toml::Table {
    std::fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap()
}

/// Every crate with those of the house that it uses; the command line is `src`.
fn crates() -> BTreeMap<String, Vec<String>> {
    let members = manifest(&root())["workspace"]["members"].clone();
    let names: Vec<String> = members.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect();
    let used = |folder: &Path| {
        let manifest = manifest(folder);
        let used = manifest["dependencies"].as_table().unwrap().keys();
        // The crate in the root is called like the product.
        let used = used.map(|name| if name == "precomp" { "src".to_owned() } else { name.clone() });
        used.filter(|name| name == "src" || names.contains(name)).collect::<Vec<_>>()
    };
    let mut crates: BTreeMap<String, Vec<String>> = names.iter().map(|name| (name.clone(), used(&root().join(name)))).collect();
    crates.insert("src".to_owned(), used(&root()));
    crates
}

/// A crate's row: one above the highest of those that it uses.
fn floor(name: &str, crates: &BTreeMap<String, Vec<String>>) -> usize {
    crates[name].iter().map(|used| 1 + floor(used, crates)).max().unwrap_or(0)
}

/// Arrows that another path of arrows does not say already.
fn direct<'a>(name: &str, crates: &'a BTreeMap<String, Vec<String>>) -> Vec<&'a String> {
    fn reaches(from: &str, to: &str, crates: &BTreeMap<String, Vec<String>>) -> bool {
        crates[from].iter().any(|used| used == to || reaches(used, to, crates))
    }
    let by_another = |used: &String| crates[name].iter().any(|other| reaches(other, used, crates));
    crates[name].iter().filter(|used| !by_another(used)).collect()
}

fn picture(crates: &BTreeMap<String, Vec<String>>) -> String {
    let mut rows: BTreeMap<usize, Vec<&String>> = BTreeMap::new();
    for name in crates.keys() {
        rows.entry(floor(name, crates)).or_default().push(name);
    }
    let top = rows.keys().max().copied().unwrap_or(0);
    let place = |name: &str| {
        let floor = floor(name, crates);
        let row = &rows[&floor];
        let index = row.iter().position(|known| *known == name).unwrap();
        let x = WIDTH * (index as f64 + 1.0) / (row.len() as f64 + 1.0);
        (x, ROW * (top - floor) as f64 + 0.5 * ROW)
    };
    let height = ROW * (top + 1) as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"system-ui, sans-serif\" font-size=\"15\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for name in crates.keys() {
        let (x, y) = place(name);
        for used in direct(name, crates) {
            let (to_x, to_y) = place(used);
            let (from_y, to_y) = (y + 0.5 * BOX.1, to_y - 0.5 * BOX.1);
            writeln!(svg, "<path d=\"M{x:.0} {from_y:.0} L{to_x:.0} {to_y:.0}\" stroke=\"#888\" fill=\"none\"/>").unwrap();
        }
    }
    for name in crates.keys() {
        let (x, y) = place(name);
        let (left, up) = (x - 0.5 * BOX.0, y - 0.5 * BOX.1);
        writeln!(
            svg,
            "<rect x=\"{left:.0}\" y=\"{up:.0}\" width=\"{}\" height=\"{}\" rx=\"6\" fill=\"#f4f6f8\" stroke=\"#456\"/>\n\
             <text x=\"{x:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{name}</text>",
            BOX.0,
            BOX.1,
            y + 5.0
        )
        .unwrap();
    }
    svg + "</svg>\n"
}

#[test]
fn the_picture_of_the_crates_is_that_of_their_manifests() {
    let (path, drawn) = (root().join("docs/crates.svg"), picture(&crates()));
    if std::env::var("UPDATE").is_ok() {
        std::fs::write(&path, &drawn).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == drawn, "docs/crates.svg is out of date: UPDATE=1 cargo test --release --test crates_picture");
}
