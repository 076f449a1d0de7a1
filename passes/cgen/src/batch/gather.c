/* Some elements of the first states, `step` numbers from element to element and
   `next` from state to state, into runs; missing lanes repeat the last state. */
static void @name@_gather(long count, const @real@ *from, long step, long next,
    const int (*spans)[2], long number, @real@ *to)
{
@blocks@    for (long lane = 0; lane < @lanes@; lane++) {
        const @real@ *own = from + (lane < count ? lane : count - 1) * next;
        for (long span = 0; span < number; span++)
            for (long i = spans[span][0]; i < spans[span][0] + spans[span][1]; i++)
                to[i * @lanes@ + lane] = own[i * step];
    }
}
