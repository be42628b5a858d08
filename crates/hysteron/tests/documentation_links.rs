//! Promise: every relative link of the documentation points to a file or folder that exists, README names the
//! two commands, and the page of metrics says what the program computes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test stops at the first surprise"
)]

use std::fs;
use std::path::{Path, PathBuf};

use hysteron_model::validate::definitions;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Markdown files of the documentation.
fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].iter().map(|name| root().join(name)).collect();
    let mut folders = vec![root().join("docs"), root().join("examples")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                pages.push(path);
            }
        }
    }
    pages
}

/// Text outside of fenced code, where `](` is no link.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let keep = |line: &&str| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    };
    text.lines().filter(keep).collect::<Vec<_>>().join("\n")
}

/// Targets of `[text](target)` and `![text](target)`.
fn links(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

/// Anchor of a heading as a forge makes it.
fn anchor(heading: &str) -> String {
    let lower = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = lower.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Why a link is broken, if it is.
fn fault(page: &Path, link: &str) -> Option<String> {
    if ["http://", "https://", "mailto:"].iter().any(|scheme| link.starts_with(scheme)) {
        return None;
    }
    let (file, heading) = link.split_once('#').unwrap_or((link, ""));
    let target = if file.is_empty() { page.to_path_buf() } else { page.parent().unwrap().join(file) };
    if !target.exists() {
        return Some(format!("{}: `{link}` points to nothing", page.display()));
    }
    if heading.is_empty() {
        return None;
    }
    let text = prose(&read(&target));
    let found = text.lines().filter(|line| line.starts_with('#')).any(|line| anchor(line) == heading);
    (!found).then(|| format!("{}: `{link}` names no heading", page.display()))
}

#[test]
fn every_relative_link_points_to_something() {
    let mut faults = Vec::new();
    let mut seen = 0;
    for page in pages() {
        let text = prose(&read(&page));
        let links = links(&text);
        seen += links.len();
        faults.extend(links.iter().filter_map(|link| fault(&page, link)));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen > 50, "only {seen} links were found: the search for them is broken");
}

#[test]
fn a_broken_link_is_seen() {
    let page = root().join("README.md");
    assert_eq!(links("see [a](b.md) and ![c](d/e.svg)"), ["b.md", "d/e.svg"]);
    assert_eq!(prose("a\n```\n[x](y)\n```\nb"), "a\nb");
    assert!(fault(&page, "no-such-file.md").is_some());
    assert!(fault(&page, "docs/README.md#no-such-heading").is_some());
    assert!(fault(&page, "docs/README.md#tutorial").is_none());
    assert!(fault(&page, "https://example.org/").is_none());
    assert_eq!(anchor("## Limits of the two-step way"), "limits-of-the-two-step-way");
}

#[test]
fn readme_names_the_two_commands() {
    let readme = read(&root().join("README.md"));
    for command in ["make demo", "make test"] {
        assert!(readme.lines().any(|line| line.starts_with(command)), "{command}");
    }
}

#[test]
fn the_page_of_metrics_is_the_table_of_definitions() {
    let page = read(&root().join("docs/metrics.md"));
    for d in definitions() {
        let row = format!("| {} | `{}` | {} | {} |", d.name, d.key, d.unit, d.meaning.replace('|', "\\|"));
        assert!(page.contains(&row), "docs/metrics.md lacks the row\n{row}");
    }
}
