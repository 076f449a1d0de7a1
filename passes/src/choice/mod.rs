//! Networks of choices: values that can be computed in several ways, and the
//! cheapest way that is early enough.
//!
//! A [`ChoiceNetwork`](network::ChoiceNetwork) holds *classes*, each
//! representing one value up to its sign, and for each class its *forms*: sums
//! of products of other classes. Classes are identified by the value itself,
//! taken at a random point of two prime fields and of the real numbers
//! ([`Fingerprint`](robovec_framework::fingerprint::Fingerprint)): two
//! expressions that are equal as polynomials meet in one class however they
//! were derived, so there is nothing to saturate and associativity and
//! commutativity cost nothing. Two different values are confused with
//! probability below (classes² · degree²) / 2¹²⁰, and only if they are also the
//! same number within the rounding of double-double.
//!
//! A [`Mapping`](map::Mapping) chooses one form per class, as technology
//! mappers do for logic networks: early enough, with few operations over all
//! outputs, a class that several chosen forms use being paid for once. Forms
//! are chosen by [curves](curve_map) of the cost of a class over its required
//! time, or, in large networks, by [flow]; then operations are counted exactly
//! (Mishchenko, Chatterjee and Brayton 2007).
//!
//! **Invariant.** Every form of a class only uses classes of smaller rank, so
//! any choice of forms is free of cycles.

pub(crate) mod chooser;
pub(crate) mod compose;
mod curve_map;
mod curve_update;
mod curves;
mod dense;
pub(crate) mod emit;
mod flow;
mod forms;
pub(crate) mod import;
pub(crate) mod map;
pub(crate) mod network;
mod order;
mod recent;
pub(crate) mod search;
pub(crate) mod term;
pub(crate) mod timing;
mod trial;
