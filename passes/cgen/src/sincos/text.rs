//! The C text of the kernel.

use super::{KernelConstants, SineKernel};
use crate::emit::Real;
use crate::emit::expression::{self, BoundText, Operands, apply};
use robovec_ir::Operation;
use std::fmt::Write;

/// Whether vectors are there, and their types.
pub(super) fn types(kernel: SineKernel) -> String {
    let KernelNames {
        real,
        integer,
        vector,
        bits,
        unaligned,
        suffix,
        ..
    } = KernelNames::of(kernel);
    let mut text = String::from("#include <math.h>\n\n");
    if kernel.lanes == 1 {
        let _ = write!(
            text,
            "typedef {real} {vector};\ntypedef {real} {unaligned};\n"
        );
        return text;
    }
    let upper = suffix.to_ascii_uppercase();
    let _ = write!(
        text,
        "#if (defined(__GNUC__) || defined(__clang__)) && !defined(ROBOVEC_SCALAR)
{widths}typedef {real} {vector} __attribute__((vector_size({bytes})));
typedef unsigned {integer} {bits} __attribute__((vector_size({bytes})));
typedef {real} {unaligned} __attribute__((vector_size({bytes}), aligned({own}), may_alias));
/* Sums are not to be regrouped, even where the rest of the file allows it. */
#if defined(__clang__)
#define ROBOVEC_PRECISE
#define ROBOVEC_AS_WRITTEN _Pragma(\"clang fp reassociate(off)\")
#else
#define ROBOVEC_PRECISE \\
    __attribute__((optimize(\"no-unsafe-math-optimizations\", \"no-finite-math-only\")))
#define ROBOVEC_AS_WRITTEN
#endif
#else
#define ROBOVEC_{upper} 0
typedef {real} {vector};
typedef {real} {unaligned};
#endif
",
        own = size(kernel.real),
        widths = widths(kernel),
        bytes = format!("{} * ROBOVEC_{upper}", size(kernel.real)),
    );
    text
}

/// The macro that says how many lanes a vector has: as many as fit into a
/// register. Compilers split wider ones in memory, which takes several times
/// longer than narrower ones one after the other.
fn widths(kernel: SineKernel) -> String {
    let upper = kernel.suffix().to_ascii_uppercase();
    let fit = |bytes: u32| (bytes / size(kernel.real)).min(kernel.lanes);
    let (all, some, least) = (kernel.lanes, fit(32), fit(16));
    format!(
        "/* Lanes of a register. */
#if defined(__AVX512F__)
#define ROBOVEC_{upper} {all}
#elif defined(__AVX2__)
#define ROBOVEC_{upper} {some}
#else
#define ROBOVEC_{upper} {least}
#endif
"
    )
}

/// The function for angles one behind the other.
pub(super) fn arrays(kernel: SineKernel) -> String {
    let names = KernelNames::of(kernel);
    let KernelNames {
        real, ref lanes, ..
    } = names;
    let name = kernel.arrays_name();
    let library = format!(
        "static void {name}(long count, const {real} *angles, {real} *sines, {real} *cosines)
{{
    for (long i = 0; i < count; i++) {{
        sines[i] = {sine};
        cosines[i] = {cosine};
    }}
}}
",
        sine = library(kernel.real, Operation::Sin, "angles[i]"),
        cosine = library(kernel.real, Operation::Cos, "angles[i]"),
    );
    if kernel.lanes == 1 {
        return library;
    }
    let KernelNames {
        vector,
        bits,
        unaligned,
        suffix,
        guard,
        sign,
        ..
    } = names;
    let core = core(kernel);
    let far = far(kernel);
    format!(
        "{guard}
{core}
{far}
static ROBOVEC_PRECISE void {name}(long count, const {real} *angles, {real} *sines, {real} *cosines)
{{
    {bits} far = {{0}};
    {vector} sine, cosine;
    long i = 0;
    for (; i + {lanes} <= count; i += {lanes}) {{
        const {vector} angle = *(const {unaligned} *)(angles + i);
        robovec_circular_{suffix}(&angle, &sine, &cosine, &far);
        *({unaligned} *)(sines + i) = sine;
        *({unaligned} *)(cosines + i) = cosine;
    }}
    if (i < count && count > {lanes}) {{
        /* The last ones once more, together with the rest. */
        i = count - {lanes};
        const {vector} angle = *(const {unaligned} *)(angles + i);
        robovec_circular_{suffix}(&angle, &sine, &cosine, &far);
        *({unaligned} *)(sines + i) = sine;
        *({unaligned} *)(cosines + i) = cosine;
    }} else if (i < count) {{
        {vector} angle = {{0}};
        for (int lane = 0; lane < count - i; lane++)
            angle[lane] = angles[i + lane];
        robovec_circular_{suffix}(&angle, &sine, &cosine, &far);
        for (int lane = 0; lane < count - i; lane++) {{
            sines[i + lane] = sine[lane];
            cosines[i + lane] = cosine[lane];
        }}
    }}
    unsigned {integer} any = 0;
    for (int lane = 0; lane < {lanes}; lane++)
        any |= far[lane];
    if (any >> {sign})
        robovec_far_{suffix}(count, angles, sines, cosines);
}}
#else
{library}#endif
",
        integer = names.integer,
    )
}

/// The function for angles of many states.
pub(super) fn runs(kernel: SineKernel) -> String {
    let names = KernelNames::of(kernel);
    let KernelNames {
        real,
        ref lanes,
        ref vector,
        ..
    } = names;
    let name = kernel.runs_name();
    let head = format!(
        "static void {name}(long count, const {real} *angles, const int *places, long stride,
    {vector} *sines, {vector} *cosines)"
    );
    let angle = "angles[places[i] * stride]";
    let library = format!(
        "{head}
{{
    for (long i = 0; i < count; i++) {{
        sines[i] = {sine};
        cosines[i] = {cosine};
    }}
}}
",
        sine = library(kernel.real, Operation::Sin, angle),
        cosine = library(kernel.real, Operation::Cos, angle),
    );
    if kernel.lanes == 1 {
        return library;
    }
    let KernelNames {
        bits,
        unaligned,
        suffix,
        guard,
        sign,
        integer,
        ..
    } = names;
    let core = core(kernel);
    let far = far(kernel);
    let precise = head.replacen("static", "static ROBOVEC_PRECISE", 1);
    format!(
        "{guard}
{core}
{far}
{precise}
{{
    {bits} far = {{0}};
    for (long i = 0; i < count; i++) {{
        const {vector} angle = *(const {unaligned} *)(angles + places[i] * stride);
        robovec_circular_{suffix}(&angle, sines + i, cosines + i, &far);
    }}
    unsigned {integer} any = 0;
    for (int lane = 0; lane < {lanes}; lane++)
        any |= far[lane];
    if (any >> {sign})
        for (long i = 0; i < count; i++)
            robovec_far_{suffix}({lanes}, angles + places[i] * stride,
                ({real} *)(sines + i), ({real} *)(cosines + i));
}}
#else
{library}#endif
"
    )
}

/// One vector of angles; `far` gathers lanes that are left to the library in
/// its sign bits.
fn core(kernel: SineKernel) -> String {
    let KernelNames {
        vector,
        bits,
        suffix,
        sign,
        ones,
        ..
    } = KernelNames::of(kernel);
    let constants = KernelConstants::of(kernel.real);
    let number = |value: f64| literal(kernel.real, value);
    let most = match kernel.real {
        Real::Double => constants.limit.to_bits(),
        Real::Float => u64::from((constants.limit as f32).to_bits()),
    };
    let mut text = format!(
        "/* Sine and cosine of angles of at most {limit} rad, within 1 ulp. */
static inline ROBOVEC_PRECISE void robovec_circular_{suffix}(const {vector} *angle, {vector} *sine, {vector} *cosine,
    {bits} *far)
{{
    ROBOVEC_AS_WRITTEN
    const {vector} x = *angle;
    *far |= {most:#x}{ones} - (({bits})x & {mask:#x}{ones});
    /* The nearest number of quarter turns: as an integer in the last bits. */
    {vector} counted = x * {turns} + {rounder};
    const {bits} count = ({bits})counted;
    const {vector} turns = counted - {rounder};
    /* r + low = x - turns * pi/2; the first products are exact. */
    {vector} near = x - turns * {first};
",
        limit = constants.limit,
        mask = most_positive(kernel.real),
        turns = number(constants.turns),
        rounder = number(constants.rounder),
        first = number(constants.quarter[0]),
    );
    reduction(&mut text, kernel);
    let _ = write!(
        text,
        "    const {vector} z = r * r;
    const {vector} zz = z * z;
    const {vector} half = z * {half};
    const {vector} head = {one} - half;
    const {vector} s = r + (r * z * ({sine}) + low * head);
    const {vector} c = head + (({one} - head - half) + (zz * ({cosine}) - r * low));
    /* Odd counts exchange the two, and every second pair changes signs. */
    const {bits} odd = -(count & 1{ones});
    const {bits} a = (({bits})c & odd) | (({bits})s & ~odd);
    const {bits} b = (({bits})s & odd) | (({bits})c & ~odd);
    const {bits} signs = {signs:#x}{ones} + ({bits}){{0}};
    *sine = ({vector})(a ^ ((count << {shift}) & signs));
    *cosine = ({vector})(b ^ (((count + 1{ones}) << {shift}) & signs));
}}
",
        half = number(0.5),
        one = number(1.0),
        sine = pairs(kernel.real, constants.sine),
        cosine = pairs(kernel.real, constants.cosine),
        signs = most_positive(kernel.real) + 1,
        shift = sign - 1,
    );
    text
}

/// The parts of a quarter turn behind the first.
fn reduction(text: &mut String, kernel: SineKernel) {
    let vector = kernel.vector();
    let parts = &KernelConstants::of(kernel.real).quarter[1..];
    let number = |value: f64| literal(kernel.real, value);
    for (index, &part) in (1..).zip(parts) {
        let (from, to) = match index {
            1 => ("near".to_owned(), "r1".to_owned()),
            _ => (format!("r{}", index - 1), format!("r{index}")),
        };
        let _ = write!(
            text,
            "    const {vector} w{index} = turns * {part};
    {vector} {to} = {from} - w{index};
    const {vector} low{index} = ({from} - {to}) - w{index}{carried};
",
            part = number(part),
            carried = match index {
                1 => String::new(),
                _ => format!(" + low{}", index - 1),
            },
        );
    }
    let last = parts.len();
    let _ = writeln!(
        text,
        "    const {vector} r = r{last};\n    const {vector} low = low{last};"
    );
}

/// The library for lanes that are too large or no numbers.
fn far(kernel: SineKernel) -> String {
    let KernelNames { real, suffix, .. } = KernelNames::of(kernel);
    let limit = literal(kernel.real, KernelConstants::of(kernel.real).limit);
    let absolute = match kernel.real {
        Real::Double => "fabs",
        Real::Float => "fabsf",
    };
    format!(
        "/* The library's, for angles beyond the range. */
static void __attribute__((noinline, cold)) robovec_far_{suffix}(long count, const {real} *angles,
    {real} *sines, {real} *cosines)
{{
    for (long i = 0; i < count; i++)
        if (!({absolute}(angles[i]) <= {limit})) {{
            sines[i] = {sine};
            cosines[i] = {cosine};
        }}
}}
",
        sine = library(kernel.real, Operation::Sin, "angles[i]"),
        cosine = library(kernel.real, Operation::Cos, "angles[i]"),
    )
}

/// The names that the text is made of.
struct KernelNames {
    real: &'static str,
    integer: &'static str,
    /// The suffix that makes a literal an unsigned integer of the lanes' width.
    ones: &'static str,
    /// The place of the sign bit.
    sign: u32,
    /// The macro that says how many lanes there are; 1 where there is one.
    lanes: String,
    vector: String,
    unaligned: String,
    bits: String,
    suffix: String,
    guard: String,
}

impl KernelNames {
    fn of(kernel: SineKernel) -> KernelNames {
        let suffix = kernel.suffix();
        let (integer, ones) = match kernel.real {
            Real::Double => ("long long", "ull"),
            Real::Float => ("int", "u"),
        };
        KernelNames {
            real: kernel.real.name(),
            integer,
            ones,
            sign: 8 * size(kernel.real) - 1,
            lanes: match kernel.lanes {
                1 => "1".to_owned(),
                _ => format!("ROBOVEC_{}", suffix.to_ascii_uppercase()),
            },
            vector: kernel.vector(),
            unaligned: kernel.unaligned(),
            bits: format!("robovec_bits_{suffix}"),
            guard: format!("#if ROBOVEC_{}", suffix.to_ascii_uppercase()),
            suffix,
        }
    }
}

/// Bytes of a number.
fn size(real: Real) -> u32 {
    match real {
        Real::Double => 8,
        Real::Float => 4,
    }
}

/// All bits but the sign.
fn most_positive(real: Real) -> u64 {
    match real {
        Real::Double => u64::MAX >> 1,
        Real::Float => u64::from(u32::MAX >> 1),
    }
}

/// A call of the library.
fn library(real: Real, operation: Operation, angle: &str) -> String {
    apply(
        operation,
        &[BoundText::primary(angle)],
        real,
        Operands::Numbers,
    )
    .text
}

/// A number as a literal that reads back as itself.
fn literal(real: Real, number: f64) -> String {
    expression::literal(number, real).text
}

/// A polynomial in `z`: pairs of terms are one step each and joined by powers
/// of `zz`, half as long a chain as term by term.
fn pairs(real: Real, coefficients: &[f64]) -> String {
    let mut text = String::new();
    for pair in coefficients.chunks(2).rev() {
        let own = match *pair {
            [first, second] => format!("{} + z * {}", literal(real, first), literal(real, second)),
            _ => literal(real, pair[0]),
        };
        text = match text.is_empty() {
            true => own,
            false => format!("({own}) + zz * ({text})"),
        };
    }
    text
}
