use super::*;
use robovec_analysis::class::NumericClass;
use robovec_num::arithmetic::Binary64;

fn message(text: &str) -> String {
    let report = RuleSet::parse(text, "test.rules").expect_err("a mistake");
    report.render_plain()
}

#[test]
fn the_files_that_ship_are_read_and_have_reasons() {
    for (name, _) in BUILT_IN {
        let set = RuleSet::named(name).expect("it ships");
        assert!(!set.rules.is_empty(), "{name}");
        for rule in &set.rules {
            assert_eq!(rule.group, *name);
            assert!(!rule.reason.is_empty(), "{}", rule.name);
        }
    }
    let mut all = RuleSet::built_in();
    let rest = RuleSet::named("associativity").expect("it ships");
    all.extend(rest).expect("names are unique over all files");
}

#[test]
fn printing_and_parsing_are_inverse() {
    let mut all = RuleSet::built_in();
    all.extend(RuleSet::named("associativity").expect("it ships"))
        .expect("unique");
    let text =
        all.to_text() + "rule odd: -(a + -2)*neg(2)/(b/c) - (a - -b) <=> sin(-(c - 1e-9))*b*a;";
    let once = RuleSet::parse(&text, "printed.rules").expect("printed");
    let again = RuleSet::parse(&once.to_text(), "printed.rules").expect("printed");
    assert_eq!(once.to_text(), again.to_text());
    for (before, after) in all.rules.iter().zip(&once.rules) {
        let same = (&before.left, &before.right) == (&after.left, &after.right);
        assert!(same, "{before}\n{after}");
        assert_eq!(before.class, after.class);
        assert_eq!(before.conditions, after.conditions);
    }
}

#[test]
fn operators_bind_as_everywhere() {
    for (text, expected) in [
        ("a - b - c", 1.0),
        ("a - (b - c)", 9.0),
        ("a/b/c", 8.0 / 3.0 / 4.0),
        ("-a*b + c", -20.0),
        ("-(a*b + c)", -28.0),
        ("a*-b", -24.0),
        ("a + b*c", 20.0),
        ("sqrt(c)*neg(a) - -2", -14.0),
        ("((((a))))", 8.0),
    ] {
        // The names must get their numbers in order.
        let set = RuleSet::parse(&format!("rule r: a + b + c => {text} + 0;"), "test");
        let set = set.expect("well formed");
        let value = set.rules[0].right.evaluate(&Binary64, &[8.0, 3.0, 4.0]);
        assert_eq!(value, expected, "{text}");
    }
}

#[test]
fn a_rule_of_both_ways_is_two_rules() {
    let set = RuleSet::parse("rule r: a + (b + c) <=> (a + b) + c class=real;", "f");
    let [forth, back] = &set.expect("well formed").directed()[..] else {
        panic!("two rules");
    };
    assert_eq!((forth.name.as_str(), back.name.as_str()), ("r", "r.back"));
    assert_eq!((&forth.left, &forth.right), (&back.right, &back.left));
}

#[test]
fn mistakes_are_named_and_placed() {
    for (text, place, expected) in [
        ("rule r a => b;", "1:8", "':'"),
        ("rule r: a + => b;", "1:13", "a number, a variable or '('"),
        ("rule r: (a + b => b;", "1:9", "not closed"),
        ("rule r: a + b) => b;", "1:14", "no '(' is open"),
        ("rule r: tan(a) => a;", "1:9", "there is no operation 'tan'"),
        ("rule r: sim(a) => a;", "1:9", "did you mean 'sin'"),
        ("rule r: sin => a;", "1:9", "in parentheses"),
        (
            "rule r: a + 0 => b;",
            "1:18",
            "'b' does not occur on the left",
        ),
        (
            "rule r: a + b <=> a*2;",
            "1:13",
            "'b' does not occur on the right",
        ),
        ("rule r: a => a + 0;", "1:9", "matches every value"),
        ("rule r: a*1 <=> a;", "1:17", "matches every value"),
        ("rule r: a + b => a + b;", "1:9", "the same"),
        (
            "rule r: a + a => 2*a class=exakt;",
            "1:28",
            "did you mean 'exact'",
        ),
        (
            "rule r: a + a => 2*a when big(a);",
            "1:27",
            "no condition 'big'",
        ),
        (
            "rule r: a + a => 2*a when constant(b);",
            "1:36",
            "no variable 'b'",
        ),
        ("rule r: a + a => 2*a \"x\" \"y\";", "1:26", "twice"),
        ("rule r: a + a => 2*a \"x", "1:22", "no closing"),
        ("rule r: a + a => 2*a", "1:21", "the file ends"),
        ("rule r: a + a => 1e999*a;", "1:18", "too large"),
        ("rule r: a + a => 2 a;", "1:20", "an operator"),
        (
            "rule r: a @ a => 2*a;",
            "1:11",
            "not allowed in a file of rules",
        ),
        ("rules r: a;", "1:1", "'rule'"),
        ("rule : a;", "1:6", "the name of the rule"),
        ("rule r: (a + => b;", "1:14", "a number, a variable or '('"),
        ("rule r: a b => a;", "1:11", "an operator, '=>' or '<=>'"),
        ("rule r: sin(a => a;", "1:9", "not closed"),
        ("rule r: a + a => 2*a class real;", "1:28", "'='"),
        ("rule r: a + a => 2*a class=;", "1:28", "a class"),
        (
            "rule r: a + a => 2*a when;",
            "1:26",
            "a condition (constant,",
        ),
        (
            "rule r: a + a => 2*a when class=real;",
            "1:27",
            "a condition",
        ),
        ("rule r: a + a => 2*a when nonzero a;", "1:35", "'('"),
        (
            "rule r: a + a => 2*a when nonzero(2);",
            "1:35",
            "a variable of the left side",
        ),
        ("rule r: a + a => 2*a when nonzero(a;", "1:36", "')'"),
        ("rule r: a + a => class;", "1:18", "a number, a variable"),
        ("rule of-rule when: a + a => 2*a;", "1:14", "':'"),
        ("rule r: a +", "1:12", "the file ends"),
        // What is wrong first is told, whatever stands behind it.
        ("rule r: a + a => 2*a class=re,al;", "1:28", "no class 're'"),
        (
            "rule r: a + a => 2*(a + 0) b;",
            "1:28",
            "an operator, 'when'",
        ),
        ("rule r: (a + 1e999 b => a;", "1:14", "too large"),
        ("rule r: a + a => 2*a class=re@;", "1:28", "no class 're'"),
        ("rule r: sim() => a;", "1:9", "no operation 'sim'"),
        ("rule r: (a + b) c => a;", "1:17", "an operator, '=>'"),
        ("rule r: a + a => 2*a \"x\" \"y\" a;", "1:26", "twice"),
        ("rule when: a + a => 2*a;", "1:6", "a word of the language"),
        (
            "rule r: a + a => 2*a;\nrule r: a*1 => a;",
            "2:6",
            "two rules 'r'",
        ),
    ] {
        let shown = message(text);
        assert!(shown.contains(expected), "{text}: {shown}");
        assert!(
            shown.contains(&format!("test.rules:{place}")),
            "{text}: {shown}"
        );
        assert!(shown.contains('^'), "{text}: {shown}");
    }
}

#[test]
fn all_mistakes_of_a_file_are_told() {
    let shown = message("rule a: x + => y;\nrule b: x*1 => x;\nrule c: x => x\nrule d: (x => x;");
    for place in ["1:13", "4:1", "4:9"] {
        assert!(shown.contains(place), "{place}: {shown}");
    }
}

#[test]
fn hostile_files_are_refused_quickly() {
    let deep = format!(
        "rule r: {}a{} => a;",
        "(".repeat(100_000),
        ")".repeat(100_000)
    );
    assert!(RuleSet::parse(&deep, "f").is_err(), "a single variable");
    let signs = format!("rule r: {}a => a;", "-(".repeat(100_000));
    assert!(message(&signs).contains("not closed"));
    let long = format!("rule r: a{} => a;", " + a".repeat(100_000));
    assert!(message(&long).contains("at most 200"));
    let wrong = "rule r: ;\n".repeat(100_000);
    assert!(message(&wrong).matches("error").count() <= 21);
    assert!(message(&" ".repeat(5 << 20)).contains("four megabytes"));
    assert!(message("\u{0}\u{1}\u{202e}").contains("not allowed in a file of rules"));
    assert!(RuleSet::parse("", "f").expect("no rules").rules.is_empty());
}

#[test]
fn sets_are_joined_when_no_name_is_taken() {
    let mut set = RuleSet::parse("rule r: a + a => 2*a;", "one.rules").expect("read");
    let other = RuleSet::parse("rule s: a*1 => a class=exact;", "two.rules").expect("read");
    set.extend(other.clone()).expect("another name");
    assert_eq!(set.rules[1].places.file, 1);
    assert_eq!(
        set.get("s").map(|rule| rule.class),
        Some(NumericClass::Exact)
    );
    let shown = set.extend(other).expect_err("the same name").render_plain();
    assert!(shown.contains("there is a rule 's' already"), "{shown}");
    assert_eq!(set.rules.len(), 2);
}
