//! A program as loaded from its images.

use super::decode::DecodedSteps;
use robovec_fpga::manifest::ValueReference;
use robovec_ir::Operation;
use robovec_num::soft_float::FormatArithmetic;
use robovec_num::trigonometry::host::TrigonometricUnit;

/// A program in the simulator's memories, ready to be run any number of times.
#[derive(Clone, Debug)]
pub struct LoadedProgram {
    pub(super) cycles: u32,
    /// Arithmetic of elements and host.
    pub(super) arithmetic: FormatArithmetic,
    pub(super) elements: Vec<ElementUnit>,
    pub(super) memories: Vec<MemoryUnit>,
    /// Words of all memories together.
    pub(super) words: usize,
    /// Words of all buffers together.
    pub(super) buffer_words: usize,
    pub(super) buffer_reads: u32,
    /// Content of the data images: word, bits.
    pub(super) data: Vec<(u32, u64)>,
    /// For every input element the words to load it into.
    pub(super) inputs: Vec<Vec<u32>>,
    pub(super) constants: Vec<f64>,
    pub(super) host: Vec<HostStep>,
    /// Unit for the host's sines and cosines, when it is given.
    pub(super) unit: Option<TrigonometricUnit>,
    pub(super) outputs: Vec<OutputUnit>,
    pub(super) steps: DecodedSteps,
}

#[derive(Clone, Debug)]
pub(super) struct ElementUnit {
    pub(super) name: String,
    /// Cycles from the issue to the result on the bus.
    pub(super) latency: u32,
    pub(super) operations: Vec<Operation>,
    /// Memories of the left and right operand: twice the same when unified.
    pub(super) memories: [u32; 2],
    /// Words of the buffer; 0 without one.
    pub(super) buffer_words: u32,
    /// Its first word among those of all buffers.
    pub(super) buffer_offset: u32,
}

#[derive(Clone, Debug)]
pub(super) struct MemoryUnit {
    pub(super) name: String,
    pub(super) words: u32,
    /// Its first word among those of all memories.
    pub(super) offset: u32,
}

/// A value the host computes.
#[derive(Clone, Debug)]
pub(super) struct HostStep {
    pub(super) operation: Operation,
    /// After the operands of the operation the first one again.
    pub(super) operands: [ValueReference; 3],
    /// Words into which it is loaded.
    pub(super) words: Vec<u32>,
}

/// Place where an output is found.
#[derive(Clone, Debug)]
pub(super) struct OutputUnit {
    pub(super) name: String,
    pub(super) index: u32,
    pub(super) place: OutputPlace,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum OutputPlace {
    /// In a memory, written at the end of a cycle.
    Home {
        memory: u32,
        address: u32,
        written: u32,
    },
    /// Known before the run.
    Known(ValueReference),
}

impl LoadedProgram {
    /// The length of a run.
    pub fn cycles(&self) -> u32 {
        self.cycles
    }

    /// The names of the outputs and their places among the function's
    /// flattened output elements, in the order of [`super::SimulatedOutputs`].
    pub fn outputs(&self) -> impl Iterator<Item = (&str, u32)> {
        self.outputs
            .iter()
            .map(|output| (output.name.as_str(), output.index))
    }
}

/// Results of a run.
#[derive(Clone, PartialEq, Debug)]
pub struct SimulatedOutputs {
    /// The output elements that the program sets, in order of
    /// [`LoadedProgram::outputs`]; numbers of the machine's format, held exactly.
    pub values: Vec<f64>,
    /// The same as words of the machine.
    pub words: Vec<u64>,
    /// Cycles the run took.
    pub cycles: u32,
}
