//! Damping and friction of joints: laws of the simulation, and reported
//! wherever they are not used.

use crate::support::programs::{robovec_in, said, stderr};
use std::fs;

/// A pendulum with further properties of its joint.
fn pendulum(dynamics: &str) -> String {
    format!(
        "<robot name=\"bob\"><link name=\"base\"/><link name=\"bob\"><inertial>\
         <origin xyz=\"0.3 0 -0.4\"/><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" \
         izz=\"0.001\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
         <joint name=\"hinge\" type=\"continuous\"><parent link=\"base\"/><child link=\"bob\"/>\
         <axis xyz=\"0 1 0\"/>{dynamics}</joint></robot>"
    )
}

#[test]
fn losses_are_laws_of_the_joints() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("written");
    };
    write(
        "lossy.urdf",
        &pendulum("<dynamics damping=\"0.8\" friction=\"0.1\"/>"),
    );
    write("plain.urdf", &pendulum(""));
    write(
        "laws.toml",
        "[[joint]]\nname = \"hinge\"\ndamping = 0.8\nfriction = 0.1\n",
    );
    write("none.toml", "[[joint]]\nname = \"*\"\ndamping = 0.0\n");
    let run = |arguments: &str| {
        let words: Vec<&str> = arguments.split(' ').collect();
        robovec_in(folder.path(), &words)
    };
    let motion = |arguments: &str| {
        said(&run(&format!(
            "sim {arguments} --time=1 --samples=5 -o motion.csv"
        )));
        fs::read_to_string(folder.path().join("motion.csv")).expect("it was written")
    };
    let lossy = motion("lossy.urdf");
    assert_eq!(lossy, motion("plain.urdf --laws=laws.toml"));
    let plain = motion("plain.urdf");
    assert_ne!(lossy, plain);
    assert_eq!(plain, motion("lossy.urdf --laws=none.toml"));
    for command in [
        "gen lossy.urdf",
        "eval lossy.urdf --states=1",
        "explore lossy.urdf --elements=1 --states=8",
    ] {
        let output = run(command);
        let message = stderr(&output);
        assert!(output.status.success(), "{command}: {message}");
        assert!(
            message.contains("including 'hinge', are in no equation"),
            "{command}: {message}"
        );
        assert!(message.contains("'robovec sim'"), "{command}: {message}");
    }
    assert!(said(&run("model lossy.urdf")).contains("damping 0.8, friction 0.1"));
    let message = stderr(&run("model lossy.urdf -o lossy.mbs"));
    assert!(
        message.contains("damping, friction and springs of 1 joints are left out"),
        "{message}"
    );
    for (command, file) in [
        ("sim", "lossy.urdf"),
        ("model", "lossy.urdf"),
        ("gen", "plain.urdf"),
    ] {
        let message = stderr(&run(&format!("{command} {file}")));
        assert!(!message.contains("in no equation"), "{command}: {message}");
    }
}
