//! Check that the machine has the ports and words that the traffic needs.

use super::ImageError;
use super::traffic::Traffic;
use robovec_ir::Value;

impl Traffic<'_> {
    /// Declared sizes must not be smaller than the sizes used.
    pub(super) fn check_addresses(&self) -> Result<(), ImageError> {
        let fits = |memory: &str, used: u32, declared: Option<u32>| match declared {
            Some(words) if used > words => Err(ImageError::AddressRange {
                memory: memory.to_owned(),
                address: used - 1,
                words,
            }),
            _ => Ok(()),
        };
        let words = self.machine.memory.words;
        fits("an operand memory", self.usage.words, words)?;
        let words = self.machine.buffer.and_then(|buffer| buffer.words);
        fits("a buffer", self.usage.buffer_words, words)
    }

    /// An element starts at most one operation per cycle, and results enter
    /// buffers before the end.
    pub(super) fn check_issues(&self) -> Result<(), ImageError> {
        for element in self.elements() {
            let mut last = None;
            for &value in self.issues.of(element) {
                let cycle = self.schedule.slot(Value(value)).cycle;
                if last.replace(cycle) == Some(cycle) {
                    return Err(ImageError::IssueTwice {
                        element: self.element_name(element),
                        cycle,
                    });
                }
                if self.placement.buffers[value as usize].is_none() {
                    continue;
                }
                if self.machine.buffer.is_none() {
                    return Err(ImageError::NotBuffered {
                        value: self.value_name(value),
                        element: self.element_name(element),
                        cycle,
                    });
                }
                let ready = self.ready(value);
                if ready >= u64::from(self.schedule.cycles) {
                    return Err(ImageError::AfterEnd {
                        value: self.value_name(value),
                        cycle: ready,
                        cycles: self.schedule.cycles,
                    });
                }
            }
        }
        Ok(())
    }

    /// No more transfers in a cycle than the machine declares ports.
    pub(super) fn check_ports(&self) -> Result<(), ImageError> {
        let ports = self.machine.memory.write_limit();
        if self.usage.write_ports > ports {
            for element in self.elements() {
                let mut groups = self.write_groups(element);
                if let Some(group) = groups.find(|group| group.len() > ports as usize) {
                    let write = self.placement.writes[group[0] as usize];
                    return Err(ImageError::WritePorts {
                        memory: self.memory_name(element, write.word.bank),
                        ports,
                        cycle: write.cycle,
                    });
                }
            }
        }
        let mut groups = self.buffer_reads.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        if let Some(buffer) = self.machine.buffer
            && let ports = buffer.read_limit()
            && let Some(group) = groups.find(|group| group.len() > ports as usize)
        {
            return Err(ImageError::BufferPorts {
                element: self.element_name(group[0].0),
                ports,
                cycle: group[0].1,
            });
        }
        Ok(())
    }
}
