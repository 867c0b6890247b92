//! The links of the documentation lead somewhere, the examples it names are there, and its book leaves no page out.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use regex::Regex;

const SUMMARY: &str = "docs/book/SUMMARY.md";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every page, relative to the repository: Markdown outside build folders.
fn pages(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        if path.is_dir() && !name.starts_with('.') && name != "target" && name != "node_modules" {
            pages(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.insert(path.strip_prefix(root()).unwrap().to_owned());
        }
    }
}

/// Text without its code, in which brackets are no links.
fn prose(text: &str) -> String {
    let fenced = Regex::new(r"(?s)```.*?```").unwrap();
    let inline = Regex::new(r"`[^`\n]*`").unwrap();
    inline.replace_all(&fenced.replace_all(text, ""), "").into_owned()
}

/// Targets of links and pictures in the repository: path, and heading on it.
fn links(page: &Path) -> Vec<(PathBuf, Option<String>)> {
    let text = prose(&std::fs::read_to_string(root().join(page)).unwrap());
    let link = Regex::new(r"\]\(([^) #\n]*)(?:#([^) \n]*))?\)").unwrap();
    let inside = link.captures_iter(&text).filter(|found| !found[1].contains(':'));
    let folder = page.parent().unwrap();
    let target = |path: &str| if path.is_empty() { page.to_owned() } else { folder.join(path) };
    inside.map(|found| (target(&found[1]), found.get(2).map(|heading| heading.as_str().to_owned()))).collect()
}

/// Names by which links reach the headings of a page.
fn headings(page: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(root().join(page)).unwrap();
    let kept = |c: char| c.is_alphanumeric() || c == '-' || c == '_' || c == ' ';
    let titles = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    titles.map(|title| title.to_lowercase().chars().filter(|c| kept(*c)).collect::<String>().replace(' ', "-")).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut all = BTreeSet::new();
    pages(&root(), &mut all);
    // Its paths are those of the book.
    all.remove(Path::new(SUMMARY));
    let mut count = 0;
    for page in &all {
        for (target, heading) in links(page) {
            count += 1;
            assert!(root().join(&target).exists(), "{}: no file {}", page.display(), target.display());
            if let Some(heading) = heading {
                assert!(headings(&target).contains(&heading), "{}: no heading {heading} in {}", page.display(), target.display());
            }
        }
    }
    assert!(count > 40, "{count} links in {} pages", all.len());
}

#[test]
fn examples_that_pages_name_are_there() {
    let mut all = BTreeSet::new();
    pages(&root(), &mut all);
    let command = Regex::new(r"-p precomp-([a-z]+) --example ([a-z_]+)").unwrap();
    let mut count = 0;
    for page in &all {
        let text = std::fs::read_to_string(root().join(page)).unwrap();
        for found in command.captures_iter(&text) {
            count += 1;
            let file = Path::new(&found[1]).join("examples").join(format!("{}.rs", &found[2]));
            assert!(root().join(&file).exists(), "{}: no example {}", page.display(), file.display());
        }
    }
    assert!(count >= 2, "{count} examples in {} pages", all.len());
}

#[test]
fn the_book_has_every_page_once() {
    let mut all = BTreeSet::new();
    pages(&root(), &mut all);
    let text = std::fs::read_to_string(root().join(SUMMARY)).unwrap();
    let link = Regex::new(r"\]\(([^)]+)\)").unwrap();
    let listed: Vec<PathBuf> = link.captures_iter(&text).map(|found| PathBuf::from(&found[1])).collect();
    let once: BTreeSet<PathBuf> = listed.iter().cloned().collect();
    assert_eq!(listed.len(), once.len(), "a page is listed twice");
    all.remove(Path::new(SUMMARY));
    assert_eq!(once, all);
}
