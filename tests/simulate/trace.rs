//! Traces: every operation's result, in its cycle, on its element.

use super::{hand, naive, random_placed, view};
use robovec::simulate::{LoadedProgram, TracedResult};
use robovec_fpga::images;
use robovec_ir::Machine;
use robovec_ir::evaluate::evaluate_nodes;
use robovec_ir::machine::Interconnect;
use robovec_num::random::Random;
use robovec_num::soft_float::FormatArithmetic;

#[test]
fn a_trace_holds_what_is_loaded_and_every_result_in_its_cycle() {
    let machine = Machine::built_in("thesis").expect("it ships");
    let module = hand::module();
    let files = images(view(&module), &machine, None).expect("it has images");
    let program = LoadedProgram::load(&files, &machine).expect("they can be loaded");
    let trace = program.run_traced(&[1.5, 2.0]).expect("no hazard");
    let word = |number: f32| u64::from(number.to_bits());
    let result = |cycle, element, number| TracedResult {
        cycle,
        element,
        word: word(number),
    };
    // Adders of 10 stages, multipliers of 5: on the bus at t + L + 1.
    let results = [
        result(11, hand::ADD0, 3.5),
        result(18, hand::MULTI0, 7.0),
        result(30, hand::ADD0, -3.5),
    ];
    assert_eq!(trace.results, results);
    let loaded: Vec<(u32, u32, u64)> = trace
        .loaded
        .iter()
        .map(|load| (load.memory, load.address, load.word))
        .collect();
    let expected = [(0, 0, word(1.5)), (0, 1, word(2.0)), (1, 0, word(2.0))];
    assert_eq!(loaded, expected);
    assert!(
        trace
            .loaded
            .iter()
            .all(|load| !load.constant && !load.overwritten)
    );
    assert_eq!(trace.outputs, program.run(&[1.5, 2.0]).expect("no hazard"));
}

/// Results are at the places of schedule and pipelines, with the evaluator's
/// bits, and the loaded words are those of the preloads.
#[test]
fn traces_are_schedules_with_the_evaluators_values() {
    for (name, _) in robovec_ir::machine::BUILT_IN {
        let machine = Machine::built_in(name).expect("it ships");
        // The naive placer knows crossbars with buffers.
        if machine.interconnect != Interconnect::Crossbar || machine.buffer.is_none() {
            continue;
        }
        let module = random_placed(3, 80, &machine);
        let function = &module.functions[0];
        let mut random = Random::new(5);
        let inputs: Vec<f64> = (0..5).map(|_| naive::number(&mut random)).collect();
        let files = images(view(&module), &machine, None).expect("it has images");
        let program = LoadedProgram::load(&files, &machine).expect("they can be loaded");
        let trace = program.run_traced(&inputs).expect("no hazard");
        assert_eq!(trace.outputs, program.run(&inputs).expect("no hazard"));

        let arithmetic = FormatArithmetic::new(machine.number);

        let rounded: Vec<f64> = inputs.iter().map(|&n| arithmetic.convert(n)).collect();
        let values = evaluate_nodes(function, &arithmetic, &rounded);
        let schedule = function.schedule.as_ref().expect("it is scheduled");
        let mut expected = Vec::new();
        for (value, _) in function.values() {
            let Some(slot) = schedule.slots[value.index()] else {
                continue;
            };
            let (kind, _) = schedule.element_name(slot.element);
            let kinds = &machine.elements;
            let kind = kinds.iter().find(|element| element.kind == kind);
            let stages = kind.expect("a kind of the machine").stages;
            expected.push(TracedResult {
                cycle: slot.cycle + stages + 1,
                element: slot.element.number(),
                word: arithmetic.word(values[value.index()]),
            });
        }
        expected.sort_by_key(|result| (result.cycle, result.element));
        assert_eq!(trace.results, expected, "{name}");
        let placement = function.placement.as_ref().expect("it is placed");
        assert_eq!(trace.loaded.len(), placement.preloads.len());
        let constants = trace.loaded.iter().filter(|load| load.constant).count();
        let literal = placement.preloads.iter();
        let literal = literal.filter(|load| load.operand.constant().is_some());
        assert_eq!(constants, literal.count());
    }
}
