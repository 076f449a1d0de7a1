//! Placements that the instruction words cannot express, and the images of
//! one that they can.

use super::hand::{self, ADD0, MULTI0, word};
use super::{float, view};
use robovec::simulate::mif::Image;
use robovec_fpga::manifest::Manifest;
use robovec_fpga::{ImageError, images};
use robovec_ir::machine::BufferDescription;
use robovec_ir::placement::{Bank, BufferWord, Element, Placement, Preload, Schedule, Slot, Write};
use robovec_ir::{Function, Input, Level, Machine, Operand, Operation, Shape, Value};

fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships")
}

/// The error for the program placed by hand after a change.
fn refused(change: impl FnOnce(&mut Function, &mut Machine)) -> ImageError {
    let (mut module, mut machine) = (hand::module(), thesis());
    change(&mut module.functions[0], &mut machine);
    images(view(&module), &machine, None).expect_err("it must be refused")
}

fn placement(function: &mut Function) -> &mut Placement {
    function.placement.as_mut().expect("it is placed")
}

fn schedule(function: &mut Function) -> &mut Schedule {
    function.schedule.as_mut().expect("it is placed")
}

fn slot(function: &mut Function, node: usize) -> &mut Slot {
    let slot = &mut schedule(function).slots[node];
    slot.as_mut().expect("the machine computes it")
}

/// Adds a write of the last value.
fn add_write(function: &mut Function, write: Write) {
    let placement = placement(function);
    placement.writes.push(write);
    *placement.write_starts.last_mut().expect("an end") += 1;
}

#[test]
fn functions_of_another_level_or_machine() {
    let error = refused(|function, _| {
        function.placement = None;
        function.level = Level::Scheduled;
    });
    assert!(matches!(
        error,
        ImageError::NotPlaced {
            level: "scheduled",
            ..
        }
    ));
    let error = refused(|_, machine| "other".clone_into(&mut machine.name));
    assert!(matches!(error, ImageError::OtherMachine(_)));
    let error = refused(|function, _| "div".clone_into(&mut schedule(function).kinds[1].name));
    assert!(matches!(error, ImageError::UnknownKind { .. }));
    let error = refused(|function, _| schedule(function).kinds[1].count = u32::MAX);
    assert!(matches!(error, ImageError::UnknownKind { .. }));
    let error = refused(|function, _| function.node_mut(Value(1)).operation = Operation::Div);
    assert!(matches!(
        error,
        ImageError::CannotPerform {
            operation: "div",
            ..
        }
    ));
    let error = refused(|_, machine| machine.number = float(8, 63, true));
    assert!(matches!(error, ImageError::Number(_)));
}

#[test]
fn two_operations_in_one_pipeline_slot() {
    let error = refused(|function, _| slot(function, 2).cycle = 0);
    // The write at 30 is then late, but the slot is what cannot be expressed.
    let late = matches!(error, ImageError::NotBuffered { .. });
    assert!(late, "{error}");
    let error = refused(|function, _| {
        slot(function, 2).cycle = 0;
        placement(function).writes[3].cycle = 11;
    });
    assert!(
        matches!(error, ImageError::IssueTwice { cycle: 0, .. }),
        "{error}"
    );
}

#[test]
fn more_writes_than_ports() {
    let extra = |address| Write {
        word: word(ADD0, address),
        cycle: 30,
    };
    let error = refused(|function, _| {
        add_write(function, extra(5));
        add_write(function, extra(6));
    });
    let ImageError::WritePorts {
        memory,
        ports,
        cycle,
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((memory.as_str(), ports, cycle), ("add0", 2, 30));
}

#[test]
fn two_buffer_words_through_one_port() {
    let error = refused(|function, _| {
        // %y leaves multi0 at 18; a second value of multi0 does not exist, so
        // %z is moved there in time for both to be read in one cycle.
        let (cycle, element) = (13, Element::new(ADD0));
        *slot(function, 2) = Slot { cycle, element };
        let placement = placement(function);
        placement.buffers[2] = Some(BufferWord::new(1));
        placement.writes[1].cycle = 26;
        placement.writes[3].cycle = 26;
    });
    let ImageError::BufferPorts {
        element,
        ports,
        cycle,
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((element.as_str(), ports, cycle), ("add0", 1, 26));
}

#[test]
fn writes_at_the_wrong_time() {
    let error = refused(|function, _| placement(function).buffers[0] = None);
    assert!(matches!(error, ImageError::NotBuffered { cycle: 13, .. }));
    let error = refused(|_, machine| machine.buffer = None);
    assert!(matches!(error, ImageError::NotBuffered { .. }));
    let error = refused(|function, _| placement(function).writes[0].cycle = 10);
    assert!(matches!(
        error,
        ImageError::WriteTooEarly {
            cycle: 10,
            ready: 11,
            ..
        }
    ));
    let error = refused(|function, _| schedule(function).cycles = 30);
    assert!(matches!(error, ImageError::AfterEnd { cycle: 30, .. }));
    let error = refused(|function, _| {
        slot(function, 2).cycle = u32::MAX - 5;
        placement(function).writes[3].cycle = u32::MAX;
    });
    assert!(matches!(error, ImageError::AfterEnd { .. }), "{error}");
    // The last result goes nowhere but into a buffer, when all is over.
    let error = refused(|function, _| {
        function.assignments.remove(0);
        schedule(function).cycles = 30;
        let placement = placement(function);
        placement.homes.remove(0);
        placement.writes.pop();
        *placement.write_starts.last_mut().expect("an end") -= 1;
        placement.buffers[2] = Some(BufferWord::new(0));
    });
    assert!(
        matches!(error, ImageError::AfterEnd { cycle: 30, .. }),
        "{error}"
    );
}

#[test]
fn addresses_beyond_the_machine() {
    let error = refused(|_, machine| machine.memory.words = Some(4));
    assert!(matches!(
        error,
        ImageError::AddressRange {
            address: 4,
            words: 4,
            ..
        }
    ));
    let error = refused(|function, machine| {
        let (words, reads) = (Some(3), Some(1));
        machine.buffer = Some(BufferDescription { words, reads });
        placement(function).buffers[0] = Some(BufferWord::new(3));
    });
    assert!(matches!(
        error,
        ImageError::AddressRange {
            address: 3,
            words: 3,
            ..
        }
    ));
}

#[test]
fn initial_data_that_is_none() {
    let error = refused(|function, _| {
        let (word, operand) = (word(ADD0, 0), Input(1).into());
        placement(function).preloads.push(Preload { word, operand });
    });
    assert!(matches!(error, ImageError::PreloadTwice { address: 0, .. }));
    let error = refused(|function, _| {
        let (word, operand) = (word(ADD0, 9), Operand::from(Value(0)));
        placement(function).preloads.push(Preload { word, operand });
    });
    assert!(matches!(error, ImageError::Malformed { .. }));
    let error = refused(|function, _| {
        let (word, operand) = (word(ADD0, 9), function.constant(f64::NAN).into());
        placement(function).preloads.push(Preload { word, operand });
    });
    assert!(matches!(error, ImageError::Number(_)));
}

#[test]
fn inputs_without_number() {
    let error = refused(|function, _| {
        let name = function.inputs()[0].name;
        function.add_input(name, Shape::Matrix(1 << 15, 1 << 14));
    });
    assert!(matches!(error, ImageError::TooManyInputs { .. }));
}

#[test]
fn placements_that_do_not_fit_their_function() {
    let changes: [fn(&mut Function); 9] = [
        |function| placement(function).homes.truncate(1),
        |function| placement(function).write_starts[1] = 9,
        |function| placement(function).write_starts.truncate(1),
        |function| placement(function).reads.truncate(1),
        |function| placement(function).reads[1][1] = None,
        |function| slot(function, 0).element = Element::new(3),
        |function| placement(function).writes[0].word.element = Element::new(3),
        |function| placement(function).writes[0].word.bank = Bank::Left,
        |function| placement(function).homes[0] = Some(word(MULTI0, 1)),
    ];
    for (number, change) in changes.into_iter().enumerate() {
        let error = refused(|function, _| change(function));
        assert!(
            matches!(error, ImageError::Malformed { .. }),
            "{number}: {error}"
        );
    }
}

/// The format is an interface: every change of it must change the snapshot.
#[test]
fn images_of_the_program_placed_by_hand() {
    let files = images(view(&hand::module()), &thesis(), None).expect("it has images");
    let mut text = String::new();
    for (name, content) in files {
        text.push_str(&format!("==== {name}\n{content}"));
    }
    insta::assert_snapshot!(text);
}

/// With input values every word that the manifest binds is in the data images.
#[test]
fn data_images_of_an_input_vector() {
    let machine = Machine::built_in("side-split").expect("it ships");
    let module = super::random_placed(5, 40, &machine);
    let inputs = [0.5, -1.0, 0.1, 2.0, 3.5];
    let files = images(view(&module), &machine, Some(&inputs)).expect("it has images");
    let file = |name: &str| {
        &files
            .iter()
            .find(|(known, _)| known == name)
            .expect("a file")
            .1
    };
    let manifest: Manifest =
        serde_json::from_str(file("random.manifest.json")).expect("it is a manifest");
    let memories: Vec<_> = manifest.elements.iter().flat_map(|e| &e.memories).collect();
    let mut expected = Vec::new();
    for (element, &number) in manifest.inputs.iter().zip(&inputs) {
        expected.extend(element.words.iter().map(|word| (word, number as f32)));
    }
    for constant in &manifest.constants {
        let number: f64 = constant.value.parse().expect("a number");
        expected.extend(constant.words.iter().map(|word| (word, number as f32)));
    }
    for (host, argument) in manifest.host.iter().zip([inputs[0], inputs[3]]) {
        let number = match host.operation.as_str() {
            "sin" => argument.sin(),
            _ => argument.cos(),
        };
        let words = host.words.iter();
        expected.extend(words.map(|word| (word, number as f32)));
    }
    assert!(expected.len() > 10);
    for (word, number) in expected {
        let memory = memories.iter().find(|memory| memory.name == word.memory);
        let image = Image::parse(file(&memory.expect("a memory").file)).expect("an image");
        assert_eq!(image.word(word.address), [u64::from(number.to_bits())]);
    }
    let error = images(view(&module), &machine, Some(&inputs[1..])).expect_err("one is missing");
    assert!(matches!(
        error,
        ImageError::InputCount {
            expected: 5,
            given: 4
        }
    ));
}
