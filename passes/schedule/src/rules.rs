//! Tests of each rule of the machine, on programs made for it.

use super::choice::RANKS;
use super::testing::{TestFunctionBuilder, machine, replay};
use super::{ElementChoice, PlaceError, PlaceOptions, Priority, place};
use robovec_ir::machine::BufferDescription;
use robovec_ir::placement::{Address, Bank, BufferWord, Element, Placement};
use robovec_ir::{Function, Machine, Operand, Operation, Value};

fn placed(builder: TestFunctionBuilder, machine: &Machine) -> Function {
    let mut function = builder.function;
    if let Err(error) = place(&mut function, machine, PlaceOptions::default()) {
        panic!("{error}");
    }
    if let Err(breach) = replay(&function, machine) {
        panic!("{breach}");
    }
    function
}

fn cycle(function: &Function, operand: Operand) -> u32 {
    let value = operand.value().expect("a node");
    function
        .schedule
        .as_ref()
        .expect("placed")
        .slot(value)
        .cycle
}

fn element(function: &Function, operand: Operand) -> Element {
    let value = operand.value().expect("a node");
    function
        .schedule
        .as_ref()
        .expect("placed")
        .slot(value)
        .element
}

fn placement(function: &Function) -> &Placement {
    function.placement.as_ref().expect("placed")
}

/// `(q1*q2) + (q3*q4)` and its three nodes.
fn sum_of_products() -> (TestFunctionBuilder, [Operand; 3]) {
    let mut builder = TestFunctionBuilder::new(4, 1);
    let q: Vec<Operand> = (0..4).map(|number| builder.input(number)).collect();
    let a = builder.push(Operation::Mul, q[0], q[1]);
    let b = builder.push(Operation::Mul, q[2], q[3]);
    let c = builder.push(Operation::Add, a, b);
    builder.output(0, c);
    (builder, [a, b, c])
}

#[test]
fn the_ranks_are_those_of_table_2_1() {
    // Rows: left in memory, direct, indirect; columns: right alike.
    assert_eq!(RANKS, [[1, 2, 5], [3, 4, 7], [6, 8, 9]]);
}

#[test]
fn a_chain_waits_for_weights_and_nothing_else() {
    let mut builder = TestFunctionBuilder::new(3, 1);
    let q: Vec<Operand> = (0..3).map(|number| builder.input(number)).collect();
    let product = builder.push(Operation::Mul, q[0], q[1]);
    let sum = builder.push(Operation::Add, product, q[2]);
    builder.output(0, sum);
    let function = placed(builder, &machine("thesis", 1, 1));
    assert_eq!((cycle(&function, product), cycle(&function, sum)), (0, 7));
    let schedule = function.schedule.as_ref().expect("placed");
    assert_eq!((schedule.cycles, schedule.lower_bound), (19, 19));
    // Both results are written directly: the product when it appears, the
    // sum, which nothing reads, into its home.
    let back: Vec<u32> = placement(&function)
        .writes
        .iter()
        .map(|w| w.cycle)
        .collect();
    assert_eq!(back, [6, 18]);
    assert!(placement(&function).buffers.iter().all(Option::is_none));
}

#[test]
fn a_taken_port_costs_a_cycle_and_goes_through_the_buffer() {
    let (builder, [_, _, sum]) = sum_of_products();
    let two_ports = machine("thesis", 1, 2);
    assert_eq!(cycle(&placed(builder, &two_ports), sum), 7);

    let (builder, [a, b, sum]) = sum_of_products();
    let mut one_port = two_ports.clone();
    one_port.memory.writes = Some(1);
    let function = placed(builder, &one_port);
    assert_eq!(cycle(&function, sum), 8);
    let buffers = &placement(&function).buffers;
    let in_buffer = [a, b].map(|operand| buffers[operand.value().expect("a node").index()]);
    assert!(in_buffer.contains(&Some(BufferWord::new(0))) && in_buffer.contains(&None));
}

#[test]
fn without_a_buffer_a_product_is_issued_later_instead() {
    let (builder, [a, b, sum]) = sum_of_products();
    let mut bare = machine("thesis", 1, 2);
    bare.memory.writes = Some(1);
    bare.buffer = None;
    let function = placed(builder, &bare);
    let mut starts = [cycle(&function, a), cycle(&function, b)];
    starts.sort_unstable();
    assert_eq!((starts, cycle(&function, sum)), ([0, 1], 8));
    assert!(placement(&function).buffers.iter().all(Option::is_none));
}

#[test]
fn one_write_port_carries_one_word_a_cycle() {
    // Two multipliers make four products in two cycles for an adder with one
    // write port: the last of them arrives two cycles late, wherever the
    // others wait.
    let mut builder = TestFunctionBuilder::new(8, 2);
    let q: Vec<Operand> = (0..8).map(|number| builder.input(number)).collect();
    let products: Vec<Operand> = (0..4)
        .map(|pair| builder.push(Operation::Mul, q[2 * pair], q[2 * pair + 1]))
        .collect();
    let first = builder.push(Operation::Add, products[0], products[1]);
    let second = builder.push(Operation::Add, products[2], products[3]);
    builder.output(0, first);
    builder.output(1, second);
    let mut narrow = machine("thesis", 1, 2);
    narrow.memory.writes = Some(1);
    let function = placed(builder, &narrow);
    let last = cycle(&function, first).max(cycle(&function, second));
    assert_eq!(last, 10);
}

#[test]
fn a_full_buffer_is_never_overfilled() {
    let mut builder = TestFunctionBuilder::new(8, 8);
    let q: Vec<Operand> = (0..8).map(|number| builder.input(number)).collect();
    let products: Vec<Operand> = (0..8)
        .map(|number| builder.push(Operation::Mul, q[number], q[(number + 3) % 8]))
        .collect();
    for number in 0..8 {
        let sum = builder.push(Operation::Add, products[number], products[7 - number]);
        builder.output(number as u32, sum);
    }
    let mut small = machine("thesis", 2, 8);
    small.memory.writes = Some(1);
    small.buffer = Some(BufferDescription {
        words: Some(1),
        reads: Some(1),
    });
    // The replay refuses a buffer word beyond the first.
    placed(builder, &small);
}

#[test]
fn a_commutative_operation_changes_sides_where_that_saves_a_transfer() {
    let mut builder = TestFunctionBuilder::new(3, 3);
    let q: Vec<Operand> = (0..3).map(|number| builder.input(number)).collect();
    let a = builder.push(Operation::Add, q[0], q[1]);
    let left = builder.push(Operation::Mul, a, q[1]);
    let right = builder.push(Operation::Mul, q[1], a);
    let difference = builder.push(Operation::Sub, q[2], a);
    for (number, operand) in [left, right, difference].into_iter().enumerate() {
        builder.output(number as u32, operand);
    }
    let function = placed(builder, &machine("side-split", 1, 1));
    let operands = |operand: Operand| function.node(operand.value().expect("a node")).operands;
    // One of the two products was turned round, and the value is in one of
    // the multiplier's memories only; the difference stayed as it was.
    assert_eq!(operands(left), operands(right));
    assert_eq!(operands(difference), Operand::list([q[2], a]));
    let value = a.value().expect("a node");
    let writes = placement(&function).writes_of(value);
    let in_multiplier = writes
        .iter()
        .filter(|write| write.word.element == Element::new(1));
    assert_eq!(in_multiplier.count(), 1);
}

#[test]
fn a_square_reads_one_word_or_one_of_each_side() {
    for (name, words) in [("thesis", 1), ("side-split", 2)] {
        let mut builder = TestFunctionBuilder::new(2, 1);
        let (q1, q2) = (builder.input(0), builder.input(1));
        let sum = builder.push(Operation::Add, q1, q2);
        let square = builder.push(Operation::Mul, sum, sum);
        builder.output(0, square);
        let function = placed(builder, &machine(name, 1, 1));
        let writes = placement(&function).writes_of(Value(0));
        assert_eq!(writes.len(), words, "{name}");
        assert!(writes.iter().all(|write| write.cycle == 11));
    }
}

#[test]
fn the_preferential_choice_goes_where_the_operands_are() {
    for (choice, expected) in [(ElementChoice::First, 0), (ElementChoice::Preferential, 1)] {
        let mut builder = TestFunctionBuilder::new(4, 3);
        let q: Vec<Operand> = (0..4).map(|number| builder.input(number)).collect();
        let p = builder.push(Operation::Mul, q[0], q[1]);
        let r = builder.push(Operation::Mul, q[2], q[3]);
        let left = builder.push(Operation::Add, p, q[0]);
        let right = builder.push(Operation::Add, r, q[1]);
        let last = builder.push(Operation::Sub, left, r);
        for (number, operand) in [left, right, last].into_iter().enumerate() {
            builder.output(number as u32, operand);
        }
        let machine = machine("thesis", 2, 2);
        let mut function = builder.function;
        let options = PlaceOptions {
            priority: Priority::Alap,
            choice,
        };
        place(&mut function, &machine, options).expect("it fits");
        assert_eq!(replay(&function, &machine), Ok(()));
        assert_eq!(element(&function, right).number(), 1);
        assert_eq!(element(&function, last).number(), expected, "{choice:?}");
    }
}

#[test]
fn a_host_value_is_preloaded() {
    let mut builder = TestFunctionBuilder::new(2, 2);
    let (q1, q2) = (builder.input(0), builder.input(1));
    let sine = builder.push(Operation::Sin, q1, Operand::NONE);
    let product = builder.push(Operation::Mul, sine, q2);
    builder.output(0, product);
    builder.output(1, sine);
    let function = placed(builder, &machine("thesis", 1, 1));
    let schedule = function.schedule.as_ref().expect("placed");
    assert!(schedule.is_host(Value(0)));
    assert_eq!(cycle(&function, product), 0);
    let preloaded: Vec<Operand> = placement(&function)
        .preloads
        .iter()
        .map(|preload| preload.operand)
        .collect();
    assert_eq!(preloaded, [sine, q2]);
    assert_eq!(placement(&function).homes[1], None);
}

#[test]
fn what_the_machine_cannot_do_is_refused() {
    let refusal = |operation, angle: bool| {
        let mut builder = TestFunctionBuilder::new(2, 1);
        let (q1, q2) = (builder.input(0), builder.input(1));
        let sum = builder.push(Operation::Add, q1, q2);
        let right = if angle { Operand::NONE } else { q2 };
        let result = builder.push(operation, sum, right);
        builder.output(0, result);
        let before = builder.function.clone();
        let mut function = builder.function;
        let result = place(
            &mut function,
            &machine("thesis", 1, 1),
            PlaceOptions::default(),
        );
        assert_eq!(function.nodes(), before.nodes());
        assert_eq!(function.level, before.level);
        result.expect_err("it must be refused")
    };
    assert_eq!(
        refusal(Operation::Div, false),
        PlaceError::NotPerformed {
            value: Value(1),
            operation: "div",
            machine: "thesis".to_owned()
        }
    );
    assert_eq!(
        refusal(Operation::Sin, true),
        PlaceError::ComputedAngle {
            value: Value(1),
            operation: "sin"
        }
    );
}

#[test]
fn a_memory_that_is_too_small_is_named() {
    let (builder, _) = sum_of_products();
    let mut tiny = machine("side-split", 1, 1);
    tiny.memory.words = Some(1);
    let mut function = builder.function;
    assert_eq!(
        place(&mut function, &tiny, PlaceOptions::default()),
        Err(PlaceError::MemoryTooSmall {
            element: "multi0.left".to_owned(),
            needed: 2,
            available: 1
        })
    );
    let mut mute = machine("thesis", 1, 1);
    mute.memory.writes = Some(0);
    assert_eq!(
        place(&mut function, &mute, PlaceOptions::default()),
        Err(PlaceError::NoWritePorts {
            machine: "thesis".to_owned()
        })
    );
}

#[test]
fn addresses_are_used_again() {
    // A chain of 200 sums keeps a handful of words alive.
    let mut builder = TestFunctionBuilder::new(1, 1);
    let q = builder.input(0);
    let mut last = q;
    for _ in 0..200 {
        last = builder.push(Operation::Add, last, q);
    }
    builder.output(0, last);
    let function = placed(builder, &machine("thesis", 1, 1));
    let placement = placement(&function);
    let highest = placement
        .writes
        .iter()
        .map(|write| write.word.address)
        .max();
    assert_eq!(highest, Some(Address::new(1)));
    let home = placement.homes[0].expect("computed");
    assert_eq!(home.bank, Bank::Unified);
}
