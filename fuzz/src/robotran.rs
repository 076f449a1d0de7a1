//! The reader must read or refuse any text without panic or hang, and its
//! result must be a sound module.

use crate::text::{check_round_trip, check_sound};
use arbitrary::{Result, Unstructured};
use robovec::robotran::{Language, read};

/// Pieces that bytes alone would take long to find.
const PIECES: [&str; 104] = [
    "void mbs_dirdyna(double **M, double *c, MbsData *s, double tsim)\n{\n",
    "void mbs_sensor(MbsSensor *sens, MbsData *s, int isens)\n{\n",
    "int mbs_accelred(MbsData *s, double tsim)\n{\n",
    "function [M,c] = dirdyna(s,tsim,usrfun)\n",
    "function [sens] = sensor(s,tsim,usrfun,isens)\n",
    "def link(frc, trq, Flink, Z, Zd, s, tsim):\n",
    "def sensor(sens, s, isens):\n",
    "#define q s->q\n",
    "#ifdef A\n",
    "#else\n",
    "#endif\n",
    "switch(isens)\n{\n",
    "switch isens\n",
    "case 1:\n",
    "case 2,\n",
    "default:\n",
    "otherwise\n",
    "break;\n",
    "end\n",
    "    if (isens == 1):\n",
    "    elif(isens==2):\n",
    "    else:\n",
    "if (A1 > A2)\n",
    "while (A1 > A2) {\n",
    "return 0;\n",
    "return\n",
    "double P1[4];\n",
    "double A1 = 2.0;\n",
    "int A1 = 0;\n",
    "P1 = zeros(4)\n",
    "M = zeros(3,3);\n",
    "q = s->q;\n",
    "frc = s.frc;\n",
    "Qq = phi\n",
    "SWr1 = user_ExtForces(P1,s,tsim,1);\n",
    "SWr1 = usrfun.fext(P1,A1,s,tsim,1);\n",
    "Flink1 = s.user_LinkForces(A1,A2,s,tsim,1)\n",
    "A3 = user_LinkForces(A1,A1,s,tsim,1);\n",
    "M[1][2] = M[2][1] = ",
    "s->frc[1][2] = ",
    "s.frc(1,2) = ",
    "frc[1,2] = ",
    "P1[1] = ",
    "P1(1) = ",
    "sens->P[1] = ",
    "qdd[1] = ",
    "q[2] = q[2]-A1;\n",
    "    ",
    "A1 = ",
    "A2 = ",
    "A3 = ",
    "A1",
    "A2",
    "A3",
    "q[1]",
    "q(1)",
    "s->dpt[3][1]",
    "s.dpt(3,1)",
    "s.dpt[3,1]",
    "SWr1[9]",
    "sin(",
    "sqrt(",
    "#if 1\n",
    "#elif 0\n",
    "#if defined(A)\n",
    "#define A1 1/2\n",
    "#define q A2\n",
    "#define A2 s->qd\n",
    "#undef q\n",
    "#define A3 /* ",
    "*/",
    "// \\\n",
    "\\\n",
    "else if (isens == 2)\n",
    "if (isens == 1)\n",
    "else\n",
    "{ ",
    "}\n",
    "return; ",
    "double P1[4] = {{0}, 0};\n",
    "double *P1 = s->dpt[1];\n",
    "double *P1 = q;\n",
    "(double)",
    "(void)A1;\n",
    "*P1 = ",
    "1/2",
    "-(0)",
    "010",
    "0x1p-3",
    "1.5f",
    "2147483647",
    "%{\n",
    "%}\n",
    "from math import sin\n",
    "(1.0)",
    "0",
    "+",
    "-",
    "*",
    "/",
    "(",
    ")",
    ";\n",
    "\n",
];

/// Reads the bytes unchanged, and as a choice of pieces, in the language that
/// the first byte selects.
///
/// # Panics
///
/// Panics when the reader gives a module that the verifier refuses or whose
/// text does not read back; the reader itself must not.
pub fn read_robotran(data: &[u8]) {
    let Some((&first, rest)) = data.split_first() else {
        return;
    };
    let language = Language::ALL.get(usize::from(first & 3)).copied();
    read_bytes(rest, language);
    // Too few bytes for a choice are no finding.
    if let Ok(text) = text_of_pieces(&mut Unstructured::new(rest), &PIECES) {
        read_bytes(text.as_bytes(), language);
    }
}

/// A text of pieces and, now and then, any character.
pub(crate) fn text_of_pieces(bytes: &mut Unstructured<'_>, pieces: &[&str]) -> Result<String> {
    let mut text = String::new();
    while !bytes.is_empty() {
        let choice = usize::from(bytes.arbitrary::<u8>()?);
        match pieces.get(choice % (pieces.len() + 1)) {
            Some(piece) => text.push_str(piece),
            None => text.push(bytes.arbitrary()?),
        }
    }
    Ok(text)
}

fn read_bytes(bytes: &[u8], language: Option<Language>) {
    let module = match read("fuzz", bytes, language) {
        Ok(read) => read.module,
        Err(error) => {
            assert!(error.report.has_errors());
            assert!(!error.report.render_plain().is_empty());
            return;
        }
    };
    check_sound(&module);
    check_round_trip(&module);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;

    #[test]
    fn anything_is_read_or_refused() {
        cases::of_sizes(3000, 3000, |bytes| {
            read_robotran(bytes.bytes(bytes.len())?);
            Ok(())
        });
    }
}
