use super::super::RuleSet;
use super::*;

fn rule(text: &str) -> Rule {
    let set = RuleSet::parse(&format!("rule r: {text};"), "test.rules");
    set.expect("well formed").rules.remove(0)
}

fn thesis() -> Machine {
    Machine::built_in("thesis").expect("it ships")
}

#[test]
fn associativity_with_commutativity_grows_as_counted() {
    let growing = alone(&rule("a + (b + c) <=> (a + b) + c"));
    assert_eq!(growing.growth, Growth::Exponential(3.0));
    assert_eq!(growing.formula, "3^n - 2*2^n + n + 1");
    assert_eq!(growing.family, "a sum of n terms");
}

#[test]
fn rules_that_end_are_told_from_those_that_do_not() {
    assert!(matches!(
        alone(&rule("a*b + a*c => a*(b + c)")).growth,
        Growth::Polynomial(_)
    ));
    assert_eq!(alone(&rule("a*b => (a + 1)*b - b")).growth, Growth::Endless);
}

#[test]
fn cycles_and_operations_follow_the_machine() {
    let change = cost::change(&rule("a*(b + c) => a*b + a*c"), &thesis());
    assert_eq!((change.operations, change.cycles), (1, 0));
    assert_eq!(change.late, Some(("b".to_owned(), 0)));
    let change = cost::change(&rule("a*(b*x + c) => (a*b)*x + a*c"), &thesis());
    assert_eq!(change.late, Some(("x".to_owned(), -7)));
    let change = cost::change(&rule("a*a - b*b => (a - b)*(a + b)"), &thesis());
    assert_eq!((change.operations, change.cycles), (0, 0));
    // Equal operations are counted once, sines not at all.
    let change = cost::change(&rule("sin(a)*b + sin(a)*b => 2*(sin(a)*b)"), &thesis());
    assert_eq!(change.operations, 0);
}

#[test]
fn distribution_is_riskier_than_factoring() {
    let transfer = error::transfer(&rule("a*(b + c) => a*b + a*c"), POINTS);
    assert!(transfer.left.high < 2.0, "{transfer:?}");
    assert!(transfer.right.high > 4.0, "{transfer:?}");
    let back = error::transfer(&rule("a*b + a*c => a*(b + c)"), POINTS);
    assert_eq!((back.left, back.right), (transfer.right, transfer.left));
    let exact = error::transfer(&rule("a + b => b + a"), POINTS);
    assert_eq!(exact.left, exact.right);
    assert!(exact.left.high <= 0.5);
}

#[test]
fn the_pair_that_blows_up_is_named() {
    let text = "rule signed: a + (b - c) <=> (a + b) - c;\n\
                rule absorb: a + -b <=> a - b;\n\
                rule calm: a*b + a*c => a*(b + c);\n";
    let set = RuleSet::parse(text, "test.rules").expect("well formed");
    let rules: Vec<&Rule> = set.rules.iter().collect();
    let pairs = pairs(&rules, &rules, &mut |_, _| {});
    let names: Vec<String> = pairs.iter().map(|pair| pair.names.join(" with ")).collect();
    assert_eq!(names, ["signed with absorb"]);
    let associative = rule("a + (b + c) <=> (a + b) + c");
    assert_eq!(partner(&associative).as_deref(), Some("add-commutes"));
    assert_eq!(partner(&rule("a*b => (a + 1)*b - b")).as_deref(), Some("r"));
}
