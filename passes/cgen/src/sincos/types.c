#if (defined(__GNUC__) || defined(__clang__)) && !defined(ROBOVEC_SCALAR)
/* Lanes of a register. */
#if defined(__AVX512F__)
#define ROBOVEC_@upper@ @all@
#elif defined(__AVX2__)
#define ROBOVEC_@upper@ @some@
#else
#define ROBOVEC_@upper@ @least@
#endif
typedef @real@ @vector@ __attribute__((vector_size(@bytes@)));
typedef unsigned @integer@ @bits@ __attribute__((vector_size(@bytes@)));
typedef @real@ @unaligned@ __attribute__((vector_size(@bytes@), aligned(@own@), may_alias));
/* Sums are not to be regrouped, even where the rest of the file allows it. */
#if defined(__clang__)
#define ROBOVEC_PRECISE
#define ROBOVEC_AS_WRITTEN _Pragma("clang fp reassociate(off)")
#else
#define ROBOVEC_PRECISE \
    __attribute__((optimize("no-unsafe-math-optimizations", "no-finite-math-only")))
#define ROBOVEC_AS_WRITTEN
#endif
#else
#define ROBOVEC_@upper@ 0
typedef @real@ @vector@;
typedef @real@ @unaligned@;
#endif
