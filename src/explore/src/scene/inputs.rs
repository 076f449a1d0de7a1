//! Inputs in a scene file: parameters, numbers, ranges, and held joints.

use super::INPUT;
use super::arrays::SceneArrays;
use super::document::{
    DocumentProblems, DocumentRange, DocumentTable, DocumentValue, array, get, limited, string,
    strings, table,
};
use super::known::{ElementKnowledge, ElementStatements, Rank};
use robovec_dynamics::kinematics;
use robovec_framework::scene::{ElementPattern, HeldJoint, Hold, IndexPattern};
use robovec_ir::Shape;
use robovec_model::Model;
use toml::de::DeValue;

/// Reader of all entries of a scene about inputs.
pub(super) struct InputReader<'r> {
    pub(super) arrays: &'r SceneArrays,
    pub(super) model: Option<&'r Model>,
    pub(super) words: ElementStatements,
    pub(super) problems: &'r mut DocumentProblems,
}

/// Meaning of the numbers of a section.
#[derive(Clone, Copy, PartialEq, Eq)]
enum InputSection {
    Bind,
    Range,
}

impl InputReader<'_> {
    /// Reads the sections, the most general ones first.
    pub(super) fn read(&mut self, file: &DocumentTable<'_>) -> Vec<HeldJoint> {
        if let Some(value) = get(file, "parameters") {
            self.parameters(value);
        }
        for (section, key) in [(InputSection::Bind, "bind"), (InputSection::Range, "range")] {
            let entries = get(file, key).and_then(|value| table(value, self.problems));
            for (key, value) in entries.into_iter().flatten() {
                self.entry(section, key.get_ref(), &key.span(), value);
            }
        }
        if let Some(value) = get(file, "free") {
            for (text, span) in strings(value, self.problems) {
                let read = self.arrays.pattern(text);
                if let Some((array, pattern)) = self.problems.take(&span, read) {
                    self.say(array, &pattern, ElementKnowledge::Free, &span);
                }
            }
        }
        let held = self.joints(file);
        self.limits();
        held
    }

    /// Limits positions to the ranges of joints, where the scene is silent.
    fn limits(&mut self) {
        let joints = self.model.map_or(&[][..], |model| &model.joints);
        for (joint, number) in joints.iter().zip(1..) {
            let Some([low, high]) = joint.limits else {
                continue;
            };
            let known = ElementKnowledge::Range(low, high);
            let (rank, nowhere) = (Rank::Model, 0..0);
            self.words
                .element("q", [number, 0], rank, known, &nowhere, self.problems);
        }
    }

    fn say(
        &mut self,
        array: usize,
        pattern: &ElementPattern,
        known: ElementKnowledge,
        span: &DocumentRange,
    ) {
        let shape = self.arrays.list[array].shape;
        self.words.say(shape, pattern, known, span, self.problems);
    }

    fn parameters(&mut self, value: &DocumentValue<'_>) {
        match string(value, self.problems) {
            None => return,
            Some("from-model") => {}
            Some(other) => {
                let known = &["from-model"];
                let what = "parameters cannot come from";
                self.problems.unknown(value.span(), what, other, known);
                return;
            }
        }
        let Some(model) = self.model else {
            let note = "name the model instead of the equations, or bind them in [bind]";
            let message = "there is no model that parameters could come from";
            self.problems
                .advise(value.span(), message, Some(note.to_owned()));
            return;
        };
        for known in &self.arrays.list {
            for offset in 0..known.shape.len() as u32 {
                let (indices, count) = known.shape.indices(offset);
                let number = kinematics::parameter(model, &known.name, &indices[..count]);
                let Some(number) = number else { continue };
                let (rank, bound) = (Rank::Model, ElementKnowledge::Bound(number));
                let name = &known.name;
                self.words
                    .element(name, indices, rank, bound, &value.span(), self.problems);
            }
        }
    }

    /// One entry of `[bind]` or `[range]`.
    fn entry(
        &mut self,
        section: InputSection,
        key: &str,
        span: &DocumentRange,
        value: &DocumentValue<'_>,
    ) {
        let read = self.arrays.pattern(key);
        let Some((array, pattern)) = self.problems.take(span, read) else {
            return;
        };
        let DeValue::Table(exceptions) = value.get_ref() else {
            self.value(section, array, &pattern, span, value);
            return;
        };
        if !pattern.indices.is_empty() {
            let message = "a table of names belongs to a whole array";
            self.problems.add(value.span(), message);
            return;
        }
        for (word, value) in exceptions {
            let (name, span) = (word.get_ref().as_ref(), word.span());
            if name == "all" {
                self.value(section, array, &pattern, &span, value);
                continue;
            }
            let index = self.arrays.last_index(array, name);
            let Some(index) = self.problems.take(&span, index) else {
                continue;
            };
            let last = IndexPattern::Between(index, index);
            let indices = match self.arrays.list[array].shape {
                Shape::Matrix(..) => vec![IndexPattern::Any, last],
                Shape::Scalar | Shape::Vector(_) => vec![last],
            };
            let pattern = ElementPattern {
                indices,
                ..pattern.clone()
            };
            self.value(section, array, &pattern, &span, value);
        }
    }

    /// The number, range or list of numbers of some elements.
    fn value(
        &mut self,
        section: InputSection,
        place: usize,
        pattern: &ElementPattern,
        span: &DocumentRange,
        value: &DocumentValue<'_>,
    ) {
        if section == InputSection::Range {
            if let Some([low, high]) = self.range(value) {
                self.say(place, pattern, ElementKnowledge::Range(low, high), span);
            }
            return;
        }
        let DeValue::Array(list) = value.get_ref() else {
            if let Some(number) = limited(value, ("bind", INPUT), self.problems) {
                self.say(place, pattern, ElementKnowledge::Bound(number), span);
            }
            return;
        };
        let rows = match (self.arrays.list[place].shape, pattern.indices.as_slice()) {
            (Shape::Matrix(rows, _), [IndexPattern::Any, _] | []) => Some(rows),
            (Shape::Vector(length), []) => Some(length),
            _ => None,
        };
        if rows != Some(list.len() as u32) {
            let message = match rows {
                Some(rows) => format!("expected one number, or {rows}, not {}", list.len()),
                None => "expected one number".to_owned(),
            };
            self.problems.add(value.span(), message);
            return;
        }
        for (item, row) in list.iter().zip(1..) {
            let Some(number) = limited(item, ("bind", INPUT), self.problems) else {
                continue;
            };
            let mut indices = vec![IndexPattern::Between(row, row)];
            indices.extend(pattern.indices.get(1).copied());
            if pattern.indices.is_empty()
                && matches!(self.arrays.list[place].shape, Shape::Matrix(..))
            {
                indices.push(IndexPattern::Any);
            }
            let element = ElementPattern {
                indices,
                ..pattern.clone()
            };
            self.say(place, &element, ElementKnowledge::Bound(number), span);
        }
    }

    /// `[low, high]`.
    fn range(&mut self, value: &DocumentValue<'_>) -> Option<[f64; 2]> {
        let list = array(value, self.problems)?;
        let [low, high] = list.as_ref() else {
            let message = format!("a range is [low, high], not {} numbers", list.len());
            return self.problems.refuse(value.span(), message);
        };
        let [first, last] = [low, high].map(|end| limited(end, ("range", INPUT), self.problems));
        let (low, high) = (first?, last?);
        if low > high {
            let message = format!("the low end {low} is above the high end {high}");
            let note = "exchange them".to_owned();
            self.problems.advise(value.span(), message, Some(note));
            return None;
        }
        Some([low, high])
    }

    /// The joints that are locked or driven.
    fn joints(&mut self, file: &DocumentTable<'_>) -> Vec<HeldJoint> {
        let mut held: Vec<(HeldJoint, DocumentRange)> = Vec::new();
        let locked = get(file, "locked").and_then(|value| table(value, self.problems));
        for (word, value) in locked.into_iter().flatten() {
            let (name, span) = (word.get_ref().as_ref(), word.span());
            let number = self.arrays.joint(name);
            let Some(number) = self.problems.take(&span, number) else {
                continue;
            };
            if let Some(position) = self.position(number, value) {
                self.add(&mut held, number, Hold::Locked(position), span);
            }
        }
        if let Some(value) = get(file, "driven") {
            for (name, span) in strings(value, self.problems) {
                if let Some(number) = self.problems.take(&span, self.arrays.joint(name)) {
                    self.add(&mut held, number, Hold::Driven, span);
                }
            }
        }
        held.sort_by_key(|(joint, _)| joint.number);
        for (joint, span) in &held {
            let Hold::Locked(position) = joint.hold else {
                continue;
            };
            for (array, number) in [("q", position), ("qd", 0.0), ("qdd", 0.0)] {
                if self.arrays.list.iter().any(|known| known.name == array) {
                    let (indices, known) = ([joint.number, 0], ElementKnowledge::Bound(number));
                    let rank = Rank::Joint;
                    self.words
                        .element(array, indices, rank, known, span, self.problems);
                }
            }
        }
        held.into_iter().map(|(joint, _)| joint).collect()
    }

    fn add(
        &mut self,
        held: &mut Vec<(HeldJoint, DocumentRange)>,
        number: u32,
        hold: Hold,
        span: DocumentRange,
    ) {
        let name = self.arrays.joint_name(number);
        if let Some((_, other)) = held.iter().find(|(joint, _)| joint.number == number) {
            let message = format!("the joint '{name}' is held already");
            let other = Some((other.clone(), "here"));
            self.problems.point(span, message, None, other);
            return;
        }
        held.push((HeldJoint { number, name, hold }, span));
    }

    /// Place where a locked joint stays.
    fn position(&mut self, joint: u32, value: &DocumentValue<'_>) -> Option<f64> {
        let DeValue::String(text) = value.get_ref() else {
            return limited(value, ("locked", INPUT), self.problems);
        };
        match (text.as_ref(), self.model) {
            ("initial", Some(model)) => Some(model.joints[joint as usize - 1].initial[0]),
            ("initial", None) => {
                let message = "there is no model that gives the initial position";
                self.problems.refuse(value.span(), message)
            }
            (other, _) => {
                let what = "a position is a number or 'initial', not";
                self.problems
                    .unknown(value.span(), what, other, &["initial"]);
                None
            }
        }
    }
}
