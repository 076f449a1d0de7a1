/* The functions of FMI 3.0. */

static fmi3Status report(Instance *s, fmi3Status status)
{
    if (s->log)
        s->log(s->environment, status, status == fmi3Discard ? "logStatusDiscard" : "logStatusError", s->message);
    return status;
}

static fmi3Status refuse(fmi3Instance instance, const char *reason)
{
    Instance *s = instance;
    fail(s, "%s", reason);
    return report(s, fmi3Error);
}

static fmi3Status evaluated(Instance *s) { return evaluate(s) ? fmi3OK : report(s, fmi3Discard); }

static void start(Numbers *n)
{
    memset(n, 0, sizeof *n);
    for (unsigned k = 0; k < sizeof starts / sizeof *starts; k++)
        n->x[start_slots[k]] = starts[k];
    n->step = 1e-3;
    n->tolerance = 1e-8;
    n->parameters_changed = n->changed = 1;
}

static fmi3Instance instantiate(fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    Instance *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->environment = environment;
    s->log = log;
    if (!token || strcmp(token, TOKEN)) {
        fail(s, "the token of the model description is not that of this binary");
        report(s, fmi3Error);
        free(s);
        return NULL;
    }
    start(&s->n);
    return s;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance instance, bool on, size_t count, const fmi3String categories[])
{
    return fmi3OK;
}

EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, bool visible,
                                                 bool logging, fmi3InstanceEnvironment environment,
                                                 fmi3LogMessageCallback log)
{
    return instantiate(token, environment, log);
}

EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, bool visible,
                                                bool logging, bool events_used, bool early_return,
                                                const fmi3ValueReference required[], size_t count,
                                                fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                fmi3IntermediateUpdateCallback update)
{
    return instantiate(token, environment, log);
}

EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                      bool visible, bool logging, fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                                      fmi3PreemptionCallback lock, fmi3PreemptionCallback unlock)
{
    return NULL;
}

EXPORT void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance, double tolerance, double time,
                                              bool has_stop, double stop)
{
    Instance *s = instance;
    s->n.x[AT_TIME] = time;
    if (has_tolerance && tolerance > 0)
        s->n.tolerance = tolerance;
    s->n.changed = 1;
    return fmi3OK;
}

EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    Instance *s = instance;
    const fmi3Status status = evaluated(s);
    watch_all(&s->n, 0);
    return status;
}

EXPORT fmi3Status fmi3Reset(fmi3Instance instance)
{
    start(&((Instance *)instance)->n);
    return fmi3OK;
}

/* Modes in which nothing changes. */
#define MODE(name) \
    EXPORT fmi3Status name(fmi3Instance instance) { return fmi3OK; }
MODE(fmi3EnterEventMode)
MODE(fmi3EnterContinuousTimeMode)
MODE(fmi3EnterStepMode)
MODE(fmi3EnterConfigurationMode)
MODE(fmi3ExitConfigurationMode)
MODE(fmi3EvaluateDiscreteStates)
MODE(fmi3Terminate)

EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference variables[], size_t count,
                                 double values[], size_t values_count)
{
    Instance *s = instance;
    if (count != values_count)
        return refuse(s, "every variable has one value");
    for (size_t k = 0; k < count; k++) {
        if (variables[k] >= SLOTS || kinds[variables[k]] == '-')
            return refuse(s, "there is no variable of this value reference");
        /* What is set is known without an evaluation. */
        const fmi3Status status = strchr("ipt", kinds[variables[k]]) ? fmi3OK : evaluated(s);
        if (status != fmi3OK)
            return status;
        if (kinds[variables[k]] == 'f' && s->n.frames_changed)
            sense_frames(&s->n, 0);
        values[k] = s->n.x[variables[k]];
    }
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference variables[], size_t count,
                                 const double values[], size_t values_count)
{
    Instance *s = instance;
    if (count != values_count)
        return refuse(s, "every variable has one value");
    for (size_t k = 0; k < count; k++) {
        if (variables[k] >= SLOTS || !strchr("ipsg", kinds[variables[k]]))
            return refuse(s, "only inputs, parameters and states are set");
        if (!isfinite(values[k]))
            return refuse(s, "a value is not finite");
        if (s->n.x[variables[k]] != values[k])
            s->n.changed = 1;
        s->n.x[variables[k]] = values[k];
        if (kinds[variables[k]] == 'p')
            s->n.parameters_changed = 1;
    }
    return fmi3OK;
}

/* Variables of other types: there are none. */
#define NO_VARIABLES(type, c_type)                                                                               \
    EXPORT fmi3Status fmi3Get##type(fmi3Instance instance, const fmi3ValueReference variables[], size_t count,   \
                                    c_type values[], size_t values_count)                                        \
    {                                                                                                            \
        return count ? refuse(instance, "there is no variable of the type " #type) : fmi3OK;                     \
    }                                                                                                            \
    EXPORT fmi3Status fmi3Set##type(fmi3Instance instance, const fmi3ValueReference variables[], size_t count,   \
                                    const c_type values[], size_t values_count)                                  \
    {                                                                                                            \
        return count ? refuse(instance, "there is no variable of the type " #type) : fmi3OK;                     \
    }
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, bool)
NO_VARIABLES(String, fmi3String)

/* Functions of binary variables, clocks, dependencies and adjoints, which this
   FMU does not have. */
#define NOT_HERE(name, ...)                                        \
    EXPORT fmi3Status name(fmi3Instance instance, __VA_ARGS__)     \
    {                                                              \
        return refuse(instance, "this FMU has no function " #name); \
    }
#define VARIABLES const fmi3ValueReference variables[], size_t count
NOT_HERE(fmi3GetBinary, VARIABLES, size_t sizes[], fmi3Binary values[], size_t values_count)
NOT_HERE(fmi3SetBinary, VARIABLES, const size_t sizes[], const fmi3Binary values[], size_t values_count)
NOT_HERE(fmi3GetClock, VARIABLES, bool values[])
NOT_HERE(fmi3SetClock, VARIABLES, const bool values[])
NOT_HERE(fmi3GetNumberOfVariableDependencies, fmi3ValueReference variable, size_t *count)
NOT_HERE(fmi3GetVariableDependencies, fmi3ValueReference variable, size_t elements[], fmi3ValueReference independents[],
         size_t independent_elements[], fmi3DependencyKind dependencies[], size_t count)
NOT_HERE(fmi3GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t unknown_count,
         const fmi3ValueReference knowns[], size_t known_count, const double seed[], size_t seed_count,
         double sensitivity[], size_t sensitivity_count)
NOT_HERE(fmi3GetIntervalDecimal, VARIABLES, double intervals[], fmi3IntervalQualifier qualifiers[])
NOT_HERE(fmi3GetIntervalFraction, VARIABLES, uint64_t counters[], uint64_t resolutions[],
         fmi3IntervalQualifier qualifiers[])
NOT_HERE(fmi3GetShiftDecimal, VARIABLES, double shifts[])
NOT_HERE(fmi3GetShiftFraction, VARIABLES, uint64_t counters[], uint64_t resolutions[])
NOT_HERE(fmi3SetIntervalDecimal, VARIABLES, const double intervals[])
NOT_HERE(fmi3SetIntervalFraction, VARIABLES, const uint64_t counters[], const uint64_t resolutions[])
NOT_HERE(fmi3SetShiftDecimal, VARIABLES, const double shifts[])
NOT_HERE(fmi3SetShiftFraction, VARIABLES, const uint64_t counters[], const uint64_t resolutions[])
NOT_HERE(fmi3GetOutputDerivatives, VARIABLES, const int32_t orders[], double values[], size_t values_count)
NOT_HERE(fmi3ActivateModelPartition, fmi3ValueReference clock, double time)

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    if (!*state)
        *state = malloc(sizeof(Numbers));
    if (!*state)
        return refuse(instance, "there is no memory left");
    memcpy(*state, &((Instance *)instance)->n, sizeof(Numbers));
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    memcpy(&((Instance *)instance)->n, state, sizeof(Numbers));
    return fmi3OK;
}

EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    free(*state);
    *state = NULL;
    return fmi3OK;
}

EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    *size = sizeof(Numbers);
    return fmi3OK;
}

EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size < sizeof(Numbers))
        return refuse(instance, "the array for a state is too short");
    memcpy(bytes, state, sizeof(Numbers));
    return fmi3OK;
}

EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                          fmi3FMUState *state)
{
    if (size != sizeof(Numbers))
        return refuse(instance, "the bytes are not a state of this FMU");
    if (!*state)
        *state = malloc(sizeof(Numbers));
    if (!*state)
        return refuse(instance, "there is no memory left");
    memcpy(*state, bytes, sizeof(Numbers));
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                               size_t unknown_count, const fmi3ValueReference knowns[],
                                               size_t known_count, const double seed[], size_t seed_count,
                                               double sensitivity[], size_t sensitivity_count)
{
    Instance *s = instance;
    double *slopes = s->n.x + SLOTS;
    if (seed_count != known_count || sensitivity_count != unknown_count)
        return refuse(s, "every variable has one derivative");
    const fmi3Status status = evaluated(s);
    if (status != fmi3OK)
        return status;
    memset(slopes, 0, SLOTS * sizeof *slopes);
    for (size_t k = 0; k < known_count; k++) {
        if (knowns[k] >= SLOTS || !strchr("is", kinds[knowns[k]]))
            return refuse(s, "derivatives are by states and inputs");
        slopes[knowns[k]] += seed[k];
    }
    along_direction(&s->n);
    for (size_t k = 0; k < unknown_count; k++) {
        if (unknowns[k] >= SLOTS || kinds[unknowns[k]] == '-')
            return refuse(s, "there is no variable of this value reference");
        sensitivity[k] = slopes[unknowns[k]];
    }
    memset(slopes, 0, SLOTS * sizeof *slopes);
    return fmi3OK;
}

EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, bool *again, bool *terminate, bool *nominals,
                                           bool *values, bool *has_next, double *next)
{
    Instance *s = instance;
    const fmi3Status status = evaluated(s);
    *again = *nominals = *values = *has_next = false;
    *next = 0;
    *terminate = status == fmi3OK && watch_all(&s->n, 1);
    return status;
}

EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, bool no_return, bool *event, bool *terminate)
{
    Instance *s = instance;
    const fmi3Status status = evaluated(s);
    /* The run ends in event mode, where sides are noted. */
    double *watched = s->n.watched, kept[EVENTS + 1];
    memcpy(kept, watched, sizeof kept);
    *event = status == fmi3OK && watch_all(&s->n, 0);
    memcpy(watched, kept, sizeof kept);
    *terminate = false;
    return status;
}

EXPORT fmi3Status fmi3SetTime(fmi3Instance instance, double time)
{
    Instance *s = instance;
    if (s->n.x[AT_TIME] != time)
        s->n.changed = 1;
    s->n.x[AT_TIME] = time;
    return fmi3OK;
}

EXPORT fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const double numbers[], size_t count)
{
    Instance *s = instance;
    if (count != STATES)
        return refuse(s, "the number of states is another");
    set_states(&s->n, s->n.x[AT_TIME], numbers);
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetContinuousStates(fmi3Instance instance, double numbers[], size_t count)
{
    Instance *s = instance;
    if (count != STATES)
        return refuse(s, "the number of states is another");
    for (unsigned k = 0; k < STATES; k++)
        numbers[k] = s->n.x[states[k]];
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, double numbers[], size_t count)
{
    Instance *s = instance;
    if (count != STATES)
        return refuse(s, "the number of states is another");
    const fmi3Status status = evaluated(s);
    for (unsigned k = 0; k < STATES; k++)
        numbers[k] = s->n.x[slopes[k]];
    return status;
}

EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, double nominals[], size_t count)
{
    for (size_t k = 0; k < count; k++)
        nominals[k] = 1;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetEventIndicators(fmi3Instance instance, double indicators[], size_t count)
{
    Instance *s = instance;
    if (count != EVENTS)
        return refuse(s, "the number of event indicators is another");
    const fmi3Status status = evaluated(s);
    for (unsigned k = 0; k < EVENTS; k++)
        indicators[k] = watch(&s->n, k);
    return status;
}

EXPORT fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *count)
{
    *count = EVENTS;
    return fmi3OK;
}

EXPORT fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *count)
{
    *count = STATES;
    return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, double time, double step, bool no_return, bool *event,
                             bool *terminate, bool *early, double *last)
{
    Instance *s = instance;
    *event = *terminate = *early = false;
    fmi3SetTime(s, time);
    const int reached = integrate(s, time + step);
    *terminate = reached == 2;
    *last = s->n.x[AT_TIME];
    return reached ? fmi3OK : report(s, fmi3Discard);
}
