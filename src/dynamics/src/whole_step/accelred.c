/* Whether constraints of the user determine what they are to determine; Growth is
   the factor by which solving for each of them enlarges rounding. */
static int robovec_determined(const double *Growth, double tsim)
{
    static const int massless[] = {@MASSLESS_JOINTS@};
    for (int row = 1; row <= USER_ROWS + MASSLESS; row++) {
        if (fabs(Growth[row]) <= @MOST_GROWTH@)
            continue;
        if (row <= USER_ROWS)
            fprintf(stderr, "@PREFIX@accelred: at %g s the constraint %d of the user repeats others, "
                    "or moves no mass\n", tsim, row);
        else
            fprintf(stderr, "@PREFIX@accelred: at %g s neither mass nor constraint determines the acceleration "
                    "of the joint '%s'\n", tsim, robovec_joints[massless[row - USER_ROWS - 1] - 1]);
        return 0;
    }
    return 1;
}

/* What MBsysC calls for the accelerations of all joints. */
int @PREFIX@accelred(@FILLED@@DATA@ *s, double tsim)
{
    UserRows user = {{0}, {0}, {{0}}, {NULL}};
    const int rounds = robovec_prepare(s, tsim, &user);
    if (rounds < 0)
        return -1;
    double Growth[USER_ROWS + MASSLESS + 1] = {0};
#if MULTIPLIERS
    double Lambda[LOOP_ROWS + USER_ROWS + 1] = {0};
    @PREFIX@accelerations(Lambda, Growth, user.J, user.jdqd, s, tsim);
    for (int i = 1; i <= s->nhu; i++)
        s->lambda[i] = Lambda[s->hu[i]];
#else
    @PREFIX@accelerations(NULL, Growth, user.J, user.jdqd, s, tsim);
#endif
    if (!robovec_determined(Growth, tsim))
        return -1;
    for (int joint = 1; joint <= JOINTS; joint++)
        if (!isfinite(s->qdd[joint])) {
            fprintf(stderr, "@PREFIX@accelred: at %g s the acceleration of the joint '%s' is no number: "
                    "a joint moves no mass, or a force is none\n", tsim, robovec_joints[joint - 1]);
            return -1;
        }
@QDDU@    return rounds;
}
