//! Shared parts of the tests of hardware: tools, and images to be edited.

use robovec::rtl::HardwareSimulator;
use robovec_fpga::manifest::Manifest;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Tests whether a tool is installed; prints a remark otherwise.
pub(crate) fn is_there(tool: HardwareSimulator) -> bool {
    if let Some(program) = tool.missing() {
        eprintln!("SKIPPED: {program} is not installed, nothing was checked with {tool:?}");
        return false;
    }
    true
}

/// Replaces the one place of a text in a file.
pub(crate) fn replace(path: &Path, right: &str, wrong: &str) {
    let text = fs::read_to_string(path).expect("it was generated");
    assert_eq!(
        text.matches(right).count(),
        1,
        "{right} in {}",
        path.display()
    );
    fs::write(path, text.replace(right, wrong)).expect("a folder of our own");
}

/// The instruction words, loaded as by the host of a bench.
#[derive(Clone)]
pub(crate) struct Loaded {
    pub(crate) manifest: Manifest,
    lines: Vec<String>,
    /// The line that writes an address first.
    writes: BTreeMap<u64, usize>,
}

impl Loaded {
    /// The instruction words of a folder with benches.
    pub(crate) fn read(folder: &Path) -> Loaded {
        let images = fs::read_dir(folder.join("img")).expect("it was generated");
        let manifest = images
            .map(|entry| entry.expect("a readable folder").path())
            .find(|path| path.display().to_string().ends_with(".manifest.json"))
            .expect("there is a manifest");
        let text = fs::read_to_string(manifest).expect("it can be read");
        let commands = fs::read_to_string(folder.join("tb/host.hex")).expect("it was generated");
        let lines: Vec<String> = commands.lines().map(str::to_owned).collect();
        let mut writes = BTreeMap::new();
        for (number, line) in lines.iter().enumerate() {
            if line.starts_with("01") {
                let address = u64::from_str_radix(&line[8..16], 16).expect("hexadecimal");
                writes.entry(address).or_insert(number);
            }
        }
        Loaded {
            manifest: serde_json::from_str(&text).expect("a manifest"),
            lines,
            writes,
        }
    }

    /// Puts them into the folder.
    pub(crate) fn write(&self, folder: &Path) {
        let text = self.lines.join("\n") + "\n";
        fs::write(folder.join("tb/host.hex"), text).expect("a folder of our own");
    }

    /// Lines of a word's limbs, and the place of a field.
    fn place(&self, element: usize, cycle: u32, field: &str) -> Option<(Vec<usize>, u32, u32)> {
        let element = &self.manifest.elements[element];
        let mut fields = element.instructions.fields.iter();
        let field = fields.find(|known| known.name == field)?;
        let window = self.manifest.window.as_ref().expect("images for hardware");
        let name = format!("{}.instructions", element.name);
        let unit = window.units.iter().find(|unit| unit.name == name)?;
        let first = u64::from(unit.address) + u64::from(cycle) * u64::from(unit.stride);
        let limbs = (first..first + u64::from(unit.limbs)).map(|address| self.writes[&address]);
        Some((limbs.collect(), field.low, field.width))
    }

    /// A field of a word; 0 for one that the element does not have.
    pub(crate) fn get(&self, element: usize, cycle: u32, field: &str) -> u64 {
        let Some((lines, low, width)) = self.place(element, cycle, field) else {
            return 0;
        };
        let word = lines.iter().rev().fold(0u128, |word, &line| {
            let limb = u32::from_str_radix(&self.lines[line][16..], 16).expect("hexadecimal");
            word << 32 | u128::from(limb)
        });
        (word >> low) as u64 & ((1 << width) - 1)
    }

    /// Changes a field of a word.
    pub(crate) fn set(&mut self, element: usize, cycle: u32, field: &str, value: u64) {
        let (lines, low, width) = self.place(element, cycle, field).expect("it has the field");
        assert!(value < 1 << width, "{field} = {value}");
        for bit in 0..width {
            let place = low + bit;
            let line = &mut self.lines[lines[(place / 32) as usize]];
            let mut limb = u32::from_str_radix(&line[16..], 16).expect("hexadecimal");
            limb &= !(1 << (place % 32));
            limb |= ((value >> bit & 1) as u32) << (place % 32);
            line.truncate(16);
            *line += &format!("{limb:08x}");
        }
    }

    /// The first word from a cycle on in which a field is not zero.
    pub(crate) fn find(&self, field: &str, from: u32) -> Option<(usize, u32)> {
        let elements = self.manifest.elements.len();
        (from..self.manifest.cycles)
            .flat_map(|cycle| (0..elements).map(move |element| (element, cycle)))
            .find(|&(element, cycle)| self.get(element, cycle, field) != 0)
    }
}
