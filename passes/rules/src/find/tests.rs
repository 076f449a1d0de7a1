use super::*;

fn search(space: &TermSpace, known: &RuleSet) -> RuleSearch {
    find(space, known, &[], &machine(), &mut |_, _| {})
}

fn machine() -> Machine {
    Machine::built_in("thesis").expect("it ships")
}

fn order_and_grouping() -> RuleSet {
    let mut set = RuleSet::named("commutativity").expect("it ships");
    for name in ["signs", "associativity"] {
        set.extend(RuleSet::named(name).expect("it ships"))
            .expect("unique");
    }
    set
}

#[test]
fn distribution_is_found_and_not_what_it_derives() {
    let space = TermSpace {
        operations: 3,
        variables: 3,
        numbers: Vec::new(),
        trigonometric: false,
        budget: 100_000,
    };
    let search = search(&space, &order_and_grouping());
    assert!(search.complete);
    assert!(search.derived > 0);
    let texts: Vec<String> = search
        .found
        .iter()
        .map(|found| found.rule.to_string())
        .collect();
    let equal = |text: &str| {
        let set = RuleSet::parse(&format!("rule r: {text};"), "f").expect("well formed");
        let rule = &set.rules[0];
        let name = |left, right| normal::name(left, right, 3, false);
        search.found.iter().any(|found| {
            let (left, right) = (&found.rule.left, &found.rule.right);
            let wanted = name(&rule.left, &rule.right);
            wanted == name(left, right) || wanted == name(right, left)
        })
    };
    // Of a sum and a difference one derives the other by the rules of signs.
    let sum = equal("a*b + a*c => a*(b + c)");
    assert!(sum || equal("a*b - a*c => a*(b - c)"), "{texts:#?}");
    // Associativity is known.
    assert!(!equal("(a + b) + c => a + (b + c)"), "{texts:#?}");
    let again = find(
        &space,
        &order_and_grouping(),
        &[],
        &machine(),
        &mut |_, _| {},
    );
    assert_eq!(search, again, "the same every time");
}

#[test]
fn what_ships_leaves_little_to_find() {
    let mut known = RuleSet::built_in();
    known
        .extend(RuleSet::named("associativity").expect("it ships"))
        .expect("unique");
    let space = TermSpace {
        operations: 3,
        ..TermSpace::default()
    };
    let (all, rest) = (
        search(&space, &order_and_grouping()),
        search(&space, &known),
    );
    assert!(rest.found.len() < all.found.len());
    for found in &rest.found {
        assert!(check::check(&found.rule, 100).is_sound(), "{}", found.rule);
    }
}

#[test]
fn the_circle_is_found() {
    let space = TermSpace {
        operations: 3,
        variables: 1,
        numbers: vec![1.0],
        trigonometric: true,
        budget: 100_000,
    };
    let search = search(&space, &order_and_grouping());
    let of_circle = |found: &&Found| found.rule.class == NumericClass::RealTrig;
    assert!(search.found.iter().any(|found| of_circle(&found)));
}

/// A function at the atomic level, in the text form.
fn program(inputs: &str, body: &str) -> robovec_ir::Module {
    let text = format!("// robovec 1\n\nfunction f atomic {{\n{inputs}\n{body}\n}}\n");
    robovec_ir::parse::parse_module("f.rvir", &text).expect("well formed")
}

/// Twice the terms of a common factor, once with other names and orders.
fn with_common_factors() -> robovec_ir::Module {
    program(
        "  in x[1..6]\n  out o[1..2]",
        "  %a = x[1]*x[2]\n  %b = x[1]*x[3]\n  %c = %a + %b\n\
         \u{20} %d = x[4]*x[5]\n  %e = x[6]*x[4]\n  %f = %e + %d\n\
         \u{20} o[1] = %c\n  o[2] = %f",
    )
}

fn mined(known: &RuleSet, from: &robovec_ir::Module) -> MinedRules {
    let functions: Vec<&Function> = from.functions.iter().collect();
    let space = MiningSpace {
        window: 6,
        shapes: 100,
        work: 100_000,
    };
    let progress = &mut |_, _| {};
    mine(space, known, &functions, &functions, &machine(), progress)
}

#[test]
fn factoring_is_mined_where_it_is_not_known() {
    let module = with_common_factors();
    let found = mined(&order_and_grouping(), &module);
    let factoring = |found: &&Found| {
        found.gain.operations == 2 && found.gain.places == 2 && found.rule.right.nodes.len() == 5
    };
    assert!(
        found.search.found.iter().any(|found| factoring(&found)),
        "one operation at each of two places: {found:#?}"
    );
    assert_eq!(found, mined(&order_and_grouping(), &module), "the same");
    let mut known = RuleSet::built_in();
    known
        .extend(RuleSet::named("associativity").expect("it ships"))
        .expect("unique");
    let again = mined(&known, &module);
    assert!(again.search.candidates > 0);
    assert_eq!(again.search.found, [], "what ships derives it");
}

#[test]
fn the_circle_is_mined() {
    let squares = |place: u32| {
        format!(
            "  %s{place} = sin(q[{place}])\n  %c{place} = cos(q[{place}])\n\
             \u{20} %a{place} = %s{place}*%s{place}\n  %b{place} = %c{place}*%c{place}\n\
             \u{20} %o{place} = %a{place} + %b{place}\n"
        )
    };
    let body = format!("{}{}  o[1] = %o1\n  o[2] = %o2", squares(1), squares(2));
    let module = program("  in q[1..2]\n  out o[1..2]", &body);
    let found = mined(&order_and_grouping(), &module).search.found;
    let circle = found
        .iter()
        .find(|found| found.rule.right.nodes.len() == 1)
        .expect("one");
    assert_eq!(circle.rule.class, NumericClass::RealTrig);
    assert_eq!(circle.gain.operations, 6, "three at each of two places");
}

#[test]
fn places_that_share_an_operation_count_once() {
    // Of x*y + x*z + x*w either pair can be joined, not both.
    let module = program(
        "  in x[1..4]\n  out o",
        "  %a = x[1]*x[2]\n  %b = x[1]*x[3]\n  %c = %a + %b\n\
         \u{20} %d = x[1]*x[4]\n  %e = %c + %d\n  o = %e",
    );
    let set = RuleSet::parse(
        "rule r: (a*b + a*c) + d => a*(b + c) + d; rule s: a*b + a*c => a*(b + c);",
        "f",
    )
    .expect("well formed");
    let function = &module.functions[0];
    let timed = [Timed::new(function, &Weights::cycles(&machine()))];
    for rule in &set.rules {
        let gain = rank::gain(rule, &timed, &machine());
        assert_eq!((gain.places, gain.operations), (1, 1), "{rule}");
    }
}
