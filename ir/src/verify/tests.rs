mod networks;
mod tables;
mod times;

use super::*;
use crate::entity::{Input, Output};
use crate::function::{Assignment, Function, Node, Shape};
use crate::module::Module;
use crate::parse::parse_module;
use crate::placement::{Address, Bank, BufferWord, Element, Slot, Word};
use crate::source::SourceSet;
use crate::symbol::{Name, Symbol};
use crate::{Machine, Tables};
use robovec_num::operation::Operation;

fn parsed(text: &str) -> Module {
    match parse_module("test", text) {
        Ok(module) => module,
        Err(diagnostics) => panic!("{diagnostics:?}"),
    }
}

fn view(module: &Module) -> View<'_> {
    module.tables.view(&module.functions[0])
}

/// The messages after a change that the parser would not let pass.
fn after(text: &str, change: impl FnOnce(&mut Function)) -> Vec<String> {
    let mut module = parsed(text);
    assert_eq!(verify(view(&module)), []);
    change(&mut module.functions[0]);
    let violations = verify(view(&module)).into_iter();
    violations.map(|violation| violation.message).collect()
}

const EQUATIONS: &str = "source 0 \"a.m\"
    function f equations {
      in q[1..3]
      out M[1..2]
      %x = q[1]*q[2] + q[3] @3:1-4
      %y = %x @4:1-4
      M[1] = %y*%x @7:1-4
      M[2] = %x
    }";

const ATOMIC: &str = "function f atomic {
      in q[1..3]
      out M
      %x = q[1]*q[2]
      %y = %x + q[3]
      M = %y
    }";

#[test]
fn operands_must_exist_and_fit_the_operation() {
    let broken = [
        Operand::list([Value(1).into(), Input(0).into()]),
        Operand::list([Input(3).into(), Input(0).into()]),
        Operand::list([Constant(0).into(), Input(0).into()]),
        Operand::list([Input(0).into()]),
        [Operand::NONE; Operand::MAX_COUNT],
        [Input(0).into(); Operand::MAX_COUNT],
    ];
    for operands in broken {
        let messages = after(ATOMIC, |f| f.node_mut(Value(1)).operands = operands);
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(
            messages[0].starts_with("%y ('add') does not read 2"),
            "{messages:?}"
        );
    }
    let messages = after(ATOMIC, |f| f.node_mut(Value(1)).operation = Operation::Sqrt);
    assert!(messages[0].contains("does not read 1"), "{messages:?}");
}

#[test]
fn names_must_be_different_words() {
    let messages = after(ATOMIC, |f| {
        f.node_mut(Value(1)).name = f.node(Value(0)).name
    });
    assert_eq!(messages, ["%x is defined twice"]);
    let messages = after(ATOMIC, |f| f.node_mut(Value(1)).name.base = Symbol(99));
    assert_eq!(messages, ["node 1 has a name that is not in the table"]);
    let messages = after(ATOMIC, |f| f.node_mut(Value(1)).name.suffix = 1_000_000_000);
    assert_eq!(messages.len(), 1);
    let mut module = parsed(ATOMIC);
    let derived = module.tables.symbols.intern("x.1");
    module.functions[0].node_mut(Value(1)).name = Name::plain(derived);
    assert!(verify(view(&module))[0].message.contains("looks derived"));
}

#[test]
fn outputs_are_set_once_in_order_and_all_arrays_are() {
    let messages = after(EQUATIONS, |f| f.assignments[1].output = Output(0));
    assert_eq!(messages, ["M[1] is set twice"]);
    let messages = after(EQUATIONS, |f| f.assignments.swap(0, 1));
    assert_eq!(messages, ["M[1] is set out of order"]);
    let messages = after(EQUATIONS, |f| f.assignments[1].output = Output(2));
    assert_eq!(messages, ["output element 2 is beyond the 2 that exist"]);
    let messages = after(EQUATIONS, |f| f.assignments[1].operand = Value(9).into());
    assert_eq!(messages.len(), 1);
    let messages = after(ATOMIC, |f| f.assignments.clear());
    assert_eq!(messages, ["no element of the output array 'M' is ever set"]);
}

#[test]
fn inner_nodes_follow_the_text() {
    // The product of %x becomes nobody's.
    let messages = after(EQUATIONS, |f| {
        f.node_mut(Value(1)).operands[0] = Input(0).into();
    });
    assert_eq!(
        messages,
        ["an inner 'mul' before %x is not used by the definition after it"]
    );
    // It is used twice.
    let messages = after(EQUATIONS, |f| {
        f.node_mut(Value(1)).operands = Operand::list([Value(0).into(); 2]);
    });
    assert_eq!(messages.len(), 1);
    assert!(
        messages[0].contains("is used more than once"),
        "{messages:?}"
    );
    // A copy of an inner node.
    let messages = after(EQUATIONS, |f| {
        f.node_mut(Value(2)).operands[0] = Value(0).into();
    });
    assert_eq!(messages.len(), 2, "{messages:?}");
    // Sources that the text cannot show.
    let messages = after(EQUATIONS, |f| {
        f.node_mut(Value(0)).sources = SourceSet::EMPTY
    });
    assert_eq!(
        messages,
        ["an inner 'mul' before %x has other sources than what it belongs to"]
    );
    // The expression of an output that no output is set to.
    let messages = after(EQUATIONS, |f| f.assignments[0].operand = Input(0).into());
    assert_eq!(
        messages,
        ["an inner 'mul' after all definitions is used by nothing"]
    );
}

#[test]
fn operands_in_the_wrong_order_of_evaluation_are_found() {
    let text = "function f equations {
      in q
      out M
      M = (q + q)*(q - q)
    }";
    let messages = after(text, |f| f.node_mut(Value(2)).operands.swap(0, 1));
    assert!(!messages.is_empty());
}

#[test]
fn levels_forbid_what_is_above_them() {
    let messages = after(EQUATIONS, |f| f.level = Level::Atomic);
    let text = messages.join("\n");
    assert!(text.contains("has no name"), "{text}");
    assert!(text.contains("is a copy"), "{text}");
    let messages = after(ATOMIC, |f| f.level = Level::Placed);
    assert_eq!(
        messages,
        [
            "a function of the level placed needs a schedule",
            "a placed function needs a placement"
        ]
    );
}

#[test]
fn constants_arrays_and_calls_are_checked() {
    let mut module = parsed(ATOMIC);
    let function = &mut module.functions[0];
    function.constant(f64::NAN);
    function.constant(f64::INFINITY);
    let q = function.inputs()[0].name;
    function.add_input(q, Shape::Matrix(1 << 15, 1 << 15));
    function.name = "1 2".to_owned();
    function.metadata.push(("a key".to_owned(), String::new()));
    function.boundaries.push(crate::Boundary {
        callee: "user".to_owned(),
        arguments: Vec::new(),
        result: Some("absent".to_owned()),
        sources: SourceSet::EMPTY,
    });
    assert_eq!(verify(view(&module)).len(), 7);
}

#[test]
fn long_lists_are_cut_and_counted() {
    let mut tables = Tables::default();
    let mut function = Function::new("f", Level::Atomic);
    let name = Name::plain(tables.symbols.intern("x"));
    let zero = function.constant(0.0);
    for _ in 0..1001 {
        function.push(Node {
            name,
            sources: SourceSet::EMPTY,
            operands: Operand::list([zero.into(); 2]),
            operation: Operation::Add,
        });
    }
    function.assignments = Vec::<Assignment>::new();
    let violations = verify(tables.view(&function));
    assert_eq!(violations.len(), MAX_DESCRIBED + 1);
    assert_eq!(
        violations[MAX_DESCRIBED].message,
        "900 further violations are not shown"
    );
}

const PLACED: &str = include_str!("../../../tests/text/placed.rvir");
const SIDE_SPLIT: &str = include_str!("../../../tests/text/placed-side-split.rvir");

/// The messages of the check against a machine after a change.
fn placement_after(text: &str, change: impl FnOnce(&mut Function, &mut Machine)) -> String {
    let mut module = parsed(text);
    let schedule = module.functions[0].schedule.as_ref().expect("it is placed");
    let mut machine = Machine::built_in(&schedule.machine).expect("it ships");
    assert_eq!(verify_placement(view(&module), &machine), []);
    change(&mut module.functions[0], &mut machine);
    let violations = verify_placement(view(&module), &machine).into_iter();
    let messages: Vec<String> = violations.map(|violation| violation.message).collect();
    messages.join("\n")
}

fn placement(function: &mut Function) -> &mut crate::placement::Placement {
    function.placement.as_mut().expect("it is placed")
}

fn slot(function: &mut Function, node: usize) -> &mut Slot {
    let schedule = function.schedule.as_mut().expect("it is placed");
    schedule.slots[node]
        .as_mut()
        .expect("the machine computes it")
}

/// Every change breaks exactly the rule whose message it is beside.
#[test]
fn placements_are_checked_against_the_machine() {
    type Change = fn(&mut Function, &mut Machine);
    let changes: [(&str, Change); 19] = [
        // Node 1 is the product %p, 2 is %r (in a buffer), 3 and 4 are sums.
        ("has 1 addresses", |f, _| placement(f).reads[3][1] = None),
        (
            "reads %p at cycle 7 from add0[0], which then holds c[1]",
            |f, _| {
                placement(f).reads[3][0] = Some(Address::new(0));
            },
        ),
        (
            "reads c[1] at cycle 7 from add0[9], which then holds nothing",
            |f, _| {
                placement(f).reads[3][1] = Some(Address::new(9));
            },
        ),
        (
            "reads %p at cycle 6 from add0[1], which then holds nothing",
            |f, _| {
                slot(f, 3).cycle = 6;
            },
        ),
        (
            "is written at cycle 5, before its result is there at 6",
            |f, _| {
                placement(f).writes[0].cycle = 5;
            },
        ),
        (
            "is written at cycle 7, after 6, but is in no buffer",
            |f, _| {
                placement(f).writes[0].cycle = 7;
            },
        ),
        ("is in a buffer that nothing reads it from", |f, _| {
            placement(f).buffers[1] = Some(BufferWord::new(1))
        }),
        ("starts on multi0 at cycle 0, and so does %p", |f, _| {
            slot(f, 2).element = Element::new(1)
        }),
        ("is on multi1, which does not perform 'add'", |f, _| {
            slot(f, 3).element = Element::new(2)
        }),
        (
            "should stay in add0[5], which at the end holds nothing",
            |f, _| {
                placement(f).homes[0] = Some(Word {
                    element: Element::new(0),
                    bank: Bank::Unified,
                    address: Address::new(5),
                });
            },
        ),
        (
            "should stay in add0[1], which at the end holds %s",
            |f, _| {
                placement(f).homes[0] = Some(Word {
                    element: Element::new(0),
                    bank: Bank::Unified,
                    address: Address::new(1),
                });
            },
        ),
        ("the machine has no word add0[0]", |_, m| {
            m.memory.words = Some(0)
        }),
        ("is written to add0[2], which does not exist", |_, m| {
            m.memory.words = Some(2)
        }),
        (
            "is in buffer word 0, but the buffers have 0 words",
            |_, m| m.buffer = None,
        ),
        (", which takes 0", |_, m| m.memory.writes = Some(0)),
        ("is written to add0[2] at cycle 9, and so is %p", |f, _| {
            let writes = &mut placement(f).writes;
            writes[0].cycle = 9;
            writes[0].word.address = Address::new(2);
            placement(f).buffers[1] = Some(BufferWord::new(1));
        }),
        ("has no processing elements 'multi'", |_, m| {
            m.elements[1].kind = "fused".to_owned()
        }),
        ("is for the machine 'thesis', not 'other'", |_, m| {
            m.name = "other".to_owned()
        }),
        (
            "more words of the buffer of multi1 are read at cycle 9 than the 0",
            |_, m| {
                m.buffer = Some(crate::machine::BufferDescription {
                    words: None,
                    reads: Some(0),
                });
            },
        ),
    ];
    for (expected, change) in changes {
        let messages = placement_after(PLACED, change);
        assert!(
            messages.contains(expected),
            "'{expected}' is not in\n{messages}"
        );
    }
}

#[test]
fn sides_of_a_split_memory_are_told_apart() {
    let messages = placement_after(SIDE_SPLIT, |f, _| {
        let writes = &mut placement(f).writes;
        writes[0].word.bank = Bank::Right;
        writes[0].word.address = Address::new(5);
        placement(f).reads[1][0] = Some(Address::new(5));
    });
    assert!(
        messages.contains("from add0.left[5], which then holds nothing"),
        "{messages}"
    );
    let messages = placement_after(SIDE_SPLIT, |f, _| {
        placement(f).writes[0].word.bank = Bank::Unified;
    });
    assert!(
        messages.contains("is written to add0[0], which does not exist"),
        "{messages}"
    );
}

#[test]
fn a_buffer_word_is_free_only_after_its_last_read() {
    let text = "function f placed {
      in a
      out M[1..2]
      schedule \"thesis\" add*1 multi*1 cycles 12 bound 8
      preload multi0[0] = a
      %p = a*a on multi0 at 0 read 0 0 buffer 0 write add0[0] at 8
      %q = a*a on multi0 at 3 read 0 0 buffer 0 write add0[1] at 10
      M[1] = %p in add0[0]
      M[2] = %q in add0[1]
    }";
    // The word is read at 8 and taken again at 3 + 5 + 1 = 9.
    placement_after(text, |_, _| {});
    for (change, complains) in [(2, true), (4, false)] {
        let messages = placement_after(text, |f, _| slot(f, 1).cycle = change);
        assert_eq!(
            messages.contains("but %p stays there until 8"),
            complains,
            "{messages}"
        );
    }
}
