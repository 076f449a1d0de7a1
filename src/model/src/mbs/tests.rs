use super::*;
use crate::family::{random_tree, serial};

/// The model of a text, with the warnings as shown.
fn read(text: &str) -> (Model, String) {
    match read_mbs("test.mbs", text.as_bytes()) {
        Ok(read) => (read.model, read.warnings.render_plain()),
        Err(error) => panic!("{}", error.report.render_plain()),
    }
}

#[test]
fn what_is_written_is_read_back() {
    let chains = (1..6).map(|joints| serial(joints, 7));
    let trees = (0..300).map(|seed| random_tree(seed, 1 + seed as usize % 30));
    for model in chains.chain(trees) {
        let text = write_mbs(&model);
        let (again, warnings) = read(&text);
        assert_eq!(model, again, "{text}");
        assert_eq!(warnings, "");
        assert_eq!(write_mbs(&again), text);
    }
}
