//! Superwords: operations of equal structure, computed as one vector.
//!
//! Mechanisms repeat themselves: two legs, four wheels, the sides of a car.
//! Their equations have the same operations on other inputs and other numbers,
//! so that one vector instruction can compute an operation of every side
//! (superword-level parallelism, Larsen and Amarasinghe, PLDI 2000). Compilers
//! look for it among neighbouring statements and loads; here the symmetry of
//! the whole function is found:
//!
//! 1. [`colours`]: values whose neighbourhoods of some radius look alike have
//!    one colour, whatever their constants are;
//! 2. [`seeds`]: inputs that look alike become the first superwords;
//! 3. [`growth`]: from there, operations whose operands lie in the same
//!    superwords, each in its lane, become superwords, and then the operands
//!    that superwords still gather;
//! 4. [`worth`]: superwords that cost more than they save are taken apart.
//!
//! Members of a superword have the same longest path from the inputs, so that
//! none waits for another one and no two superwords wait for each other.
//! Every lane computes what the operation alone computed, bit for bit.

mod colours;
mod graph;
mod growth;
mod seeds;
mod worth;

use graph::DataGraph;
use robovec_framework::option_words;
use robovec_ir::{Function, Operand, Operation, Value};

option_words! {
    /// The numbers that a superword holds.
    #[derive(Default)]
    pub enum SuperwordLanes {
        /// No superwords: every operation on its own.
        #[default]
        None = "none",
        /// Two, for mechanisms with two sides.
        Two = "2",
        /// Three, in vectors of four, for three arms.
        Three = "3",
        /// Four, for mechanisms with four legs or wheels.
        Four = "4",
        /// Two, three, four or none, whichever has the fewest instructions.
        Auto = "auto",
    }
}

/// The largest share of the instructions without superwords that
/// [`SuperwordLanes::Auto`] accepts.
const GAIN: f64 = 0.9;

/// Values or input elements that are the lanes of one vector.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Superword {
    /// The value or input element of each lane.
    pub(crate) items: Vec<Operand>,
    /// The operation, or none for inputs, sines and cosines, which are read
    /// from memory.
    pub(crate) operation: Option<Operation>,
    /// Lanes in which the second operand of a sum is subtracted; bit 0 is the
    /// first lane.
    pub(crate) negative: u8,
    /// For each operand of the operation those of all lanes.
    pub(crate) operands: Vec<Vec<Operand>>,
}

impl Superword {
    /// True if every lane of a superword that computes has operation and
    /// operands of its value.
    fn repeats(&self, function: &Function) -> bool {
        let Some(operation) = self.operation else {
            return true;
        };
        self.items.iter().enumerate().all(|(lane, item)| {
            let value = item
                .value()
                .expect("a superword that computes holds values");
            let node = function.node(value);
            let own: Vec<Operand> = self.operands.iter().map(|lanes| lanes[lane]).collect();
            let is_same = node.operands() == own;
            let is_either = is_same || node.operands().iter().eq(own.iter().rev());
            match operation {
                Operation::Add if self.negative >> lane & 1 == 1 => {
                    node.operation == Operation::Sub && is_same
                }
                Operation::Add | Operation::Mul => node.operation == operation && is_either,
                _ => node.operation == operation && is_same,
            }
        })
    }
}

/// The superwords of a function.
#[derive(Clone, Debug)]
pub(crate) struct Superwords {
    lanes: usize,
    words: Vec<Superword>,
    /// For each value, then each input element, its superword and lane; empty
    /// if there are no superwords.
    places: Vec<Option<(u32, u8)>>,
    /// Number of values of the function.
    values: usize,
}

impl Superwords {
    /// No superwords.
    pub(crate) fn none() -> Superwords {
        Superwords {
            lanes: 1,
            words: Vec::new(),
            places: Vec::new(),
            values: 0,
        }
    }

    /// The superwords of a function among the values that are `computed`.
    /// Values that are `loaded` are read from memory.
    pub(crate) fn find(
        function: &Function,
        computed: &[bool],
        loaded: &[bool],
        lanes: SuperwordLanes,
    ) -> Superwords {
        let lanes: &[usize] = match lanes {
            SuperwordLanes::None => &[],
            SuperwordLanes::Two => &[2],
            SuperwordLanes::Three => &[3],
            SuperwordLanes::Four => &[4],
            SuperwordLanes::Auto => &[2, 3, 4],
        };
        if lanes.is_empty() {
            return Superwords::none();
        }
        let graph = DataGraph::new(function, computed, loaded);
        let most = match lanes {
            [_] => usize::MAX,
            _ => (GAIN * graph.operations() as f64) as usize,
        };
        let found = lanes.iter().map(|&lanes| seeds::superwords(&graph, lanes));
        let best = found.min_by_key(|(instructions, _)| *instructions);
        match best {
            Some((instructions, words)) if instructions <= most && worth::is_useful(&words) => {
                assert!(
                    words.words.iter().all(|word| word.repeats(function)),
                    "every lane computes its value"
                );
                words
            }
            _ => Superwords::none(),
        }
    }

    /// Numbers of a superword; 1 if there are none.
    pub(crate) fn lanes(&self) -> usize {
        self.lanes
    }

    /// Numbers of a vector that holds a superword.
    pub(crate) fn width(&self) -> usize {
        self.lanes.next_power_of_two()
    }

    /// The superwords by number; those taken apart are not read by any other.
    pub(crate) fn words(&self) -> &[Superword] {
        &self.words
    }

    /// The superword of a value or input element, and its lane.
    pub(crate) fn place(&self, operand: Operand) -> Option<(usize, usize)> {
        if self.places.is_empty() {
            return None;
        }
        let item = graph::item(self.values, operand)?;
        let (word, lane) = self.places[item]?;
        Some((word as usize, usize::from(lane)))
    }

    /// The superword that computes a value, and its lane.
    pub(crate) fn computing(&self, value: Value) -> Option<(usize, usize)> {
        self.place(value.into())
            .filter(|&(word, _)| self.words[word].operation.is_some())
    }

    /// The value in the first lane of the superword that computes a value; the
    /// value itself if none does.
    pub(crate) fn leader(&self, value: Value) -> Value {
        let Some((word, _)) = self.computing(value) else {
            return value;
        };
        let first = self.words[word].items[0].value();
        first.expect("a superword that computes holds values")
    }

    /// The operands of all operations that are computed with a value.
    pub(crate) fn reads<'a>(
        &'a self,
        function: &'a Function,
        value: Value,
    ) -> impl Iterator<Item = Operand> + 'a {
        let word = self.computing(value).map(|(word, _)| &self.words[word]);
        let own = word.map_or(function.node(value).operands(), |_| &[]);
        let lanes = word.into_iter().flat_map(|word| &word.operands);
        own.iter().chain(lanes.flatten()).copied()
    }

    /// The superword whose lanes are these operands, in order.
    pub(crate) fn word_of(&self, operands: &[Operand]) -> Option<usize> {
        let (word, _) = self.place(operands[0])?;
        (self.words[word].items == operands).then_some(word)
    }

    /// Superwords of inputs only.
    fn of_inputs(graph: &DataGraph<'_>, lanes: usize, inputs: &[Vec<Operand>]) -> Superwords {
        let mut words = Superwords {
            lanes,
            words: Vec::new(),
            places: vec![None; graph.len()],
            values: graph.function.nodes().len(),
        };
        for items in inputs {
            words.add(graph, seeds::gathered(items.clone()));
        }
        words
    }

    fn add(&mut self, graph: &DataGraph<'_>, word: Superword) {
        assert_eq!(word.items.len(), self.lanes, "a superword is full");
        let number = self.words.len() as u32;
        for (lane, &item) in (0u8..).zip(&word.items) {
            let place = &mut self.places[graph.item(item).expect("a value or an input")];
            assert!(place.is_none(), "a value is in one superword");
            *place = Some((number, lane));
        }
        self.words.push(word);
    }
}
