//! Images and manifest into a program, with every check that needs no run.

use super::decode::{DecodedSteps, WordFields};
use super::error::LoadError;
use super::mif::Image;
use super::program::{ElementUnit, HostStep, LoadedProgram, MemoryUnit, OutputPlace, OutputUnit};
use robovec_fpga::manifest::{self, Manifest, OutputValue, ValueReference, WordAddress};
use robovec_ir::{Machine, Operation};
use robovec_num::soft_float::FormatArithmetic;
use robovec_num::trigonometry::host::TrigonometricUnit;
use std::collections::BTreeMap;

/// Most words of memories, of buffers, of images in limbs, and of pipelines.
const MAX_WORDS: u64 = 1 << 24;

impl LoadedProgram {
    /// Loads a program from its files, as (file name, text), and checks that
    /// they belong together, to this machine, and were not changed.
    ///
    /// Names may have folders; one of the files must be a `manifest.json`.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong with files or machine.
    pub fn load(files: &[(String, String)], machine: &Machine) -> Result<LoadedProgram, LoadError> {
        let loader = Loader::new(files, machine)?;
        let program = loader.program()?;
        loader.check_hashes()?;
        Ok(program)
    }

    /// As [`LoadedProgram::load`] for images edited by hand: neither the hash of
    /// the instruction images nor that of the machine is compared.
    ///
    /// # Errors
    ///
    /// As [`LoadedProgram::load`], without those of the hashes.
    pub fn load_edited(
        files: &[(String, String)],
        machine: &Machine,
    ) -> Result<LoadedProgram, LoadError> {
        Loader::new(files, machine)?.program()
    }
}

pub(super) struct Loader<'a> {
    pub(super) files: BTreeMap<&'a str, &'a str>,
    pub(super) manifest: Manifest,
    pub(super) machine: &'a Machine,
    memories: Vec<MemoryUnit>,
    /// Memory names to places in `memories`.
    names: BTreeMap<String, u32>,
    words: usize,
}

fn base_name(name: &str) -> &str {
    let mut parts = name.rsplit(['/', '\\']);
    parts.next().expect("a text has a last part")
}

impl<'a> Loader<'a> {
    fn new(files: &'a [(String, String)], machine: &'a Machine) -> Result<Loader<'a>, LoadError> {
        let files: BTreeMap<&str, &str> = files
            .iter()
            .map(|(name, text)| (base_name(name), text.as_str()))
            .collect();
        let mut manifests = files
            .keys()
            .copied()
            .filter(|name| name.ends_with("manifest.json"));
        let name = manifests.next().ok_or(LoadError::NoManifest)?;
        if let Some(other) = manifests.next() {
            return Err(LoadError::SeveralManifests(
                name.to_owned(),
                other.to_owned(),
            ));
        }
        let text = files[name];
        let fail = |error: serde_json::Error| LoadError::Manifest {
            file: name.to_owned(),
            message: error.to_string(),
        };
        #[derive(serde::Deserialize)]
        struct Version {
            format: u32,
        }
        let version: Version = serde_json::from_str(text).map_err(fail)?;
        if version.format != manifest::FORMAT {
            return Err(LoadError::Format {
                found: version.format,
                expected: manifest::FORMAT,
            });
        }
        let manifest: Manifest = serde_json::from_str(text).map_err(fail)?;
        let mut loader = Loader {
            files,
            manifest,
            machine,
            memories: Vec::new(),
            names: BTreeMap::new(),
            words: 0,
        };
        loader.check_machine()?;
        loader.collect_memories()?;
        Ok(loader)
    }

    pub(super) fn buffer_reads(&self) -> u32 {
        let first = self.manifest.elements.first();
        first.map_or(0, |element| element.buffer_reads())
    }

    fn collect_memories(&mut self) -> Result<(), LoadError> {
        let mut total = 0u64;
        let mut element_names = BTreeMap::new();
        for element in &self.manifest.elements {
            if element_names.insert(&element.name, ()).is_some() {
                return Err(LoadError::NameTwice(element.name.clone()));
            }
            for memory in &element.memories {
                let place = self.memories.len() as u32;
                if self.names.insert(memory.name.clone(), place).is_some() {
                    return Err(LoadError::NameTwice(memory.name.clone()));
                }
                self.memories.push(MemoryUnit {
                    name: memory.name.clone(),
                    words: memory.words,
                    offset: total as u32,
                });
                total += u64::from(memory.words);
                if total > MAX_WORDS {
                    return Err(LoadError::TooLarge(format!("{total} memory words")));
                }
            }
        }
        self.words = total as usize;
        Ok(())
    }

    fn program(&self) -> Result<LoadedProgram, LoadError> {
        let manifest = &self.manifest;
        let steps = self.steps()?;
        let data = self.data()?;
        let (elements, buffer_words) = self.elements()?;
        let mut initial = vec![false; self.words];
        let inputs = manifest.inputs.iter();
        let inputs = inputs
            .map(|input| self.initial_words(&input.name, &input.words, &mut initial))
            .collect::<Result<_, _>>()?;
        let mut constants = Vec::new();
        for constant in &manifest.constants {
            self.initial_words(&constant.value, &constant.words, &mut initial)?;
            let number = constant.value.parse().map_err(|_| LoadError::Dangling {
                user: "a constant".to_owned(),
                what: format!("the number '{}'", constant.value),
            })?;
            constants.push(number);
        }
        let mut host = Vec::new();
        for (place, value) in manifest.host.iter().enumerate() {
            let words = self.initial_words(&value.name, &value.words, &mut initial)?;
            host.push(self.host_step(place, value, words)?);
        }
        let unit = manifest.trigonometry.as_deref().map(|name| {
            let unit = name.parse().and_then(TrigonometricUnit::new);
            unit.map_err(|error| LoadError::Dangling {
                user: "the manifest's 'trigonometry'".to_owned(),
                what: format!("'{name}': {error}"),
            })
        });
        let unit = unit.transpose()?;
        Ok(LoadedProgram {
            cycles: manifest.cycles,
            arithmetic: FormatArithmetic::new(manifest.number),
            elements,
            memories: self.memories.clone(),
            words: self.words,
            buffer_words,
            buffer_reads: self.buffer_reads(),
            data,
            inputs,
            constants,
            host,
            unit,
            outputs: self.outputs()?,
            steps,
        })
    }

    fn image(&self, file: &str, depth: u32, width: u32) -> Result<Image, LoadError> {
        let text = self.files.get(file).copied();
        let text = text.ok_or_else(|| LoadError::NoFile(file.to_owned()))?;
        let image = Image::parse(text).map_err(|error| LoadError::Image {
            file: file.to_owned(),
            error,
        })?;
        for (what, found, expected) in [
            ("depth", image.depth(), depth),
            ("width", image.width(), width),
        ] {
            if found != expected {
                return Err(LoadError::ImageSize {
                    file: file.to_owned(),
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(image)
    }

    fn steps(&self) -> Result<DecodedSteps, LoadError> {
        let manifest = &self.manifest;
        let cycles = manifest.cycles;
        let limbs = manifest.elements.iter().map(|element| {
            u64::from(cycles) * u64::from(element.instructions.width.div_ceil(64).max(1))
        });
        let total = limbs.fold(0u64, u64::saturating_add);
        if total > MAX_WORDS {
            return Err(LoadError::TooLarge(format!("{cycles} cycles")));
        }
        let mut images = Vec::new();
        let mut fields = Vec::new();
        for element in &manifest.elements {
            let instructions = &element.instructions;
            images.push(self.image(&instructions.file, cycles, instructions.width)?);
            fields.push(WordFields::new(element)?);
        }
        let names: Vec<&str> = manifest
            .elements
            .iter()
            .map(|element| element.name.as_str())
            .collect();
        DecodedSteps::decode(cycles, &names, &images, &fields)
    }

    /// The words that the data images give a content.
    fn data(&self) -> Result<Vec<(u32, u64)>, LoadError> {
        let width = self.manifest.number.width();
        let mut data = Vec::new();
        let files = self.manifest.elements.iter().flat_map(|e| &e.memories);
        for (memory, unit) in files.zip(&self.memories) {
            let image = self.image(&memory.file, memory.words, width)?;
            let defined = (0..memory.words).filter(|&address| image.is_defined(address));
            data.extend(defined.map(|address| (unit.offset + address, image.word(address)[0])));
        }
        Ok(data)
    }

    fn elements(&self) -> Result<(Vec<ElementUnit>, usize), LoadError> {
        let mut units = Vec::new();
        let mut buffer_offset = 0u64;
        let mut slots = 0u64;
        for element in &self.manifest.elements {
            let kind = self
                .machine
                .elements
                .iter()
                .find(|k| k.kind == element.kind);
            let kind = kind.expect("the machine was found to have the kind of every element");
            let stages = kind.stages;
            let operations = element
                .operations
                .iter()
                .map(|name| self.operation(&element.name, name))
                .collect::<Result<_, _>>()?;
            let place = |memory: &manifest::OperandMemory| self.names[&memory.name];
            let memories = match element.memories.as_slice() {
                [one] => [place(one); 2],
                [left, right] => [place(left), place(right)],
                _ => unreachable!("the memories were found to be those of the machine"),
            };
            let buffer_words = element.buffer.as_ref().map_or(0, |buffer| buffer.words);
            units.push(ElementUnit {
                name: element.name.clone(),
                latency: stages + 1,
                operations,
                memories,
                buffer_words,
                buffer_offset: buffer_offset as u32,
            });
            buffer_offset += u64::from(buffer_words);
            slots += u64::from(stages) + 1;
            if buffer_offset.max(slots) > MAX_WORDS {
                return Err(LoadError::TooLarge(format!(
                    "{buffer_offset} buffer words and {slots} pipeline stages"
                )));
            }
        }
        Ok((units, buffer_offset as usize))
    }

    fn operation(&self, user: &str, name: &str) -> Result<Operation, LoadError> {
        let mut known = Operation::ALL.into_iter();
        known
            .find(|operation| operation.name() == name)
            .ok_or_else(|| LoadError::Dangling {
                user: user.to_owned(),
                what: format!("operation '{name}'"),
            })
    }

    fn word(&self, user: &str, memory: &str, address: u32) -> Result<(u32, u32), LoadError> {
        let place = self.names.get(memory).copied();
        place
            .filter(|&place| address < self.memories[place as usize].words)
            .map(|place| (place, address))
            .ok_or_else(|| LoadError::Dangling {
                user: user.to_owned(),
                what: format!("word {address} of memory '{memory}'"),
            })
    }

    fn initial_words(
        &self,
        user: &str,
        words: &[WordAddress],
        taken: &mut [bool],
    ) -> Result<Vec<u32>, LoadError> {
        let mut places = Vec::with_capacity(words.len());
        for word in words {
            let (memory, address) = self.word(user, &word.memory, word.address)?;
            let place = self.memories[memory as usize].offset + address;
            if std::mem::replace(&mut taken[place as usize], true) {
                return Err(LoadError::InitialTwice {
                    memory: word.memory.clone(),
                    address,
                });
            }
            places.push(place);
        }
        Ok(places)
    }

    /// A reference must be in range; among the host's values, before `host`.
    fn reference(
        &self,
        user: &str,
        reference: ValueReference,
        host: usize,
    ) -> Result<(), LoadError> {
        let (index, length, what) = match reference {
            ValueReference::Input(index) => (index, self.manifest.inputs.len(), "input"),
            ValueReference::Constant(index) => (index, self.manifest.constants.len(), "constant"),
            ValueReference::Host(index) => (index, host, "earlier host value"),
        };
        if (index as usize) < length {
            return Ok(());
        }
        Err(LoadError::Dangling {
            user: user.to_owned(),
            what: format!("{what} {index}"),
        })
    }

    fn host_step(
        &self,
        place: usize,
        value: &manifest::HostElement,
        words: Vec<u32>,
    ) -> Result<HostStep, LoadError> {
        let operation = self.operation(&value.name, &value.operation)?;
        for &operand in &value.operands {
            self.reference(&value.name, operand, place)?;
        }
        let operands = match (operation.arity(), value.operands.as_slice()) {
            (1, &[only]) => [only; 3],
            (2, &[left, right]) => [left, right, left],
            (3, &[left, right, addend]) => [left, right, addend],
            (arity, given) => {
                return Err(LoadError::Dangling {
                    user: value.name.clone(),
                    what: format!("{} operands instead of {arity}", given.len()),
                });
            }
        };
        Ok(HostStep {
            operation,
            operands,
            words,
        })
    }

    fn outputs(&self) -> Result<Vec<OutputUnit>, LoadError> {
        let unit = |output: &manifest::OutputElement| {
            let place = match &output.value {
                OutputValue::Home(home) => {
                    let (memory, address) = self.word(&output.name, &home.memory, home.address)?;
                    OutputPlace::Home {
                        memory,
                        address,
                        written: home.written,
                    }
                }
                OutputValue::Known(reference) => {
                    self.reference(&output.name, *reference, self.manifest.host.len())?;
                    OutputPlace::Known(*reference)
                }
            };
            Ok(OutputUnit {
                name: output.name.clone(),
                index: output.index,
                place,
            })
        };
        self.manifest.outputs.iter().map(unit).collect()
    }
}
