//! The simulator against the evaluator, on placed programs, and against
//! images with planted errors.

mod hand;
mod hazards;
mod loading;
pub(crate) mod naive;
mod refusals;
mod rooms;
mod trace;

use robovec::simulate::LoadedProgram;
use robovec_fpga::images;
use robovec_framework::manager::{self, Config};
use robovec_ir::evaluate::evaluate_mixed;
use robovec_ir::machine::Interconnect;
use robovec_ir::{Format, Machine, Module, View};
use robovec_num::NumberFormat;
use robovec_num::random::Random;
use robovec_num::soft_float::FormatArithmetic;
use robovec_passes::registry::REGISTRY;
use robovec_schedule::{ElementChoice, PlaceOptions, place};

/// A floating-point format.
fn float(exponent: u32, mantissa: u32, subnormals: bool) -> Format {
    Format::Float(NumberFormat {
        exponent,
        mantissa,
        subnormals,
    })
}

fn view(module: &Module) -> View<'_> {
    View {
        tables: &module.tables,
        function: &module.functions[0],
    }
}

fn random_placed(seed: u64, operations: usize, machine: &Machine) -> Module {
    let mut random = Random::new(seed);
    let mut module = naive::random_function(&mut random, operations, machine);
    naive::place(&mut module.functions[0], machine, &mut random);
    module
}

/// The simulator's outputs must be the evaluator's, bit for bit.
fn check(module: &Module, machine: &Machine, inputs: &[f64]) -> LoadedProgram {
    let function = &module.functions[0];
    let files = images(view(module), machine, None).expect("it has images");
    let program = LoadedProgram::load(&files, machine).expect("they can be loaded");
    let outputs = program.run(inputs).expect("no hazard");
    let values = &outputs.values;
    assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
    let arithmetic = FormatArithmetic::new(machine.number);
    let expected = evaluate_mixed(function, machine.number, inputs);
    let words: Vec<u64> = expected.iter().map(|&n| arithmetic.word(n)).collect();
    assert_eq!(outputs.words, words);
    for (&number, &word) in outputs.values.iter().zip(&outputs.words) {
        match machine.number {
            Format::BINARY32 => assert_eq!(u64::from((number as f32).to_bits()), word),
            Format::BINARY64 => assert_eq!(number.to_bits(), word),
            _ => assert!(word >> machine.number.width() == 0),
        }
    }
    program
}

#[test]
fn random_programs_give_the_evaluators_bits_on_every_machine() {
    for (name, _) in robovec_ir::machine::BUILT_IN {
        let mut machine = Machine::built_in(name).expect("it ships");
        // The random placement writes late, and images are for crossbars.
        if machine.interconnect != Interconnect::Crossbar || machine.buffer.is_none() {
            continue;
        }
        for seed in 0..6 {
            let format = [
                "f32",
                "f64",
                "float(8,17)",
                "float(11,51,flush)",
                "fixed(20,30)",
                "float(9,38)",
            ][seed as usize];
            machine.number = format.parse().expect("a format");
            for (element, count) in machine.elements.iter_mut().zip([1 + seed % 4, 3]) {
                element.count = count as u32;
            }
            let module = random_placed(seed, 60, &machine);
            let mut random = Random::new(seed + 100);
            let inputs: Vec<f64> = (0..5).map(|_| naive::number(&mut random)).collect();
            check(&module, &machine, &inputs);
        }
    }
}

/// The real placement on the machines and numbers of elements that matter.
#[test]
fn placed_programs_give_the_evaluators_bits() {
    let mut buffered = 0;
    for name in [
        "thesis",
        "side-split",
        "ideal",
        "de10-nano",
        "pipeline-3-3",
        "fused",
        "bufferless",
        "bufferless-split",
        "four-port",
    ] {
        for count in [1, 2, 3, 4, 8, 16, 32] {
            let mut machine = Machine::built_in(name).expect("it ships");
            for element in &mut machine.elements {
                element.count = count;
            }
            for choice in [ElementChoice::First, ElementChoice::Preferential] {
                let seed = u64::from(count)
                    + if choice == ElementChoice::First {
                        100
                    } else {
                        0
                    };
                let mut module = naive::random_function(&mut Random::new(seed), 400, &machine);
                let options = PlaceOptions {
                    choice,
                    ..PlaceOptions::default()
                };
                let placed = place(&mut module.functions[0], &machine, options);
                placed.unwrap_or_else(|error| panic!("{name} {count}: {error}"));
                let mut random = Random::new(seed + 1);
                let inputs: Vec<f64> = (0..5).map(|_| naive::number(&mut random)).collect();
                check(&module, &machine, &inputs);
                let placement = module.functions[0].placement.as_ref();
                let buffers = placement.map(|placement| &placement.buffers);
                buffered += buffers.into_iter().flatten().flatten().count();
            }
        }
    }
    assert!(buffered > 0, "buffers were in use");
}

/// Interleaved instances give the results of a single one, each from its own
/// inputs.
#[test]
fn interleaved_programs_give_the_bits_of_every_instance() {
    const COUNT: usize = 3;
    for name in ["thesis", "bufferless-split", "four-port"] {
        let machine = Machine::built_in(name).expect("it ships");
        let original = naive::random_function(&mut Random::new(7), 150, &machine);
        let mut module = original.clone();
        let pipeline = REGISTRY
            .pipeline("interleave{instances=3},place")
            .expect("well formed");
        let mut log = Vec::new();
        let config = Config {
            check_each: Some(2),
            ..Config::new(&machine, &mut log)
        };
        manager::run(&mut module, &pipeline, config).expect("it is placed and checked");
        let mut random = Random::new(8);
        let inputs: Vec<f64> = (0..5 * COUNT).map(|_| naive::number(&mut random)).collect();
        let program = check(&module, &machine, &inputs);
        let words = program.run(&inputs).expect("no hazard").words;
        let arithmetic = FormatArithmetic::new(machine.number);
        let outputs = words.len() / COUNT;
        for (instance, words) in words.chunks(outputs).enumerate() {
            let own = &inputs[5 * instance..5 * (instance + 1)];
            let function = &original.functions[0];
            let alone = evaluate_mixed(function, machine.number, own);
            let alone: Vec<u64> = alone.iter().map(|&n| arithmetic.word(n)).collect();
            assert_eq!(words, alone, "{name}, instance {instance}");
        }
    }
}

/// A machine without subnormal numbers holds none: inputs and products that
/// small become zeros of their sign.
#[test]
fn machines_without_subnormal_numbers_flush() {
    let mut machine = Machine::built_in("thesis").expect("it ships");
    let module = hand::module();
    let run = |machine: &Machine, inputs: &[f64]| {
        let files = images(view(&module), machine, None).expect("it has images");
        let program = LoadedProgram::load(&files, machine).expect("they can be loaded");
        program.run(inputs).expect("no hazard").values
    };
    // (a + b)*b is 2e-40, below the least normal binary32 number.
    let inputs = [1e-20, -2e-20];
    assert_eq!(
        run(&machine, &inputs)[1],
        f64::from(-1e-20_f32 * -2e-20_f32)
    );
    assert!(run(&machine, &inputs)[1] > 0.0);
    machine.number = float(8, 23, false);
    let flushed = run(&machine, &inputs);
    assert_eq!(flushed[1], 0.0);
    assert_eq!(flushed[0], f64::from(1e-20_f32 - 2e-20_f32));
    // A subnormal input is a zero: the sum is b itself.
    let sum = |machine: &Machine| run(machine, &[1e-39, 2e-38])[0];
    assert_eq!(sum(&machine), f64::from(2e-38_f32));
    machine.number = float(8, 23, true);
    assert!(sum(&machine) > f64::from(2e-38_f32));
}
