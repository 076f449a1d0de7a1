//! Target for the FPCore reader: it reads or refuses any text without panic or
//! hang, and a function that it reads is sound and unchanged after it is
//! written and read again.

use crate::robotran::text_of_pieces;
use crate::text::{check_round_trip, check_sound};
use arbitrary::{Result, Unstructured};
use robovec::fpcore::{names, read};
use robovec_cgen::c::Real;
use robovec_cgen::fpcore::fpcore;
use robovec_ir::View;

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
    // A `#` is an expression that is still to be chosen.
    let mut text = String::from("(FPCore f (x y) :pre (<= 1 x 2) #)");
    while let Some(place) = text.find('#') {
        let choice = if bytes.is_empty() {
            0
        } else {
            bytes.arbitrary::<u8>()? % 16
        };
        let term = match choice {
            0..4 => "x ",
            4 => "y ",
            5 => "-0.1 ",
            6 => "(+ ##)",
            7 => "(- ##)",
            8 => "(* ##)",
            9 => "(/ ##)",
            10 => "(- #)",
            11 => "(sqrt #)",
            12 => "(fma ###)",
            13 => "(let ([x #][y #])#)",
            14 => "(let* ([x #][y #])#)",
            _ => "(cos #)",
        };
        text.replace_range(place..=place, term);
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
        check_sound(&core.module);
        check_round_trip(&core.module);
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
