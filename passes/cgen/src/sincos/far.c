/* The library's, for angles beyond the range. */
static void __attribute__((noinline, cold)) robovec_far_@suffix@(long count, const @real@ *angles,
    @real@ *sines, @real@ *cosines)
{
    for (long i = 0; i < count; i++)
        if (!(@absolute@(angles[i]) <= @limit_number@)) {
            sines[i] = @sine@;
            cosines[i] = @cosine@;
        }
}
