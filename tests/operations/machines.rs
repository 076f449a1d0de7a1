//! Machines known by their content, and placed text edited by hand.

use super::{folder, placed, read, refused, write};
use crate::support::programs::{opt_in, robovec_in, said};
use std::path::Path;

const SHIPPED: &str = include_str!("../../machines/thesis.toml");

/// A machine file with the name of the thesis' and adders of other stages.
fn copied_machine(folder: &Path) {
    let text = SHIPPED.replacen("stages = 10", "stages = 9", 1);
    assert_ne!(text, SHIPPED, "the file has such a line");
    write(&folder.join("copy.toml"), &text);
}

#[test]
fn a_copy_of_a_machine_with_its_name_is_another_machine() {
    let folder = folder();
    copied_machine(folder.path());
    let at = |name: &str| folder.path().join(name);
    let place = [
        "blend.rvir",
        "-passes=place",
        "--machine",
        "copy.toml",
        "-o",
        "placed.rvir",
    ];
    said(&opt_in(folder.path(), &place));
    assert!(read(&at("placed.rvir")).contains("schedule \"thesis\" (hash \""));
    for more in [
        &["-passes=asap-alap"][..],
        &["-passes=codegen{target=mif}", "-o", "images"],
        &["--simulate"],
    ] {
        let arguments = [&["placed.rvir"][..], more].concat();
        let message = refused(&opt_in(folder.path(), &arguments));
        assert!(message.contains("placed.rvir:"), "{message}");
        assert!(message.contains("hash"), "{message}");
        assert!(message.contains("place the program again"), "{message}");
        said(&opt_in(
            folder.path(),
            &[&arguments[..], &["--machine", "copy.toml"]].concat(),
        ));
    }
    let message = refused(&robovec_in(
        folder.path(),
        &["rtl", "placed.rvir", "-o", "hardware"],
    ));
    assert!(message.contains("placed.rvir:"), "{message}");
    assert!(!at("hardware").exists());
    // Anew, as the advice says, and under another name for the same content.
    said(&opt_in(
        folder.path(),
        &["placed.rvir", "-passes=place", "--simulate"],
    ));
    let renamed = read(&at("copy.toml")).replace("name = \"thesis\"", "name = \"mine\"");
    write(&at("mine.toml"), &renamed);
    said(&opt_in(
        folder.path(),
        &["placed.rvir", "--simulate", "--machine", "mine.toml"],
    ));
    // The images know it as well.
    let simulate = ["rtl", "simulate", "images", "--inputs", "2,3"];
    let message = refused(&robovec_in(folder.path(), &simulate));
    assert!(message.contains("machine with hash"), "{message}");
    let simulate = [&simulate[..], &["--machine", "copy.toml"]].concat();
    assert_eq!(said(&robovec_in(folder.path(), &simulate)), "M = 11.0\n");
}

#[test]
fn text_without_a_hash_stands_for_the_machine_of_its_name() {
    let folder = placed();
    let at = |name: &str| folder.path().join(name);
    let text = read(&at("placed.rvir"));
    let start = text.find(" (hash \"").expect("it has one");
    let end = start + text[start..].find(')').expect("it is closed") + 1;
    let old = format!("{}{}", &text[..start], &text[end..]);
    write(&at("old.rvir"), &old);
    said(&opt_in(folder.path(), &["old.rvir", "--simulate"]));
    assert_eq!(
        said(&opt_in(folder.path(), &["old.rvir"])),
        old,
        "nothing is made up"
    );
    let message = refused(&opt_in(
        folder.path(),
        &["old.rvir", "--simulate", "--machine", "fused"],
    ));
    assert!(message.contains("not 'fused'"), "{message}");
    for (wrong, expected) in [
        ("(hash \"75dc\")", "sixteen hexadecimal digits"),
        (
            "(name \"75dc667cc87998a4\")",
            "is not a memory or processing element",
        ),
        ("(hash 75)", "not expected"),
    ] {
        let broken = format!("{} {wrong}{}", &text[..start], &text[end..]);
        write(&at("broken.rvir"), &broken);
        let message = refused(&opt_in(folder.path(), &["broken.rvir"]));
        assert!(message.contains(expected), "{message}");
        assert!(message.contains("broken.rvir:"), "{message}");
    }
}

#[test]
fn edited_placements_blame_the_file() {
    let folder = placed();
    let at = |name: &str| folder.path().join(name);
    let text = read(&at("placed.rvir"));
    let line = text
        .lines()
        .find(|line| line.contains("%s = "))
        .expect("it is there");
    let reads = line.find(" read ").expect("it reads");
    let cycle = line.find(" at ").expect("it starts");
    let early = format!("{} at 5{}", &line[..cycle], &line[reads..]);
    let other = line.replacen(" read ", " read 1", 1);
    for edited in [early, other] {
        assert_ne!(edited, line);
        write(&at("edited.rvir"), &text.replace(line, &edited));
        for more in [
            &["-passes=asap-alap"][..],
            &["-passes=asap-alap", "--check-each"],
            &["-passes=codegen{target=mif}", "-o", "images"],
            &["-passes=codegen{target=rtl}", "-o", "images"],
            &["-passes=codegen{target=c}", "-o", "images"],
            &["--simulate"],
        ] {
            let message = refused(&opt_in(
                folder.path(),
                &[&["edited.rvir"][..], more].concat(),
            ));
            assert!(message.contains("edited.rvir:"), "{message}");
            assert!(message.contains("%s"), "{message}");
            assert!(message.contains('^'), "{message}");
            assert!(!at("images").exists());
        }
        let message = refused(&robovec_in(
            folder.path(),
            &["rtl", "edited.rvir", "-o", "images"],
        ));
        assert!(
            message.contains("edited.rvir:") && message.contains('^'),
            "{message}"
        );
        said(&opt_in(
            folder.path(),
            &["edited.rvir", "-passes=place", "--simulate"],
        ));
    }
}
