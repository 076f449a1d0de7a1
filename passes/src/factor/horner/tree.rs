//! Search for the first variables: a tree of the beginnings of orders.
//!
//! Monte Carlo tree search after Kuipers, Plaat, Vermaseren and van den Herik
//! ("Improving multivariate Horner schemes with Monte Carlo tree search",
//! 2013): the most promising beginning by the costs of its orders so far and by
//! its number of trials (UCT) is extended by one variable, and the rest is
//! random.

use robovec_num::random::Random;

/// Weight of beginnings that were seldom tried.
const EXPLORATION: f64 = 0.3;

#[derive(Default)]
struct OrderBeginning {
    visits: f64,
    /// The sum of its rewards.
    rewards: f64,
    /// The variables tried next, and their beginnings.
    next: Vec<(u32, usize)>,
}

/// Beginnings tried so far; the first is the empty one.
pub(super) struct OrderTree {
    beginnings: Vec<OrderBeginning>,
    variables: usize,
}

impl OrderTree {
    pub(super) fn new(variables: usize) -> OrderTree {
        OrderTree {
            beginnings: vec![OrderBeginning::default()],
            variables,
        }
    }

    /// The next order to be tried, and its beginnings.
    pub(super) fn next(&mut self, random: &mut Random) -> (Vec<u32>, Vec<usize>) {
        let mut order: Vec<u32> = (0..self.variables as u32).collect();
        let mut path = vec![0];
        for place in 0..self.variables {
            let beginning = path[place];
            let is_full = self.beginnings[beginning].next.len() == self.variables - place;
            let (variable, next) = if is_full {
                self.best(beginning)
            } else {
                self.grow(beginning, &order[place..], random)
            };
            let at = order.iter().position(|&other| other == variable);
            order.swap(
                place,
                at.expect("a beginning goes on with a variable it lacks"),
            );
            path.push(next);
            if !is_full {
                shuffle(&mut order[place + 1..], random);
                break;
            }
        }
        (order, path)
    }

    /// Records the reward of an order with these beginnings.
    pub(super) fn reward(&mut self, path: &[usize], reward: f64) {
        for &beginning in path {
            self.beginnings[beginning].visits += 1.0;
            self.beginnings[beginning].rewards += reward;
        }
    }

    fn best(&self, beginning: usize) -> (u32, usize) {
        let own = &self.beginnings[beginning];
        let promise = |&(_, next): &(u32, usize)| {
            let next = &self.beginnings[next];
            let seldom = (2.0 * own.visits.ln() / next.visits).sqrt();
            next.rewards / next.visits + EXPLORATION * seldom
        };
        let best = own
            .next
            .iter()
            .max_by(|a, b| promise(a).total_cmp(&promise(b)));
        *best.expect("a full beginning goes on")
    }

    /// A new beginning with one of the variables that were not tried.
    fn grow(&mut self, beginning: usize, open: &[u32], random: &mut Random) -> (u32, usize) {
        let tried = &self.beginnings[beginning].next;
        let is_new = |variable: &&u32| tried.iter().all(|(other, _)| other != *variable);
        let new: Vec<u32> = open.iter().filter(is_new).copied().collect();
        let variable = new[random.below(new.len())];
        let next = self.beginnings.len();
        self.beginnings.push(OrderBeginning::default());
        self.beginnings[beginning].next.push((variable, next));
        (variable, next)
    }
}

/// Puts variables into a random order.
fn shuffle(order: &mut [u32], random: &mut Random) {
    for place in (1..order.len()).rev() {
        order.swap(place, random.below(place + 1));
    }
}
