//! Check that images fit the machine they are loaded into.

use super::error::LoadError;
use super::load::Loader;
use robovec_fpga::manifest;
use robovec_num::fnv::Fnv;

const MAX_ELEMENTS: usize = 1 << 14;

impl Loader<'_> {
    /// The manifest must describe a part of the machine.
    pub(super) fn check_machine(&self) -> Result<(), LoadError> {
        let (manifest, machine) = (&self.manifest, self.machine);
        let format = manifest.number;
        if !format.is_possible() {
            return Err(LoadError::UnsupportedNumber(format));
        }
        if format != machine.number {
            return Err(LoadError::Machine(
                "it has another number format".to_owned(),
            ));
        }
        if manifest.elements.len() > MAX_ELEMENTS {
            let count = manifest.elements.len();
            return Err(LoadError::TooLarge(format!("{count} elements")));
        }
        for element in &manifest.elements {
            self.check_element(element)?;
        }
        self.check_sources()
    }

    fn check_element(&self, element: &manifest::ProcessingElement) -> Result<(), LoadError> {
        let machine = self.machine;
        let fail = |message: String| Err(LoadError::Machine(message));
        let kind = machine
            .elements
            .iter()
            .find(|kind| kind.kind == element.kind);
        let Some(kind) = kind else {
            return fail(format!("it has no elements of kind '{}'", element.kind));
        };
        let foreign = |name: &&String| !kind.operations.contains(name);
        if let Some(name) = element.operations.iter().find(foreign) {
            return fail(format!("its '{}' does not perform '{name}'", element.kind));
        }
        let sides = machine.memory.style.banks();
        if element.memories.len() != sides {
            return fail(format!(
                "it has {sides} memories per element, {} has {}",
                element.name,
                element.memories.len()
            ));
        }
        for memory in &element.memories {
            let allowed = machine.memory.write_limit();
            if memory.write_ports > allowed {
                return Err(LoadError::WritePorts {
                    memory: memory.name.clone(),
                    ports: memory.write_ports,
                    allowed,
                });
            }
            check_words(&memory.name, memory.words, machine.memory.words)?;
        }
        let Some(buffer) = &element.buffer else {
            return Ok(());
        };
        let Some(described) = machine.buffer else {
            return fail(format!("it has no buffers, {} has one", element.name));
        };
        let allowed = described.read_limit();
        if buffer.read_ports > allowed {
            return Err(LoadError::BufferPorts {
                element: element.name.clone(),
                ports: buffer.read_ports,
                allowed,
            });
        }
        let name = format!("the buffer of {}", element.name);
        check_words(&name, buffer.words, described.words)
    }

    /// The crossbar's inputs: all results, then port by port all buffers.
    fn check_sources(&self) -> Result<(), LoadError> {
        let elements = &self.manifest.elements;
        let ports = self.buffer_reads();
        let expected = elements.len() as u64 * (1 + u64::from(ports));
        let sources = &self.manifest.sources;
        if elements
            .iter()
            .any(|element| element.buffer_reads() != ports)
            || sources.len() as u64 != expected
        {
            return Err(LoadError::Sources);
        }
        for (code, source) in sources.iter().enumerate() {
            let name = &elements[code % elements.len()].name;
            let port = code / elements.len();
            let suffix = match (port, ports) {
                (0, _) => String::new(),
                (_, 1) => ".buffer".to_owned(),
                (port, _) => format!(".buffer.{}", port - 1),
            };
            if source.strip_prefix(name.as_str()) != Some(suffix.as_str()) {
                return Err(LoadError::Sources);
            }
        }
        Ok(())
    }

    /// The machine and all files must be those the manifest was written for.
    pub(super) fn check_hashes(&self) -> Result<(), LoadError> {
        for one in &self.manifest.files {
            let text = self.files.get(one.file.as_str()).copied();
            let text = text.ok_or_else(|| LoadError::NoFile(one.file.clone()))?;
            let found = Fnv::of(text.as_bytes()).text();
            if found != one.hash {
                return Err(LoadError::OtherFile {
                    file: one.file.clone(),
                    found,
                    expected: one.hash.clone(),
                });
            }
        }
        let mut found = Fnv::new();
        for element in &self.manifest.elements {
            // The instructions were loaded from it.
            found.update(self.files[element.instructions.file.as_str()].as_bytes());
        }
        if found.text() != self.manifest.schedule_hash {
            return Err(LoadError::OtherSchedule {
                found: found.text(),
                expected: self.manifest.schedule_hash.clone(),
            });
        }
        let hash = self.machine.content_hash();
        if hash.text() != self.manifest.machine.hash {
            return Err(LoadError::OtherMachine {
                images: self.manifest.machine.hash.clone(),
                machine: hash.text(),
            });
        }
        Ok(())
    }
}

fn check_words(name: &str, words: u32, allowed: Option<u32>) -> Result<(), LoadError> {
    match allowed {
        Some(allowed) if words > allowed => Err(LoadError::Words {
            memory: name.to_owned(),
            words,
            allowed,
        }),
        _ => Ok(()),
    }
}
