//! The making of curves: again only where something changed.

use super::curves::{CurvePoint, Curves, POINTS, is_beaten};
use super::dense::{FlowState, FormFlow, FormsByClass};
use super::trial::FormTrial;
use smallvec::SmallVec;

/// The part by which operations change before a curve is made again.
const TOLERANCE: f32 = 0.01;

/// Buffers kept from one class to the next while curves are made.
#[derive(Default)]
struct CurveSpace {
    trial: FormTrial,
    curve: Vec<CurvePoint>,
}

impl Curves {
    /// Makes the curves of all classes, which have this number of users.
    pub(super) fn update(&mut self, forms: &FormsByClass<'_>, shares: &[f32], outputs: &[usize]) {
        assert_eq!(shares.len(), self.counts.len(), "every class has a share");
        let mut space = CurveSpace::default();
        for (class, &share) in shares.iter().enumerate() {
            self.class(forms, class, share, forms.of(class), &mut space);
        }
        self.find_live(forms, outputs);
    }

    /// Makes the curves of those classes that others had a use for when all
    /// were made last, from the forms that were of use.
    pub(super) fn update_live(&mut self, forms: &FormsByClass<'_>, shares: &[f32]) {
        let mut space = CurveSpace::default();
        let live = std::mem::take(&mut self.live);
        for of_class in live.chunk_by(|&a, &b| forms.class_of(a) == forms.class_of(b)) {
            let class = forms.class_of(of_class[0]);
            let of_class = of_class.iter().copied();
            self.class(forms, class, shares[class], of_class, &mut space);
        }
        self.live = live;
    }

    /// Finds the forms of the points that outputs may come to use.
    fn find_live(&mut self, forms: &FormsByClass<'_>, outputs: &[usize]) {
        let mut is_used = vec![false; self.counts.len()];
        for &output in outputs {
            is_used[output] = true;
        }
        let mut live = std::mem::take(&mut self.live);
        live.clear();
        for class in (0..is_used.len()).rev() {
            if !is_used[class] {
                continue;
            }
            let start = live.len();
            for point in self.of(class) {
                if !live[start..].contains(&point.form) {
                    live.push(point.form);
                    forms.operands(point.form, |operand| is_used[operand] = true);
                }
            }
        }
        live.reverse();
        self.live = live;
    }

    /// Makes the curve of a class from some of its forms, unless all its
    /// dependences are unchanged.
    fn class(
        &mut self,
        forms: &FormsByClass<'_>,
        class: usize,
        share: f32,
        of_class: impl Iterator<Item = u32> + Clone,
        space: &mut CurveSpace,
    ) {
        let is_known = (self.shares[class] - share).abs() <= TOLERANCE * share;
        let is_behind = |form: u32| {
            let mut is_behind = false;
            forms.operands(form, |operand| is_behind |= self.changed[operand]);
            is_behind
        };
        if is_known && !of_class.clone().any(is_behind) {
            self.changed[class] = false;
            return;
        }
        self.shares[class] = share;
        space.curve.clear();
        // What was of use mostly is again: beside it most others need not be
        // looked at closely.
        let known: SmallVec<[u32; POINTS]> =
            self.of(class).iter().map(|point| point.form).collect();
        let others = of_class.filter(|form| !known.contains(form));
        for form in known.iter().copied().chain(others) {
            let Some((flow, earliest)) = self.outlook(forms, form) else {
                continue;
            };
            if !is_beaten(&space.curve, earliest, flow / share) {
                space.trial.read(forms, self, form);
                space.trial.trace(self, earliest, share, &mut space.curve);
            }
        }
        let is_changed = !is_alike(self.of(class), &space.curve);
        self.changed[class] = is_changed;
        if is_changed {
            let start = class * POINTS;
            self.points[start..start + space.curve.len()].copy_from_slice(&space.curve);
            self.counts[class] = space.curve.len() as u8;
            if let (Some(first), Some(last)) = (space.curve.first(), space.curve.last()) {
                self.best[class] = FlowState {
                    flow: f64::from(last.flow),
                    arrival: first.arrival,
                };
            }
        }
    }

    /// Minimum number of operations of a form and a time before which it is not
    /// available, for any choice of points. `None` when one of its classes
    /// cannot be computed.
    fn outlook(&self, forms: &FormsByClass<'_>, form: u32) -> Option<(f32, u32)> {
        match forms.flow(&self.best, form, f64::INFINITY) {
            FormFlow::Found(flow, (earliest, _)) => Some((flow as f32, earliest)),
            FormFlow::TooMuch | FormFlow::Missing(_) => None,
        }
    }
}

fn is_alike(a: &[CurvePoint], b: &[CurvePoint]) -> bool {
    let alike = |(a, b): (&CurvePoint, &CurvePoint)| {
        a.arrival == b.arrival && a.form == b.form && (a.flow - b.flow).abs() <= TOLERANCE * b.flow
    };
    a.len() == b.len() && a.iter().zip(b).all(alike)
}
