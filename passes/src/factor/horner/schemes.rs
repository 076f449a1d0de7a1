//! Horner's scheme in many variables, and its cost.
//!
//! An order of the variables decides the scheme: the common factor of all terms
//! is taken out; the rest is split into the terms without the first variable in
//! which they differ and those with it, and each part is written in the same
//! way. The second part has the variable in common.
//!
//! With the terms sorted by the order every part is a range of them, and its
//! value at a random point of a field a difference of two prefix sums. Equal
//! parts, up to their sign, are thus known before they are looked into: a
//! scheme of many polynomials is counted in time near linear in their terms,
//! with every part that occurs twice, in one or in several, counted once.

use super::polynomials::{NetworkPolynomials, PolynomialTerm};
use hashbrown::HashMap;
use robovec_num::field::Modulus;
use robovec_num::random::mix;
use rustc_hash::{FxBuildHasher, FxHashSet};

/// Number of rows that have their least exponents kept.
const STRETCH: usize = 32;

/// Exponents of sixteen variables.
type Exponents = [u8; 16];

/// A prime. It affects only the estimated cost of a scheme.
const PRIME: u64 = (1 << 60) - 93;

/// The variables of some polynomials, and their values at a random point.
pub(super) struct SchemeVariables {
    pub(super) nodes: Vec<u32>,
    inverses: Vec<u64>,
    /// Number of terms that contain each of them.
    pub(super) occurrences: Vec<u32>,
}

/// A polynomial laid out for sorting.
pub(super) struct PackedPolynomial {
    /// The node that has its value.
    pub(super) node: u32,
    variables: Vec<u32>,
    /// By term, this number of groups of exponents in the order of `variables`.
    rows: Vec<Exponents>,
    pub(super) coefficients: Vec<i64>,
    values: Vec<u64>,
}

/// Polynomials that are written with one order of their variables.
pub(super) struct SchemeSet {
    pub(super) variables: SchemeVariables,
    pub(super) polynomials: Vec<PackedPolynomial>,
    field: Modulus,
}

/// A part of a polynomial: the common factor of its terms, times the rest.
pub(super) struct SchemePart {
    /// Variables and exponents, in [`Scheme::powers`].
    pub(super) common: (u32, u32),
    pub(super) rest: SchemeRest,
}

/// Rest of a part after the common powers have been taken out.
pub(super) enum SchemeRest {
    /// A single term: its coefficient.
    Number(i64),
    /// The sum of two parts, which come later.
    Sum([u32; 2]),
}

/// The scheme of one polynomial.
#[derive(Default)]
pub(super) struct Scheme {
    pub(super) parts: Vec<SchemePart>,
    /// Variables and exponents.
    pub(super) powers: Vec<(u32, u32)>,
}

/// A range of sorted terms that has to be written.
#[derive(Clone, Copy)]
struct OpenPart {
    start: u32,
    end: u32,
    /// The part of which it is the first (0) or second (1) term.
    parent: (u32, u8),
    /// The inverse of the value of the powers taken out so far.
    inverse: u64,
}

/// Memory that is used again from one scheme to the next.
#[derive(Default)]
pub(super) struct SchemeBuffers {
    known: FxHashSet<u64>,
    /// The variables of the polynomial, first in the order first.
    columns: Vec<(u32, u32)>,
    /// Sorted terms, with exponents in the order of the columns.
    terms: Vec<(u128, u32)>,
    rows: Vec<Exponents>,
    /// The smallest exponents of every [`STRETCH`] rows, so that a part is not
    /// looked through term by term.
    minima: Vec<Exponents>,
    prefix: Vec<u64>,
    open: Vec<OpenPart>,
    /// By open part, the exponents taken out so far.
    taken: Vec<Exponents>,
    least: Vec<Exponents>,
    /// Terms considered so far: the measure of work.
    pub(super) work: u64,
}

impl SchemeSet {
    /// Lays the polynomials of a network out.
    pub(super) fn new(polynomials: &NetworkPolynomials, order: &[u32]) -> SchemeSet {
        let field = Modulus::new(PRIME);
        let mut set = SchemeSet {
            variables: SchemeVariables {
                nodes: Vec::new(),
                inverses: Vec::new(),
                occurrences: Vec::new(),
            },
            polynomials: Vec::new(),
            field,
        };
        let mut numbers: HashMap<u32, u32, FxBuildHasher> = HashMap::default();
        for &node in order {
            if let Some(terms) = &polynomials.terms[node as usize] {
                let packed = set.pack(node, terms, &mut numbers);
                set.polynomials.push(packed);
            }
        }
        set
    }

    fn pack(
        &mut self,
        node: u32,
        terms: &[PolynomialTerm],
        numbers: &mut HashMap<u32, u32, FxBuildHasher>,
    ) -> PackedPolynomial {
        let field = self.field;
        let mut local: Vec<u32> = terms
            .iter()
            .flat_map(|term| term.powers.iter().map(|&(node, _)| node))
            .collect();
        local.sort_unstable();
        local.dedup();
        let points: Vec<u64> = local
            .iter()
            .map(|&node| field.number(mix(u64::from(node)) % PRIME))
            .collect();
        let variables: Vec<u32> = local
            .iter()
            .zip(&points)
            .map(|(&node, &point)| {
                *numbers.entry(node).or_insert_with(|| {
                    self.variables.nodes.push(node);
                    self.variables.inverses.push(field.invert(point));
                    self.variables.occurrences.push(0);
                    self.variables.nodes.len() as u32 - 1
                })
            })
            .collect();
        let blocks = blocks(variables.len());
        let mut packed = PackedPolynomial {
            node,
            variables,
            rows: Vec::with_capacity(terms.len() * blocks),
            coefficients: terms.iter().map(|term| term.coefficient).collect(),
            values: Vec::with_capacity(terms.len()),
        };
        for term in terms {
            let first = packed.rows.len();
            packed.rows.resize(first + blocks, [0; 16]);
            let size = field.number(term.coefficient.unsigned_abs());
            let mut value = if term.coefficient < 0 {
                field.neg(size)
            } else {
                size
            };
            for &(node, exponent) in &term.powers {
                let at = local
                    .binary_search(&node)
                    .expect("a term has variables of its sum");
                packed.rows[first + at / 16][at % 16] = exponent as u8;
                self.variables.occurrences[packed.variables[at] as usize] += 1;
                value = field.mul(value, field.power(points[at], u64::from(exponent)));
            }
            packed.values.push(value);
        }
        packed
    }

    /// The operations of the schemes of all polynomials; `ranks` gives every
    /// variable its place in the order.
    pub(super) fn cost(&self, ranks: &[u32], buffers: &mut SchemeBuffers) -> u64 {
        buffers.known.clear();
        self.polynomials
            .iter()
            .map(|polynomial| self.scheme(polynomial, ranks, buffers, None))
            .sum()
    }

    /// The number of operations of the scheme of one polynomial that no known
    /// value provides; on request the scheme itself, in which equal parts are
    /// not merged.
    pub(super) fn scheme(
        &self,
        polynomial: &PackedPolynomial,
        ranks: &[u32],
        buffers: &mut SchemeBuffers,
        mut record: Option<&mut Scheme>,
    ) -> u64 {
        let field = self.field;
        let blocks = blocks(polynomial.variables.len());
        buffers.sort(polynomial, ranks, field);
        let mut cost = 0;
        while let Some(part) = buffers.open.pop() {
            let (start, end) = (part.start as usize, part.end as usize);
            buffers.find_least(start, end, blocks);
            let powers = record.as_mut().map(|scheme| &mut scheme.powers);
            let first = powers.as_ref().map_or(0, |powers| powers.len() as u32);
            let common = self.common(polynomial, part.inverse, buffers, powers);
            cost += common.powers;
            let single = end - start == 1;
            let coefficient = polynomial.coefficients[buffers.terms[start].1 as usize];
            let number = record.as_mut().map_or(0, |scheme| {
                let rest = if single {
                    SchemeRest::Number(coefficient)
                } else {
                    SchemeRest::Sum([0, 0])
                };
                scheme.push(first, rest, part.parent)
            });
            let sum = field.sub(buffers.prefix[end], buffers.prefix[start]);
            let factors = common.factors + u64::from(!single || coefficient.unsigned_abs() != 1);
            if factors > 1 {
                let is_new = buffers.learn(field, field.mul(sum, part.inverse));
                if !is_new && record.is_none() {
                    continue;
                }
                cost += factors - 1;
            }
            if single || !buffers.learn(field, field.mul(sum, common.inverse)) && record.is_none() {
                continue;
            }
            cost += 1;
            buffers.split((start, end), blocks, (number, common.inverse));
        }
        cost
    }

    /// Takes the common powers of a part, the smallest ones, out of it.
    fn common(
        &self,
        polynomial: &PackedPolynomial,
        inverse: u64,
        buffers: &mut SchemeBuffers,
        mut record: Option<&mut Vec<(u32, u32)>>,
    ) -> CommonPowers {
        let mut common = CommonPowers {
            factors: 0,
            powers: 0,
            inverse,
        };
        let first = buffers.taken.len() - buffers.least.len();
        for (block, least) in buffers.least.iter().enumerate() {
            // No exponent is less than what has been taken out of it, so that
            // nothing is borrowed from one byte to the next.
            let taken = u128::from_le_bytes(buffers.taken[first + block]);
            let mut rest = u128::from_le_bytes(*least) - taken;
            while rest != 0 {
                let lane = rest.trailing_zeros() / 8;
                let power = (rest >> (8 * lane)) as u8;
                rest ^= u128::from(power) << (8 * lane);
                let variable = polynomial.variables[16 * block + lane as usize];
                let one = self.variables.inverses[variable as usize];
                for _ in 0..power {
                    common.inverse = self.field.mul(common.inverse, one);
                }
                common.factors += 1;
                // A power is one more operation when the one below is there.
                let name = u64::MAX - (u64::from(variable) << 8 | u64::from(power));
                common.powers += u64::from(power > 1 && buffers.known.insert(name));
                if let Some(powers) = record.as_mut() {
                    powers.push((variable, u32::from(power)));
                }
            }
        }
        buffers.taken.truncate(first);
        common
    }
}

/// Powers taken out of a part.
struct CommonPowers {
    /// Number of variables.
    factors: u64,
    /// The operations of those of their powers that were not known.
    powers: u64,
    /// The inverse of the value of all powers taken out so far.
    inverse: u64,
}

impl Scheme {
    /// Appends a part whose powers begin at a place, and returns its parent.
    fn push(&mut self, first: u32, rest: SchemeRest, parent: (u32, u8)) -> u32 {
        let number = self.parts.len() as u32;
        let common = (first, self.powers.len() as u32);
        self.parts.push(SchemePart { common, rest });
        if number > 0 {
            match &mut self.parts[parent.0 as usize].rest {
                SchemeRest::Sum(sides) => sides[usize::from(parent.1)] = number,
                SchemeRest::Number(_) => unreachable!("a single term has no parts"),
            }
        }
        number
    }
}

fn blocks(variables: usize) -> usize {
    variables.div_ceil(16)
}

impl SchemeBuffers {
    /// Sorts the terms of a polynomial and opens it as one part.
    fn sort(&mut self, polynomial: &PackedPolynomial, ranks: &[u32], field: Modulus) {
        let count = polynomial.values.len();
        self.columns.clear();
        self.columns
            .extend((0..).zip(polynomial.variables.iter().copied()));
        self.columns
            .sort_unstable_by_key(|&(_, variable)| ranks[variable as usize]);
        let blocks = blocks(polynomial.variables.len());
        self.sort_terms(polynomial, blocks);
        self.work += count as u64;
        self.rows.clear();
        self.prefix.clear();
        self.prefix.push(0);
        let mut sum = 0;
        for &(_, term) in &self.terms {
            let term = term as usize;
            self.rows
                .extend_from_slice(&polynomial.rows[term * blocks..(term + 1) * blocks]);
            sum = field.add(sum, polynomial.values[term]);
            self.prefix.push(sum);
        }
        self.minima.clear();
        for start in (0..count / STRETCH).map(|stretch| stretch * STRETCH) {
            let rows = &self.rows[start * blocks..(start + STRETCH) * blocks];
            self.minima.extend_from_slice(&rows[..blocks]);
            let first = self.minima.len() - blocks;
            lower(&mut self.minima[first..], rows);
        }
        self.taken.clear();
        self.taken.resize(blocks, [0; 16]);
        self.open.clear();
        self.open.push(OpenPart {
            start: 0,
            end: count as u32,
            parent: (0, 0),
            inverse: field.one(),
        });
    }

    /// Sorts terms by their exponents in the order of the columns: sixteen
    /// columns at a time, the last ones first, in a stable sort.
    fn sort_terms(&mut self, polynomial: &PackedPolynomial, blocks: usize) {
        self.terms.clear();
        let count = polynomial.values.len() as u32;
        self.terms.extend((0..count).map(|term| (0, term)));
        for columns in self.columns.chunks(16).rev() {
            for (key, term) in &mut self.terms {
                let row = &polynomial.rows[*term as usize * blocks..][..blocks];
                let mut exponents = [0; 16];
                for (exponent, &(column, _)) in exponents.iter_mut().zip(columns) {
                    *exponent = row[column as usize / 16][column as usize % 16];
                }
                *key = u128::from_be_bytes(exponents);
            }
            match blocks {
                1 => self.terms.sort_unstable(),
                _ => self.terms.sort_by_key(|&(key, _)| key),
            }
        }
    }

    /// The smallest exponents of a range of terms.
    fn find_least(&mut self, start: usize, end: usize, blocks: usize) {
        self.least.clear();
        self.least
            .extend_from_slice(&self.rows[start * blocks..(start + 1) * blocks]);
        let (first, last) = (start.div_ceil(STRETCH), end / STRETCH);
        if first >= last {
            lower(&mut self.least, &self.rows[start * blocks..end * blocks]);
            self.work += (end - start) as u64;
            return;
        }
        let (head, tail) = (first * STRETCH, last * STRETCH);
        lower(&mut self.least, &self.rows[start * blocks..head * blocks]);
        lower(&mut self.least, &self.minima[first * blocks..last * blocks]);
        lower(&mut self.least, &self.rows[tail * blocks..end * blocks]);
        self.work += (head - start + last - first + end - tail) as u64;
    }

    /// Takes note of a value; false when it or its negation was known.
    fn learn(&mut self, field: Modulus, value: u64) -> bool {
        self.known.insert(value.min(field.neg(value)))
    }

    /// Separates the terms without the first variable in which a range differs
    /// from those with it.
    fn split(&mut self, (start, end): (usize, usize), blocks: usize, from: (u32, u64)) {
        let at = |term: usize, column: u32| {
            self.rows[term * blocks + column as usize / 16][column as usize % 16]
        };
        let (column, _) = *self
            .columns
            .iter()
            .find(|&&(column, _)| at(start, column) != at(end - 1, column))
            .expect("terms of a polynomial differ");
        let lowest = at(start, column);
        let (mut low, mut high) = (start, end);
        while low < high {
            let middle = low.midpoint(high);
            if at(middle, column) == lowest {
                low = middle + 1
            } else {
                high = middle
            }
        }
        let (parent, inverse) = from;
        for (side, (start, end)) in (0..).zip([(start, low), (low, end)]) {
            self.taken.extend_from_slice(&self.least);
            self.open.push(OpenPart {
                start: start as u32,
                end: end as u32,
                parent: (parent, side),
                inverse,
            });
        }
    }
}

/// Lowers exponents to those of some rows where these are less.
fn lower(least: &mut [Exponents], rows: &[Exponents]) {
    if let [least] = least {
        for row in rows {
            for (least, exponent) in least.iter_mut().zip(row) {
                *least = (*least).min(*exponent);
            }
        }
        return;
    }
    for row in rows.chunks_exact(least.len().max(1)) {
        for (least, exponents) in least.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
            *least = (*least).min(*exponents);
        }
    }
}
