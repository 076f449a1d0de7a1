//! The inputs and outputs of a function, in Robotran's order.

use super::FunctionEmitter;
use crate::conventions::{INPUT_ORDER, SENSOR_FIELDS};
use crate::storage::Initial;
use robovec_ir::{Input, Operand, Shape, Symbol};

impl<'e, 'a, 't> FunctionEmitter<'e, 'a, 't> {
    pub(super) fn declare_inputs(&mut self) {
        let rank = |array: u32| {
            let text = match self.storage.arrays[array as usize].initial {
                Initial::Input(name) => self.shared.tables.symbols.text(name),
                Initial::Zero | Initial::Nothing => "",
            };
            let before = INPUT_ORDER.iter().take_while(|&&known| known != text);
            before.count()
        };
        let mut read: Vec<u32> = (0..self.storage.arrays.len() as u32)
            .filter(|&array| self.scan.read[array as usize])
            .collect();
        read.sort_by_key(|&array| rank(array));
        for array in read {
            self.declare_input(array);
        }
    }

    /// Declares the input that an array begins as, unless another array
    /// begins as the same.
    pub(in crate::lower) fn declare_input(&mut self, number: u32) {
        let array = self.storage.arrays[number as usize];
        let Initial::Input(name) = array.initial else {
            return;
        };
        let input = match self.declared.get(&name) {
            Some(&known) => known,
            None => {
                let shape = self.storage.input_shape(name).unwrap_or(array.shape);
                self.function.add_input(name, shape)
            }
        };
        self.declared.insert(name, input);
        self.inputs[number as usize] = Some(input);
    }

    /// Outputs in the order of the signature, then of first appearance.
    pub(super) fn declare_outputs(&mut self) {
        let rank = |array: &u32| {
            let name = self.storage.arrays[*array as usize].name;
            let place = self.parameters.get(&name);
            // The fields of a sensor stand in the order of its structure, so
            // that no case of a file depends on what the others ask for.
            let text = self.shared.tables.symbols.text(name.symbol());
            let before = SENSOR_FIELDS.iter().take_while(|&&field| field != text);
            (place.copied().unwrap_or(usize::MAX), before.count())
        };
        let mut written: Vec<u32> = (0..self.storage.arrays.len() as u32)
            .filter(|&array| {
                let number = array as usize;
                let visible = !self.storage.arrays[number].local
                    || self.scan.passed[number]
                    || self.crossing.is_some();
                self.scan.written[number] && visible
            })
            .collect();
        written.sort_by_key(rank);
        for number in written {
            let array = self.storage.arrays[number as usize];
            let output = self.function.add_output(array.name.symbol(), array.shape);
            self.declared_outputs.insert(output.name);
            self.outputs[number as usize] = Some(output);
        }
    }

    pub(in crate::lower) fn scalar_input(&mut self, symbol: Symbol) -> Operand {
        match self.declared.get(&symbol).map(|array| array.shape) {
            None => {}
            Some(Shape::Scalar) => self.defined_twice(symbol),
            Some(Shape::Vector(_) | Shape::Matrix(..)) => self.both_scalar_and_array(symbol),
        }
        let array = self.function.add_input(symbol, Shape::Scalar);
        self.declared.insert(symbol, array);
        let operand = Operand::from(Input(array.offset));
        self.set_definition(symbol, operand);
        operand
    }
}
