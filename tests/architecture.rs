//! Nothing imports upward: every crate uses only crates of lower floors, only the crates that should know burn, Parquet or the
//! terminal do, and the files of a crate do not import each other in a circle.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

/// Floor of every crate, and what it may use of the house.
const FLOORS: [(&str, &[&str]); 11] = [
    ("gcode", &[]),
    ("motion", &[]),
    ("machine", &["motion"]),
    ("compensation", &["motion", "machine"]),
    ("datasets", &["motion", "machine"]),
    ("servo", &["motion"]),
    ("models", &["motion", "machine", "servo"]),
    ("diagnosis", &["motion", "datasets", "servo"]),
    ("training", &["motion", "machine", "datasets", "servo", "models"]),
    ("pipeline", &["gcode", "motion", "machine", "compensation", "datasets", "models", "training"]),
    ("fleet", &["motion", "machine", "datasets", "servo", "models", "diagnosis", "pipeline"]),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn dependencies(manifest: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(manifest).unwrap();
    let table: toml::Table = text.parse().unwrap();
    table["dependencies"].as_table().unwrap().keys().cloned().collect()
}

#[test]
fn crates_use_only_what_their_floor_allows() {
    let house: Vec<&str> = FLOORS.iter().map(|(name, _)| *name).collect();
    for (name, allowed) in FLOORS {
        for used in dependencies(&root().join(name).join("Cargo.toml")) {
            if house.contains(&used.as_str()) {
                assert!(allowed.contains(&used.as_str()), "{name} must not use {used}");
            }
            let only = BTreeMap::from([
                ("parquet", vec!["datasets"]),
                ("burn", vec!["models", "training"]),
                ("polars", vec!["fleet"]),
                ("clap", vec![]),
                ("indicatif", vec![]),
                ("anyhow", vec![]),
                ("minijinja", vec![]),
                ("comfy-table", vec![]),
                ("serde_json", vec!["datasets", "models", "training", "fleet"]),
            ]);
            if let Some(owners) = only.get(used.as_str()) {
                assert!(owners.contains(&name), "{name} must not know {used}");
            }
        }
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// What the compiler denies in the library: printing, ending the process, reading the clock (`clippy.toml`).
#[test]
fn only_the_command_line_prints_reads_the_clock_or_exits() {
    let denied =
        "#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]";
    for (name, _) in FLOORS {
        let text = std::fs::read_to_string(root().join(name).join("src/lib.rs")).unwrap();
        assert!(text.lines().any(|line| line == denied), "{name}/src/lib.rs lacks {denied}");
        let mut files = Vec::new();
        sources(&root().join(name).join("src"), &mut files);
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let allowed = ["print_stdout", "print_stderr", "clippy::exit", "disallowed_methods"];
            let allows = |line: &&str| line.contains("allow(") && allowed.iter().any(|lint| line.contains(lint));
            assert_eq!(text.lines().find(allows), None, "{}", file.display());
        }
    }
}

/// A module that is a file, as its path from the root of its crate; empty for `lib.rs`.
type Module = Vec<String>;

/// The code of a file without comments, texts and what is compiled for tests only, cut into words, `::` and single characters.
fn tokens(text: &str) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let mut out: Vec<String> = Vec::new();
    let mut k = 0;
    while k < chars.len() {
        let rest = &chars[k..];
        let (length, is_code) = match rest {
            ['/', '/', ..] => (rest.iter().position(|c| *c == '\n').unwrap_or(rest.len()), false),
            ['/', '*', ..] => (rest.windows(2).position(|two| two == ['*', '/']).map_or(rest.len(), |end| end + 2), false),
            // A lifetime has no second quote.
            ['"', ..] | ['\'', '\\', ..] | ['\'', _, '\'', ..] => (quoted(rest), false),
            [':', ':', ..] => (2, true),
            [c, ..] if c.is_whitespace() => (1, false),
            [c, ..] if is_of_word(c) => match raw_text(rest) {
                Some(length) => (length, false),
                None => (rest.iter().position(|c| !is_of_word(c)).unwrap_or(rest.len()), true),
            },
            _ => (1, true),
        };
        if is_code {
            out.push(rest[..length].iter().collect());
        }
        k += length;
    }
    without_tests(&out)
}

fn is_of_word(c: &char) -> bool {
    c.is_alphanumeric() || *c == '_'
}

/// Length of a text in quotes, both included.
fn quoted(chars: &[char]) -> usize {
    let mut k = 1;
    while k < chars.len() && chars[k] != chars[0] {
        k += if chars[k] == '\\' { 2 } else { 1 };
    }
    (k + 1).min(chars.len())
}

/// Length of a text like `r#"…"#`; `None` where there is none.
fn raw_text(chars: &[char]) -> Option<usize> {
    let after = chars.strip_prefix(&['r'])?;
    let hashes = after.iter().take_while(|c| **c == '#').count();
    let text = after[hashes..].strip_prefix(&['"'])?;
    let end: Vec<char> = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
    let length = text.windows(end.len()).position(|part| part == end)?;
    Some(1 + hashes + 1 + length + end.len())
}

/// The tokens without the items under `#[cfg(test)]`.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let marks = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut out = Vec::new();
    let mut k = 0;
    while k < tokens.len() {
        if !tokens[k..].iter().map(String::as_str).take(marks.len()).eq(marks) {
            out.push(tokens[k].clone());
            k += 1;
            continue;
        }
        // An item ends with its braces, or with a semicolon before any.
        let mut depth = 0;
        k += marks.len();
        while k < tokens.len() {
            let token = tokens[k].as_str();
            depth += i32::from(token == "{") - i32::from(token == "}");
            k += 1;
            if depth == 0 && (token == "}" || token == ";") {
                break;
            }
        }
    }
    out
}

/// A path that a file names, with the name that it goes by afterwards.
#[derive(Debug, PartialEq)]
struct Named {
    path: Vec<String>,
    name: String,
}

/// The paths of a `use` tree after `prefix`, up to the end of the tree.
fn expand(tokens: &mut std::iter::Peekable<std::slice::Iter<'_, String>>, prefix: &[String], out: &mut Vec<Named>) {
    let mut path = prefix.to_vec();
    let mut name = None;
    while let Some(token) = tokens.next_if(|token| !["}", ",", ";"].contains(&token.as_str())) {
        match token.as_str() {
            "::" => {}
            "{" => {
                while tokens.peek().is_some_and(|token| *token != "}") {
                    expand(tokens, &path, out);
                    tokens.next_if(|token| *token == ",");
                }
                tokens.next();
                return;
            }
            "as" => name = tokens.next().cloned(),
            // `use parent::{self, …}` names the parent.
            "self" if !path.is_empty() => {}
            word => path.push(word.to_owned()),
        }
    }
    let name = name.or_else(|| path.last().cloned()).unwrap_or_default();
    out.push(Named { path, name });
}

/// What a file imports or names by its path, and what it re-exports.
fn imports(tokens: &[String]) -> (Vec<Named>, Vec<Named>) {
    let (mut used, mut exported) = (Vec::new(), Vec::new());
    let mut k = 0;
    while k < tokens.len() {
        let at = |k: usize| tokens.get(k).map_or("", String::as_str);
        let before = if k > 0 { at(k - 1) } else { "" };
        if at(k) == "use" && at(k + 1) != "<" {
            let end = k + tokens[k..].iter().position(|token| token == ";").unwrap_or(tokens.len() - k);
            // The tree ends the statement.
            let mut tree = tokens[k + 1..end].iter().peekable();
            expand(&mut tree, &[], if ["pub", ")"].contains(&before) { &mut exported } else { &mut used });
            k = end;
        } else if at(k + 1) == "::" && before != "::" && before != "in" {
            let mut path = vec![tokens[k].clone()];
            while at(k + 1) == "::" && at(k + 2).starts_with(|c| is_of_word(&c)) {
                path.push(tokens[k + 2].clone());
                k += 2;
            }
            used.push(Named { name: String::new(), path });
        }
        k += 1;
    }
    (used, exported)
}

/// One crate: its files, with what they import and re-export.
struct Sources(BTreeMap<Module, (Vec<Named>, Vec<Named>)>);

impl Sources {
    fn read(folder: &Path) -> Self {
        let mut files = Vec::new();
        sources(folder, &mut files);
        let module = |file: &Path| -> Module {
            let below = file.strip_prefix(folder).unwrap().with_extension("");
            let mut module: Module = below.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            module.pop_if(|last| *last == "mod");
            module.pop_if(|last| *last == "lib");
            module
        };
        let read = |file: &PathBuf| (module(file), imports(&tokens(&std::fs::read_to_string(file).unwrap())));
        Self(files.iter().map(read).collect())
    }

    /// The file that a path named in `from` leads into, and what is left of the path there; `None` for other crates.
    fn walk<'a>(&self, from: &Module, path: &'a [String]) -> Option<(Module, &'a [String])> {
        let mut module = from.clone();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => (module, rest) = (Module::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|part| part == "super") {
                    module.pop();
                    rest = &rest[1..];
                }
            }
            child if self.0.contains_key(&[from.as_slice(), &[child.to_owned()]].concat()) => {}
            _ => return None,
        }
        while let Some((part, after)) = rest.split_first() {
            let child = [module.as_slice(), std::slice::from_ref(part)].concat();
            if !self.0.contains_key(&child) {
                break;
            }
            (module, rest) = (child, after);
        }
        Some((module, rest))
    }

    /// The file that defines what a path in `from` names: re-exports are followed.
    fn target(&self, from: &Module, path: &[String]) -> Option<Module> {
        let (module, rest) = self.walk(from, path)?;
        let (_, exported) = self.0.get(&module)?;
        let export = rest.first().and_then(|name| exported.iter().find(|export| export.name == *name));
        match export {
            Some(export) if export.path != path => self.target(&module, &export.path).or(Some(module)),
            _ => Some(module),
        }
    }

    fn graph(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let targets = |(module, (used, _)): (&Module, &(Vec<Named>, Vec<Named>))| {
            let targets = used.iter().filter_map(|named| self.target(module, &named.path));
            (module.clone(), targets.filter(|target| target != module && self.0.contains_key(target)).collect())
        };
        self.0.iter().map(targets).collect()
    }
}

/// The shortest chain of imports from a file back to itself.
fn circle(graph: &BTreeMap<Module, BTreeSet<Module>>, start: &Module) -> Option<Vec<Module>> {
    let mut seen = BTreeSet::new();
    let mut chains = VecDeque::from([vec![start.clone()]]);
    while let Some(chain) = chains.pop_front() {
        for next in &graph[chain.last()?] {
            if next == start {
                return Some(chain);
            }
            if seen.insert(next) {
                chains.push_back([chain.as_slice(), std::slice::from_ref(next)].concat());
            }
        }
    }
    None
}

#[test]
fn no_file_of_a_crate_imports_in_a_circle() {
    // The command line is the crate in the root itself; the Python package stands beside it.
    let crates = FLOORS.iter().map(|(name, _)| *name).chain([".", "python"]);
    let mut circles = Vec::new();
    for name in crates {
        let graph = Sources::read(&root().join(name).join("src")).graph();
        assert!(graph.values().any(|targets| !targets.is_empty()), "{name}: no import was read");
        let mut known = BTreeSet::new();
        for circle in graph.keys().filter_map(|module| circle(&graph, module)) {
            let text = |module: &Module| if module.is_empty() { "lib".to_owned() } else { module.join("::") };
            if known.insert(circle.iter().cloned().collect::<BTreeSet<_>>()) {
                circles.push(format!("{name}: {}", circle.iter().map(text).collect::<Vec<_>>().join(" → ")));
            }
        }
    }
    assert!(circles.is_empty(), "files that import each other in a circle:\n{}", circles.join("\n"));
}

#[test]
fn imports_are_read_from_code_alone() {
    let code = r##"
        //! use crate::comment::A;
        use crate::a::{self, b::{B, c as d}, e};
        pub use child::Exported as Name;
        pub(super) use other::Other;
        fn f() -> impl Iterator<Item = u8> + use<> { super::super::g::G::new("use crate::text::T;", 'x', r#"crate::raw"#) }
        #[cfg(test)]
        mod tests { use crate::tested::T; fn f() { if true {} } }
        pub(in crate::h) struct S<'a>(&'a crate::i::I);
    "##;
    let (used, exported) = imports(&tokens(code));
    let paths: Vec<String> = used.iter().map(|named| named.path.join("::")).collect();
    assert_eq!(paths, ["crate::a", "crate::a::b::B", "crate::a::b::c", "crate::a::e", "super::super::g::G::new", "crate::i::I"]);
    let names: Vec<&str> = exported.iter().map(|named| named.name.as_str()).collect();
    assert_eq!(names, ["Name", "Other"]);
}
