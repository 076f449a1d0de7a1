//! Instruction words decoded, once, into the actions of each cycle.

use super::error::LoadError;
use super::mif::Image;
use robovec_fpga::manifest;
use std::collections::BTreeMap;

/// Bits of a word; a field without bits always reads 0.
#[derive(Clone, Copy, Default, Debug)]
struct BitField {
    low: u32,
    width: u32,
}

/// Places of the fields in an element's words.
#[derive(Clone, Debug)]
pub(super) struct WordFields {
    issue: BitField,
    operation: BitField,
    /// Left, right, addend; the last without bits if nothing is fused.
    reads: [BitField; 3],
    /// Memory (0 or 1), enable, address and select of every write port.
    writes: Vec<(usize, [BitField; 3])>,
    buffer_write: [BitField; 2],
    buffer_reads: Vec<BitField>,
    /// The bits that some field covers.
    covered: Vec<u64>,
}

impl WordFields {
    /// Reads the layout of an element's words.
    pub(super) fn new(element: &manifest::ProcessingElement) -> Result<WordFields, LoadError> {
        let fail = |problem: String| LoadError::Layout {
            element: element.name.clone(),
            problem,
        };
        let width = element.instructions.width;
        let mut covered = vec![0u64; width.div_ceil(64) as usize];
        let mut named = BTreeMap::new();
        for field in &element.instructions.fields {
            let end = field.low.checked_add(field.width);
            let inside = end.is_some_and(|end| end <= width);
            if !inside || !(1..=32).contains(&field.width) {
                return Err(fail(format!(
                    "field '{}' is not 1 to 32 bits within the word",
                    field.name
                )));
            }
            for bit in field.low..field.low + field.width {
                let mask = 1u64 << (bit % 64);
                let limb = &mut covered[(bit / 64) as usize];
                if *limb & mask != 0 {
                    return Err(fail(format!("field '{}' overlaps another", field.name)));
                }
                *limb |= mask;
            }
            let bits = BitField {
                low: field.low,
                width: field.width,
            };
            if named.insert(field.name.clone(), bits).is_some() {
                return Err(fail(format!("field '{}' occurs twice", field.name)));
            }
        }
        let mut take = |name: &str| named.remove(name).unwrap_or_default();
        let mut fields = WordFields {
            issue: take("issue"),
            operation: take("operation"),
            reads: ["read.left", "read.right", "read.addend"].map(&mut take),
            writes: Vec::new(),
            buffer_write: [take("buffer.write.enable"), take("buffer.write.address")],
            buffer_reads: Vec::new(),
            covered,
        };
        let sides: &[&str] = match element.memories.len() {
            1 => &[""],
            _ => &["left.", "right."],
        };
        for (number, (memory, side)) in element.memories.iter().zip(sides).enumerate() {
            for port in 0..memory.write_ports {
                let of = |name: &str| format!("{side}write{port}.{name}");
                let bits = ["enable", "address", "select"].map(|name| take(&of(name)));
                if bits[0].width != 1 {
                    return Err(fail(format!("'{}' is not a bit", of("enable"))));
                }
                fields.writes.push((number, bits));
            }
        }
        for port in 0..element.buffer_reads() {
            let name = format!("buffer.read{port}.address");
            let bits = take(&name);
            if bits.width == 0 {
                return Err(fail(format!("there is no '{name}'")));
            }
            fields.buffer_reads.push(bits);
        }
        match named.keys().next() {
            Some(name) => Err(fail(format!("there is no field '{name}' in such a word"))),
            None => Ok(fields),
        }
    }
}

fn get(image: &Image, cycle: u32, bits: BitField) -> u32 {
    if bits.width == 0 {
        return 0;
    }
    image.bits(cycle, bits.low, bits.width)
}

/// An operation starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Issue {
    pub(super) element: u32,
    pub(super) code: u32,
    /// Read addresses: left, right, addend.
    pub(super) reads: [u32; 3],
}

/// A write port stores a word from the crossbar.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemoryWrite {
    /// Element that owns the memory.
    pub(super) element: u32,
    pub(super) memory: u32,
    pub(super) address: u32,
    /// Input of the crossbar.
    pub(super) select: u32,
    /// For a buffer as the source: the word at its read port.
    pub(super) buffer_word: u32,
}

/// A result enters its element's buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct BufferWrite {
    pub(super) element: u32,
    pub(super) word: u32,
}

/// Steps, cycle after cycle and within a cycle element after element.
#[derive(Clone, Debug)]
pub(super) struct DecodedSteps {
    issues: ByCycle<Issue>,
    writes: ByCycle<MemoryWrite>,
    buffer_writes: ByCycle<BufferWrite>,
}

impl DecodedSteps {
    /// Decodes all words of all elements. Every image must have a word for
    /// each cycle, of the width the fields were laid out for.
    pub(super) fn decode(
        cycles: u32,
        names: &[&str],
        images: &[Image],
        fields: &[WordFields],
    ) -> Result<DecodedSteps, LoadError> {
        assert_eq!(names.len(), images.len(), "every image is of an element");
        assert_eq!(fields.len(), images.len(), "every image has a layout");
        let mut found = ElementSteps::default();
        for (element, image) in images.iter().enumerate() {
            let name = || names[element].to_owned();
            if let Some(cycle) = (0..cycles).find(|&cycle| !image.is_defined(cycle)) {
                let element = name();
                return Err(LoadError::UndefinedInstruction { element, cycle });
            }
            let covered = &fields[element].covered;
            for cycle in 0..cycles {
                let word = image.word(cycle);
                if word.iter().all(|&limb| limb == 0) {
                    continue;
                }
                if word
                    .iter()
                    .zip(covered)
                    .any(|(word, mask)| word & !mask != 0)
                {
                    let element = name();
                    return Err(LoadError::UndefinedBits { element, cycle });
                }
                found.word(cycle, element, images, fields);
            }
        }
        Ok(DecodedSteps {
            issues: ByCycle::new(cycles, found.issues),
            writes: ByCycle::new(cycles, found.writes),
            buffer_writes: ByCycle::new(cycles, found.buffer_writes),
        })
    }

    pub(super) fn issues(&self, cycle: u32) -> &[Issue] {
        self.issues.of(cycle)
    }

    pub(super) fn writes(&self, cycle: u32) -> &[MemoryWrite] {
        self.writes.of(cycle)
    }

    pub(super) fn buffer_writes(&self, cycle: u32) -> &[BufferWrite] {
        self.buffer_writes.of(cycle)
    }
}

#[derive(Clone, Debug)]
struct ByCycle<T> {
    /// For each cycle the start of its steps; one entry more at the end.
    starts: Vec<u32>,
    steps: Vec<T>,
}

impl<T: Copy> ByCycle<T> {
    /// Sorts steps by cycle; those of one cycle keep their order.
    fn new(cycles: u32, found: Vec<(u32, T)>) -> ByCycle<T> {
        let mut starts = vec![0u32; cycles as usize + 1];
        for &(cycle, _) in &found {
            starts[cycle as usize + 1] += 1;
        }
        for cycle in 0..cycles as usize {
            starts[cycle + 1] += starts[cycle];
        }
        let mut next = starts.clone();
        let mut places: Vec<u32> = vec![0; found.len()];
        for (index, &(cycle, _)) in (0u32..).zip(&found) {
            let place = &mut next[cycle as usize];
            places[*place as usize] = index;
            *place += 1;
        }
        let steps = places.iter().map(|&index| found[index as usize].1);
        ByCycle {
            steps: steps.collect(),
            starts,
        }
    }

    fn of(&self, cycle: u32) -> &[T] {
        let cycle = cycle as usize;
        &self.steps[self.starts[cycle] as usize..self.starts[cycle + 1] as usize]
    }
}

#[derive(Default)]
struct ElementSteps {
    issues: Vec<(u32, Issue)>,
    writes: Vec<(u32, MemoryWrite)>,
    buffer_writes: Vec<(u32, BufferWrite)>,
}

impl ElementSteps {
    fn word(&mut self, cycle: u32, element: usize, images: &[Image], all: &[WordFields]) {
        let (image, fields) = (&images[element], &all[element]);
        let own = |bits: BitField| get(image, cycle, bits);
        let owner = element as u32;
        if own(fields.issue) == 1 {
            let issue = Issue {
                element: owner,
                code: own(fields.operation),
                reads: fields.reads.map(own),
            };
            self.issues.push((cycle, issue));
        }
        for &(memory, [enable, address, select]) in &fields.writes {
            if own(enable) == 1 {
                let select = own(select);
                // The codes count all results, then all first read ports of
                // the buffers, then all second ones.
                let source = select as usize % images.len();
                let port = (select as usize / images.len()).checked_sub(1);
                let read = port.and_then(|port| all[source].buffer_reads.get(port));
                let write = MemoryWrite {
                    element: owner,
                    memory: memory as u32,
                    address: own(address),
                    select,
                    buffer_word: read.map_or(0, |&bits| get(&images[source], cycle, bits)),
                };
                self.writes.push((cycle, write));
            }
        }
        let [enable, word] = fields.buffer_write;
        if own(enable) == 1 {
            let element = owner;
            let word = own(word);
            self.buffer_writes
                .push((cycle, BufferWrite { element, word }));
        }
    }
}
