//! Blocks of numbers turned about: rows of states into runs of elements, and
//! back.
//!
//! A number at a time takes a load and a store for each; a block of registers
//! takes one of both for a row, and shuffles between them.

use crate::c::Real;

/// True when a batch of so many lanes can be turned in blocks.
pub(super) fn has_blocks(lanes: u32) -> bool {
    lanes.is_multiple_of(4)
}

/// The function that turns one square block of `ROBOVEC_BLOCK` rows, which is
/// 0 where compilers know no vectors.
pub(super) fn turned_block(name: &str, real: Real) -> String {
    let (wide, integer, condition) = match real {
        Real::Double => (2, "long long", "defined(__AVX__)"),
        Real::Float => (4, "int", "1"),
    };
    let real = real.name();
    format!(
        "#if (defined(__GNUC__) || defined(__clang__)) && !defined(ROBOVEC_SCALAR)
#if {condition}
#define ROBOVEC_BLOCK 4
#else
#define ROBOVEC_BLOCK {wide}
#endif
typedef {real} {name}_row __attribute__((vector_size(sizeof({real}) * ROBOVEC_BLOCK)));
typedef {real} {name}_rowu __attribute__((vector_size(sizeof({real}) * ROBOVEC_BLOCK), aligned(sizeof({real})), may_alias));
typedef {integer} {name}_places __attribute__((vector_size(sizeof({real}) * ROBOVEC_BLOCK)));
#if defined(__clang__)
#define ROBOVEC_MIX(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define ROBOVEC_MIX(a, b, ...) __builtin_shuffle(a, b, ({name}_places){{__VA_ARGS__}})
#endif
/* A square block, its rows `next` numbers apart, into columns; the new rows are
   `step` apart. */
static inline void {name}_turn(const {real} *from, long next, {real} *to, long step)
{{
    const {name}_row a = *(const {name}_rowu *)from;
    const {name}_row b = *(const {name}_rowu *)(from + next);
#if ROBOVEC_BLOCK == 2
    *({name}_rowu *)to = ROBOVEC_MIX(a, b, 0, 2);
    *({name}_rowu *)(to + step) = ROBOVEC_MIX(a, b, 1, 3);
#else
    const {name}_row c = *(const {name}_rowu *)(from + 2 * next);
    const {name}_row d = *(const {name}_rowu *)(from + 3 * next);
    const {name}_row even = ROBOVEC_MIX(a, b, 0, 4, 2, 6), odd = ROBOVEC_MIX(a, b, 1, 5, 3, 7);
    const {name}_row below = ROBOVEC_MIX(c, d, 0, 4, 2, 6), last = ROBOVEC_MIX(c, d, 1, 5, 3, 7);
    *({name}_rowu *)to = ROBOVEC_MIX(even, below, 0, 1, 4, 5);
    *({name}_rowu *)(to + step) = ROBOVEC_MIX(odd, last, 0, 1, 4, 5);
    *({name}_rowu *)(to + 2 * step) = ROBOVEC_MIX(even, below, 2, 3, 6, 7);
    *({name}_rowu *)(to + 3 * step) = ROBOVEC_MIX(odd, last, 2, 3, 6, 7);
#endif
}}
#else
#define ROBOVEC_BLOCK 0
#endif

"
    )
}

/// What a copy of spans does with a full batch whose elements stand side by
/// side: blocks, then what is left. Places are those of element `i` of state
/// `lane`, in what is read and in what is written; rows of a block are so far
/// apart.
pub(super) struct TurnedPlaces {
    /// Place in `from`, and the distance of rows.
    pub(super) from: (String, String),
    /// Place in `to`, and the distance of rows.
    pub(super) to: (String, String),
}

impl TurnedPlaces {
    /// The lines; nothing for batches that have no blocks.
    pub(super) fn lines(&self, name: &str, lanes: u32) -> String {
        if !has_blocks(lanes) {
            return String::new();
        }
        let ((from, next), (to, step)) = (&self.from, &self.to);
        format!(
            "#if ROBOVEC_BLOCK
    if (count == {lanes} && step == 1) {{
        for (long span = 0; span < number; span++) {{
            const long end = spans[span][0] + spans[span][1];
            long i = spans[span][0];
            for (; i + ROBOVEC_BLOCK <= end; i += ROBOVEC_BLOCK)
                for (long lane = 0; lane < {lanes}; lane += ROBOVEC_BLOCK)
                    {name}_turn(from + {from}, {next}, to + {to}, {step});
            for (; i < end; i++)
                for (long lane = 0; lane < {lanes}; lane++)
                    to[{to}] = from[{from}];
        }}
        return;
    }}
#endif
"
        )
    }
}
