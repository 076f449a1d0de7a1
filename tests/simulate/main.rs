//! The simulator against the evaluator, on placed programs, and against
//! images with planted errors.

mod hand;
mod hazards;
mod loading;
mod naive;

use naive::Random;
use robovec::simulate::Program;
use robovec_ir::arithmetic::{Binary32, Binary64};
use robovec_ir::evaluate::evaluate;
use robovec_ir::{Machine, Module, View};
use robovec_passes::codegen::images;

fn view(module: &Module) -> View<'_> {
    View {
        tables: &module.tables,
        function: &module.functions[0],
    }
}

fn random_placed(seed: u64, operations: usize, machine: &Machine) -> Module {
    let mut random = Random(seed);
    let mut module = naive::random_function(&mut random, operations);
    naive::place(&mut module.functions[0], machine, &mut random);
    module
}

/// The simulator's outputs must be the evaluator's, bit for bit.
fn check(module: &Module, machine: &Machine, inputs: &[f64]) {
    let function = &module.functions[0];
    let files = images(view(module), machine, None).expect("it has images");
    let program = Program::load(&files, machine).expect("they can be loaded");
    let outputs = program.run(inputs).expect("no hazard");
    if machine.number.exponent == 8 {
        let inputs: Vec<f32> = inputs.iter().map(|&number| number as f32).collect();
        let expected = evaluate(function, &Binary32, &inputs);
        let words: Vec<u64> = expected.iter().map(|n| u64::from(n.to_bits())).collect();
        assert_eq!(outputs.words, words);
    } else {
        let expected = evaluate(function, &Binary64, inputs);
        let words: Vec<u64> = expected.iter().map(|n| n.to_bits()).collect();
        assert_eq!(outputs.words, words);
    }
}

#[test]
fn random_programs_give_the_evaluators_bits_on_every_machine() {
    for (name, _) in robovec_ir::machine::BUILT_IN {
        let mut machine = Machine::built_in(name).expect("it ships");
        for seed in 0..6 {
            machine.number.exponent = 8;
            machine.number.mantissa = 23;
            if seed % 2 == 1 {
                machine.number.exponent = 11;
                machine.number.mantissa = 52;
            }
            for (element, count) in machine.elements.iter_mut().zip([1 + seed % 4, 3]) {
                element.count = count as u32;
            }
            let module = random_placed(seed, 60, &machine);
            let mut random = Random(seed + 100);
            let inputs: Vec<f64> = (0..5).map(|_| random.number()).collect();
            check(&module, &machine, &inputs);
        }
    }
}
