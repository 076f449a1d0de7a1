//! The layout of an instruction word.
//!
//! All elements of a machine share the sizes (one block of hardware serves them
//! all); only the operation field depends on the kind. A size declared in the
//! machine file is kept, so that another model on the same machine needs new
//! images and no new hardware; where the file has "unlimited", the layout takes
//! the size that the program uses.

use super::manifest;
use super::traffic::Usage;
use robovec_ir::Machine;

/// Sizes that all elements share.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    /// Words per memory.
    pub(super) words: u32,
    /// Write ports per memory.
    pub(super) write_ports: u32,
    /// Memories per element: 1, or 2 when split by side.
    pub(super) memories: u32,
    /// Words and read ports of the buffer, if there is one.
    pub(super) buffer: Option<(u32, u32)>,
    pub(super) elements: u32,
}

impl Sizes {
    /// The sizes that the machine declares, else those that the program uses.
    pub(super) fn new(machine: &Machine, usage: &Usage) -> Sizes {
        let memory = &machine.memory;
        Sizes {
            words: memory.words.unwrap_or(usage.words).max(1),
            write_ports: memory.writes.unwrap_or(usage.write_ports),
            memories: memory.style.banks() as u32,
            buffer: machine.buffer.map(|buffer| {
                (
                    buffer.words.unwrap_or(usage.buffer_words).max(1),
                    buffer.reads.unwrap_or(usage.buffer_reads).max(1),
                )
            }),
            elements: usage.elements,
        }
    }

    /// The number of sources that a write port can select from.
    pub(super) fn sources(&self) -> u32 {
        self.elements * (1 + self.buffer.map_or(0, |(_, reads)| reads))
    }
}

/// Bits that distinguish `count` things, at least one.
pub(super) fn bits(count: u32) -> u32 {
    (u32::BITS - count.saturating_sub(1).leading_zeros()).max(1)
}

/// The fields of one element's word, from bit 0 up.
#[derive(Clone, Debug)]
pub(super) struct WordLayout {
    fields: Vec<manifest::InstructionField>,
    width: u32,
    write_ports: u32,
    writes_from: u32,
    buffer_from: u32,
}

/// Place of the field `issue`.
pub(super) const ISSUE: u32 = 0;
/// Place of the field `operation`.
pub(super) const OPERATION: u32 = 1;
/// Place of the field `read.left`; `read.right` follows and, in an element of
/// fused operations, `read.addend`.
pub(super) const READ: u32 = 2;

impl WordLayout {
    /// The layout of an element that performs a number of operations, on
    /// three operands if some of them are fused.
    pub(super) fn new(sizes: &Sizes, operations: usize, fused: bool) -> WordLayout {
        let mut layout = WordLayout {
            fields: Vec::new(),
            width: 0,
            write_ports: sizes.write_ports,
            writes_from: 0,
            buffer_from: 0,
        };
        let address = bits(sizes.words);
        let select = bits(sizes.sources());
        layout.field("issue".to_owned(), 1);
        let codes = if operations > 1 {
            bits(operations as u32)
        } else {
            0
        };
        layout.field("operation".to_owned(), codes);
        layout.field("read.left".to_owned(), address);
        layout.field("read.right".to_owned(), address);
        if fused {
            layout.field("read.addend".to_owned(), address);
        }
        layout.writes_from = layout.fields.len() as u32;
        for memory in 0..sizes.memories {
            let side = match (sizes.memories, memory) {
                (1, _) => "",
                (_, 0) => "left.",
                (_, _) => "right.",
            };
            for port in 0..sizes.write_ports {
                layout.field(format!("{side}write{port}.enable"), 1);
                layout.field(format!("{side}write{port}.address"), address);
                layout.field(format!("{side}write{port}.select"), select);
            }
        }
        layout.buffer_from = layout.fields.len() as u32;
        if let Some((words, reads)) = sizes.buffer {
            layout.field("buffer.write.enable".to_owned(), 1);
            layout.field("buffer.write.address".to_owned(), bits(words));
            for port in 0..reads {
                layout.field(format!("buffer.read{port}.address"), bits(words));
            }
        }
        layout
    }

    fn field(&mut self, name: String, width: u32) {
        self.fields.push(manifest::InstructionField {
            name,
            low: self.width,
            width,
        });
        self.width += width;
    }

    /// Bits of a word.
    pub(super) fn width(&self) -> u32 {
        self.width
    }

    /// All fields, those without a bit included.
    pub(super) fn fields(&self) -> &[manifest::InstructionField] {
        &self.fields
    }

    /// Place of a write port's `enable`; `address` and `select` follow.
    pub(super) fn write(&self, memory: u32, port: u32) -> u32 {
        assert!(port < self.write_ports, "a memory has the write port");
        self.writes_from + 3 * (memory * self.write_ports + port)
    }

    /// Place of `buffer.write.enable`; `buffer.write.address` follows.
    pub(super) fn buffer_write(&self) -> u32 {
        self.buffer_from
    }

    /// Place of a buffer read port's address.
    pub(super) fn buffer_read(&self, port: u32) -> u32 {
        self.buffer_from + 2 + port
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_hold_exactly_what_they_must_tell_apart() {
        let expected = [
            (0, 1),
            (1, 1),
            (2, 1),
            (3, 2),
            (4, 2),
            (5, 3),
            (2048, 11),
            (2049, 12),
        ];
        for (count, width) in expected {
            assert_eq!(bits(count), width, "{count}");
        }
    }

    #[test]
    fn the_word_of_the_bogie_machine_has_the_fields_of_the_thesis() {
        let sizes = Sizes {
            words: 2048,
            write_ports: 2,
            memories: 1,
            buffer: Some((16, 1)),
            elements: 8,
        };
        let layout = WordLayout::new(&sizes, 2, false);
        // Four addresses of 11 bits, two enables and the operation as in the
        // thesis; the issue bit is ours; two selects of 4 bits; 9 bits for
        // the buffer.
        assert_eq!(layout.width(), 4 * 11 + 2 + 1 + 1 + 2 * 4 + 9);
        let end = layout.fields().iter().fold(0, |end, field| {
            assert_eq!(field.low, end, "{} leaves a gap", field.name);
            end + field.width
        });
        assert_eq!(end, layout.width());
        let name = |place: u32| layout.fields()[place as usize].name.as_str();
        assert_eq!(name(layout.write(0, 1)), "write1.enable");
        assert_eq!(name(layout.buffer_write()), "buffer.write.enable");
        assert_eq!(name(layout.buffer_read(0)), "buffer.read0.address");
        let fused = WordLayout::new(&sizes, 2, true);
        assert_eq!(fused.width(), layout.width() + 11);
        let addend = fused.fields().iter().position(|f| f.name == "read.addend");
        assert_eq!(addend, Some(READ as usize + 2));
        let place = fused.write(0, 1) as usize;
        assert_eq!(fused.fields()[place].name, "write1.enable");
    }
}
