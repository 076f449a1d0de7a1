/* @PREFIX@@NAME@ by robovec: @TITLE@ of the model @STEM@.
   It takes the place of Robotran's function of the same name. It returns the
   rounds that closing the loops took, or -1 where they do not close, where
   forces determine no motion, or where the project is another than the one
   this was made for. */
#include <math.h>
#include <stdio.h>

#include "@HEADER@"
#include "@FUNCTIONS@"

@GENERATED@
/* What this was made for: joints, rows of constraints of loops and of the user,
   multipliers wanted or not. */
#define JOINTS @JOINTS@
#define LOOP_ROWS @LOOP_ROWS@
#define USER_ROWS @USER_ROWS@
#define MULTIPLIERS @MULTIPLIERS@

/* Joints that get their accelerations from constraints of the user alone. */
#define MASSLESS @MASSLESS@

/* Rounds of Newton's method before closing is given up, as in MBsysC. */
#define MAX_ROUNDS 100

/* Constraints of the user. All arrays count from 1. */
typedef struct UserRows
{
    double h[USER_ROWS + 1], jdqd[USER_ROWS + 1];
    double entries[USER_ROWS + 1][JOINTS + 1];
    double *J[USER_ROWS + 1];
} UserRows;

/* Roles of joints: independent (u), dependent (v), driven (c). */
static const char robovec_roles[JOINTS + 1] = "@ROLES@";
static const char *const robovec_joints[] = {@NAMES@};

static const char *robovec_role(char role)
{
    return role == 'c' ? "driven" : role == 'u' ? "independent" : "dependent";
}

/* Whether the project has the coordinates that the equations were made for. */
static int robovec_same_project(const @DATA@ *s)
{
    char roles[JOINTS + 1];
    if (s->njoint != JOINTS || s->Nuserc != USER_ROWS) {
        fprintf(stderr, "@PREFIX@@NAME@: made for %d joints and %d constraint(s) of the user, and the "
                "project has %d and %d\n", JOINTS, USER_ROWS, s->njoint, s->Nuserc);
        return 0;
    }
    for (int joint = 0; joint < JOINTS; joint++)
        roles[joint] = 'v';
    for (int i = 1; i <= s->nqu; i++)
        roles[s->qu[i] - 1] = 'u';
    for (int i = 1; i <= s->nqc; i++)
        roles[s->qc[i] - 1] = 'c';
    for (int joint = 0; joint < JOINTS; joint++)
        if (roles[joint] != robovec_roles[joint]) {
            fprintf(stderr, "@PREFIX@@NAME@: the joint '%s' (%d) is %s in the project and %s in this file: "
                    "set its nature in the model, or use --driven\n", robovec_joints[joint], joint + 1,
                    robovec_role(roles[joint]), robovec_role(robovec_roles[joint]));
            return 0;
        }
    return 1;
}

/* Values and Jacobian of the user's constraints. */
static void robovec_user_rows(UserRows *user, @DATA@ *s, double tsim)
{
#if USER_ROWS > 0
    for (int row = 1; row <= USER_ROWS; row++) {
        user->J[row] = user->entries[row];
        for (int joint = 1; joint <= JOINTS; joint++)
            user->entries[row][joint] = 0;
    }
    user_cons_hJ(user->h, user->J, s, tsim);
#else
    (void)user, (void)s, (void)tsim;
#endif
}

#if LOOP_ROWS + USER_ROWS > 0
/* The largest of some numbers; what is no number is larger than all. */
static double robovec_largest(double largest, const double *numbers, int count)
{
    for (int i = 1; i <= count; i++) {
        const double size = fabs(numbers[i]);
        if (!(size <= largest))
            largest = size <= 1e300 ? size : INFINITY;
    }
    return largest;
}

/* Reports the constraint that stays open most. */
static int robovec_open(double tsim, const double *h, const double *user)
{
    static const char *const cuts[] = {@CUTS@};
    int worst = 1;
    for (int row = 1; row <= LOOP_ROWS + USER_ROWS; row++) {
        const double gap = row <= LOOP_ROWS ? h[row] : user[row - LOOP_ROWS];
        const double most = worst <= LOOP_ROWS ? h[worst] : user[worst - LOOP_ROWS];
        if (!(fabs(gap) <= fabs(most)))
            worst = row;
    }
    if (worst <= LOOP_ROWS)
        fprintf(stderr, "@PREFIX@@NAME@: at %g s the cut '%s' stays open by %g\n", tsim, cuts[worst - 1], h[worst]);
    else
        fprintf(stderr, "@PREFIX@@NAME@: at %g s the constraint %d of the user stays open by %g\n", tsim,
                worst - LOOP_ROWS, user[worst - LOOP_ROWS]);
    return -1;
}

/* Closes the loops; gives the rounds it took, or -1. */
static int robovec_close(@DATA@ *s, double tsim, UserRows *user)
{
    double h[LOOP_ROWS + 1] = {0};
    for (int round = 0; round <= MAX_ROUNDS; round++) {
        robovec_user_rows(user, s, tsim);
        @PREFIX@loop_positions(h, user->h, user->J, s, tsim);
        const double loops = robovec_largest(0, h, LOOP_ROWS);
        const double largest = robovec_largest(loops, user->h, USER_ROWS);
        if (!isfinite(largest))
            break;
        if (largest <= s->NRerr) {
            /* The positions have moved a last time. */
            robovec_user_rows(user, s, tsim);
            @PREFIX@loop_velocities(user->J, s, tsim);
            return round;
        }
    }
    return robovec_open(tsim, h, user->h);
}
#endif

/* Forces on bodies and joints. */
static void robovec_forces(@DATA@ *s, double tsim)
{
    for (int axis = 1; axis <= 3; axis++)
        for (int joint = 1; joint <= JOINTS; joint++)
            s->frc[axis][joint] = s->trq[axis][joint] = 0;
@LOADS@    s->Qq = user_JointForces(s, tsim);
}

/* Driven joints, closed loops, forces; gives the rounds of closing, or -1. */
static int robovec_prepare(@DATA@ *s, double tsim, UserRows *user)
{
    int rounds = 0;
    if (!robovec_same_project(s))
        return -1;
@DRIVEN@#if LOOP_ROWS + USER_ROWS > 0
    rounds = robovec_close(s, tsim, user);
    if (rounds < 0)
        return -1;
#else
    robovec_user_rows(user, s, tsim);
#endif
#if USER_ROWS > 0
    user_cons_jdqd(user->jdqd, s, tsim);
#endif
    robovec_forces(s, tsim);
    return rounds;
}

