/* The motion: values, their derivatives along a direction, and steps in time. */

typedef struct {
    /* Values of all variables, and their derivatives along a direction. */
    double x[2 * SLOTS];
    /* Inputs of the generated functions; those that are parameters change when
       a parameter is set. */
    double in[INPUTS + 1];
    /* Length of the next step, tolerance of a step. */
    double step, tolerance;
    /* What has to be computed again: parameters of functions, variables, frames. */
    int parameters_changed, changed, frames_changed;
    /* Sides on which the watched quantities are. */
    double watched[EVENTS + 1];
} Numbers;

typedef struct {
    Numbers n;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    char message[400];
} Instance;

static int fail(Instance *s, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(s->message, sizeof s->message, format, arguments);
    va_end(arguments);
    return 0;
}

/* Runs a generated function. */
static void call(Numbers *n, int along, int kind)
{
    const Function *f = &functions[along][kind];
    if (!f->run)
        return;
    double *in = n->in + f->place, results[MOST_RESULTS + 1];
    for (unsigned k = 0; k < f->moving; k++)
        in[k] = n->x[f->from[k]];
    f->run(in, results);
    for (unsigned k = 0; k < f->results; k++)
        n->x[f->to[k]] = results[k];
}

static void set_parameters(Numbers *n)
{
    for (int along = 0; along < 2; along++)
        for (int kind = 0; kind < KINDS + FRAMES; kind++) {
            const Function *f = &functions[along][kind];
            for (unsigned k = f->moving; k < f->inputs; k++)
                n->in[f->place + k] = n->x[f->from[k]];
        }
    n->parameters_changed = 0;
}

#if ROWS > 0
static void take_positions(double *x)
{
    for (unsigned k = 0; k < DEPENDENT; k++)
        x[AT_Q + dependent[k]] = x[AT_MOVED + dependent[k]];
}

/* Closes the loops by Newton's method, to the last digits. */
static int close_loops(Instance *s)
{
    double *x = s->n.x, before = INFINITY;
    unsigned worst = 0;
    for (int round = 0; round < 25; round++) {
        call(&s->n, 0, POSITIONS);
        double gap = 0;
        for (unsigned row = 0; row < ROWS; row++)
            if (!(fabs(x[AT_GAP_ROWS + row]) <= gap)) {
                gap = fabs(x[AT_GAP_ROWS + row]);
                worst = row;
            }
        if (gap <= 8 * DBL_EPSILON || (gap >= 0.5 * before && gap <= 1e4 * DBL_EPSILON)) {
            call(&s->n, 0, VELOCITIES);
            return 1;
        }
        if (!isfinite(gap))
            break;
        before = gap;
        take_positions(x);
    }
    return fail(s, "at %.17g s the cut '%s' does not close: its ends stay %.3g apart", x[AT_TIME], cuts[worst],
                fabs(x[AT_GAP_ROWS + worst]));
}
#endif

/* Loads on bodies: links, then external forces, by their laws. */
static void loads(Numbers *n, int along)
{
    double *x = n->x;
    memset(x + AT_BODY_LOADS + along * SLOTS, 0, 6 * JOINTS * sizeof *x);
#if LINKS > 0
    call(n, along, LENGTHS);
    link_forces(x);
    call(n, along, LINK_LOADS);
#endif
#if FORCES > 0
    call(n, along, POINTS);
    point_forces(x);
    call(n, along, POINT_LOADS);
#endif
    joint_forces(x);
}

/* Computes all variables from time, states, inputs and parameters. */
static int evaluate(Instance *s)
{
    Numbers *n = &s->n;
    if (n->parameters_changed)
        set_parameters(n);
    if (!n->changed)
        return 1;
    drive(n->x);
#if ROWS > 0
    if (!close_loops(s))
        return 0;
#endif
    loads(n, 0);
    call(n, 0, ACCELERATIONS);
    for (unsigned joint = 0; joint < JOINTS; joint++)
        if (!isfinite(n->x[AT_QDD + joint]))
            return fail(s, "at %.17g s the acceleration of the joint '%s' is not finite", n->x[AT_TIME], joints[joint]);
    n->changed = 0;
    n->frames_changed = 1;
    return 1;
}

static void sense_frames(Numbers *n, int along)
{
    for (int kind = KINDS; kind < KINDS + FRAMES; kind++)
        call(n, along, kind);
    if (!along)
        n->frames_changed = 0;
}

/* Computes the derivatives of all variables along a direction of states and
   inputs, after their values. */
static void along_direction(Numbers *n)
{
#if ROWS > 0
    call(n, 1, POSITIONS);
    take_positions(n->x + SLOTS);
    call(n, 1, VELOCITIES);
#endif
    loads(n, 1);
    call(n, 1, ACCELERATIONS);
    sense_frames(n, 1);
}

static double watch(const Numbers *n, unsigned event) { return n->x[events[event].slot] - events[event].value; }

/* Notes on which side of their values the watched quantities are; true when one
   that ends the run has passed its value since the last time. An importer that
   stops at an event may be just before it: in event mode it has passed when it is
   as near as rounding allows. */
static int watch_all(Numbers *n, int event_mode)
{
    int stops = 0;
    for (unsigned k = 0; k < EVENTS; k++) {
        const double side = watch(n, k), before = n->watched[k];
        const double near = 1e-9 * (1 + fabs(events[k].value)), reach = event_mode ? near : 0;
        const int rises = before < 0 && side > -reach, falls = before > 0 && side < reach;
        if (events[k].stops && ((rises && events[k].direction >= 0) || (falls && events[k].direction <= 0)))
            stops = 1;
        if (fabs(side) > near)
            n->watched[k] = side;
    }
    return stops;
}

/* The method of Dormand and Prince of orders 5 and 4 ("A family of embedded
   Runge-Kutta formulae", 1980, Table 2). */
static const double nodes[7] = {0, 0.2, 0.3, 0.8, 8.0 / 9, 1, 1};
static const double stages[7][6] = {
    {0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
};
static const double differences[7] = {
    71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

static void set_states(Numbers *n, double time, const double *place)
{
    n->x[AT_TIME] = time;
    for (unsigned k = 0; k < STATES; k++)
        n->x[states[k]] = place[k];
    n->changed = 1;
}

/* Tries a step from the present state; gives its error over the tolerance. */
static double attempt(Instance *s, double step)
{
    Numbers *n = &s->n;
    double start[STATES + 1], place[STATES + 1], slope[7][STATES + 1], ratio = 0;
    const double time = n->x[AT_TIME];
    for (unsigned k = 0; k < STATES; k++)
        start[k] = n->x[states[k]];
    for (int stage = 0; stage < 7; stage++) {
        for (unsigned k = 0; k < STATES; k++) {
            double sum = 0;
            for (int i = 0; i < stage; i++)
                sum += stages[stage][i] * slope[i][k];
            place[k] = start[k] + step * sum;
        }
        set_states(n, time + nodes[stage] * step, place);
        if (!evaluate(s))
            return INFINITY;
        for (unsigned k = 0; k < STATES; k++)
            slope[stage][k] = n->x[slopes[k]];
    }
    for (unsigned k = 0; k < STATES; k++) {
        double error = 0;
        for (int i = 0; i < 7; i++)
            error += differences[i] * slope[i][k];
        const double size = fmax(fabs(start[k]), fabs(place[k]));
        const double part = fabs(step * error) / (n->tolerance * (1 + size));
        ratio = part <= ratio ? ratio : isfinite(part) ? part : INFINITY;
    }
    return ratio;
}

/* Shortens a step after which an event ends the run to just after the event. */
static void shorten(Instance *s, const Numbers *start, double step)
{
    double from = 0, to = step;
    while (to - from > 1e-9) {
        const double middle = 0.5 * (from + to);
        Numbers *n = &s->n;
        *n = *start;
        attempt(s, middle);
        if (watch_all(n, 0))
            to = middle;
        else
            from = middle;
    }
    s->n = *start;
    attempt(s, to);
    watch_all(&s->n, 0);
}

/* Integrates up to a time; 1 when it is reached, 2 when an event ends the run, 0
   when it fails. */
static int integrate(Instance *s, double until)
{
    Numbers *n = &s->n, *start = malloc(sizeof *start);
    if (!start)
        return fail(s, "there is no memory left");
    int result = evaluate(s);
    const double span = until - n->x[AT_TIME];
    while (result == 1 && n->x[AT_TIME] < until) {
        const double time = n->x[AT_TIME], rest = until - time;
        const int last = n->step >= rest;
        const double step = last ? rest : n->step;
        *start = *n;
        const double ratio = attempt(s, step);
        const double factor = isfinite(ratio) ? fmin(fmax(0.9 * pow(fmax(ratio, 1e-10), -0.2), 0.2), 5) : 0.25;
        if (ratio <= 1) {
            if (last)
                n->x[AT_TIME] = until;
            if (watch_all(n, 0)) {
                shorten(s, start, step);
                result = 2;
            }
        } else {
            *n = *start;
        }
        if (!last || ratio > 1)
            n->step = step * factor;
        if (n->step < 1e-14 * fmax(span, fabs(until)))
            result = isfinite(ratio) ? fail(s, "at %.17g s steps become too short", time) : 0;
    }
    free(start);
    return result;
}
