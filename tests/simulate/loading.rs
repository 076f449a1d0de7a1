//! Images that must not be loaded.

use super::float;
use super::hand::{Edited, mif};
use robovec::simulate::mif::Image;
use robovec::simulate::{LoadError, LoadedProgram};
use robovec_fpga::manifest::{HostElement, ValueReference};
use robovec_ir::Machine;
use robovec_ir::machine::{BufferDescription, MemoryStyle};
use robovec_num::fnv::Fnv;

fn refused(change: impl FnOnce(&mut Edited)) -> LoadError {
    let mut images = Edited::new();
    change(&mut images);
    images.load().expect_err("it must be refused")
}

#[test]
fn files_that_are_not_there() {
    let images = Edited::new();
    let load = |files: &[(String, String)]| LoadedProgram::load(files, &images.machine);
    assert_eq!(load(&[]).expect_err("nothing"), LoadError::NoManifest);
    let missing = load(&images.files[1..]).expect_err("one is missing");
    let file = "hand.add0.instructions.mif".to_owned();
    assert_eq!(missing, LoadError::NoFile(file));
    let mut files = images.files.clone();
    files.push(("out/other.manifest.json".to_owned(), String::new()));
    assert!(matches!(
        load(&files),
        Err(LoadError::SeveralManifests(_, _))
    ));
}

#[test]
fn directories_before_file_names_do_not_matter() {
    let images = Edited::new();
    let mut files = images.files.clone();
    for (name, _) in &mut files {
        name.insert_str(0, "some/where/");
    }
    assert!(LoadedProgram::load(&files, &images.machine).is_ok());
}

#[test]
fn manifests_that_are_none() {
    let images = Edited::new();
    let load = |text: &str| {
        let files = [("manifest.json".to_owned(), text.to_owned())];
        LoadedProgram::load(&files, &images.machine).expect_err("no manifest")
    };
    assert!(matches!(load("{"), LoadError::Manifest { .. }));
    assert!(matches!(
        load("{\"format\": 2}"),
        LoadError::Manifest { .. }
    ));
    // The first version did not tell the hash of every file.
    for (found, expected) in [(99, 2), (1, 2)] {
        assert_eq!(
            load(&format!("{{\"format\": {found}}}")),
            LoadError::Format { found, expected }
        );
    }
    let deep = "[".repeat(200_000);
    assert!(matches!(load(&deep), LoadError::Manifest { .. }));
}

#[test]
fn changed_images_and_other_machines() {
    let mut images = Edited::new();
    let mut machine = images.machine.clone();
    machine.clock_mhz = Some(1.0);
    machine.elements[0].count = 9;
    assert!(
        LoadedProgram::load(&images.files, &machine).is_ok(),
        "not of interest"
    );
    machine.elements[0].stages = 9;
    assert!(matches!(
        LoadedProgram::load(&images.files, &machine),
        Err(LoadError::OtherMachine { .. })
    ));
    images.set("add0", 1, "read.left", 1);
    assert!(matches!(
        LoadedProgram::load(&images.files, &images.machine),
        Err(LoadError::OtherFile { .. })
    ));
    // With the hash of the file set right, that of the schedule is wrong.
    let text = images.file("add0.instructions.mif").clone();
    let manifest = images.manifest.files.iter_mut();
    let mut named = manifest.filter(|one| one.file.ends_with("add0.instructions.mif"));
    named.next().expect("it is an image").hash = Fnv::of(text.as_bytes()).text();
    let manifest = serde_json::to_string(&images.manifest).expect("it is JSON");
    *images.file("manifest.json") = manifest;
    assert!(matches!(
        LoadedProgram::load(&images.files, &images.machine),
        Err(LoadError::OtherSchedule { .. })
    ));
}

#[test]
fn data_images_that_were_changed_are_refused() {
    for name in ["add0.data.mif", "multi0.data.mif", "multi1.data.mif"] {
        let mut images = Edited::new();
        images.file(name).push_str("-- the same words\n");
        let error = LoadedProgram::load(&images.files, &images.machine).expect_err(name);
        assert!(matches!(error, LoadError::OtherFile { .. }), "{error}");
        let mut images = Edited::new();
        images.files.retain(|(file, _)| !file.ends_with(name));
        let error = LoadedProgram::load(&images.files, &images.machine).expect_err(name);
        assert!(matches!(error, LoadError::NoFile(_)), "{error}");
    }
}

#[test]
fn more_ports_or_words_than_the_machine_has() {
    let error = refused(|images| images.manifest.elements[0].memories[0].write_ports = 3);
    let (memory, ports, allowed) = ("add0".to_owned(), 3, 2);
    assert_eq!(
        error,
        LoadError::WritePorts {
            memory,
            ports,
            allowed
        }
    );
    let error = refused(|images| {
        for element in &mut images.manifest.elements {
            element.buffer.as_mut().expect("a buffer").read_ports = 2;
        }
    });
    let (element, ports, allowed) = ("add0".to_owned(), 2, 1);
    assert_eq!(
        error,
        LoadError::BufferPorts {
            element,
            ports,
            allowed
        }
    );
    let error = refused(|images| images.machine.memory.words = Some(4));
    let (memory, words, allowed) = ("add0".to_owned(), 5, 4);
    assert_eq!(
        error,
        LoadError::Words {
            memory,
            words,
            allowed
        }
    );
    let error = refused(|images| {
        let (words, reads) = (Some(0), Some(1));
        images.machine.buffer = Some(BufferDescription { words, reads });
    });
    let (memory, words, allowed) = ("the buffer of add0".to_owned(), 1, 0);
    assert_eq!(
        error,
        LoadError::Words {
            memory,
            words,
            allowed
        }
    );
}

#[test]
fn machines_that_lack_something() {
    let of = |change: fn(&mut Machine)| refused(|images| change(&mut images.machine));
    let changes: [fn(&mut Machine); 5] = [
        |machine| machine.buffer = None,
        |machine| machine.memory.style = MemoryStyle::SideSplit,
        |machine| machine.elements.truncate(1),
        |machine| machine.elements[0].operations.truncate(1),
        |machine| machine.number = float(8, 23, false),
    ];
    for change in changes {
        assert!(matches!(of(change), LoadError::Machine(_)));
    }
}

#[test]
fn number_formats_that_nothing_computes_in() {
    let quad = float(15, 112, true);
    let error = refused(|images| images.manifest.number = quad);
    let LoadError::Manifest { message, .. } = error else {
        panic!("{error:?}");
    };
    assert!(message.contains("15 is not allowed"), "{message}");
}

#[test]
fn images_of_the_wrong_size() {
    let error = refused(|images| images.manifest.cycles = 32);
    assert!(matches!(
        error,
        LoadError::ImageSize {
            what: "depth",
            found: 31,
            expected: 32,
            ..
        }
    ));
    let error = refused(|images| images.manifest.elements[1].memories[0].words = 4);
    assert!(matches!(error, LoadError::ImageSize { what: "depth", .. }));
    let error = refused(|images| *images.file("add0.data.mif") = mif(64, &[0; 5]));
    assert!(matches!(error, LoadError::ImageSize { what: "width", .. }));
    let error = refused(|images| images.manifest.cycles = u32::MAX);
    assert!(matches!(error, LoadError::TooLarge(_)));
}

#[test]
fn instruction_words_with_holes() {
    let error = refused(|images| {
        images.manifest.elements[0]
            .instructions
            .fields
            .retain(|field| field.name != "issue");
    });
    let (element, cycle) = ("add0".to_owned(), 0);
    assert_eq!(error, LoadError::UndefinedBits { element, cycle });
    let error = refused(|images| {
        let text = images.file("add0.instructions.mif");
        let line = text
            .lines()
            .find(|line| line.contains(" 12 : "))
            .expect("cycle 18");
        *text = text.replace(line, "");
    });
    let (element, cycle) = ("add0".to_owned(), 18);
    assert_eq!(error, LoadError::UndefinedInstruction { element, cycle });
    let error = refused(|images| images.file("add0.instructions.mif").truncate(300));
    assert!(matches!(error, LoadError::Image { .. }));
}

#[test]
fn fields_that_overlap_or_leave_the_word() {
    let changes: [fn(&mut Edited); 5] = [
        // A port that nothing can switch on.
        |images| {
            let fields = &mut images.manifest.elements[0].instructions.fields;
            fields.retain(|field| field.name != "write0.enable");
        },
        |images| images.manifest.elements[0].instructions.fields[1].low = 0,
        |images| images.manifest.elements[0].instructions.fields[1].low = u32::MAX,
        |images| images.manifest.elements[0].instructions.fields[1].width = 0,
        |images| "op".clone_into(&mut images.manifest.elements[0].instructions.fields[1].name),
    ];
    for change in changes {
        assert!(matches!(refused(change), LoadError::Layout { .. }));
    }
}

#[test]
fn names_twice_and_references_into_the_void() {
    let error = refused(|images| "add0".clone_into(&mut images.manifest.elements[1].name));
    assert_eq!(
        error,
        LoadError::Sources,
        "the crossbar names the element too"
    );
    let error = refused(|images| {
        "add0".clone_into(&mut images.manifest.elements[1].memories[0].name);
    });
    assert_eq!(error, LoadError::NameTwice("add0".to_owned()));
    let error = refused(|images| images.manifest.inputs[0].words[0].address = 5);
    assert!(matches!(error, LoadError::Dangling { .. }));
    let error = refused(|images| "add9".clone_into(&mut images.manifest.inputs[0].words[0].memory));
    assert!(matches!(error, LoadError::Dangling { .. }));
    let error = refused(|images| images.manifest.inputs[0].words[0].address = 1);
    let (memory, address) = ("add0".to_owned(), 1);
    assert_eq!(error, LoadError::InitialTwice { memory, address });
}

#[test]
fn host_values_read_earlier_ones_only() {
    let value = |name: &str, operand| HostElement {
        name: name.to_owned(),
        operation: "sin".to_owned(),
        operands: vec![operand],
        words: Vec::new(),
    };
    let with = |operands: [ValueReference; 2]| {
        let mut images = Edited::new();
        let values = ["first", "second"].into_iter().zip(operands);
        images.manifest.host = values.map(|(name, operand)| value(name, operand)).collect();
        images.load()
    };
    assert!(with([ValueReference::Input(0), ValueReference::Host(0)]).is_ok());
    for later in [0, 1] {
        let error = with([ValueReference::Host(later), ValueReference::Input(0)]);
        let error = error.expect_err("it is not known yet");
        let user = "first".to_owned();
        let what = format!("earlier host value {later}");
        assert_eq!(error, LoadError::Dangling { user, what });
    }
}

#[test]
fn octal_digits_reach_into_the_next_limb() {
    let digits = format!("7{}", "0".repeat(21));
    let text =
        format!("WIDTH=70;DEPTH=1;ADDRESS_RADIX=HEX;DATA_RADIX=OCT;CONTENT BEGIN 0:{digits};END;");
    let image = Image::parse(&text).expect("it is an image");
    assert_eq!(image.word(0), [1 << 63, 3]);
}
