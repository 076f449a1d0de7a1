//! Permissions, links and leftovers.

use super::{PROGRAM, folder, read, write};
use crate::support::programs::{opt_in, said};
use std::fs;

#[cfg(unix)]
#[test]
fn new_files_have_what_the_mask_leaves_and_old_ones_keep_their_mode() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mode = |name: &str| fs::metadata(at(name)).expect("it is there").mode() & 0o7777;
    for (mask, expected) in [
        ("022", 0o644),
        ("027", 0o640),
        ("077", 0o600),
        ("002", 0o664),
    ] {
        let _ = fs::remove_file(at("new.rvir"));
        let script = format!("umask {mask}; exec \"$0\" blend.rvir -o new.rvir");
        let run = std::process::Command::new("sh")
            .current_dir(folder.path())
            .args(["-c", &script, env!("CARGO_BIN_EXE_robovec-opt")])
            .output()
            .expect("there is a shell");
        said(&run);
        assert_eq!(mode("new.rvir"), expected, "{mask}");
    }
    for kept in [0o600, 0o755, 0o664] {
        let permissions = fs::Permissions::from_mode(kept);
        fs::set_permissions(at("new.rvir"), permissions).expect("it is ours");
        said(&opt_in(folder.path(), &["blend.rvir", "-o", "new.rvir"]));
        assert_eq!(mode("new.rvir"), kept);
    }
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_its_target_is_written() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("there")).expect("made");
    symlink("there/target.rvir", at("link.rvir")).expect("made");
    // Once to nothing, as compilers do, and once to what is there.
    for _ in 0..2 {
        said(&opt_in(folder.path(), &["blend.rvir", "-o", "link.rvir"]));
        assert!(
            fs::symlink_metadata(at("link.rvir"))
                .expect("it is there")
                .is_symlink()
        );
        assert_eq!(read(&at("there/target.rvir")), PROGRAM);
    }
    let names = |name: &str| fs::read_dir(at(name)).expect("a folder").count();
    assert_eq!(names("there"), 1, "nothing else is left there");
}

#[cfg(unix)]
#[test]
fn the_doors_of_the_system_stay_what_they_are() {
    let folder = folder();
    let run = opt_in(folder.path(), &["blend.rvir", "-o", "/dev/stdout"]);
    assert_eq!(said(&run), PROGRAM);
    assert_eq!(
        said(&opt_in(folder.path(), &["blend.rvir", "-o", "/dev/null"])),
        ""
    );
    let null = fs::metadata("/dev/null").expect("it is there");
    assert!(!null.is_file());
}

#[test]
fn leftovers_of_a_killed_run_go() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    write(&at(".robovec-Ab3dEf9hIj.part"), "half a file");
    write(&at(".robovec-notes.txt"), "somebody's");
    write(&at("robovec-notes.part"), "somebody's");
    let held = fs::File::create(at(".robovec-9876543210.part")).expect("made");
    held.lock().expect("it is ours");
    said(&opt_in(folder.path(), &["blend.rvir", "-o", "new.rvir"]));
    assert!(!at(".robovec-Ab3dEf9hIj.part").exists());
    for kept in [
        ".robovec-notes.txt",
        "robovec-notes.part",
        ".robovec-9876543210.part",
    ] {
        assert!(at(kept).exists(), "{kept}");
    }
}
