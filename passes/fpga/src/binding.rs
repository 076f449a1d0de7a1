//! Initial data: the content of every preloaded word, symbolically and, for a
//! given input vector, as a number.

use super::ImageError;
use super::manifest::Home;
use super::manifest::{
    ConstantElement, HostElement, InputElement, OutputElement, OutputValue, ValueReference,
    WordAddress,
};
use super::traffic::Traffic;
use robovec_ir::placement::{Preload, Word};
use robovec_ir::print::{print_operand, print_output};
use robovec_ir::{Constant, Input, MAX_INPUT_ELEMENTS, Operand, OperandKind, Value};
use robovec_num::arithmetic::Arithmetic;
use robovec_num::soft_float::FormatArithmetic;

/// The values known before the run and the words they are loaded into.
pub(super) struct PreloadBinding<'a> {
    traffic: &'a Traffic<'a>,
    /// The preloads in order of operand.
    by_operand: Vec<Preload>,
    /// The constants that are loaded, put out or read by the host, in order.
    constants: Vec<Constant>,
    /// The values of the host, in program order.
    host: Vec<Value>,
}

impl<'a> PreloadBinding<'a> {
    /// Collects the initial data.
    pub(super) fn new(traffic: &'a Traffic<'a>) -> Result<PreloadBinding<'a>, ImageError> {
        let function = traffic.view.function;
        if function.input_len() as u64 > MAX_INPUT_ELEMENTS {
            return Err(ImageError::TooManyInputs {
                count: function.input_len(),
            });
        }
        let mut by_operand = traffic.placement.preloads.clone();
        by_operand.sort_by_key(|load| (load.operand, load.word));
        let host: Vec<Value> = function
            .values()
            .map(|(value, _)| value)
            .filter(|&value| traffic.schedule.is_host(value))
            .collect();
        let read_by_host = host
            .iter()
            .flat_map(|&value| function.node(value).operands());
        let mut constants: Vec<Constant> = (function.assignments.iter().map(|a| &a.operand))
            .chain(read_by_host)
            .chain(by_operand.iter().map(|load| &load.operand))
            .filter_map(|operand| operand.constant())
            .collect();
        constants.sort_unstable();
        constants.dedup();
        let binding = PreloadBinding {
            traffic,
            by_operand,
            constants,
            host,
        };
        binding.check()?;
        Ok(binding)
    }

    /// Initial data must be known before the run, and finite.
    fn check(&self) -> Result<(), ImageError> {
        let function = self.traffic.view.function;
        for load in &self.by_operand {
            self.reference(load.operand)?;
        }
        for &value in &self.host {
            for &operand in function.node(value).operands() {
                self.reference(operand)?;
            }
        }
        for &constant in &self.constants {
            let number = function.constant_number(constant);
            if !number.is_finite() {
                return Err(ImageError::Number(format!(
                    "the constant {number:?} has no place in an image"
                )));
            }
        }
        let mut words: Vec<Word> = self.by_operand.iter().map(|load| load.word).collect();
        words.sort_unstable();
        if let Some(pair) = words.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(ImageError::PreloadTwice {
                memory: self.traffic.memory_name(pair[0].element, pair[0].bank),
                address: pair[0].address.number(),
            });
        }
        Ok(())
    }

    /// The place of an operand in the manifest's lists.
    fn reference(&self, operand: Operand) -> Result<ValueReference, ImageError> {
        let place = |found: Result<usize, usize>| found.ok().map(|place| place as u32);
        let reference = match operand.kind() {
            OperandKind::Input(input) => Some(ValueReference::Input(input.0)),
            OperandKind::Constant(constant) => {
                place(self.constants.binary_search(&constant)).map(ValueReference::Constant)
            }
            OperandKind::Value(value) => {
                place(self.host.binary_search(&value)).map(ValueReference::Host)
            }
            OperandKind::None => None,
        };
        reference.ok_or_else(|| {
            let text = print_operand(self.traffic.view, operand);
            self.traffic
                .malformed(format!("{text} is not known before the run"))
        })
    }

    fn words(&self, operand: Operand) -> Vec<WordAddress> {
        let start = self
            .by_operand
            .partition_point(|load| load.operand < operand);
        self.by_operand[start..]
            .iter()
            .take_while(|load| load.operand == operand)
            .map(|load| self.address(load.word))
            .collect()
    }

    fn address(&self, word: Word) -> WordAddress {
        WordAddress {
            memory: self.traffic.memory_name(word.element, word.bank),
            address: word.address.number(),
        }
    }

    /// The manifest's inputs.
    pub(super) fn inputs(&self) -> Vec<InputElement> {
        let count = self.traffic.view.function.input_len() as u32;
        (0..count)
            .map(|index| {
                let operand = Operand::from(Input(index));
                InputElement {
                    name: print_operand(self.traffic.view, operand),
                    words: self.words(operand),
                }
            })
            .collect()
    }

    /// The manifest's constants.
    pub(super) fn constants(&self) -> Vec<ConstantElement> {
        self.constants
            .iter()
            .map(|&constant| ConstantElement {
                value: format!("{:?}", self.traffic.view.function.constant_number(constant)),
                words: self.words(constant.into()),
            })
            .collect()
    }

    /// The manifest's values of the host.
    pub(super) fn host(&self) -> Result<Vec<HostElement>, ImageError> {
        self.host
            .iter()
            .map(|&value| {
                let node = self.traffic.view.function.node(value);
                let operands = node.operands().iter();
                Ok(HostElement {
                    name: self.traffic.value_name(value.0),
                    operation: node.operation.name().to_owned(),
                    operands: operands
                        .map(|&operand| self.reference(operand))
                        .collect::<Result<_, _>>()?,
                    words: self.words(value.into()),
                })
            })
            .collect()
    }

    /// The manifest's outputs.
    pub(super) fn outputs(&self) -> Result<Vec<OutputElement>, ImageError> {
        let view = self.traffic.view;
        let homes = &self.traffic.placement.homes;
        assert_eq!(
            homes.len(),
            view.function.assignments.len(),
            "every output has a home or none"
        );
        let assignments = view.function.assignments.iter();
        assignments
            .zip(homes)
            .map(|(assignment, home)| {
                let name = print_output(view, assignment.output);
                let value = match home {
                    Some(word) => OutputValue::Home(self.home(&name, assignment.operand, *word)?),
                    None => OutputValue::Known(self.reference(assignment.operand)?),
                };
                Ok(OutputElement {
                    name,
                    index: assignment.output.0,
                    value,
                })
            })
            .collect()
    }

    fn home(&self, name: &str, operand: Operand, word: Word) -> Result<Home, ImageError> {
        let write = operand
            .value()
            .and_then(|value| self.traffic.last_write(value, word));
        let Some(write) = write else {
            let memory = self.traffic.memory_name(word.element, word.bank);
            return Err(self.traffic.malformed(format!(
                "the home {memory}[{}] of {name} is never written with its value",
                word.address
            )));
        };
        let WordAddress { memory, address } = self.address(word);
        Ok(Home {
            memory,
            address,
            written: write.cycle,
        })
    }

    /// The numbers of all preloads in order of word, each with its operand;
    /// `None` where it depends on inputs and none are given.
    pub(super) fn loaded(
        &self,
        arithmetic: &FormatArithmetic,
        inputs: Option<&[f64]>,
    ) -> Result<Vec<(Preload, Option<u64>)>, ImageError> {
        let function = self.traffic.view.function;
        let expected = function.input_len();
        if let Some(given) = inputs.filter(|given| given.len() != expected) {
            return Err(ImageError::InputCount {
                expected,
                given: given.len(),
            });
        }
        let unit = function.trigonometry_unit();
        let unit = unit.map(|unit| unit.expect("the verifier accepts only names of units"));
        let mut host: Vec<Option<f64>> = Vec::with_capacity(self.host.len());
        for &value in &self.host {
            let node = function.node(value);
            let get = |operand: Operand| self.number(arithmetic, inputs, &host, operand);
            let mut operands = Some([0.0; Operand::MAX_COUNT]);
            for (place, &operand) in node.operands().iter().enumerate() {
                operands = operands.zip(get(operand)).map(|(mut known, number)| {
                    known[place] = number;
                    known
                });
            }
            let result = operands.map(|operands| match &unit {
                Some(unit) => unit.within(*arithmetic).apply(node.operation, operands),
                None => arithmetic.apply(node.operation, operands),
            });
            host.push(result);
        }
        let mut loads = self.traffic.placement.preloads.clone();
        loads.sort_by_key(|load| load.word);
        let numbers = loads.into_iter().map(|load| {
            let number = self.number(arithmetic, inputs, &host, load.operand);
            (load, number.map(|number| arithmetic.word(number)))
        });
        Ok(numbers.collect())
    }

    fn number(
        &self,
        arithmetic: &FormatArithmetic,
        inputs: Option<&[f64]>,
        host: &[Option<f64>],
        operand: Operand,
    ) -> Option<f64> {
        match operand.kind() {
            OperandKind::Input(input) => Some(arithmetic.convert(inputs?[input.index()])),
            OperandKind::Constant(constant) => {
                let function = self.traffic.view.function;
                Some(arithmetic.convert(function.constant_number(constant)))
            }
            OperandKind::Value(value) => host[self.host.binary_search(&value).ok()?],
            OperandKind::None => None,
        }
    }
}
