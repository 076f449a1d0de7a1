//! The documents as a book: `docs/SUMMARY.md` lists every page once, and every
//! link leads somewhere.

use crate::packages::{crates, sources};
use crate::support::files::{list, name, tree};
use std::fs;
use std::path::Path;

/// Lines of a Markdown text that are not in fences.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    text.lines().filter(move |line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Addresses of the links of a Markdown text.
fn links(text: &str) -> Vec<&str> {
    let rests = prose(text).flat_map(|line| line.split("](").skip(1));
    rests.filter_map(|rest| rest.split(')').next()).collect()
}

/// Anchors of the headings of a Markdown text.
fn anchors(text: &str) -> Vec<String> {
    let titles = prose(text).filter_map(|line| line.trim_start_matches('#').strip_prefix(' '));
    let anchor = |title: &str| {
        let is_kept = |letter: &char| letter.is_alphanumeric() || "-_".contains(*letter);
        let title = title.to_lowercase().replace(' ', "-");
        title.chars().filter(is_kept).collect()
    };
    titles.map(anchor).collect()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).expect("a readable document")
}

#[test]
fn every_page_is_in_the_book_once() {
    let summary = read(&tree("docs/SUMMARY.md"));
    let mut listed = links(&summary);
    listed.sort_unstable();
    let mut pages: Vec<String> = list("docs", &["md"])
        .iter()
        .map(|path| name(path))
        .collect();
    pages.retain(|page| page != "SUMMARY.md");
    assert_eq!(listed, pages);
}

#[test]
fn every_link_of_the_documents_resolves() {
    let (mut count, mut broken) = (0, Vec::new());
    let pages = list("docs", &["md"]);
    for path in list("", &["md"]).iter().chain(&pages) {
        let text = read(path);
        let is_page = pages.contains(path);
        for link in links(&text) {
            if link.starts_with("https://") {
                continue;
            }
            count += 1;
            let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
            // A page of the book finds nothing outside of it.
            let leaves = is_page && target.contains('/');
            let target = match target {
                "" => path.clone(),
                _ => path.with_file_name(target),
            };
            let is_there = if anchor.is_empty() {
                target.exists()
            } else {
                target.is_file() && anchors(&read(&target)).iter().any(|one| one == anchor)
            };
            if leaves || !is_there {
                broken.push(format!("{}: {link}", name(path)));
            }
        }
    }
    assert!(count > 200, "{count} links");
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn sources_name_pages_that_are_there() {
    let (mut count, mut missing) = (0, Vec::new());
    for path in crates().iter().flat_map(|folder| sources(folder)) {
        for rest in read(&path).split("docs/").skip(1) {
            let is_part = |letter: &char| letter.is_ascii_lowercase() || *letter == '-';
            let page: String = rest.chars().take_while(is_part).collect();
            if rest[page.len()..].starts_with(".md") {
                count += 1;
                if !tree(&format!("docs/{page}.md")).is_file() {
                    missing.push(format!("{}: docs/{page}.md", path.display()));
                }
            }
        }
    }
    assert!(count > 20, "{count} names of pages");
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn results_begin_with_their_origin() {
    let words = ["**Date** ", "**revision** ", "**machine** ", "**command** "];
    let mut count = 0;
    for path in list("docs", &["md"]) {
        if name(&path).starts_with("results-") {
            for section in read(&path).split("\n## ").skip(1) {
                let origin = section.lines().nth(2).unwrap_or_default();
                let is_whole = words.iter().all(|word| origin.contains(word));
                assert!(is_whole, "{}: {section:.60}", name(&path));
                count += 1;
            }
        }
    }
    assert!(count > 30, "{count} results");
}
