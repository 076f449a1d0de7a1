//! The operators of an element: its cores, their selection, and the result that
//! is put on the bus.

use super::cores::{self, OperatorCore};
use super::error::RtlError;
use super::text::range;
use robovec_ir::Operation;
use robovec_ir::machine::{Device, ElementDescription};
use robovec_num::NumberFormat;
use std::fmt::Write;

/// A core of a kind, with its operations and their codes.
struct UnitCore {
    core: OperatorCore,
    /// Name and code.
    operations: Vec<(String, u32)>,
}

impl UnitCore {
    fn name(&self) -> &'static str {
        self.core.name()
    }
}

/// The core that performs an operation.
fn core_of(name: &str) -> Option<OperatorCore> {
    let mut all = Operation::ALL.into_iter();
    all.find(|operation| operation.name() == name)
        .and_then(OperatorCore::of)
}

/// The cores that a kind of element needs, in order of their first
/// operations.
fn parts(kind: &ElementDescription) -> Vec<UnitCore> {
    let mut parts: Vec<UnitCore> = Vec::new();
    for (name, code) in kind.operations.iter().zip(0..) {
        // Hardware is made only for what has a core.
        let Some(core) = core_of(name) else { continue };
        let operation = (name.clone(), code);
        match parts.iter_mut().find(|part| part.core == core) {
            Some(part) => part.operations.push(operation),
            None => parts.push(UnitCore {
                core,
                operations: vec![operation],
            }),
        }
    }
    parts
}

/// The cores that a kind of element needs.
pub(crate) fn cores(kind: &ElementDescription) -> Vec<OperatorCore> {
    parts(kind).into_iter().map(|part| part.core).collect()
}

/// Every operation of a kind must have a core.
pub(super) fn check(kind: &ElementDescription) -> Result<(), RtlError> {
    let lacking = kind.operations.iter().find(|name| core_of(name).is_none());
    match lacking {
        None => Ok(()),
        Some(operation) => Err(RtlError::NoCore {
            operation: operation.clone(),
            kind: kind.kind.clone(),
        }),
    }
}

/// The text between the operands `left`, `right` and `addend` and the wire
/// `result`. `code_bits` is the width of the wire `operation`, 0 where an
/// element performs one operation only.
pub(super) fn text(
    kind: &ElementDescription,
    number: NumberFormat,
    code_bits: u32,
    device: &Device,
) -> String {
    let parts = parts(kind);
    let mut text = String::new();
    // Writing to a string cannot fail, here and below.
    if code_bits > 0 {
        let _ = writeln!(
            text,
            "    // The operation whose operands enter the pipeline in this cycle.\n    \
             reg {} entering;\n    \
             always @(posedge clock)\n        if (advance) entering <= operation;\n",
            range(code_bits)
        );
    }
    for part in &parts {
        core_instance(&mut text, part, (kind, device), number, code_bits);
    }
    select_result(&mut text, &parts, kind.stages, code_bits);
    text
}

fn core_instance(
    text: &mut String,
    part: &UnitCore,
    (kind, device): (&ElementDescription, &Device),
    number: NumberFormat,
    code_bits: u32,
) {
    let cuts = cores::cuts(part.core, number, kind.stages, device);
    let blocks = part.core.device_parameters(device).into_iter();
    let blocks: Vec<String> = blocks
        .map(|(name, value)| format!(".{name}({value}), "))
        .collect();
    let code = |wanted: &str| {
        let found = part.operations.iter().find(|(name, _)| name == wanted);
        found.map(|&(_, code)| format!("entering == {code_bits}'d{code}"))
    };
    let several = part.operations.len() > 1;
    let ports = match part.name() {
        "fp_add" => {
            let subtract = match (code("sub"), several) {
                (Some(is_sub), true) => is_sub,
                (Some(_), false) => "1'b1".to_owned(),
                (None, _) => "1'b0".to_owned(),
            };
            format!(".subtract({subtract}), .left(left), .right(right)")
        }
        "fp_sqrt" => ".left(left)".to_owned(),
        "fp_fma" => {
            let choice = fused_operation(part, code_bits);
            format!(".operation({choice}), .left(left), .right(right),\n        .addend(addend)")
        }
        _ => ".left(left), .right(right)".to_owned(),
    };
    let _ = writeln!(
        text,
        "    wire {word} {module}_result;\n    \
         {module} #(\n        .EXPONENT({exponent}), .MANTISSA({mantissa}), \
         .SUBNORMALS({subnormals}), {blocks}.CUTS(64'h{mask:x}), .EXTRA({extra})\n    ) {module}_core (\n        \
         .clock(clock), .enable(advance), {ports},\n        .result({module}_result)\n    );\n",
        module = part.name(),
        word = range(1 + number.exponent + number.mantissa),
        exponent = number.exponent,
        mantissa = number.mantissa,
        subnormals = u32::from(number.subnormals),
        blocks = blocks.concat(),
        mask = cuts.mask,
        extra = cuts.extra,
    );
}

/// The core's code of a fused operation, from the element's.
fn fused_operation(part: &UnitCore, code_bits: u32) -> String {
    let core_code = |name: &str| match name {
        "fms" => 1,
        "fnma" => 2,
        _ => 0,
    };
    match &part.operations[..] {
        [(name, _)] => format!("2'd{}", core_code(name)),
        several => {
            let mut text = String::new();
            for (name, code) in several {
                match core_code(name) {
                    0 => {}
                    own => {
                        let _ = write!(text, "entering == {code_bits}'d{code} ? 2'd{own} : ");
                    }
                }
            }
            text + "2'd0"
        }
    }
}

/// Writes the selection of the bus value: with several cores, the result of the
/// one whose operation entered as many cycles ago as the pipeline has stages.
fn select_result(text: &mut String, parts: &[UnitCore], stages: u32, code_bits: u32) {
    if let [part] = parts {
        let _ = writeln!(text, "    assign result = {}_result;", part.name());
        return;
    }
    let bits = stages * code_bits;
    let shifted = if stages > 1 {
        format!("{{leaving[{}:0], entering}}", bits - code_bits - 1)
    } else {
        "entering".to_owned()
    };
    let _ = writeln!(
        text,
        "    // The operations in the pipeline, the oldest one highest.\n    \
         reg {} leaving;\n    \
         always @(posedge clock)\n        if (advance) leaving <= {shifted};\n    \
         wire {} left_now = leaving[{}:{}];",
        range(bits),
        range(code_bits),
        bits - 1,
        bits - code_bits,
    );
    let mut choice = String::new();
    let (last, others) = parts.split_last().expect("a unit has a part");
    for part in others {
        let codes: Vec<String> = (part.operations.iter())
            .map(|(_, code)| format!("left_now == {code_bits}'d{code}"))
            .collect();
        let _ = write!(
            choice,
            "({}) ? {}_result : ",
            codes.join(" || "),
            part.name()
        );
    }
    let _ = writeln!(text, "    assign result = {choice}{}_result;", last.name());
}
