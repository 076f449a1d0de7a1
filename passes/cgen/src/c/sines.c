/* Sines and cosines of @exact@ angle(s), within 1.1 units in the last place. */
#undef ROBOVEC_ANGLES
#if defined(__AVX2__) || defined(ROBOVEC_CLONED)
#define ROBOVEC_ANGLES @count@
#else
#define ROBOVEC_ANGLES @exact@
#endif
#if defined(__FAST_MATH__) || (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0)
static void @name@(@real@ *restrict work)
{
    for (int i = 0; i < ROBOVEC_ANGLES; i++) {
        const double angle = work[2 * @count@ + i];
        work[i] = (@real@)sin(angle);
        work[@count@ + i] = (@real@)cos(angle);
    }
}
#else
ROBOVEC_CLONES ROBOVEC_APART static void @name@(@real@ *restrict work)
{
    int large = 0;
    for (int i = 0; i < ROBOVEC_ANGLES; i++) {
        const double angle = work[2 * @count@ + i];
        const double shifted = angle * 0.6366197723675814 + 6755399441055744.0;
        const double turns = shifted - 6755399441055744.0;
        uint64_t bits, sine, cosine;
        /* Quarter turns taken away: the rest is rest + tail. */
        const double first = angle - turns * 1.5707963267341256;
        const double second = turns * 6.077100506303966e-11;
        const double third = first - second;
        const double more = turns * 2.0222662487959506e-21 - ((first - third) - second);
        const double rest = third - more;
        const double tail = (third - rest) - more;
        const double square = rest * rest;
        const double half = 0.5 * square;
        const double one = 1.0 - half;
        const double odd = square * (-0.16666666666666632 + square * (0.008333333333322422 + square * (-0.00019841269829815465
            + square * (2.755731369472794e-06 + square * (-2.5050758576480244e-08 + square * 1.589682350501512e-10)))));
        const double even = square * square * (0.0416666666666666 + square * (-0.0013888888888874138 + square * (2.4801587289490797e-05
            + square * (-2.755731435493541e-07 + square * (2.0875723641529234e-09 + square * -1.1359667580936628e-11)))));
        const double s = rest + (rest * odd + tail * one);
        const double c = one + (((1.0 - one) - half) + (even - rest * tail));
        memcpy(&bits, &shifted, sizeof bits);
        memcpy(&sine, &s, sizeof sine);
        memcpy(&cosine, &c, sizeof cosine);
        const uint64_t swap = (sine ^ cosine) & (0 - (bits & 1));
        const uint64_t up = (sine ^ swap) ^ ((bits & 2) << 62);
        const uint64_t across = (cosine ^ swap) ^ (((bits + 1) & 2) << 62);
        double up_number, across_number;
        memcpy(&up_number, &up, sizeof up);
        memcpy(&across_number, &across, sizeof across);
        work[i] = (@real@)up_number;
        work[@count@ + i] = (@real@)across_number;
        large |= !(fabs(angle) < 524288.0);
    }
    if (large) {
        for (int i = 0; i < ROBOVEC_ANGLES; i++) {
            const double angle = work[2 * @count@ + i];
            if (!(fabs(angle) < 524288.0)) {
                work[i] = (@real@)sin(angle);
                work[@count@ + i] = (@real@)cos(angle);
            }
        }
    }
}
#endif
