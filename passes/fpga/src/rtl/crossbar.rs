//! The crossbar: connections from the buses to every write port.
//!
//! Every write port has a multiplexer, a tree of four to one. In a full
//! crossbar its select is the instruction's; in a pruned one the instruction's
//! select is first decoded into the number of the leg, which costs a table or
//! two per port and saves every leg that no program of this hardware uses.

use super::hardware::{Crossbar, Hardware};
use super::legs;
use super::text::{bits_of, heading, range};
use crate::layout::bits;
use std::collections::BTreeSet;
use std::fmt::Write;

/// The codes of the sources that carry the host's words, each once.
pub(super) fn host_sources(hardware: &Hardware) -> Vec<u32> {
    match &hardware.crossbar {
        Crossbar::Full => vec![0],
        Crossbar::Pruned(legs) => {
            let chosen = legs::host_legs(legs, hardware.write_ports);
            let distinct: BTreeSet<u32> = chosen.into_iter().flatten().collect();
            distinct.into_iter().collect()
        }
    }
}

/// The legs of every write port: all sources with a full crossbar; else the leg
/// that carries the host's words comes first, since an unknown select, and the
/// 0 of an idle machine, mean leg 0.
fn legs_of(hardware: &Hardware) -> Vec<Vec<u32>> {
    let sizes = hardware.sizes();
    let ports = sizes.elements * sizes.memories * sizes.write_ports;
    let Crossbar::Pruned(legs) = &hardware.crossbar else {
        return vec![(0..sizes.sources()).collect(); ports as usize];
    };
    let mut legs = legs.clone();
    let chosen = legs::host_legs(&legs, hardware.write_ports);
    for (memory, chosen) in chosen.into_iter().enumerate() {
        let codes = &mut legs[memory * hardware.write_ports as usize];
        if let Some(place) = codes.iter().position(|&code| Some(code) == chosen) {
            let code = codes.remove(place);
            codes.insert(0, code);
        }
    }
    legs
}

pub(super) fn text(hardware: &Hardware) -> String {
    let legs = legs_of(hardware);
    let sizes = hardware.sizes();
    let full = hardware.crossbar == Crossbar::Full;
    let (width, select) = (hardware.width(), bits(sizes.sources()));
    let ports = legs.len() as u32;
    let (built, all) = hardware.crossbar_pairs();
    let mut text = heading(&[
        format!(
            "The crossbar: {} sources, {ports} write ports, {built} of {all} pairs.",
            sizes.sources()
        ),
        String::new(),
        "`selects` has the code of a source for every write port, element by element,".to_owned(),
        "within an element memory by memory. The word `host` reaches ports without a".to_owned(),
        "source, so that the host can load their memories.".to_owned(),
    ]);
    let _ = writeln!(
        text,
        "module robovec_crossbar (\n    input  {} sources,\n    input  {} selects,\n    \
         input  {} host,\n    output {} words\n);\n",
        range(sizes.sources() * width),
        range(ports * select),
        range(width),
        range(ports * width),
    );
    for (port, codes) in (0u32..).zip(&legs) {
        let word = bits_of("words", port * width, width);
        let code = bits_of("selects", port * select, select);
        match &codes[..] {
            [] => {
                let _ = writeln!(text, "    assign {word} = host;\n");
                continue;
            }
            [only] => {
                let source = bits_of("sources", only * width, width);
                let _ = writeln!(text, "    assign {word} = {source};\n");
                continue;
            }
            _ => {}
        }
        let leg = if full {
            code
        } else {
            decoder(&mut text, port, codes, &code, select);
            format!("leg{port}")
        };
        let sources: Vec<String> = (codes.iter())
            .map(|code| bits_of("sources", code * width, width))
            .collect();
        let _ = writeln!(
            text,
            "    robovec_multiplexer_{} port{port} (\n        .select({leg}),\n        \
             .words({}),\n        .word({word})\n    );\n",
            codes.len(),
            if full {
                "sources".to_owned()
            } else {
                super::text::joined(&sources)
            },
        );
    }
    // A pruned crossbar reads a part of them.
    text += "    wire unused = &{1'b0, sources, selects, host};\n\nendmodule\n";
    text
}

/// The multiplexers that the crossbar needs: name of the file and text.
pub(super) fn multiplexers(hardware: &Hardware) -> Vec<(String, String)> {
    let legs = legs_of(hardware);
    let sizes: BTreeSet<usize> = (legs.iter().map(Vec::len))
        .filter(|&count| count > 1)
        .collect();
    let width = hardware.width();
    let file = |count: usize| {
        let name = format!("robovec_multiplexer_{count}.v");
        (name, multiplexer(count as u32, width))
    };
    sizes.into_iter().map(file).collect()
}

/// From the code of a source to the number of its leg.
fn decoder(text: &mut String, port: u32, codes: &[u32], code: &str, select: u32) {
    let leg = bits(codes.len() as u32);
    let _ = write!(
        text,
        "    reg {} leg{port};\n    always @*\n        case ({code})\n",
        range(leg)
    );
    for (place, code) in codes.iter().enumerate().skip(1) {
        let _ = writeln!(
            text,
            "            {select}'d{code}: leg{port} = {leg}'d{place};"
        );
    }
    let _ = writeln!(
        text,
        "            default: leg{port} = {leg}'d0;\n        endcase"
    );
}

/// One of `count` words, as a tree of multiplexers of four.
fn multiplexer(count: u32, width: u32) -> String {
    let select = bits(count);
    let mut text = heading(&[format!("One of {count} words, the first one lowest.")]);
    let _ = write!(
        text,
        "module robovec_multiplexer_{count} (\n    input  {} select,\n    input  {} words,\n    \
         output {} word\n);\n\n",
        range(select),
        range(count * width),
        range(width),
    );
    let mut level: Vec<String> = (0..count)
        .map(|place| bits_of("words", place * width, width))
        .collect();
    let mut low = 0;
    while level.len() > 1 {
        let own = (select - low).min(2);
        let mut next = Vec::new();
        for (place, group) in level.chunks(4).enumerate() {
            let name = format!("level{}_{place}", low / 2);
            match group {
                [only] => {
                    next.push(only.clone());
                    continue;
                }
                [zero, one] => {
                    let _ = writeln!(
                        text,
                        "    wire {} {name} = select[{low}] ? {one} : {zero};",
                        range(width)
                    );
                }
                several => {
                    let _ = write!(
                        text,
                        "    wire {} {name};\n    multiplexer_4 #(.WIDTH({width})) {name}_of (\n        \
                         .select({}),\n",
                        range(width),
                        bits_of("select", low, own),
                    );
                    for input in 0..4 {
                        // The code of a missing word is never selected.
                        let source = several.get(input).unwrap_or(&several[0]);
                        let _ = writeln!(text, "        .word{input}({source}),");
                    }
                    let _ = writeln!(text, "        .word({name})\n    );");
                }
            }
            next.push(name);
        }
        level = next;
        low += 2;
    }
    let _ = write!(text, "    assign word = {};\n\nendmodule\n", level[0]);
    text
}
