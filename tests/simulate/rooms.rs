//! Places of words: fields across the limbs of an instruction, inputs that are
//! outputs, buffer words that change hands.

use super::{check, random_placed, view};
use robovec_fpga::images;
use robovec_ir::machine::BufferDescription;
use robovec_ir::parse::parse_module;
use robovec_ir::{Machine, Module};

fn placed(text: &str) -> Module {
    parse_module("placed", text).expect("it is well formed")
}

#[test]
fn fields_across_limbs_arrive_whole() {
    let mut straddling = 0;
    for count in 1..=5 {
        let mut machine = Machine::built_in("thesis").expect("it ships");
        for element in &mut machine.elements {
            element.count = count;
        }
        // Addresses of 10 to 16 bits move the fields behind them across the
        // end of the first 64 bits.
        for bits in 10..=16u32 {
            machine.memory.words = Some(1 << bits);
            let module = random_placed(u64::from(bits), 60, &machine);
            let inputs = vec![0.5; module.functions[0].input_len()];
            check(&module, &machine, &inputs);
            let files = images(view(&module), &machine, None).expect("it has images");
            let (_, manifest) = files.last().expect("the manifest");
            let manifest: robovec_fpga::manifest::Manifest =
                serde_json::from_str(manifest).expect("it is JSON");
            let fields = manifest
                .elements
                .iter()
                .flat_map(|e| &e.instructions.fields);
            straddling += fields
                .filter(|field| field.low < 64 && field.low + field.width > 64)
                .filter(|field| field.name.ends_with("select"))
                .count();
        }
    }
    assert!(straddling > 5, "only {straddling} selects cross a limb");
}

#[test]
fn an_input_that_is_an_output_is_rounded() {
    let module = placed(
        "function f placed {
          in a
          out o[1..2]
          schedule \"thesis\" add*1 multi*1 cycles 12 bound 1
          preload add0[0] = a
          %s = a + a on add0 at 0 read 0 0 write add0[1] at 11
          o[1] = %s in add0[1]
          o[2] = a
        }",
    );
    let machine = Machine::built_in("thesis").expect("it ships");
    check(&module, &machine, &[0.1]);
}

#[test]
fn an_output_is_what_its_last_write_left() {
    let module = placed(
        "function f placed {
          in a
          out o[1..2]
          schedule \"thesis\" add*1 multi*1 cycles 24 bound 1
          preload add0[0] = a
          %x = a + a on add0 at 0 read 0 0 buffer 0 write add0[1] at 11, add0[1] at 13
          %y = %x - a on add0 at 12 read 1 0 write add0[2] at 23
          o[1] = %x in add0[1]
          o[2] = %y in add0[2]
        }",
    );
    let machine = Machine::built_in("thesis").expect("it ships");
    check(&module, &machine, &[0.75]);
}

#[test]
fn two_ports_of_a_buffer_show_two_words() {
    let module = placed(
        "function f placed {
          in a
          out o[1..2]
          schedule \"thesis\" add*1 multi*1 cycles 20 bound 1
          preload add0[0] = a
          %x = a + a on add0 at 0 read 0 0 buffer 0 write add0[1] at 15
          %y = a - a on add0 at 1 read 0 0 buffer 1 write add0[2] at 15
          o[1] = %x in add0[1]
          o[2] = %y in add0[2]
        }",
    );
    let mut machine = Machine::built_in("thesis").expect("it ships");
    machine.buffer = Some(BufferDescription {
        words: None,
        reads: Some(2),
    });
    check(&module, &machine, &[0.75]);
}

#[test]
fn values_in_formats_of_their_own_have_no_images() {
    let module = placed(
        "function f placed {
          in a
          out o
          schedule \"thesis\" add*1 multi*1 cycles 12 bound 1
          preload add0[0] = a
          %s = a + a as f16 on add0 at 0 read 0 0 write add0[1] at 11
          o = %s in add0[1]
        }",
    );
    let machine = Machine::built_in("thesis").expect("it ships");
    assert!(images(view(&module), &machine, None).is_err());
}
