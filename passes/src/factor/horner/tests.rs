use super::polynomials::NetworkPolynomials;
use super::rebuild::rebuild;
use super::schemes::{SchemeBuffers, SchemeSet};
use super::search::orders;
use crate::factor::network::FactorNetwork;
use crate::factor::read::read;
use robovec_framework::rewrite_limit::RewriteLimit;
use robovec_ir::parse::parse_module;

/// The sum over all i < j < k of x[i]*x[j]*x[k], written out over eight
/// variables, with its terms in an order that shares little.
fn symmetric() -> FactorNetwork {
    let mut text = "function f atomic {\n  in x[1..8]\n  out o\n\n".to_owned();
    let mut sum = String::new();
    for (number, mask) in (0..256u32)
        .filter(|mask| mask.count_ones() == 3)
        .enumerate()
    {
        let mask = mask.rotate_left(number as u32 * 8);
        let bits: Vec<u32> = (0..32)
            .filter(|bit| mask >> bit & 1 == 1)
            .map(|bit| bit % 8 + 1)
            .collect();
        let [a, b, c] = bits[..] else {
            unreachable!("three bits are set")
        };
        text += &format!("  %p.{number} = x[{a}]*x[{b}]\n  %q.{number} = %p.{number}*x[{c}]\n");
        let next = format!("%s.{number}");
        if number > 0 {
            text += &format!("  {next} = {sum} + %q.{number}\n");
        }
        sum = if number > 0 { next } else { "%q.0".to_owned() };
    }
    text += &format!("\n  o = {sum}\n}}\n");
    let mut module = parse_module("symmetric", &text).expect("it is well formed");
    let function = module.functions[0].clone();
    read(&function, &mut module.tables, false)
}

/// Calls back with the parts of a search in a network of polynomials.
fn with_set(of: impl FnOnce(&FactorNetwork, &[u32], &NetworkPolynomials, &SchemeSet)) {
    let mut network = symmetric();
    let order = network.order();
    network.regroup(&order);
    let order = network.renumber();
    let polynomials = NetworkPolynomials::read(&network, &order, true, &RewriteLimit::default());
    let set = SchemeSet::new(&polynomials, &order);
    of(&network, &order, &polynomials, &set);
}

#[test]
fn a_scheme_costs_what_was_counted() {
    with_set(|network, order, polynomials, set| {
        for rated in orders(set, 200_000, 8, 1) {
            let mut buffers = SchemeBuffers::default();
            assert_eq!(set.cost(&rated.ranks, &mut buffers), rated.cost);
            let rebuilt = rebuild(network, order, polynomials, set, &rated.ranks);
            assert_eq!(rebuilt.cost, rated.cost as i64);
        }
    });
}

#[test]
fn a_search_finds_the_same_orders_again_and_more_work_finds_better_ones() {
    with_set(|network, _, _, set| {
        let found = orders(set, 200_000, 8, 1);
        assert_eq!(found, orders(set, 200_000, 8, 1));
        assert!(found.len() <= 8 && found[0].cost <= orders(set, 0, 8, 1)[0].cost);
        assert!((found[0].cost as i64) < network.cost / 2);
    });
}
