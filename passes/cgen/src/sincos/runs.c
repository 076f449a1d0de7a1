{
    @bits@ far = {0};
    for (long i = 0; i < count; i++) {
        const @vector@ angle = *(const @unaligned@ *)(angles + places[i] * stride);
        robovec_circular_@suffix@(&angle, sines + i, cosines + i, &far);
    }
    unsigned @integer@ any = 0;
    for (int lane = 0; lane < @lanes@; lane++)
        any |= far[lane];
    if (any >> @sign@)
        for (long i = 0; i < count; i++)
            robovec_far_@suffix@(@lanes@, angles + places[i] * stride,
                (@real@ *)(sines + i), (@real@ *)(cosines + i));
}
