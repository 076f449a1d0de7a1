/* Forces of the laws. A number has its derivative along a direction, so that one
   formula gives a force and its slope; where none is wanted, slopes are zero. */

/* Parameters of laws, in the order of laws.rs. */
enum { LAW_STIFFNESS, LAW_DAMPING, LAW_NEUTRAL, LAW_FORCE, LAW_FRICTION, LAW_SLIP };
enum {
    FORCE_FORCE = 0, FORCE_TORQUE = 3, FORCE_STIFFNESS = 6, FORCE_DAMPING = 9, FORCE_PLACE = 12,
    FORCE_AMPLITUDE = 15, FORCE_FREQUENCY = 18, FORCE_PHASE
};
enum { GROUND_PLACE = 0, GROUND_NORMAL = 3, GROUND_STIFFNESS = 6, GROUND_DAMPING, GROUND_FRICTION, GROUND_SLIP };
enum { TYRE_RADIUS, TYRE_AXIS, TYRE_SLIP = 4, TYRE_KIND, TYRE_LAW };
enum { CURVE_B, CURVE_C, CURVE_D, CURVE_E, CURVE_LENGTH };
enum { DRIVE_OFFSET, DRIVE_AMPLITUDE, DRIVE_FREQUENCY, DRIVE_PHASE };

typedef struct {
    double v, d;
} Dual;

static Dual at(const double *x, unsigned slot) { return (Dual){x[slot], x[slot + SLOTS]}; }

static void put(double *x, unsigned slot, Dual number)
{
    x[slot] = number.v;
    x[slot + SLOTS] = number.d;
}

static Dual fixed(double value) { return (Dual){value, 0}; }
static Dual add(Dual a, Dual b) { return (Dual){a.v + b.v, a.d + b.d}; }
static Dual sub(Dual a, Dual b) { return (Dual){a.v - b.v, a.d - b.d}; }
static Dual mul(Dual a, Dual b) { return (Dual){a.v * b.v, a.d * b.v + a.v * b.d}; }
static Dual scale(double factor, Dual a) { return (Dual){factor * a.v, factor * a.d}; }

static Dual quotient(Dual a, Dual b)
{
    const double value = a.v / b.v;
    return (Dual){value, (a.d - value * b.d) / b.v};
}

static Dual length2(Dual a, Dual b)
{
    const double value = hypot(a.v, b.v);
    return (Dual){value, a.v / value * a.d + b.v / value * b.d};
}

/* A spring, a damper and dry friction, against displacement and velocity. */
static Dual resistance(const double *x, unsigned law, Dual place, Dual rate)
{
    const double slip = x[law + LAW_SLIP];
    const Dual way = sub(place, fixed(x[law + LAW_NEUTRAL]));
    const Dual share = quotient(rate, length2(rate, fixed(slip)));
    Dual sum = scale(x[law + LAW_STIFFNESS], way);
    sum = add(sum, scale(x[law + LAW_DAMPING], rate));
    return add(sum, scale(x[law + LAW_FRICTION], share));
}

static void joint_forces(double *x)
{
    for (unsigned joint = 0; joint < JOINTS; joint++) {
        Dual sum = at(x, AT_INPUT_FORCES + joint);
        const unsigned law = joint_laws[joint];
        if (law) {
            const Dual against = resistance(x, law, at(x, AT_Q + joint), at(x, AT_QD + joint));
            sum = add(sum, sub(fixed(x[law + LAW_FORCE]), against));
        }
        put(x, AT_JOINT_FORCES + joint, sum);
    }
}

#if LINKS > 0
/* A law pulls the ends of a link together. A length along one axis has its sign. */
static void link_forces(double *x)
{
    for (unsigned link = 0; link < LINKS; link++) {
        Dual pull = at(x, AT_INPUT_PULLS + link);
        const unsigned law = link_laws[link];
        const double sign = link_signs[link];
        if (law) {
            const Dual length = scale(sign, at(x, AT_LENGTHS + link));
            const Dual rate = scale(sign, at(x, AT_RATES + link));
            pull = add(pull, add(fixed(x[law + LAW_FORCE]), resistance(x, law, length, rate)));
        }
        put(x, AT_PULLS + link, scale(sign, pull));
    }
}
#endif

#if FORCES > 0
typedef struct {
    Dual k[3];
} Vector;

static Vector vector_at(const double *x, unsigned slot)
{
    return (Vector){{at(x, slot), at(x, slot + 1), at(x, slot + 2)}};
}

static Dual inner(Vector a, Vector b)
{
    return add(add(mul(a.k[0], b.k[0]), mul(a.k[1], b.k[1])), mul(a.k[2], b.k[2]));
}

static Vector outer(Vector a, Vector b)
{
    Vector c;
    for (int k = 0; k < 3; k++) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        c.k[k] = sub(mul(a.k[next], b.k[last]), mul(a.k[last], b.k[next]));
    }
    return c;
}

static Vector plus(Vector a, Vector b, Dual factor)
{
    for (int k = 0; k < 3; k++)
        a.k[k] = add(a.k[k], mul(b.k[k], factor));
    return a;
}

/* The vector of length one in the direction of a parameter. */
static Vector direction(const double *x, unsigned slot)
{
    const double length = hypot(hypot(x[slot], x[slot + 1]), x[slot + 2]);
    return (Vector){{fixed(x[slot] / length), fixed(x[slot + 1] / length), fixed(x[slot + 2] / length)}};
}

/* Where the ground touches: the point itself, or the lowest point of a wheel. */
typedef struct {
    Vector normal, arm, velocity, axis, heading, spin;
    Dual gap, rate;
    int upright;
} Footprint;

static Footprint footprint(const double *x, unsigned force, unsigned law)
{
    Footprint print = {.normal = direction(x, law + GROUND_NORMAL)};
    Vector place = vector_at(x, AT_PLACES + 3 * force);
    print.velocity = vector_at(x, AT_VELOCITIES + 3 * force);
    print.spin = vector_at(x, AT_SPINS + 3 * force);
    if (tyre_laws[force]) {
        const Vector along = direction(x, tyre_laws[force] + TYRE_AXIS);
        for (unsigned k = 0; k < 3; k++)
            print.axis = plus(print.axis, vector_at(x, AT_AXES + 9 * force + 3 * k), along.k[k]);
        const Vector forward = outer(print.axis, print.normal);
        const Dual square = inner(forward, forward);
        print.upright = square.v > 1e-12;
        if (print.upright) {
            const double root = sqrt(square.v);
            const Dual sine = {root, square.d / (2 * root)};
            const Dual reach = quotient(fixed(-x[tyre_laws[force] + TYRE_RADIUS]), sine);
            const Vector down = plus(print.normal, print.axis, scale(-1, inner(print.normal, print.axis)));
            print.arm = plus(print.arm, down, reach);
            print.heading = plus(print.heading, forward, quotient(fixed(1), sine));
        }
        print.velocity = plus(print.velocity, outer(print.spin, print.arm), fixed(1));
        place = plus(place, print.arm, fixed(1));
    }
    for (unsigned k = 0; k < 3; k++)
        place.k[k] = sub(place.k[k], fixed(x[law + GROUND_PLACE + k]));
    print.gap = inner(print.normal, place);
    print.rate = inner(print.normal, print.velocity);
    return print;
}

static Dual arctangent(Dual a) { return (Dual){atan(a.v), a.d / (1 + a.v * a.v)}; }

/* The magic formula at a slip that is normalised by its slope. */
static Dual magic(const double *x, unsigned curve, Dual slip)
{
    const double shape = x[curve + CURVE_C];
    if (x[curve + CURVE_B] == 0 || shape == 0)
        return fixed(0);
    const Dual k = scale(1 / shape, slip);
    const Dual bent = sub(k, scale(x[curve + CURVE_E], sub(k, arctangent(k))));
    const Dual angle = scale(shape, arctangent(bent));
    return scale(x[curve + CURVE_D], (Dual){sin(angle.v), cos(angle.v) * angle.d});
}

/* Forces along and across a wheel at its slips. */
static void tyre_forces(const double *x, unsigned law, const Dual slips[2], Dual pressure, Dual forces[2])
{
    const unsigned curves[2] = {law + TYRE_LAW, law + TYRE_LAW + CURVE_LENGTH};
    if (x[law + TYRE_KIND] == 0) {
        const Dual most = scale(x[law + TYRE_LAW], pressure);
        for (int k = 0; k < 2; k++)
            forces[k] = scale(x[law + TYRE_LAW + 1 + k], slips[k]);
        if (hypot(forces[0].v, forces[1].v) > most.v) {
            const Dual share = quotient(most, length2(forces[0], forces[1]));
            for (int k = 0; k < 2; k++)
                forces[k] = mul(forces[k], share);
        }
        return;
    }
    Dual normalised[2];
    for (int k = 0; k < 2; k++)
        normalised[k] = scale(x[curves[k] + CURVE_B] * x[curves[k] + CURVE_C], slips[k]);
    const int rests = normalised[0].v == 0 && normalised[1].v == 0;
    const Dual size = rests ? fixed(1) : length2(normalised[0], normalised[1]);
    for (int k = 0; k < 2; k++) {
        const Dual share = rests ? fixed(x[curves[k] + CURVE_D]) : magic(x, curves[k], size);
        forces[k] = mul(mul(pressure, share), quotient(normalised[k], size));
    }
}

/* Force of the ground on a point or wheel, and its torque about the point. */
static void ground(const double *x, unsigned force, Vector *push, Vector *turn)
{
    const unsigned law = ground_laws[force], tyre = tyre_laws[force];
    const Footprint print = footprint(x, force, law);
    if (print.gap.v >= 0)
        return;
    const Dual pressure = scale(-1, add(scale(x[law + GROUND_STIFFNESS], print.gap),
                                        scale(x[law + GROUND_DAMPING], print.rate)));
    if (!(pressure.v > 0))
        return;
    Vector sum = plus((Vector){{{0, 0}}}, print.normal, pressure);
    if (tyre && print.upright) {
        const Vector across = outer(print.normal, print.heading);
        const Dual slipping[2] = {inner(print.heading, print.velocity), inner(across, print.velocity)};
        Dual rolling = add(slipping[0], scale(x[tyre + TYRE_RADIUS], inner(print.axis, print.spin)));
        rolling = length2(rolling, fixed(x[tyre + TYRE_SLIP]));
        const Dual slips[2] = {scale(-1, quotient(slipping[0], rolling)), scale(-1, quotient(slipping[1], rolling))};
        Dual forces[2];
        tyre_forces(x, tyre, slips, pressure, forces);
        sum = plus(plus(sum, print.heading, forces[0]), across, forces[1]);
    } else if (!tyre) {
        const Vector slip = plus(print.velocity, print.normal, scale(-1, print.rate));
        const double around = x[law + GROUND_SLIP];
        const Dual square = add(inner(slip, slip), fixed(around * around));
        const double speed = sqrt(square.v);
        const Dual share = quotient(scale(x[law + GROUND_FRICTION], pressure), (Dual){speed, square.d / (2 * speed)});
        sum = plus(sum, slip, scale(-1, share));
    }
    *push = plus(*push, sum, fixed(1));
    *turn = plus(*turn, outer(print.arm, sum), fixed(1));
}

static void point_forces(double *x)
{
    for (unsigned force = 0; force < FORCES; force++) {
        Vector push = vector_at(x, AT_INPUT_LOADS + 6 * force), turn = vector_at(x, AT_INPUT_LOADS + 6 * force + 3);
        const unsigned law = force_laws[force];
        if (law) {
            const double angle = x[law + FORCE_FREQUENCY] * x[AT_TIME] + x[law + FORCE_PHASE];
            for (unsigned k = 0; k < 3; k++) {
                const double moved = x[law + FORCE_AMPLITUDE + k];
                const double held = x[law + FORCE_PLACE + k] + moved * sin(angle);
                const double rate = moved * x[law + FORCE_FREQUENCY] * cos(angle);
                const Dual spring = sub(at(x, AT_PLACES + 3 * force + k), fixed(held));
                const Dual damper = sub(at(x, AT_VELOCITIES + 3 * force + k), fixed(rate));
                Dual sum = scale(x[law + FORCE_STIFFNESS + k], spring);
                sum = add(sum, scale(x[law + FORCE_DAMPING + k], damper));
                push.k[k] = add(push.k[k], sub(fixed(x[law + FORCE_FORCE + k]), sum));
                turn.k[k] = add(turn.k[k], fixed(x[law + FORCE_TORQUE + k]));
            }
        }
        if (ground_laws[force]) {
            put(x, AT_GAPS + force, footprint(x, force, ground_laws[force]).gap);
            ground(x, force, &push, &turn);
        }
        for (unsigned k = 0; k < 3; k++) {
            put(x, AT_LOADS + 6 * force + k, push.k[k]);
            put(x, AT_LOADS + 6 * force + 3 + k, turn.k[k]);
        }
    }
}
#endif

/* Driven joints with a law. */
static void drive(double *x)
{
    for (unsigned joint = 0; joint < JOINTS; joint++) {
        const unsigned law = drive_laws[joint];
        if (law) {
            const double w = x[law + DRIVE_FREQUENCY], angle = w * x[AT_TIME] + x[law + DRIVE_PHASE];
            const double size = x[law + DRIVE_AMPLITUDE];
            x[AT_Q + joint] = x[law + DRIVE_OFFSET] + size * sin(angle);
            x[AT_QD + joint] = size * w * cos(angle);
            x[AT_QDD + joint] = -size * w * w * sin(angle);
        }
    }
}
