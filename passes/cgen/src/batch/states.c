    const long batches = (states + @lanes@ - 1) / @lanes@;
    int failed = 0;
#ifdef _OPENMP
#pragma omp parallel reduction(| : failed)
#endif
    {
        /* Room to begin at a multiple of 64 bytes. */
        char *memory = malloc(@size@ * sizeof(@real@) + 64);
        failed |= !memory;
#ifdef _OPENMP
#pragma omp for
#endif
        for (long batch = 0; batch < batches; batch++) {
            const long first = batch * @lanes@;
            const long count = states - first < @lanes@ ? states - first : @lanes@;
            if (memory)
                @name@_copied(count, 0, (@real@ *)(memory + (64 - (size_t)memory % 64)), @scattered@);
        }
        free(memory);
    }
    return failed ? -1 : 0;
}
