//! Counting the rewrites of a pass, and stopping after some of them.
//!
//! A pass that rewrites piece by piece calls it before each piece. Without a
//! limit the answer is yes and costs a counter; when a rewrite has broken a
//! function, running the pass with a smaller and smaller limit finds that
//! rewrite (as `-opt-bisect-limit` does for whole passes in LLVM).
//!
//! Invariants: questions come in an order that the function alone decides, and
//! those up to the limit do not depend on the limit. A refused piece is left as
//! the original operations.

use robovec_ir::Name;
use std::cell::{Cell, RefCell};

/// The rewrites of one run of a pass.
#[derive(Default, Debug)]
pub struct RewriteLimit {
    limit: Option<u64>,
    asked: Cell<u64>,
    last: RefCell<Option<(Name, String)>>,
}

impl RewriteLimit {
    /// Any number of rewrites, or the first `limit` only.
    pub fn new(limit: Option<u64>) -> RewriteLimit {
        RewriteLimit {
            limit,
            ..RewriteLimit::default()
        }
    }

    /// Tests whether the value of this name may be rewritten; `rule` names how,
    /// in a few words or by the name of a rule.
    ///
    /// A group of operations is one rewrite, requested by the name of its
    /// result; inner nodes at the equations level have none ([`Name::NONE`]).
    #[inline]
    pub fn allow(&self, name: Name, rule: &str) -> bool {
        let number = self.asked.get() + 1;
        self.asked.set(number);
        let Some(limit) = self.limit else {
            return true;
        };
        if number == limit {
            *self.last.borrow_mut() = Some((name, rule.to_owned()));
        }
        number <= limit
    }

    /// True when a rewrite has been refused. A pass that compares its result
    /// with its input must then give the result nevertheless, and stop, whether
    /// or not the first rewrites alone are an improvement.
    pub fn has_refused(&self) -> bool {
        self.limit.is_some_and(|limit| self.asked.get() > limit)
    }

    /// The number of rewrites requested, refused ones included.
    pub fn asked(&self) -> u64 {
        self.asked.get()
    }

    /// The rewrite at the limit, when it was reached: the value's name, and the
    /// rule.
    pub fn last(&self) -> Option<(Name, String)> {
        self.last.borrow().clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_rewrites_are_allowed_and_the_last_one_is_known() {
        let name = |suffix| Name {
            base: robovec_ir::Symbol(0),
            suffix,
        };
        let free = RewriteLimit::new(None);
        let limited = RewriteLimit::new(Some(2));
        for number in 0..4 {
            assert!(free.allow(name(number), "rule"));
            assert_eq!(limited.allow(name(number), "rule"), number < 2);
        }
        assert_eq!((free.asked(), free.last()), (4, None));
        assert_eq!(limited.asked(), 4);
        assert!(limited.has_refused() && !free.has_refused());
        assert_eq!(limited.last(), Some((name(1), "rule".to_owned())));
        assert!(!RewriteLimit::new(Some(0)).allow(name(0), "rule"));
    }
}
