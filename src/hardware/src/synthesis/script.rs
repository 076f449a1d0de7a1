//! The script that yosys runs.
//!
//! `synth_intel_alm` runs in two parts. Between them are the memories that
//! no block took: the rest of the mapping would turn their words into
//! registers one by one, which takes minutes and makes every figure
//! meaningless, so the script writes their names and stops. A memory without
//! a write port is a table and may well become logic.

use std::fmt::Write;

/// A design for the mapping.
#[derive(Clone, Debug)]
pub struct SynthesisDesign {
    /// The module to map.
    pub top: String,
    /// Parameters of the top that differ from their defaults.
    pub parameters: Vec<(String, String)>,
    /// Verilog: name of the file and text.
    pub sources: Vec<(String, String)>,
    /// Verilog of modules that stay closed, because yosys has no cell of the
    /// device for them.
    pub closed: Vec<(String, String)>,
    /// Other files that the Verilog reads: initial contents of memories.
    pub others: Vec<(String, String)>,
    /// Modules that are mapped by themselves. Equal ones are then mapped once,
    /// and can be distinguished in the netlist; all else is opened.
    pub kept: Vec<String>,
}

/// The file that the netlist is written to.
pub(super) const NETLIST: &str = "netlist.json";

/// The file with the names of the memories that were not mapped.
pub(super) const UNMAPPED: &str = "unmapped.txt";

/// The script for a design.
pub fn script(design: &SynthesisDesign) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, _) in &design.sources {
        let _ = writeln!(text, "read_verilog \"{name}\"");
    }
    for (name, _) in &design.closed {
        let _ = writeln!(text, "read_verilog -lib \"{name}\"");
    }
    let top = &design.top;
    for (name, value) in &design.parameters {
        let _ = writeln!(text, "chparam -set {name} {value} {top}");
    }
    if !design.kept.is_empty() {
        // Modules get names with their parameters here, hence the patterns.
        let _ = writeln!(text, "hierarchy -check -top {top}");
        let patterns: Vec<String> = design.kept.iter().map(|name| format!("*{name}*")).collect();
        let _ = writeln!(
            text,
            "setattr -mod -set keep_hierarchy 1 {}",
            patterns.join(" ")
        );
    }
    let synthesis = format!("synth_intel_alm -noiopad -noclkbuf -top {top}");
    let unmapped = "t:$mem_v2 r:WR_PORTS>0 %i";
    let _ = writeln!(text, "{synthesis} -run begin:map_ffram");
    let _ = writeln!(text, "tee -q -o {UNMAPPED} select -list {unmapped}");
    let _ = writeln!(text, "select -assert-none {unmapped}");
    let _ = writeln!(text, "{synthesis} -run map_ffram:");
    let _ = writeln!(text, "write_json {NETLIST}");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_stops_before_memories_become_registers() {
        let design = SynthesisDesign {
            top: "machine".to_owned(),
            parameters: vec![("CUTS".to_owned(), "5".to_owned())],
            sources: vec![("a.v".to_owned(), String::new())],
            closed: vec![("b.v".to_owned(), String::new())],
            others: Vec::new(),
            kept: vec!["part".to_owned()],
        };
        let script = script(&design);
        let lines: Vec<&str> = script.lines().collect();
        assert_eq!(
            lines[..3],
            [
                "read_verilog \"a.v\"",
                "read_verilog -lib \"b.v\"",
                "chparam -set CUTS 5 machine"
            ]
        );
        let place = |part: &str| lines.iter().position(|line| line.contains(part));
        assert!(place("keep_hierarchy 1 *part*") > place("hierarchy -check -top machine"));
        assert!(place("select -list") < place("select -assert-none"));
        assert!(place("select -assert-none") < place("-run map_ffram:"));
    }
}
