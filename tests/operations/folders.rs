//! Folders of images and hardware that are complete, or visibly not.

use super::{folder, placed, read, refused, write};
use crate::support::programs::{opt_in, robovec_in, said};
use std::fs;
use std::path::Path;

/// The files of a folder whose names end so.
fn files(folder: &Path, end: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("readable").file_name());
    let mut names: Vec<String> = names
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    names.retain(|name| name.ends_with(end));
    names.sort();
    names
}

#[test]
fn images_that_differ_from_their_manifest_are_refused() {
    let folder = folder();
    let images = folder.path().join("images");
    let make = || {
        let passes = "-passes=place,codegen{target=mif}";
        said(&opt_in(
            folder.path(),
            &["blend.rvir", passes, "-o", "images"],
        ));
    };
    let simulate = || {
        robovec_in(
            folder.path(),
            &["rtl", "simulate", "images", "--inputs", "2,3"],
        )
    };
    make();
    assert_eq!(said(&simulate()), "M = 11.0\n");
    let all = files(&images, ".mif");
    assert!(all.len() > 10, "{all:?}");
    for name in &all {
        let path = images.join(name);
        let text = read(&path);
        // A remark changes no word, and still it is another file.
        write(&path, &format!("{text}-- a remark\n"));
        let message = refused(&simulate());
        assert!(
            message.contains(&format!("'{name}' was changed")),
            "{message}"
        );
        fs::remove_file(&path).expect("it is there");
        let message = refused(&simulate());
        assert!(message.contains(name), "{message}");
        write(&path, &text);
    }
    fs::remove_file(images.join("blend.manifest.json")).expect("it is there");
    let message = refused(&simulate());
    assert!(message.contains("not complete"), "{message}");
    make();
    assert_eq!(said(&simulate()), "M = 11.0\n");
}

#[test]
fn hardware_that_differs_from_its_description_is_refused() {
    let folder = placed();
    let at = |name: &str| folder.path().join(name);
    let build = || {
        said(&robovec_in(
            folder.path(),
            &["rtl", "placed.rvir", "-o", "hardware"],
        ))
    };
    build();
    let fits = |path: &str| robovec_in(folder.path(), &["rtl", "placed.rvir", "--fits", path]);
    said(&fits("hardware"));
    said(&fits("hardware/rtl/machine.json"));
    let names = files(&at("hardware/rtl"), "");
    for name in names.iter().filter(|name| *name != "machine.json") {
        let path = at("hardware/rtl").join(name);
        let text = read(&path);
        write(&path, &text.replacen('\n', "\n\n", 1));
        for named in ["hardware", "hardware/rtl", "hardware/rtl/machine.json"] {
            let message = refused(&fits(named));
            assert!(
                message.contains(&format!("'{name}' was changed")),
                "{message}"
            );
        }
        fs::remove_file(&path).expect("it is there");
        assert!(refused(&fits("hardware")).contains("missing"));
        write(&path, &text);
    }
    said(&fits("hardware"));
    // A description that is kept alone still describes.
    fs::copy(at("hardware/rtl/machine.json"), at("kept.json")).expect("copied");
    said(&fits("kept.json"));
    fs::remove_file(at("hardware/rtl/machine.json")).expect("it is there");
    for named in ["hardware", "hardware/rtl"] {
        let message = refused(&fits(named));
        assert!(message.contains("no complete hardware"), "{message}");
    }
    build();
    said(&fits("hardware"));
}
