//! Every hazard, planted into the images of the program placed by hand.

use super::hand::Edited;
use robovec::simulate::Hazard;

fn add0() -> String {
    "add0".to_owned()
}

fn multi0() -> String {
    "multi0".to_owned()
}

#[test]
fn the_program_itself_runs() {
    let outputs = Edited::new().load().expect("fine").run(&[1.5, 0.25]);
    let outputs = outputs.expect("no hazard");
    assert_eq!(outputs.values, [1.75 - 1.75 * 0.25, 1.75 * 0.25]);
    assert_eq!(outputs.cycles, 31);
}

#[test]
fn wrong_number_of_inputs() {
    let program = Edited::new().load().expect("fine");
    let (expected, given) = (2, 3);
    let hazard = program.run(&[0.0; 3]).expect_err("three are given");
    assert_eq!(hazard, Hazard::InputCount { expected, given });
}

#[test]
fn read_in_the_cycle_of_the_write() {
    let mut images = Edited::new();
    images.set("multi0", 11, "issue", 1);
    images.set("multi0", 11, "read.left", 1);
    let hazard = Hazard::UninitialisedRead {
        cycle: 11,
        element: multi0(),
        memory: multi0(),
        address: 1,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn read_of_a_word_without_initial_data() {
    let mut images = Edited::new();
    images.manifest.inputs[1].words.clear();
    let hazard = Hazard::UninitialisedRead {
        cycle: 0,
        element: add0(),
        memory: add0(),
        address: 1,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn buffer_read_without_a_value() {
    let mut images = Edited::new();
    images.clear("add0", 11, &["buffer.write.enable"]);
    let hazard = Hazard::UninitialisedBufferRead {
        cycle: 13,
        element: add0(),
        word: 0,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn buffer_read_in_the_cycle_of_the_write() {
    let mut images = Edited::new();
    images.set("multi1", 11, "write0.enable", 1);
    images.set("multi1", 11, "write0.select", 3);
    let hazard = Hazard::UninitialisedBufferRead {
        cycle: 11,
        element: add0(),
        word: 0,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn a_bus_without_a_result() {
    let mut images = Edited::new();
    images.set("multi0", 11, "write0.select", 2);
    let hazard = Hazard::NoResult {
        cycle: 11,
        memory: multi0(),
        element: "multi1".to_owned(),
    };
    assert_eq!(images.hazard(), hazard);
    let mut images = Edited::new();
    images.set("add0", 17, "write0.enable", 1);
    images.set("add0", 17, "write0.select", 1);
    let hazard = Hazard::NoResult {
        cycle: 17,
        memory: add0(),
        element: multi0(),
    };
    assert_eq!(
        images.hazard(),
        hazard,
        "a cycle before it leaves the pipeline"
    );
}

#[test]
fn buffer_write_without_a_result() {
    let mut images = Edited::new();
    images.set("add0", 12, "buffer.write.enable", 1);
    let hazard = Hazard::NoResultToBuffer {
        cycle: 12,
        element: add0(),
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn select_code_beyond_the_crossbar() {
    let mut images = Edited::new();
    images.set("add0", 18, "write0.select", 6);
    let hazard = Hazard::UnknownSource {
        cycle: 18,
        memory: add0(),
        select: 6,
        inputs: 6,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn operation_code_of_no_operation() {
    let mut images = Edited::new();
    images.manifest.elements[0].operations.pop();
    let hazard = Hazard::UnknownOperation {
        cycle: 19,
        element: add0(),
        code: 1,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn one_word_written_through_two_ports() {
    let mut images = Edited::new();
    images.set("multi0", 11, "write1.enable", 1);
    images.set("multi0", 11, "write1.address", 1);
    let hazard = Hazard::WrittenTwice {
        cycle: 11,
        memory: multi0(),
        address: 1,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn addresses_beyond_the_memory() {
    let range = |cycle, address| Hazard::AddressRange {
        cycle,
        memory: add0(),
        address,
        words: 5,
    };
    let mut images = Edited::new();
    images.set("add0", 19, "read.right", 5);
    assert_eq!(images.hazard(), range(19, 5));
    let mut images = Edited::new();
    images.set("add0", 30, "write0.address", 7);
    assert_eq!(images.hazard(), range(30, 7));
}

#[test]
fn buffer_words_beyond_the_buffer() {
    let overflow = |cycle| Hazard::BufferOverflow {
        cycle,
        element: add0(),
        word: 1,
        words: 1,
    };
    let mut images = Edited::new();
    images.set("add0", 11, "buffer.write.address", 1);
    assert_eq!(images.hazard(), overflow(11));
    let mut images = Edited::new();
    images.set("add0", 13, "buffer.read0.address", 1);
    assert_eq!(images.hazard(), overflow(13));
}

#[test]
fn a_value_overwritten_before_it_is_read() {
    let mut images = Edited::new();
    images.set("add0", 14, "write0.enable", 1);
    images.set("add0", 14, "write0.address", 2);
    images.set("add0", 14, "write0.select", 3);
    let hazard = Hazard::Lost {
        cycle: 14,
        memory: add0(),
        address: 2,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn a_buffered_value_overwritten_before_it_is_read() {
    let mut images = Edited::new();
    images.clear("add0", 13, &["write0.enable"]);
    images.set("add0", 19, "read.left", 3);
    images.set("add0", 30, "buffer.write.enable", 1);
    let hazard = Hazard::LostInBuffer {
        cycle: 30,
        element: add0(),
        word: 0,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn an_operation_that_does_not_finish() {
    let mut images = Edited::new();
    images.set("add0", 20, "issue", 1);
    let hazard = Hazard::StillRunning {
        cycles: 31,
        element: add0(),
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn an_output_written_elsewhere() {
    let mut images = Edited::new();
    images.set("add0", 30, "write0.address", 0);
    let hazard = Hazard::OutputNotWritten {
        output: "out[1]".to_owned(),
        memory: add0(),
        address: 4,
        expected: 30,
    };
    assert_eq!(images.hazard(), hazard);
}

#[test]
fn an_output_overwritten_before_the_end() {
    let mut images = Edited::new();
    images.set("add0", 20, "write0.enable", 1);
    images.set("add0", 20, "write0.address", 3);
    images.set("add0", 20, "write0.select", 3);
    let hazard = Hazard::OutputOverwritten {
        output: "out[2]".to_owned(),
        memory: add0(),
        address: 3,
        cycle: 20,
    };
    assert_eq!(images.hazard(), hazard);
}
