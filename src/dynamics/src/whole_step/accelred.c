/* What MBsysC calls for the accelerations of all joints. */
int @PREFIX@accelred(@FILLED@@DATA@ *s, double tsim)
{
    UserRows user = {{0}, {0}, {{0}}, {NULL}};
    const int rounds = robovec_prepare(s, tsim, &user);
    if (rounds < 0)
        return -1;
#if MULTIPLIERS
    double Lambda[LOOP_ROWS + USER_ROWS + 1] = {0};
    @PREFIX@accelerations(Lambda, user.J, user.jdqd, s, tsim);
    for (int i = 1; i <= s->nhu; i++)
        s->lambda[i] = Lambda[s->hu[i]];
#else
    @PREFIX@accelerations(NULL, user.J, user.jdqd, s, tsim);
#endif
    for (int joint = 1; joint <= JOINTS; joint++)
        if (!isfinite(s->qdd[joint])) {
            fprintf(stderr, "@PREFIX@accelred: masses and constraints determine no acceleration at %g s: "
                    "a constraint says what others say, or a joint moves no mass\n", tsim);
            return -1;
        }
@QDDU@    return rounds;
}
