//! The equations of a function while they are generated.
//!
//! Every right-hand side is kept once: an equation that equals an earlier one,
//! or its negative, in any order of terms and factors, is that earlier one
//! (hash-consing). Terms that cancel, zeros and ones disappear on the way. So
//! structural zeros, like a centre of mass on an axis, cost nothing.

use super::algebra::{ProductFactor, Scalar, SignedProduct, Sum};
use super::joint_arrays::JointNumbers;
use hashbrown::HashTable;
use robovec_ir::Boundary;
use rustc_hash::FxBuildHasher;
use smallvec::SmallVec;
use std::hash::BuildHasher;

/// The name of a quantity in Robotran's manner: prefix, component, joint and
/// column (`CM213_1`). It becomes text only for equations that are needed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct QuantityLabel {
    pub(super) prefix: &'static str,
    /// Kind and number of the sensor, link or chain it belongs to (`ROcp1_53`).
    pub(super) group: Option<(&'static str, u32)>,
    /// Component, counted from 1; 0 for none.
    pub(super) component: u8,
    /// Joint, counted from 1.
    pub(super) joint: u32,
    /// After the underscore, counted from 1; 0 for none.
    pub(super) column: u32,
}

impl QuantityLabel {
    pub(super) fn new(prefix: &'static str, component: usize, joint: usize) -> QuantityLabel {
        QuantityLabel {
            prefix,
            group: None,
            component: component as u8,
            joint: joint as u32,
            column: 0,
        }
    }

    pub(super) fn column(self, column: usize) -> QuantityLabel {
        QuantityLabel {
            column: column as u32,
            ..self
        }
    }

    pub(super) fn text(self) -> String {
        let QuantityLabel {
            prefix,
            group,
            component,
            joint,
            column,
        } = self;
        let mut text = prefix.to_owned();
        if let Some((kind, number)) = group {
            text.push_str(&format!("{kind}{number}_"));
        }
        for (separator, number) in [("", u32::from(component)), ("", joint), ("_", column)] {
            if number > 0 {
                text.push_str(separator);
                text.push_str(&number.to_string());
            }
        }
        text
    }
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Atom {
    Zero,
    One,
    Number(f64),
    /// An element of an input array; indices count from 1, 0 for none.
    Input {
        array: u32,
        indices: [u32; 2],
    },
    /// The result of an equation.
    Equation(u32),
}

#[derive(Clone, PartialEq, Debug)]
pub(super) enum RightHandSide {
    Sum(Box<Sum>),
    /// The scalar itself, with its sign.
    Copy(Scalar),
    Sin(Scalar),
    Cos(Scalar),
    Sqrt(Scalar),
    /// A numerator over a denominator.
    Quotient(Scalar, Scalar),
}

#[derive(Clone, Debug)]
pub(super) struct Equation {
    pub(super) label: QuantityLabel,
    pub(super) body: RightHandSide,
}

/// The place of an entry in a list; a new one at its end where there is none.
fn place_of<T>(list: &mut Vec<T>, is: impl FnMut(&T) -> bool, new: impl FnOnce() -> T) -> u32 {
    let found = list.iter().position(is);
    let place = found.unwrap_or_else(|| {
        list.push(new());
        list.len() - 1
    });
    place as u32
}

/// Treatment of signs and equal equations.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct EquationStyle {
    /// Keep the terms in the order of the recursion even when the first is
    /// negative, and print that minus, as generator 8.1 does. Otherwise
    /// positive terms go first, and negative equations are negated.
    pub(super) leading_signs: bool,
}

/// All equations of a function, in an order in which they can be evaluated.
#[derive(Debug)]
pub(super) struct Equations {
    pub(super) style: EquationStyle,
    pub(super) atoms: Vec<Atom>,
    pub(super) equations: Vec<Equation>,
    pub(super) groups: Vec<Sum>,
    /// Names of the input arrays and the number of indices of each.
    pub(super) arrays: Vec<(String, usize)>,
    /// Names of the output arrays, in order of appearance.
    pub(super) results: Vec<String>,
    /// Array, indices and value of each output element.
    pub(super) outputs: Vec<(u32, [u32; 2], Scalar)>,
    /// Calls of user functions.
    pub(super) calls: Vec<Boundary>,
    /// Joints of the indices of arrays.
    pub(super) numbers_of_joints: JointNumbers,
    inputs: hashbrown::HashMap<(u32, [u32; 2]), u32, FxBuildHasher>,
    numbers: hashbrown::HashMap<u64, u32, FxBuildHasher>,
    /// Hash, atom (with the sign that belongs to the key's) of every equation.
    known: HashTable<(u64, Scalar)>,
    keys: Vec<(u32, u32)>,
    known_groups: HashTable<(u64, u32)>,
    group_keys: Vec<(u32, u32)>,
    key_words: Vec<u32>,
    scratch: Vec<u32>,
}

/// A key starts with its kind, so that a sum is no sine.
const SUM: u32 = 0;

impl Equations {
    pub(super) fn new(style: EquationStyle) -> Equations {
        Equations {
            style,
            atoms: vec![Atom::Zero, Atom::One],
            equations: Vec::new(),
            groups: Vec::new(),
            arrays: Vec::new(),
            results: Vec::new(),
            outputs: Vec::new(),
            calls: Vec::new(),
            numbers_of_joints: JointNumbers::default(),
            inputs: hashbrown::HashMap::default(),
            numbers: hashbrown::HashMap::default(),
            known: HashTable::new(),
            keys: vec![(0, 0); Scalar::FIRST_ATOM as usize],
            known_groups: HashTable::new(),
            group_keys: Vec::new(),
            key_words: Vec::new(),
            scratch: Vec::new(),
        }
    }

    fn atom(&mut self, atom: Atom) -> u32 {
        self.atoms.push(atom);
        self.keys.push((0, 0));
        self.atoms.len() as u32 - 1
    }

    /// An element of an input array; indices count from 1, and frames where the
    /// array counts joints. For a joint that moves against its axis the
    /// negative of the symbol; for a constant rotation nothing.
    pub(super) fn input(&mut self, array: &str, indices: &[usize]) -> Scalar {
        let Some((padded, negative)) = self.numbers_of_joints.element(array, padded(indices))
        else {
            return Scalar::ZERO;
        };
        let number = place_of(
            &mut self.arrays,
            |(name, _)| name == array,
            || (array.to_owned(), indices.len()),
        );
        assert_eq!(
            self.arrays[number as usize].1,
            indices.len(),
            "an array has the same number of indices everywhere"
        );
        if let Some(&atom) = self.inputs.get(&(number, padded)) {
            return Scalar::of_atom(atom).negated_if(negative);
        }
        let atom = self.atom(Atom::Input {
            array: number,
            indices: padded,
        });
        self.inputs.insert((number, padded), atom);
        Scalar::of_atom(atom).negated_if(negative)
    }

    pub(super) fn number(&mut self, number: f64) -> Scalar {
        assert!(number.is_finite(), "the numbers of a model are finite");
        let magnitude = number.abs();
        if magnitude == 0.0 {
            return Scalar::ZERO;
        }
        if magnitude == 1.0 {
            return Scalar::ONE.negated_if(number < 0.0);
        }
        let atom = match self.numbers.get(&magnitude.to_bits()) {
            Some(&atom) => atom,
            None => {
                let atom = self.atom(Atom::Number(magnitude));
                self.numbers.insert(magnitude.to_bits(), atom);
                atom
            }
        };
        Scalar::of_atom(atom).negated_if(number < 0.0)
    }

    /// Sets an output element, in frames until [`Equations::number_outputs`].
    pub(super) fn output(&mut self, array: &str, indices: &[usize], value: Scalar) {
        assert!(
            (value.atom() as usize) < self.atoms.len(),
            "an output is defined before it is set"
        );
        let padded = padded(indices);
        if self.numbers_of_joints.element(array, padded).is_none() {
            return;
        }
        let array = place_of(&mut self.results, |name| name == array, || array.to_owned());
        self.outputs.push((array, padded, value));
    }

    /// Gives the elements of outputs the numbers and signs of joints.
    pub(super) fn number_outputs(&mut self) {
        self.numbers_of_joints
            .outputs(&self.results, &mut self.outputs);
    }

    /// Frees the tables for finding earlier equations, at the end.
    pub(super) fn close(&mut self) {
        self.inputs = hashbrown::HashMap::default();
        self.numbers = hashbrown::HashMap::default();
        self.known = HashTable::new();
        self.known_groups = HashTable::new();
        for keys in [&mut self.keys, &mut self.group_keys] {
            *keys = Vec::new();
        }
        for words in [&mut self.key_words, &mut self.scratch] {
            *words = Vec::new();
        }
    }

    /// The value of a sum: a new equation, an earlier one or a scalar.
    pub(super) fn define(&mut self, label: QuantityLabel, mut sum: Sum) -> Scalar {
        debug_assert!(
            sum.terms
                .iter()
                .flat_map(|term| &term.factors)
                .all(|factor| match *factor {
                    ProductFactor::Atom(atom) => (atom as usize) < self.atoms.len(),
                    ProductFactor::Group(group) => (group as usize) < self.groups.len(),
                }),
            "an equation reads what is defined before it"
        );
        cancel(&mut sum);
        if let Some(scalar) = trivial(&sum) {
            return scalar;
        }
        let negated = self.write_key(&sum);
        let (hash, start) = (self.hash_scratch(), self.key_words.len() as u32);
        let found = self.known.find(hash, |&(other, scalar)| {
            other == hash && self.key(self.keys[scalar.atom() as usize]) == self.scratch
        });
        if let Some(&(_, scalar)) = found {
            return scalar.negated_if(negated);
        }
        self.key_words.extend_from_slice(&self.scratch);
        let key = (start, self.key_words.len() as u32);
        let flipped = self.order_signs(&mut sum);
        let scalar = self.push(label, RightHandSide::Sum(Box::new(sum)), key);
        self.known.insert_unique(
            hash,
            (hash, scalar.negated_if(negated ^ flipped)),
            |&(hash, _)| hash,
        );
        scalar.negated_if(flipped)
    }

    /// The sum in parentheses, as a term to multiply further; `None` when zero.
    pub(super) fn group(&mut self, mut sum: Sum) -> Option<SignedProduct> {
        cancel(&mut sum);
        if sum.terms.len() <= 1 {
            return sum.terms.pop();
        }
        let negated = self.write_key(&sum);
        let hash = self.hash_scratch();
        let found = self.known_groups.find(hash, |&(other, group)| {
            other == hash && self.key(self.group_keys[group as usize >> 1]) == self.scratch
        });
        let (group, negative) = match found {
            Some(&(_, found)) => (found >> 1, negated ^ (found & 1 == 1)),
            None => {
                let start = self.key_words.len() as u32;
                self.key_words.extend_from_slice(&self.scratch);
                let group = self.groups.len() as u32;
                let flipped = self.order_signs(&mut sum);
                self.groups.push(sum);
                self.group_keys.push((start, self.key_words.len() as u32));
                let sign = u32::from(negated ^ flipped);
                self.known_groups
                    .insert_unique(hash, (hash, group << 1 | sign), |&(hash, _)| hash);
                (group, flipped)
            }
        };
        Some(SignedProduct {
            negative,
            factors: SmallVec::from_slice(&[ProductFactor::Group(group)]),
        })
    }

    /// The scalar under a name that others rely on, as the argument of a user
    /// function: `label` if the scalar is not that equation already. An
    /// equation of that name with the opposite sign gets another prefix.
    pub(super) fn named(
        &mut self,
        label: QuantityLabel,
        other: &'static str,
        scalar: Scalar,
    ) -> Scalar {
        if let Atom::Equation(number) = self.atoms[scalar.atom() as usize] {
            let equation = &mut self.equations[number as usize];
            if equation.label == label {
                if !scalar.is_negative() {
                    return scalar;
                }
                equation.label.prefix = other;
            }
        }
        self.push(label, RightHandSide::Copy(scalar), (0, 0))
    }

    pub(super) fn sin(&mut self, label: QuantityLabel, angle: Scalar) -> Scalar {
        let negative = angle.is_negative();
        self.function(label, 1, RightHandSide::Sin(angle.magnitude()))
            .negated_if(negative)
    }

    pub(super) fn cos(&mut self, label: QuantityLabel, angle: Scalar) -> Scalar {
        self.function(label, 2, RightHandSide::Cos(angle.magnitude()))
    }

    pub(super) fn sqrt(&mut self, label: QuantityLabel, radicand: Scalar) -> Scalar {
        self.function(label, 3, RightHandSide::Sqrt(radicand))
    }

    /// A numerator over a denominator that is not zero.
    pub(super) fn quotient(
        &mut self,
        label: QuantityLabel,
        above: Scalar,
        below: Scalar,
    ) -> Scalar {
        let negative = above.is_negative() ^ below.is_negative();
        if above.is_zero() {
            return Scalar::ZERO;
        }
        if below.magnitude() == Scalar::ONE {
            return above.magnitude().negated_if(negative);
        }
        if let (Scalar::ONE, Atom::Number(number)) =
            (above.magnitude(), self.atoms[below.atom() as usize])
            && number.log2().fract() == 0.0
        {
            // The inverse of a power of two is exact.
            return self.number(number.recip()).negated_if(negative);
        }
        self.function(
            label,
            4,
            RightHandSide::Quotient(above.magnitude(), below.magnitude()),
        )
        .negated_if(negative)
    }

    fn function(&mut self, label: QuantityLabel, kind: u32, body: RightHandSide) -> Scalar {
        self.scratch.clear();
        self.scratch.push(kind);
        match body {
            RightHandSide::Sin(a) | RightHandSide::Cos(a) | RightHandSide::Sqrt(a) => {
                self.scratch.push(a.atom())
            }
            RightHandSide::Quotient(a, b) => self.scratch.extend([a.atom(), b.atom()]),
            RightHandSide::Sum(_) | RightHandSide::Copy(_) => {}
        }
        let hash = self.hash_scratch();
        let found = self.known.find(hash, |&(other, scalar)| {
            other == hash && self.key(self.keys[scalar.atom() as usize]) == self.scratch
        });
        if let Some(&(_, scalar)) = found {
            return scalar;
        }
        let start = self.key_words.len() as u32;
        self.key_words.extend_from_slice(&self.scratch);
        let key = (start, self.key_words.len() as u32);
        let scalar = self.push(label, body, key);
        self.known
            .insert_unique(hash, (hash, scalar), |&(hash, _)| hash);
        scalar
    }

    fn push(&mut self, label: QuantityLabel, body: RightHandSide, key: (u32, u32)) -> Scalar {
        let number = self.equations.len() as u32;
        self.equations.push(Equation { label, body });
        let atom = self.atom(Atom::Equation(number));
        self.keys[atom as usize] = key;
        Scalar::of_atom(atom)
    }

    fn key(&self, (start, end): (u32, u32)) -> &[u32] {
        &self.key_words[start as usize..end as usize]
    }

    fn hash_scratch(&self) -> u64 {
        FxBuildHasher.hash_one(&self.scratch)
    }

    /// Puts a positive term first; true for a sum without, which is negated.
    fn order_signs(&self, sum: &mut Sum) -> bool {
        if self.style.leading_signs {
            return false;
        }
        match sum.terms.iter().position(|term| !term.negative) {
            Some(first) => {
                sum.terms[..=first].rotate_right(1);
                false
            }
            None => {
                for term in &mut sum.terms {
                    term.negative = false;
                }
                true
            }
        }
    }

    /// Writes the canonical key of a sum into the scratch space: in order, the
    /// first term positive. True when the sum's signs are the opposite.
    fn write_key(&mut self, sum: &Sum) -> bool {
        let mut terms: SmallVec<[(SmallVec<[ProductFactor; 4]>, bool); 8]> = sum
            .terms
            .iter()
            .map(|term| {
                let mut factors = term.factors.clone();
                factors.sort_unstable();
                (factors, term.negative)
            })
            .collect();
        terms.sort_unstable();
        let negated = terms[0].1;
        self.scratch.clear();
        self.scratch.push(SUM);
        for (factors, negative) in &terms {
            let sign = u32::from(negative ^ negated);
            self.scratch.push((factors.len() as u32) << 1 | sign);
            self.scratch
                .extend(factors.iter().map(|&factor| match factor {
                    ProductFactor::Atom(atom) => atom << 1,
                    ProductFactor::Group(group) => group << 1 | 1,
                }));
        }
        negated
    }
}

/// One or two indices; 0 represents none.
fn padded(indices: &[usize]) -> [u32; 2] {
    let mut padded = [0; 2];
    for (place, &index) in padded.iter_mut().zip(indices) {
        *place = index as u32;
    }
    padded
}

/// The scalar, if the sum is one.
fn trivial(sum: &Sum) -> Option<Scalar> {
    match sum.terms.as_slice() {
        [] => Some(Scalar::ZERO),
        [term] => match term.factors.as_slice() {
            [] => Some(Scalar::ONE.negated_if(term.negative)),
            [ProductFactor::Atom(atom)] => Some(Scalar::of_atom(*atom).negated_if(term.negative)),
            _ => None,
        },
        _ => None,
    }
}

/// Removes pairs of terms that are each other's negative.
fn cancel(sum: &mut Sum) {
    let mut index = 0;
    while index < sum.terms.len() {
        let term = &sum.terms[index];
        let opposite = sum.terms[index + 1..]
            .iter()
            .position(|other| other.negative != term.negative && same_factors(term, other));
        match opposite {
            Some(distance) => {
                sum.terms.remove(index + 1 + distance);
                sum.terms.remove(index);
            }
            None => index += 1,
        }
    }
}

fn same_factors(left: &SignedProduct, right: &SignedProduct) -> bool {
    left.factors.len() == right.factors.len()
        && (left.factors == right.factors || {
            let (mut a, mut b) = (left.factors.clone(), right.factors.clone());
            a.sort_unstable();
            b.sort_unstable();
            a == b
        })
}
