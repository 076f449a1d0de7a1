use super::*;

fn rule(text: &str) -> Rule {
    let set = RuleSet::parse(&format!("rule r: {text};"), "test.rules");
    set.unwrap_or_else(|report| panic!("{}", report.render_plain()))
        .rules
        .remove(0)
}

fn found(text: &str) -> Finding {
    check(&rule(text), 2_000)
}

impl RuleVerdict {
    /// The number that may be zero or negative.
    fn doubt(&self) -> &str {
        match self {
            RuleVerdict::Unproved(Doubt::Domain(operand)) => operand,
            other => panic!("{other:?}"),
        }
    }
}

fn refutation(text: &str) -> String {
    match found(text).verdict {
        RuleVerdict::False(found) => found.to_string(),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn every_rule_that_ships_keeps_what_it_declares() {
    for (name, _) in super::super::BUILT_IN {
        for rule in RuleSet::named(name).expect("it ships").rules {
            let finding = check(&rule, TRIALS);
            assert!(finding.is_sound(), "{rule}\n{finding:?}");
            // Nor do they promise less than they keep.
            assert_eq!(finding.class, rule.class, "{rule}\n{finding:?}");
        }
    }
}

#[test]
fn false_rules_are_refuted_by_the_smallest_integers() {
    for (text, expected) in [
        (
            "a + b => a",
            "a = 0, b = 1: the left side is 1, the right side is 0",
        ),
        (
            "a*(b + c) => a*b + c",
            "a = 0, b = 0, c = 1: the left side is 0, the right side is 1",
        ),
        (
            "a*a => a",
            "a = -1: the left side is 1, the right side is -1",
        ),
        (
            "sqrt(a*a) => a",
            "a = -1: the left side is 1, the right side is -1",
        ),
        // Right at -2, -1, 0, 1, 2.
        (
            "a*(a*a - 1)*(a*a - 4) => a - a",
            "a = 3: the left side is 120, the right side is 0",
        ),
        (
            "1 + 1 => 3",
            "always: the left side is 2, the right side is 3",
        ),
        (
            "a/3 => a*0.3333333333333333",
            "a = 1: the left side is 0.3333333333333333, the right side is 1.9e-17 less",
        ),
        // Nothing is lost on the left, a division by zero on the right.
        (
            "a + b <=> (a*a - b*b)/(a - b)",
            "a = 0, b = 0: the left side is 0, the right side is not defined",
        ),
    ] {
        assert_eq!(refutation(text), expected, "{text}");
    }
    assert!(refutation("sin(a)*sin(a) + cos(a)*cos(a) => 2").contains("a = 0"));
    assert!(refutation("cos(a) => 1 - a*a/2").contains("a = 1"));
}

#[test]
fn conditions_make_rules_true() {
    for text in [
        "a*b/b => a when nonzero(b)",
        "sqrt(a)*sqrt(b) <=> sqrt(a*b) when positive(a), positive(b)",
        "sqrt(a*a*b) => a*sqrt(b) when positive(a), positive(b)",
        "a*b + 0*b => a*b*b/b when nonzero(b)",
    ] {
        assert!(found(text).is_sound(), "{text}: {:?}", found(text));
    }
    for (text, expected) in [
        (
            "a*b + 0*b => a*b*b/b",
            "a = 0, b = 0: the left side is 0, the right side is not defined",
        ),
        (
            "sqrt(a)*sqrt(b) <=> sqrt(a*b)",
            "backwards, a = 0, b = -1: the left side is 0, the right side is not defined",
        ),
    ] {
        assert!(refutation(text).contains(expected), "{}", refutation(text));
    }
}

#[test]
fn the_circle_is_told_from_the_plane() {
    for text in [
        "1 - sin(a)*sin(a) => cos(a)*cos(a)",
        "sin(a + b) => sin(a)*cos(b) + cos(a)*sin(b)",
        "cos(a)*cos(b) - sin(a)*sin(b) <=> cos(a + b)",
        "cos(a - b) => cos(a)*cos(b) + sin(a)*sin(b)",
        "sin(2*a) => 2*sin(a)*cos(a)",
        "cos(2*a) => 1 - 2*sin(a)*sin(a)",
        "sin(3*a) => 3*sin(a) - 4*sin(a)*sin(a)*sin(a)",
        "sin(a) => 2*sin(a/2)*cos(0.5*a)",
        "sin(a*b + 0.1*c) => sin(a*b)*cos(0.1*c) + cos(b*a)*sin(0.1*c)",
        "sin(a/b + c) => sin(a/b)*cos(c) + cos(a/b)*sin(c)",
        "(1 - cos(2*a))/2 => sin(a)*sin(a)",
        "sin(a + b)/(cos(a)*cos(b)) => sin(a)/cos(a) + sin(b)/cos(b)",
    ] {
        let finding = found(text);
        let RuleVerdict::Proved(proof) = finding.verdict else {
            panic!("{text}: {finding:?}");
        };
        assert!(proof.circle, "{text}");
        assert_eq!(finding.class, NumericClass::RealTrig, "{text}");
    }
    assert_eq!(
        found("sin(a)*b + sin(a)*c => sin(a)*(b + c)").class,
        NumericClass::Real
    );
    for text in [
        "sin(a + b) => sin(a)*cos(b) - cos(a)*sin(b)",
        "sin(2*a) => 2*sin(a)",
        "cos(a + 0.1*b) => cos(a)*cos(0.1*b) + sin(a)*sin(0.1*b)",
        "sin(a/b) => sin(a)/b",
        "sin(a + 6.283185307179586) => sin(a)",
    ] {
        refutation(text);
    }
}

#[test]
fn what_is_not_known_is_not_proved() {
    // It is true: where the left side is defined a is at least 2.
    let finding = found("sqrt((a - 1)*(a - 1)) + 0*sqrt(a - 2) => a - 1");
    assert_eq!(finding.verdict, RuleVerdict::Unproved(Doubt::Fields));
    assert!(!finding.is_sound());
    // The left side is defined nowhere, and at one point only.
    for text in ["1/(a - a) => 5", "sqrt(-(a*a)) => 5*a"] {
        let verdict = found(text).verdict;
        assert!(
            matches!(verdict, RuleVerdict::Unproved(_)),
            "{text}: {verdict:?}"
        );
    }
    // Nothing says that this polynomial has no real zero.
    let finding = found("a + 0 => a*(a*a + a + 1)/(a*a + a + 1)");
    assert_eq!(finding.verdict.doubt(), "a*a + a + 1");
    // The left side is also defined at a = 0, whatever b is.
    for text in [
        "sqrt(a) + sqrt(a*b) + sqrt(b*b) => sqrt(a) + sqrt(a*b) + b when nonzero(b)",
        "sqrt(a + b/c) + sqrt(a*c + b) + sqrt(c*c) => sqrt(a + b/c) + sqrt(a*c + b) + c",
        "sqrt(a*a*(b - 1)) => sqrt(a*a)*sqrt(b - 1)",
        "sqrt(a*a*(b - 1)) => sqrt(a*a*(b - 1)) + sqrt((b - 1)*(b - 1)) - (b - 1)",
        "sqrt((a*a + b*b)*(c - 1)) + 0 => sqrt((a*a + b*b)*(c - 1)) + sqrt((c - 1)*(c - 1)) - (c - 1)",
    ] {
        assert!(!found(text).is_sound(), "{text}: {:?}", found(text));
    }
}

#[test]
fn powers_of_two_are_told_apart() {
    for text in [
        "a*2305843009213693952 => a",
        "a*1073741824*2147483648 => a",
        "a + 4.336808689942018e-19*b => a + b",
        "sin(a + 2305843009213693952*b) => sin(a + b)",
        "a*1e300*1e-300 => a",
    ] {
        refutation(text);
    }
}

#[test]
fn holes_are_found_whatever_the_number() {
    for (text, place) in [
        ("a + b - b => a*(2*b - 1)/(2*b - 1)", "b = 0.5"),
        ("a + b - b => a*(b - 100)/(b - 100)", "b = 100"),
        ("a*b + c*d - c*d => a*b*(d - 9)/(d - 9)", "d = 9"),
        ("a*sin(b) => a*sin(b)*(2*b - 3)/(2*b - 3)", "b = 1.5"),
        ("1/(a - 0.1) => (a + 0.1)/(a*a - 0.1*0.1)", "a = -0.1"),
        (
            "a/(b*b + 1) => a*(2*b - 1)/((b*b + 1)*(2*b - 1))",
            "b = 0.5",
        ),
        ("a*b => a*b*(a*a - 2)/(a*a - 2)", "near a = "),
        (
            "a*b => a*b*(3*a - 1)*(3*a - 1)/((3*a - 1)*(3*a - 1))",
            "near a = ",
        ),
        ("a + b => (a + b)*cos(a)/cos(a)", "near a = "),
        ("a + b => (a + b)*(a - 1e200)/(a - 1e200)", "a = 1e200"),
        (
            "a + b => (a + b)*(a*1e-200 - 3)/(a*1e-200 - 3)",
            "near a = ",
        ),
        ("a + b => (a*a - b*b)/(a - b)", "a = 0, b = 0"),
        ("a + b => a + b + 0*sqrt(a + 1e9)", "not defined"),
        ("a + b => a + b + 0*sqrt(1e9 - a)", "not defined"),
    ] {
        let shown = refutation(text);
        assert!(shown.contains(place), "{text}: {shown}");
    }
    for text in [
        "a/b + c/b => (a + c)/b",
        "1/(a - b) - 1/(a + b) => 2*b/(a*a - b*b)",
        "a/(a*a - b*b) => a/(a - b)/(a + b)",
        "1/(a - 0.1) => 1/(a - 0.1)/1",
        "1/a + 1/b => (a + b)/(a*b)",
        "a/(1/b + 1/c) => a*b*c/(b + c)",
        "a + b + 0*c => (a*c + b*c)/c when nonzero(c)",
        "a/(b*b + 1) + 0*c => a*c/(b*b*c + c) when positive(c)",
        "a + b => (a + b)*(b*b + 1)/(b*b + 1)",
        "a + 0*b => a*(2 + sin(b))/(2 + sin(b))",
        "a/(cos(b)*cos(b)) => a/(1 - sin(b))/(1 + sin(b))",
        "a/b/c/d => a/(b*c*d)",
        "a/sqrt(b) => a*sqrt(b)/b",
    ] {
        assert!(found(text).is_sound(), "{text}: {:?}", found(text));
    }
    // Half a turn is left out by the usual parametrisation of the circle.
    let finding = found("a + b => (a + b)*(cos(a) + 1)/(cos(a) + 1)");
    assert_eq!(finding.verdict.doubt(), "cos(a) + 1");
}

#[test]
fn signs_of_roots_are_not_left_to_chance() {
    let numbers: Vec<String> = (1..150)
        .flat_map(|number| {
            let whole = f64::from(number * number);
            [
                whole,
                -whole,
                whole / 8.0,
                0.1 * whole,
                1.37e3 * whole,
                whole * 1e-3,
            ]
        })
        .chain([1e300, -1e300, 1.5e-300, -1e-9, 2f64.powi(61), 4e15, 1e100])
        .map(|number| format!("{number}"))
        .collect();
    for (index, number) in numbers.iter().enumerate() {
        let forms = [
            format!("sqrt((a - {number})*(a - {number})) => a - {number}"),
            format!("sqrt((2*a - {number})*(2*a - {number})) => 2*a - {number}"),
            format!("sqrt((a*b - {number})*(a*b - {number})) => a*b - {number}"),
            format!("sqrt((a + b - {number})*(a + b - {number})) => a + b - {number}"),
            format!("sqrt(({number} - a)*(a - {number})*-1) => {number} - a"),
        ];
        refutation(&forms[index % forms.len()]);
    }
    for text in [
        "sqrt((a - b)*(a - b)) => a - b",
        "sqrt(a*a*b) => a*sqrt(b) when positive(b)",
        "sqrt(a*a*b*b) => a*b",
        "sqrt(cos(a)*cos(a)) => cos(a)",
        "sqrt(1 - sin(a)*sin(a)) => cos(a)",
        "sqrt(sqrt(a*a*a*a)) => a",
        "sqrt(9) => -3",
        "sqrt(3 - 2*sqrt(2)) => 1 - sqrt(2)",
    ] {
        refutation(text);
    }
}

#[test]
fn roots_with_known_signs_are_proved() {
    for text in [
        "sqrt(a)*sqrt(a) => a",
        "sqrt(a*a)*sqrt(a*a) => a*a",
        "sqrt(a*a*b*b) => sqrt(a*a)*sqrt(b*b)",
        "sqrt(4*a) => 2*sqrt(a)",
        "sqrt(9.765625*a*a) => 3.125*a when positive(a)",
        "sqrt(a/b) => sqrt(a)/sqrt(b) when positive(a), positive(b)",
        "1/sqrt(a) => sqrt(a)/a",
        "sqrt(a*a + 2*a*b + b*b) => a + b when positive(a), positive(b)",
        "sqrt((a*a + 1)*(a*a + 1)) => a*a + 1",
        "sqrt((a - b)*(a - b)) => sqrt((b - a)*(b - a))",
        "(sqrt(a) - sqrt(b))*(sqrt(a) + sqrt(b)) => a - b",
        "sqrt(1 - sin(a)*sin(a)) => sqrt(cos(a)*cos(a))",
        "sqrt(2.25) => 1.5",
        "sqrt((a - 1)*(a - 1))*sqrt(4) => sqrt((2*a - 2)*(2*a - 2))",
    ] {
        assert!(found(text).is_sound(), "{text}: {:?}", found(text));
    }
}

#[test]
fn bits_decide_the_class() {
    for (text, class) in [
        ("a + b => b + a", NumericClass::Exact),
        ("0*a => 0", NumericClass::Exact),
        ("a*2 => a + a", NumericClass::Exact),
        ("a*4*b => a*(4*b)", NumericClass::Real),
        ("a + (b + c) => (a + b) + c", NumericClass::Real),
        ("a/3 + b/3 => (a + b)/3", NumericClass::Real),
    ] {
        assert_eq!(found(text).class, class, "{text}");
    }
    // Nothing becomes a number.
    assert_eq!(found("a/a => 1").class, NumericClass::Real);
    assert_eq!(found("a/a => 1 when nonzero(a)").class, NumericClass::Exact);
    assert_eq!(found("a - 0.1 + 0.1 => a + 0").class, NumericClass::Real);
    let finding = found("a*(b + c) => a*b + a*c");
    assert!(
        (0.4..0.9).contains(&finding.equal_bits),
        "{}",
        finding.equal_bits
    );
}

#[test]
fn without_any_equal_bits_nothing_is_proved() {
    let finding = found("1 + 1e300 - 1e300 => 1");
    assert_eq!(finding.verdict, RuleVerdict::Unproved(Doubt::Bits));
    assert_eq!(finding.equal_bits, 0.0);
    let finding = found("sqrt(2)*sqrt(3) => sqrt(6)");
    assert_eq!(finding.verdict, RuleVerdict::Unproved(Doubt::Bits));
    // Out of the reach of binary32.
    let finding = found("a*1e60*b => a*b*1e60");
    assert!(
        finding.is_sound() && finding.equal_bits > 0.0,
        "{finding:?}"
    );
}

#[test]
fn special_values_are_noted() {
    let kinds = |text: &str| -> Vec<NoteKind> {
        let notes = found(text).notes;
        notes.iter().map(|note| note.kind).collect()
    };
    assert_eq!(kinds("a + b => b + a"), []);
    assert_eq!(kinds("a + 0 => a"), [NoteKind::SignedZero]);
    assert!(kinds("0*a => 0").contains(&NoteKind::NotANumber));
    assert!(kinds("a*(b + c) => a*b + a*c").contains(&NoteKind::Overflow));
    assert!(kinds("(a + b) - b => 1*a").contains(&NoteKind::OverflowRemoved));
    assert!(kinds("a*(b*c) => (a*b)*c").contains(&NoteKind::Underflow));
    let finding = found("a + 0 => a");
    let example = "a = -0: left 0, right -0";
    assert_eq!(finding.notes[0].example, example);
}

#[test]
fn a_set_is_cleared_of_what_is_false() {
    let text = "rule good: a*b + a*c => a*(b + c);\n\
                rule bad: a - b => b - a;\n\
                rule proud: a*(b + c) => a*b + a*c class=exact;\n";
    let set = RuleSet::parse(text, "mine.rules").expect("well formed");
    let (sound, report) = set.sound();
    let names: Vec<&str> = sound.rules.iter().map(|rule| rule.name.as_str()).collect();
    assert_eq!(names, ["good", "proud"]);
    assert_eq!(sound.rules[1].class, NumericClass::Real);
    assert!(!report.has_errors(), "they are warnings");
    let shown = report.render_plain();
    assert!(shown.contains("the rule 'bad' is false"), "{shown}");
    assert!(
        shown.contains("^^^^^^^^^^^^^^ a = 0, b = 1: the left side is -1"),
        "{shown}"
    );
    assert!(
        shown.contains("the rule 'proud' is true, but not exact"),
        "{shown}"
    );
}
