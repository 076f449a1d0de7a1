//! The parts of a proof, one after the other.

use super::super::rule::Rule;
use super::agree::{Agreement, agree};
use super::ball::ScaledBall;
use super::counterexample::{Counterexample, compare, smallest};
use super::facts::NodeFacts;
use super::joined::Joined;
use super::point::{RealPoint, evaluate};
use super::states::RulePoints;
use super::{RuleVerdict, domain, zeros};
use robovec_ir::Operation;
use std::fmt;

/// States at which numbers are compared.
const STATES: u32 = 64;
/// States tried for those at which both sides are defined.
const MAX_TRIED: u32 = 1_024;
/// Minimum number of states for a proof.
const FEWEST: u32 = 8;
/// Real points that show signs.
const REALS: usize = 6;

/// The facts established about a rule that is proved.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Proof {
    /// True when sine and cosine must lie on the circle.
    pub circle: bool,
    /// Points at which the sides agree in each of two prime fields.
    pub points: u32,
    /// Real states at which they agree as numbers.
    pub states: u32,
    /// Their largest distance there, by the largest number that occurs.
    pub distance: f64,
}

impl fmt::Display for Proof {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let states = match self.states {
            1 => "one state".to_owned(),
            states => format!("{states} states"),
        };
        write!(
            formatter,
            "equal at {} points of each of two prime fields and at {states} within {:.0e}",
            self.points, self.distance
        )
    }
}

/// The reason why a rule is neither proved nor refuted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Doubt {
    /// The sides differ in the prime fields.
    Fields,
    /// The sides are hardly ever both defined.
    Nowhere,
    /// Roots: the points that their radicands on the left side permit may be
    /// unknown.
    Roots,
    /// This number of the right side may be zero or negative, where it must
    /// not be.
    Domain(String),
    /// In floating point not one result has the same bits.
    Bits,
}

impl fmt::Display for Doubt {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Doubt::Fields => {
                "the sides differ in a prime field, but no numbers were found that distinguish \
                 them; the proof does not know which sums are positive"
            }
            Doubt::Nowhere => "no place was found where both sides are defined",
            Doubt::Roots => "the left side may be defined at single points beyond the proof",
            Doubt::Domain(operand) => {
                return write!(
                    formatter,
                    "nothing shows that the right side is defined wherever the left side is: \
                     {operand}"
                );
            }
            Doubt::Bits => "in floating point no result of the two sides has equal bits",
        })
    }
}

/// Proves or refutes a rule in each of its directions.
pub(super) fn verdict(rule: &Rule) -> RuleVerdict {
    let mut verdicts = rule
        .directed()
        .into_iter()
        .enumerate()
        .map(|(index, rule)| match one_way(&Joined::new(&rule)) {
            RuleVerdict::False(found) => RuleVerdict::False(Counterexample {
                backwards: index > 0,
                ..found
            }),
            other => other,
        });
    let first = verdicts.next().expect("a rule has a direction");
    verdicts.fold(first, |first, second| match (&first, &second) {
        (RuleVerdict::False(_), _) => first,
        (_, RuleVerdict::False(_)) | (RuleVerdict::Proved(_), RuleVerdict::Unproved(_)) => second,
        (RuleVerdict::Unproved(_), _) => first,
        (RuleVerdict::Proved(one), RuleVerdict::Proved(two)) => RuleVerdict::Proved(Proof {
            circle: one.circle || two.circle,
            points: one.points.min(two.points),
            states: one.states.min(two.states),
            distance: one.distance.max(two.distance),
        }),
    })
}

fn one_way(joined: &Joined<'_>) -> RuleVerdict {
    let doubt = match prove(joined) {
        Ok(proof) => return RuleVerdict::Proved(proof),
        // Small numbers say more to people than those that were met first.
        Err(Refusal::Refuted(found)) => {
            return RuleVerdict::False(smallest(joined).unwrap_or(found));
        }
        Err(Refusal::Doubted(doubt)) => doubt,
    };
    match search(joined) {
        Some(found) => RuleVerdict::False(found),
        None => RuleVerdict::Unproved(doubt),
    }
}

/// The reason why there is no proof.
enum Refusal {
    Doubted(Doubt),
    Refuted(Counterexample),
}

impl From<Doubt> for Refusal {
    fn from(doubt: Doubt) -> Refusal {
        Refusal::Doubted(doubt)
    }
}

fn prove(joined: &Joined<'_>) -> Result<Proof, Refusal> {
    let all = joined.pattern.nodes.len();
    let with_roots = joined.uses(Operation::Sqrt, 0..all);
    let first = same_function(joined, &[]);
    if let (Err(doubt), false) = (&first, with_roots) {
        return Err(doubt.clone().into());
    }
    let (reals, states, distance) = same_numbers(joined)?;
    let partial = with_roots || joined.uses(Operation::Div, joined.left..all);
    let mut found = first;
    if partial {
        let mut facts = NodeFacts::of(joined, &reals)?;
        domain::prove(&mut facts).map_err(|operand| {
            let operand = joined.part(operand).to_text(&joined.rule.variables);
            Doubt::Domain(operand)
        })?;
        if found.is_err() {
            found = same_function(joined, &facts.signs());
        }
    }
    let (circle, points) = found?;
    Ok(Proof {
        circle,
        points: points / 2,
        states,
        distance,
    })
}

/// Tests whether the sides are equal in the fields: on the circle only, and the
/// number of points.
fn same_function(joined: &Joined<'_>, signs: &[(usize, i32)]) -> Result<(bool, u32), Doubt> {
    let mut doubt = Doubt::Nowhere;
    for circle in [false, true] {
        match agree(joined, circle, signs) {
            Agreement::Equal(points) => return Ok((circle, points)),
            Agreement::Different => doubt = Doubt::Fields,
            Agreement::Never => {}
        }
    }
    Err(doubt)
}

/// Compares numbers at states: all nodes at some of them, the number of states,
/// and the largest distance.
fn same_numbers(joined: &Joined<'_>) -> Result<(Vec<Vec<ScaledBall>>, u32, f64), Refusal> {
    let rule = joined.rule;
    let mut states = RulePoints::of(rule, 7);
    let (mut reals, mut seen, mut distance) = (Vec::new(), 0, 0f64);
    let (wanted, tried) = if rule.variables.is_empty() {
        (1, 1)
    } else {
        (STATES, MAX_TRIED)
    };
    for _ in 0..tried {
        let place = RealPoint::exactly(states.next());
        if let Some(found) = compare(joined, &place) {
            return Err(Refusal::Refuted(found));
        }
        let sides = [&rule.left, &rule.right];
        let [Some(left), Some(right)] =
            sides.map(|side| evaluate(side, &place, &joined.fields).numbers())
        else {
            continue;
        };
        distance = distance.max(apart(&left, &right));
        if reals.len() < REALS {
            reals.push(left.into_iter().chain(right).collect());
        }
        seen += 1;
        if seen == wanted {
            break;
        }
    }
    if seen < wanted.min(FEWEST) {
        return Err(Doubt::Nowhere.into());
    }
    Ok((reals, seen, distance))
}

/// A bound of the distance of two sides by the largest of all numbers.
fn apart(left: &[ScaledBall], right: &[ScaledBall]) -> f64 {
    let largest = left
        .iter()
        .chain(right)
        .map(|number| number.log_size())
        .max();
    match (left.last(), right.last(), largest) {
        (Some(left), Some(right), Some(largest)) => {
            let distance = left.plus(right.negative()).log_size() - largest;
            2f64.powi(distance.clamp(-1000, 2) as i32) * f64::from(u8::from(distance > -1000))
        }
        _ => f64::INFINITY,
    }
}

/// Points tried at random when no small one refutes the rule.
const RANDOM: usize = 3_000;

/// Numbers that refute a rule of one direction: the smallest integers at which
/// the sides differ; if there are none, numbers near the constants of the rule,
/// and near the zeros of its divisors and radicands.
fn search(joined: &Joined<'_>) -> Option<Counterexample> {
    smallest(joined)
        .or_else(|| {
            let mut states = RulePoints::of(joined.rule, 1);
            (0..RANDOM).find_map(|_| compare(joined, &RealPoint::exactly(states.next())))
        })
        .or_else(|| zeros::search(joined))
}
