#if (defined(__GNUC__) || defined(__clang__)) && !defined(ROBOVEC_SCALAR)
#if @condition@
#define ROBOVEC_BLOCK 4
#else
#define ROBOVEC_BLOCK @wide@
#endif
typedef @real@ @name@_row __attribute__((vector_size(sizeof(@real@) * ROBOVEC_BLOCK)));
typedef @real@ @name@_rowu __attribute__((vector_size(sizeof(@real@) * ROBOVEC_BLOCK), aligned(sizeof(@real@)), may_alias));
typedef @integer@ @name@_places __attribute__((vector_size(sizeof(@real@) * ROBOVEC_BLOCK)));
#if defined(__clang__)
#define ROBOVEC_MIX(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define ROBOVEC_MIX(a, b, ...) __builtin_shuffle(a, b, (@name@_places){__VA_ARGS__})
#endif
/* A square block, its rows `next` numbers apart, into columns; the new rows are
   `step` apart. */
static inline void @name@_turn(const @real@ *from, long next, @real@ *to, long step)
{
    const @name@_row a = *(const @name@_rowu *)from;
    const @name@_row b = *(const @name@_rowu *)(from + next);
#if ROBOVEC_BLOCK == 2
    *(@name@_rowu *)to = ROBOVEC_MIX(a, b, 0, 2);
    *(@name@_rowu *)(to + step) = ROBOVEC_MIX(a, b, 1, 3);
#else
    const @name@_row c = *(const @name@_rowu *)(from + 2 * next);
    const @name@_row d = *(const @name@_rowu *)(from + 3 * next);
    const @name@_row even = ROBOVEC_MIX(a, b, 0, 4, 2, 6), odd = ROBOVEC_MIX(a, b, 1, 5, 3, 7);
    const @name@_row below = ROBOVEC_MIX(c, d, 0, 4, 2, 6), last = ROBOVEC_MIX(c, d, 1, 5, 3, 7);
    *(@name@_rowu *)to = ROBOVEC_MIX(even, below, 0, 1, 4, 5);
    *(@name@_rowu *)(to + step) = ROBOVEC_MIX(odd, last, 0, 1, 4, 5);
    *(@name@_rowu *)(to + 2 * step) = ROBOVEC_MIX(even, below, 2, 3, 6, 7);
    *(@name@_rowu *)(to + 3 * step) = ROBOVEC_MIX(odd, last, 2, 3, 6, 7);
#endif
}
#else
#define ROBOVEC_BLOCK 0
#endif
