/* Runs into some elements of the first states, without the missing lanes. */
static void @name@_scatter(long count, @real@ *to, long step, long next,
    const int (*spans)[2], long number, const @real@ *from)
{
@blocks@    for (long lane = 0; lane < count; lane++) {
        @real@ *own = to + lane * next;
        for (long span = 0; span < number; span++)
            for (long i = spans[span][0]; i < spans[span][0] + spans[span][1]; i++)
                own[i * step] = from[i * @lanes@ + lane];
    }
}
