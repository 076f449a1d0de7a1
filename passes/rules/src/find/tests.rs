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
