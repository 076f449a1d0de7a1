//! Cost curves of classes: cost against the time they are needed at.
//!
//! The *curve* of a class holds its ways to be computed, the earliest first and
//! every later one cheaper (Chaudhary and Pedram 1992, for trees of gates). A
//! class that is used in several places shares its operations among them, by
//! its number of uses when forms were last chosen (*area flow*; Manohararajah,
//! Brown and Vranesic 2006). Curves are valid for every required time of the
//! outputs, and are made again only where a part changed.

use super::dense::FlowState;

/// One way to compute a class.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct CurvePoint {
    pub(super) arrival: u32,
    pub(super) form: u32,
    /// Share of the operations per user.
    pub(super) flow: f32,
}

/// Points that a curve has at most; six were no better than four.
pub(super) const POINTS: usize = 4;

/// By class its curve.
#[derive(Clone)]
pub(super) struct Curves {
    /// [`POINTS`] for every class, of which its count are in use.
    pub(super) points: Vec<CurvePoint>,
    pub(super) counts: Vec<u8>,
    /// By class its fewest operations and its earliest arrival, though no point
    /// need have both: no form that uses it does better.
    pub(super) best: Vec<FlowState>,
    /// The number of users that its curve was made for.
    pub(super) shares: Vec<f32>,
    /// True if its curve changed when curves were made last.
    pub(super) changed: Vec<bool>,
    /// The forms that outputs may come to use, by class.
    pub(super) live: Vec<u32>,
}

impl Curves {
    /// Curves without points.
    pub(super) fn new(classes: usize) -> Curves {
        Curves {
            points: vec![CurvePoint::default(); classes * POINTS],
            counts: vec![0; classes],
            best: vec![FlowState::UNKNOWN; classes],
            shares: vec![0.0; classes],
            changed: vec![true; classes],
            live: Vec::new(),
        }
    }

    pub(super) fn of(&self, class: usize) -> &[CurvePoint] {
        let start = class * POINTS;
        &self.points[start..start + usize::from(self.counts[class])]
    }

    #[inline]
    pub(super) fn point(&self, class: usize, point: usize) -> CurvePoint {
        self.points[class * POINTS + point]
    }

    /// The place of the cheapest point that is in time, or the earliest.
    pub(super) fn in_time(&self, class: usize, required: u32) -> usize {
        let curve = self.of(class);
        let late = curve.partition_point(|point| point.arrival <= required);
        late.max(1) - 1
    }

    /// Adds a point to a curve unless another is as good.
    pub(super) fn add(curve: &mut Vec<CurvePoint>, point: CurvePoint) {
        if is_beaten(curve, point.arrival, point.flow) {
            return;
        }
        let place = curve.partition_point(|known| known.arrival < point.arrival);
        let worse = curve[place..].iter();
        let worse = worse.take_while(|known| known.flow >= point.flow).count();
        curve.splice(place..place + worse, [point]);
        debug_assert!(
            curve.is_sorted_by(|one, next| one.arrival < next.arrival && one.flow > next.flow),
            "every later point is cheaper"
        );
        if curve.len() > POINTS {
            curve.remove(most_dispensable(curve));
        }
    }
}

/// The point without which a curve loses least: those who would have taken it
/// take the one before.
fn most_dispensable(curve: &[CurvePoint]) -> usize {
    let loss = |&at: &usize| {
        let time = curve[at + 1].arrival - curve[at].arrival;
        (curve[at - 1].flow - curve[at].flow) * time as f32
    };
    let between = 1..curve.len() - 1;
    let least = between.min_by(|a, b| loss(a).total_cmp(&loss(b)));
    least.expect("a curve with too many points has one between two")
}

/// Tests whether a curve has a point as early and as cheap.
pub(super) fn is_beaten(curve: &[CurvePoint], arrival: u32, flow: f32) -> bool {
    let late = curve.partition_point(|known| known.arrival <= arrival);
    let before = late.checked_sub(1);
    before.is_some_and(|last| curve[last].flow <= flow)
}
