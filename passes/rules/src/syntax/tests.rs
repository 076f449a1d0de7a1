use super::*;

fn all() -> RuleSet {
    let mut all = RuleSet::built_in();
    let rest = RuleSet::named("associativity").expect("it ships");
    all.extend(rest).expect("unique");
    all
}

fn shown(text: &str, syntax: Syntax) -> String {
    match import(text, "other.egg", syntax) {
        Ok((set, report)) => panic!("{}{}", set.to_text(), report.render_plain()),
        Err(report) => report.render_plain(),
    }
}

#[test]
fn egglog_keeps_rules_and_conditions() {
    let text = export(&all(), Syntax::Egglog);
    let (again, warnings) = import(&text, "all.egg", Syntax::Egglog).expect("exported");
    assert!(warnings.is_empty(), "{}", warnings.render_plain());
    assert_eq!(again.rules.len(), all().rules.len());
    for (before, after) in all().rules.iter().zip(&again.rules) {
        assert_eq!((&before.left, &before.right), (&after.left, &after.right));
        assert_eq!(
            (&before.name, before.both_ways),
            (&after.name, after.both_ways)
        );
        assert_eq!(before.conditions, after.conditions, "{before}");
        assert_eq!(before.reason, after.reason);
    }
}

#[test]
fn herbie_keeps_rules_without_conditions() {
    let text = export(&all(), Syntax::Herbie);
    let (again, warnings) = import(&text, "all.rkt", Syntax::Herbie).expect("exported");
    assert!(warnings.is_empty(), "{}", warnings.render_plain());
    let mut directed = all().directed();
    directed.retain(|rule| rule.conditions.is_empty());
    assert_eq!(again.rules.len(), directed.len());
    for (before, after) in directed.iter().zip(&again.rules) {
        let text = |rule: &super::super::Rule| {
            let side = |pattern: &super::super::Pattern| pattern.to_text(&rule.variables);
            (side(&rule.left), side(&rule.right))
        };
        assert_eq!(text(before), text(after));
    }
}

#[test]
fn what_robovec_has_not_is_left_out_with_a_warning() {
    let text = "#lang racket ; a file\n#| many\n lines |#\n(require \"x.rkt\")\n\
                (define-ruleset* powers (arithmetic) #:type ([a real] [b real])\n\
                [sqr-pow (pow a 2) (* a a)]\n[half (* 1/2 a) (/ a 2)]\n\
                [neg-one (- a) (* -1 a)]\n[id a (* 1 a)]\n[pi (sin PI) 0])\n";
    let (set, warnings) = import(text, "rules.rkt", Syntax::Herbie).expect("well formed");
    let rules: Vec<String> = set.rules.iter().map(ToString::to_string).collect();
    assert_eq!(
        rules,
        [
            "rule half: 0.5*a => a/2 class=real;",
            "rule neg-one: -a => -1*a class=real;"
        ]
    );
    let shown = warnings.render_plain();
    for word in [
        "no operation 'pow'",
        "matches every value",
        "'PI' is not a variable",
        "rules.rkt:6:",
    ] {
        assert!(shown.contains(word), "{word}: {shown}");
    }
    assert!(!warnings.has_errors());
}

#[test]
fn programs_of_egglog_are_read_past_their_other_commands() {
    let text = "(datatype Math (Num f64))\n(ruleset fast)\n; twice\n\
                (rewrite (Add x x) (Mul (Num 2.0) x) :ruleset fast)\n\
                (birewrite (Mul ?a ?b) (Mul ?b ?a))\n\
                (rewrite (Div (Mul a (Num n)) (Num n)) a :when ((!= n 0.0)))\n\
                (rewrite (Div a a) (Num 1.0) :when ((!= a b)))\n(run 10)\n";
    let (set, warnings) = import(text, "my.egg", Syntax::Egglog).expect("well formed");
    let rules: Vec<String> = set.rules.iter().map(ToString::to_string).collect();
    assert_eq!(
        rules,
        [
            "rule egglog-1: x + x => 2*x class=real \"twice\";",
            "rule egglog-2: a*b <=> b*a class=real;",
            "rule egglog-3: a*n/n => a when nonzero(n) class=real;",
        ]
    );
    let warned = warnings.render_plain();
    assert!(warned.contains("no such condition"));
    assert!(warned.contains("the ruleset 'fast' is not kept"));
    assert_eq!(warnings.diagnostics().len(), 2);
}

#[test]
fn commands_and_options_that_are_not_read_are_warned_of() {
    let text = "(rewrite (Add x x) (Mul (Num 2.0) x) :ruleset fast :subsume)\n\
                (rewrite (Sub x x) (Num 0.0) :ruleset fast)\n\
                (rewrite (Add x y) (Add y x) :until 3)\n\
                (rule ((= e (Sub a a))) ((union e (Num 0.0))))\n\
                (include \"more.egg\")\n(run 3)\n";
    let (set, warnings) = import(text, "my.egg", Syntax::Egglog).expect("well formed");
    assert_eq!(set.rules.len(), 2);
    let shown = warnings.render_plain();
    for word in [
        "ruleset 'fast'",
        "no such option",
        "'rule' is not a rewrite",
        "'include' is not",
    ] {
        assert_eq!(shown.matches(word).count(), 1, "{word}: {shown}");
    }
    assert_eq!(warnings.diagnostics().len(), 4);
}

#[test]
fn mistakes_are_placed() {
    for (text, place, expected) in [
        ("(rewrite (Add a b)", "1:1", "not closed"),
        ("(rewrite (Add a b) c))", "1:22", "no parenthesis is open"),
        ("(rewrite (Add a b] c)", "1:18", "not of the kind"),
        ("(rewrite (Add a b))", "1:1", "a left side and a right side"),
        (
            "(rewrite (Add a b) (Add b c))",
            "1:20",
            "'c' does not occur",
        ),
        ("(rewrite (Add a) a)", "1:10", "two operands, not 1"),
        ("(rewrite ((a) b) b)", "1:10", "an operation"),
        ("(rewrite (Add a 1e999) a)", "1:17", "too large"),
        ("(rewrite (Add a 1e-999) a)", "1:17", "too small"),
        ("(rewrite (Add a b) b :when)", "1:22", "has a value"),
        ("(rewrite \"x", "1:10", "no closing"),
        ("rewrite", "1:1", "a command"),
    ] {
        let shown = shown(text, Syntax::Egglog);
        assert!(shown.contains(expected), "{text}: {shown}");
        assert!(
            shown.contains(&format!("other.egg:{place}")),
            "{text}: {shown}"
        );
    }
    assert!(shown("(define-rules x [a (+ b c)])", Syntax::Herbie).contains("a name"));
}

#[test]
fn hostile_texts_are_refused_quickly() {
    let deep = format!(
        "(rewrite {}a{} a)",
        "(Neg ".repeat(100_000),
        ")".repeat(100_000)
    );
    assert!(shown(&deep, Syntax::Egglog).contains("at most 200"));
    assert!(shown(&"(".repeat(200_000), Syntax::Egglog).contains("not closed"));
    assert!(shown("\u{0}\u{1}", Syntax::Egglog).contains("a command"));
    let many = format!("(define-rules x {})", "[p (pow a b) a]".repeat(10_000));
    let (set, warnings) = import(&many, "f", Syntax::Herbie).expect("well formed");
    assert!(set.rules.is_empty());
    assert_eq!(warnings.diagnostics().len(), 51);
}
