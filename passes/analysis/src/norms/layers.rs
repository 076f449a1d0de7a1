//! Sets of values as sums of layers: matrices in blocks times earlier sets.

use super::terms::{NormTermKind, SumDefinition, is_atom};
use super::{Layers, SlotSet};
use crate::adjoint::Tape;
use robovec_ir::Operation;

/// Maximum number of members of a set that is decomposed.
const MEMBERS: usize = 64;

/// A block of a layer: a factor times its operands.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct LayerBlock {
    pub factor: LayerFactor,
    pub operands: SlotSet,
}

/// The factor of a block.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum LayerFactor {
    /// A value.
    Value(usize),
    /// The inverse of a value.
    Inverse(usize),
    /// A row of values, or a rotation with them as cosine and sine.
    Row(SlotSet),
}

/// A block-diagonal matrix times a set.
#[derive(Clone, Default, Debug)]
pub(super) struct Layer {
    pub set: SlotSet,
    /// Some members of the set are not multiplied.
    pub kept: bool,
    pub blocks: Vec<LayerBlock>,
    /// The members of the decomposed set that it contributes to, as bits.
    pub members: u64,
    /// The same as a sum of products of values, if it has that form.
    pub products: Vec<(usize, usize)>,
}

/// A member of a set under decomposition.
struct OpenMember {
    place: usize,
    plains: Vec<usize>,
    products: Vec<(bool, usize, usize)>,
    quotients: Vec<(usize, usize)>,
}

/// A product with a sine or cosine.
#[derive(Clone, Copy, Debug)]
struct WaveProduct {
    /// Its place among the products of a member.
    index: usize,
    angle: usize,
    cosine: bool,
    slot: usize,
    operand: (usize, bool),
}

/// A row `a c + b s` of a rotation about one angle.
struct RotationRow {
    place: usize,
    angle: usize,
    /// The nodes of the cosine and the sine that it reads.
    waves: SlotSet,
    /// The other factor of the cosine, and a flag: true when it is subtracted.
    cosine: Option<(usize, bool)>,
    sine: Option<(usize, bool)>,
}

/// A set as a sum of layers, the definitions of its latest members opened;
/// `None` if it has none that can be.
pub(super) fn decompose(tape: &Tape, uses: &[u32], set: &[usize]) -> Option<Layers> {
    if set.len() > MEMBERS {
        return None;
    }
    let mut order: Vec<usize> = set.to_vec();
    order.sort_by_key(|&slot| std::cmp::Reverse(time(tape, slot)));
    if let Some(split) = split(tape, &order) {
        return Some(split);
    }
    let mut layers = Layers {
        parts: Vec::new(),
        nodes: vec![Vec::new(); order.len()],
    };
    let (mut members, mut kept, mut after) = (Vec::new(), Vec::new(), 0);
    for (place, &slot) in order.iter().enumerate() {
        let opened = if time(tape, slot) > after && kept.is_empty() {
            SumDefinition::of(tape, uses, slot)
        } else {
            None
        };
        match opened {
            Some(definition) => {
                after = after.max(definition.after(tape));
                members.push(OpenMember::new(place, &definition));
                layers.nodes[place] = definition.nodes;
            }
            None => kept.push((place, slot)),
        }
    }
    if members.is_empty() {
        return None;
    }
    let mut open = Opened { tape, members };
    open.main(&kept, &mut layers.parts);
    open.plains(&mut layers.parts);
    open.quotients(&mut layers.parts);
    open.factors(&mut layers.parts);
    open.rest(&mut layers.parts);
    Some(layers)
}

/// Time of a slot: leaves are there before all nodes.
fn time(tape: &Tape, slot: usize) -> usize {
    if slot < tape.nodes() { slot + 1 } else { 0 }
}

/// The angle of a sine or cosine, and a flag: true for the cosine.
fn wave(tape: &Tape, slot: usize) -> Option<(usize, bool)> {
    if slot >= tape.nodes() {
        return None;
    }
    let angle = tape.operands(slot)[0];
    match tape.operation(slot) {
        Operation::Cos => Some((angle, true)),
        Operation::Sin => Some((angle, false)),
        _ => None,
    }
}

/// True for the sine and the cosine of one angle.
pub(super) fn is_pair(tape: &Tape, one: usize, other: usize) -> bool {
    match (wave(tape, one), wave(tape, other)) {
        (Some((angle, first)), Some((same, second))) => angle == same && first != second,
        _ => false,
    }
}

/// The latest member, a sine with its cosine or another value without a
/// definition, in a separate layer; `None` if there is no such member, or no
/// other.
fn split(tape: &Tape, order: &[usize]) -> Option<Layers> {
    let latest = *order.first()?;
    let atom = latest < tape.nodes() && is_atom(tape.operation(latest));
    if !atom || order.len() == 1 || order.len() == 2 && is_pair(tape, order[0], order[1]) {
        return None;
    }
    let partner = (1..order.len()).find(|&place| is_pair(tape, latest, order[place]));
    let mut first: u64 = 1;
    first |= partner.map_or(0, |place| 1 << place);
    let part = |members: u64| {
        let places = (0..order.len()).filter(|place| members >> place & 1 == 1);
        let mut set: SlotSet = places.map(|place| order[place]).collect();
        set.sort_unstable();
        Layer {
            set,
            kept: true,
            members,
            ..Layer::default()
        }
    };
    let all = u64::MAX >> (64 - order.len());
    let mut parts = vec![part(first)];
    if all & !first != 0 {
        parts.push(part(all & !first));
    }
    Some(Layers {
        parts,
        nodes: Vec::new(),
    })
}

impl OpenMember {
    fn new(place: usize, definition: &SumDefinition) -> OpenMember {
        let mut member = OpenMember {
            place,
            plains: Vec::new(),
            products: Vec::new(),
            quotients: Vec::new(),
        };
        for term in &definition.terms {
            match term.kind {
                NormTermKind::Plain(slot) => member.plains.push(slot),
                NormTermKind::Product(a, b) => member.products.push((term.negative, a, b)),
                NormTermKind::Quotient(a, b) => member.quotients.push((a, b)),
            }
        }
        member
    }

    /// Takes out the terms that are a row of a rotation: two products with
    /// the sine and the cosine of one angle, or the only term, with one.
    fn rotation(&mut self, tape: &Tape) -> Option<RotationRow> {
        let waves: Vec<WaveProduct> = (self.products.iter().enumerate())
            .flat_map(|(index, &(negative, a, b))| {
                let of = |slot: usize, operand: usize| {
                    let (angle, cosine) = wave(tape, slot)?;
                    Some(WaveProduct {
                        index,
                        angle,
                        cosine,
                        slot,
                        operand: (operand, negative),
                    })
                };
                [of(a, b), of(b, a)]
            })
            .flatten()
            .collect();
        let mut chosen: Vec<WaveProduct> = Vec::new();
        for (place, one) in waves.iter().enumerate() {
            let fits = |other: &&WaveProduct| {
                other.index != one.index && other.angle == one.angle && other.cosine != one.cosine
            };
            if let Some(other) = waves[place + 1..].iter().find(fits) {
                chosen = vec![*one, *other];
                break;
            }
        }
        let lonely =
            self.plains.is_empty() && self.quotients.is_empty() && self.products.len() == 1;
        if chosen.is_empty() && lonely {
            chosen.extend(waves.first());
        }
        // The later first, so that places stay.
        for wave in chosen.iter().rev() {
            self.products.remove(wave.index);
        }
        let of = |cosine: bool| {
            let mut waves = chosen.iter().filter(|wave| wave.cosine == cosine);
            waves.next().map(|wave| wave.operand)
        };
        let angle = chosen.first()?.angle;
        let mut waves: SlotSet = chosen.iter().map(|wave| wave.slot).collect();
        waves.sort_unstable();
        Some(RotationRow {
            place: self.place,
            angle,
            waves,
            cosine: of(true),
            sine: of(false),
        })
    }
}

impl RotationRow {
    fn operands(&self) -> impl Iterator<Item = usize> {
        self.cosine
            .into_iter()
            .chain(self.sine)
            .map(|(slot, _)| slot)
    }

    /// True if both are the rows of one rotation of the same operands, or its
    /// column of one operand.
    fn completes(&self, other: &RotationRow) -> bool {
        let slot = |operand: Option<(usize, bool)>| operand.map(|(slot, _)| slot);
        let lone = self.waves.len() == 1 && other.waves.len() == 1;
        let same = self.angle == other.angle
            && (lone || self.waves == other.waves)
            && slot(self.cosine) == slot(other.sine)
            && slot(self.sine) == slot(other.cosine);
        let sign = |a: Option<(usize, bool)>, b: Option<(usize, bool)>| {
            a.zip(b).map(|((_, a), (_, b))| a != b)
        };
        match (sign(self.cosine, other.sine), sign(self.sine, other.cosine)) {
            (Some(one), Some(other)) => same && one != other,
            _ => same,
        }
    }
}

/// The opened members, from which terms are taken out.
struct Opened<'a> {
    tape: &'a Tape,
    members: Vec<OpenMember>,
}

impl Opened<'_> {
    /// Selects the layer of the members that are rotated or unchanged.
    fn main(&mut self, kept: &[(usize, usize)], parts: &mut Vec<Layer>) {
        let tape = self.tape;
        let rows = self.members.iter_mut();
        let mut rows: Vec<RotationRow> = rows.filter_map(|one| one.rotation(tape)).collect();
        let mut layer = Layer {
            set: kept.iter().map(|&(_, slot)| slot).collect(),
            kept: !kept.is_empty(),
            members: kept.iter().fold(0, |all, &(place, _)| all | 1 << place),
            ..Layer::default()
        };
        let mut near: Option<usize> = None;
        while !rows.is_empty() {
            let row = rows.remove(0);
            layer.members |= 1 << row.place;
            let mut waves = row.waves.clone();
            if let Some(other) = rows.iter().position(|other| row.completes(other)) {
                let other = rows.remove(other);
                layer.members |= 1 << other.place;
                waves.extend(other.waves);
                waves.sort_unstable();
                waves.dedup();
            }
            let mut operands: SlotSet = row.operands().collect();
            operands.sort_unstable();
            near = near.max(operands.iter().map(|&slot| time(tape, slot)).max());
            layer.set.extend(&operands);
            layer.blocks.push(LayerBlock {
                factor: LayerFactor::Row(waves),
                operands,
            });
        }
        let near = near.or_else(|| kept.iter().map(|&(_, slot)| time(tape, slot)).max());
        self.take_plains(near, &mut layer);
        if layer.members != 0 {
            layer.set.sort_unstable();
            parts.push(layer);
        }
    }

    /// Moves into the layer one plain term of every member missing from it: the
    /// nearest to a time, by default to that of the latest term.
    fn take_plains(&mut self, near: Option<usize>, layer: &mut Layer) {
        let tape = self.tape;
        let plains = || self.members.iter().flat_map(|member| &member.plains);
        let latest = plains().map(|&slot| time(tape, slot)).max();
        let Some(near) = near.or(latest) else {
            return;
        };
        let free = |member: &&mut OpenMember| layer.members >> member.place & 1 == 0;
        let mut taken = Vec::new();
        for member in self.members.iter_mut().filter(free) {
            let plains = member.plains.iter().enumerate();
            let nearest = plains.min_by_key(|&(_, &slot)| time(tape, slot).abs_diff(near));
            if let Some((index, _)) = nearest {
                taken.push((member.place, member.plains.remove(index)));
            }
        }
        for (place, slot) in taken {
            layer.set.push(slot);
            layer.kept = true;
            layer.members |= 1 << place;
        }
    }

    /// Layers of the remaining plain terms.
    fn plains(&mut self, parts: &mut Vec<Layer>) {
        loop {
            let mut layer = Layer::default();
            self.take_plains(None, &mut layer);
            if layer.members == 0 {
                return;
            }
            layer.set.sort_unstable();
            parts.push(layer);
        }
    }

    /// Layers of quotients with a common divisor.
    fn quotients(&mut self, parts: &mut Vec<Layer>) {
        loop {
            let mut quotients = self.members.iter().flat_map(|member| &member.quotients);
            let Some(&(_, divisor)) = quotients.next() else {
                return;
            };
            let mut found = Vec::new();
            for member in &mut self.members {
                let shared = member.quotients.iter().position(|&(_, by)| by == divisor);
                if let Some(index) = shared {
                    found.push((member.place, member.quotients.remove(index).0));
                }
            }
            parts.push(scaled(LayerFactor::Inverse(divisor), &found));
        }
    }

    /// Layers of products with a common factor in two members or more, the
    /// factor first that takes the most of their products.
    fn factors(&mut self, parts: &mut Vec<Layer>) {
        while let Some(factor) = self.best_factor() {
            let mut found: Vec<(usize, usize)> = Vec::new();
            for member in &mut self.members {
                let with = member
                    .products
                    .iter()
                    .enumerate()
                    .filter_map(|(index, term)| {
                        let &(_, a, b) = term;
                        let other = if a == factor { b } else { a };
                        (a == factor || b == factor).then_some((index, other))
                    });
                let near = found.first().map_or(0, |&(_, slot)| time(self.tape, slot));
                let with = with.min_by_key(|&(_, slot)| time(self.tape, slot).abs_diff(near));
                if let Some((index, other)) = with {
                    member.products.remove(index);
                    found.push((member.place, other));
                }
            }
            parts.push(scaled(LayerFactor::Value(factor), &found));
        }
    }

    /// The factor of products in at least two members that has the largest
    /// share of their products; of equal ones the latest.
    fn best_factor(&self) -> Option<usize> {
        let mut scores: Vec<(usize, f64, usize)> = Vec::new();
        for member in &self.members {
            let share = 1.0 / member.products.len() as f64;
            let mut factors: Vec<usize> = member
                .products
                .iter()
                .flat_map(|&(_, a, b)| [a, b])
                .collect();
            factors.sort_unstable();
            factors.dedup();
            for factor in factors {
                match scores.iter_mut().find(|(slot, ..)| *slot == factor) {
                    Some((_, score, count)) => {
                        *score += share;
                        *count += 1;
                    }
                    None => scores.push((factor, share, 1)),
                }
            }
        }
        let shared = scores.iter().filter(|(.., count)| *count > 1);
        let best = shared.max_by(|a, b| {
            let times = || time(self.tape, a.0).cmp(&time(self.tape, b.0));
            a.1.total_cmp(&b.1).then_with(times)
        });
        best.map(|&(slot, ..)| slot)
    }

    /// Layers of the products that share no factor: a row times a vector per
    /// member.
    fn rest(&mut self, parts: &mut Vec<Layer>) {
        for member in &mut self.members {
            if member.products.is_empty() {
                continue;
            }
            let (mut set, mut row, mut products) = (Vec::new(), Vec::new(), Vec::new());
            for (_, a, b) in member.products.drain(..) {
                let (early, late) = if time(self.tape, a) <= time(self.tape, b) {
                    (a, b)
                } else {
                    (b, a)
                };
                set.push(late);
                row.push(early);
                products.push((a, b));
            }
            set.sort_unstable();
            row.sort_unstable();
            parts.push(Layer {
                blocks: vec![LayerBlock {
                    factor: LayerFactor::Row(row),
                    operands: set.clone(),
                }],
                set,
                members: 1 << member.place,
                products,
                ..Layer::default()
            });
        }
    }
}

/// A common factor times a vector, given the members and their elements.
fn scaled(factor: LayerFactor, elements: &[(usize, usize)]) -> Layer {
    let mut set: SlotSet = elements.iter().map(|&(_, slot)| slot).collect();
    set.sort_unstable();
    Layer {
        blocks: vec![LayerBlock {
            factor,
            operands: set.clone(),
        }],
        set,
        members: elements.iter().fold(0, |all, &(place, _)| all | 1 << place),
        ..Layer::default()
    }
}
