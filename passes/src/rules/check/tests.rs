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

fn refutation(text: &str) -> String {
    match found(text).verdict {
        Verdict::False(found) => found.to_string(),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn every_rule_that_ships_keeps_what_it_declares() {
    for (name, _) in super::super::BUILT_IN {
        for rule in RuleSet::named(name).expect("it ships").rules {
            let finding = check(&rule, TRIALS);
            assert!(finding.keeps(rule.class), "{rule}\n{finding:?}");
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
    let finding = found("1 - sin(a)*sin(a) => cos(a)*cos(a)");
    assert!(matches!(
        finding.verdict,
        Verdict::Proved { circle: true, .. }
    ));
    assert_eq!(finding.class, NumericClass::RealTrig);
    assert!(!finding.keeps(NumericClass::Real));
    assert_eq!(
        found("sin(a)*b + sin(a)*c => sin(a)*(b + c)").class,
        NumericClass::Real
    );
}

#[test]
fn what_the_field_does_not_know_is_not_proved() {
    let finding = found("sin(a + b) => sin(a)*cos(b) + cos(a)*sin(b)");
    assert_eq!(finding.verdict, Verdict::Unproved);
    assert!(!finding.is_sound());
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
    let finding = found("a*(b + c) => a*b + a*c");
    assert!(
        (0.4..0.9).contains(&finding.equal_bits),
        "{}",
        finding.equal_bits
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
