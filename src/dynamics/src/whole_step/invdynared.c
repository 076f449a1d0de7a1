/* What MBsysC calls for the forces of actuators. */
int @PREFIX@invdynared(@DATA@ *s, double tsim)
{
    UserRows user = {{0}, {0}, {{0}}, {NULL}};
    const int rounds = robovec_prepare(s, tsim, &user);
    if (rounds < 0)
        return -1;
    @PREFIX@actuator_forces(user.J, user.jdqd, s, tsim);
    return rounds;
}
