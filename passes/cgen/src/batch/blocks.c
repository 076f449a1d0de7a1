#if ROBOVEC_BLOCK
    if (count == @lanes@ && step == 1) {
        for (long span = 0; span < number; span++) {
            const long end = spans[span][0] + spans[span][1];
            long i = spans[span][0];
            for (; i + ROBOVEC_BLOCK <= end; i += ROBOVEC_BLOCK)
                for (long lane = 0; lane < @lanes@; lane += ROBOVEC_BLOCK)
                    @name@_turn(from + @from@, @next@, to + @to@, @step@);
            for (; i < end; i++)
                for (long lane = 0; lane < @lanes@; lane++)
                    to[@to@] = from[@from@];
        }
        return;
    }
#endif
