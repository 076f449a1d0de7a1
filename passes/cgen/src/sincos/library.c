{
    for (long i = 0; i < count; i++) {
        sines[i] = @sine@;
        cosines[i] = @cosine@;
    }
}
