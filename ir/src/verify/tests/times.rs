//! Times of operations: each of the four alone.

use super::after;
use crate::function::{Function, Timing};

const TIMED: &str = "function f atomic {
      in q
      out M
      %a = q + q {asap 1 alap 1 asap_cycle 12 alap_cycle 12}
      %b = %a*q {asap 2 alap 2 asap_cycle 30 alap_cycle 30}
      %c = sin(q) {asap 0 alap 2 asap_cycle 0 alap_cycle 30}
      %d = %b + %c {asap 3 alap 3 asap_cycle 42 alap_cycle 42}
      M = %d
    }";

/// The messages after a change of the times of a node.
fn retimed(node: usize, change: impl FnOnce(&mut Timing)) -> Vec<String> {
    after(TIMED, |function: &mut Function| {
        let timing = function.timing.as_mut().expect("it has times");
        change(&mut timing[node]);
    })
}

#[test]
fn no_earliest_time_comes_after_its_latest() {
    let expected = "%c has an earliest time after its latest";
    assert_eq!(retimed(2, |times| times.asap_cycle = 31), [expected]);
    // What reads it then starts too early as well.
    assert_eq!(retimed(2, |times| times.asap = 3)[..1], [expected]);
}

#[test]
fn each_time_comes_after_that_of_an_operand() {
    let expected = "%b has a time that does not come after that of %a, which it reads";
    let changes: [fn(&mut Timing); 2] = [|times| times.asap = 1, |times| times.asap_cycle = 12];
    for change in changes {
        assert_eq!(retimed(1, change), [expected]);
    }
    // The latest times of an operand may reach those of what reads it.
    let expected = "%d has a time that does not come after that of %c, which it reads";
    let changes: [fn(&mut Timing); 2] = [|times| times.alap = 3, |times| times.alap_cycle = 42];
    for change in changes {
        assert_eq!(retimed(2, change), [expected]);
    }
}

#[test]
fn sines_take_no_time() {
    let messages = retimed(2, |times| times.alap_cycle = 41);
    assert!(messages.is_empty(), "{messages:?}");
}
