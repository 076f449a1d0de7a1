//! Target for the FPCore reader: it reads or refuses any text without panic or
//! hang, and a function that it reads is sound and unchanged after it is
//! written and read again.

use crate::robotran::text_of_pieces;
use arbitrary::{Result, Unstructured};
use robovec::fpcore::{names, read};
use robovec_cgen::c::Real;
use robovec_cgen::fpcore::fpcore;
use robovec_ir::View;
use robovec_ir::parse::parse_module;
use robovec_ir::print::print_module;
use robovec_ir::verify::verify;

/// Pieces that bytes alone would take long to find.
const PIECES: [&str; 44] = [
    "(FPCore ",
    "(x y) ",
    "f ",
    ":name \"f g\" ",
    ":pre ",
    ":precision binary32 ",
    ":precision binary64 ",
    ":round nearestEven ",
    ":round toZero ",
    "(and ",
    "(<= 0 x 1) ",
    "(>= y 2) ",
    "(== x ",
    "(let (",
    "(let* (",
    "[x ",
    "[t* ",
    "]",
    ")",
    ") ",
    "(",
    "(+ ",
    "(- ",
    "(* ",
    "(/ ",
    "(sqrt ",
    "(sin ",
    "(cos ",
    "(fma ",
    "(! :spec 1 ",
    "(if ",
    "(pow ",
    "x ",
    "y ",
    "t* ",
    "1.5 ",
    "1/3 ",
    "0x1.8p3 ",
    "-2e-9 ",
    "1e400 ",
    "PI ",
    "TRUE ",
    "; word\n",
    "#| a |# ",
];

/// Reads the bytes unchanged, as a choice of pieces, and as a core with
/// balanced parentheses.
///
/// # Panics
///
/// Panics when a function that was read is not sound, or is another one after
/// it was written and read; the reader itself must not.
pub fn read_fpcore(data: &[u8]) {
    if let Ok(text) = std::str::from_utf8(data) {
        read_text(text);
    }
    // Too few bytes for a choice are no finding.
    if let Ok(text) = text_of_pieces(&mut Unstructured::new(data), &PIECES) {
        read_text(&text);
    }
    if let Ok(text) = core(&mut Unstructured::new(data)) {
        read_text(&text);
    }
}

/// A core in which every operation has its operands.
fn core(bytes: &mut Unstructured<'_>) -> Result<String> {
    let mut text = String::from("(FPCore f (x y) :pre (<= 1 x 2) ");
    // What is still to write, the last one first; `None` is an expression.
    let mut open: Vec<Option<&str>> = vec![Some(")"), None];
    while let Some(piece) = open.pop() {
        let Some(piece) = piece else {
            let choice = if bytes.is_empty() {
                0
            } else {
                bytes.arbitrary::<u8>()? % 16
            };
            let parts: &[Option<&str>] = match choice {
                0..4 => &[Some("x ")],
                4 => &[Some("y ")],
                5 => &[Some("-0.1 ")],
                6 => &[Some("(+ "), None, None, Some(")")],
                7 => &[Some("(- "), None, None, Some(")")],
                8 => &[Some("(* "), None, None, Some(")")],
                9 => &[Some("(/ "), None, None, Some(")")],
                10 => &[Some("(- "), None, Some(")")],
                11 => &[Some("(sqrt "), None, Some(")")],
                12 => &[Some("(fma "), None, None, None, Some(")")],
                13 => &[
                    Some("(let ([x "),
                    None,
                    Some("][y "),
                    None,
                    Some("])"),
                    None,
                    Some(")"),
                ],
                14 => &[
                    Some("(let* ([x "),
                    None,
                    Some("][y "),
                    None,
                    Some("])"),
                    None,
                    Some(")"),
                ],
                _ => &[Some("(cos "), None, Some(")")],
            };
            open.extend(parts.iter().rev());
            continue;
        };
        text.push_str(piece);
    }
    Ok(text)
}

fn read_text(text: &str) {
    let Ok(names) = names("fuzz", text) else {
        return;
    };
    for name in names {
        let core = match read("fuzz", text, Some(&name)) {
            Ok(core) => core,
            Err(report) => {
                assert!(report.has_errors() && !report.render_plain().is_empty());
                continue;
            }
        };
        let view = core.module.tables.view(&core.module.functions[0]);
        assert_eq!(verify(view), []);
        let printed = print_module(&core.module);
        let parsed = parse_module("fuzz", &printed).expect("printed text can be parsed");
        assert_eq!(print_module(&parsed), printed);
        let written = fpcore(view, Real::Double, &core.ranges).expect("it is short");
        let again = read("again", &written, None).expect("written cores can be read");
        let tables = &again.module.tables;
        let function = &again.module.functions[0];
        let twice = fpcore(View { tables, function }, Real::Double, &again.ranges);
        assert_eq!(twice.as_deref(), Some(written.as_str()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn anything_is_read_or_refused() {
        cases::of_sizes(2000, 3000, |bytes| {
            read_fpcore(bytes.bytes(bytes.len())?);
            Ok(())
        });
    }
}
