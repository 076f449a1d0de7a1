{
    @bits@ far = {0};
    @vector@ sine, cosine;
    long i = 0;
    for (; i + @lanes@ <= count; i += @lanes@) {
        const @vector@ angle = *(const @unaligned@ *)(angles + i);
        robovec_circular_@suffix@(&angle, &sine, &cosine, &far);
        *(@unaligned@ *)(sines + i) = sine;
        *(@unaligned@ *)(cosines + i) = cosine;
    }
    if (i < count && count > @lanes@) {
        /* The last ones once more, together with the rest. */
        i = count - @lanes@;
        const @vector@ angle = *(const @unaligned@ *)(angles + i);
        robovec_circular_@suffix@(&angle, &sine, &cosine, &far);
        *(@unaligned@ *)(sines + i) = sine;
        *(@unaligned@ *)(cosines + i) = cosine;
    } else if (i < count) {
        @vector@ angle = {0};
        for (int lane = 0; lane < count - i; lane++)
            angle[lane] = angles[i + lane];
        robovec_circular_@suffix@(&angle, &sine, &cosine, &far);
        for (int lane = 0; lane < count - i; lane++) {
            sines[i + lane] = sine[lane];
            cosines[i + lane] = cosine[lane];
        }
    }
    unsigned @integer@ any = 0;
    for (int lane = 0; lane < @lanes@; lane++)
        any |= far[lane];
    if (any >> @sign@)
        robovec_far_@suffix@(count, angles, sines, cosines);
}
