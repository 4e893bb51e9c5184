/* The lever with CVODE (SUNDIALS 6), Adams' method, as its manual shows: roots at the stop and at peaks,
 * the solver started anew after each impact. An entrant of ./chart: the scene comes on standard input, then
 * the number of a method per line; each is answered with two peaks [rad], no bound and the time [s]. */

#include <cvode/cvode.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <time.h>

/* Angle off the stop after an event [rad], and times that are one instant [s]. */
#define ASIDE 1e-18
#define INSTANT 1e-12

static struct {
    double start, rate, inertia, unbalance, preload, stiffness, damping, contact_stiffness, contact_damping;
    double rest_angle, restitution, lift_off;
    int count;
    double *samples;
} scene;

static struct {
    const char *name;
    int at_samples;
    double tolerance;
} const methods[] = {
    {"cvode\t1e-6", 0, 1e-6},         {"cvode\t1e-9", 0, 1e-9},
    {"cvode\t1e-12", 0, 1e-12},       {"cvode\t1e-14", 0, 1e-14},
    {"cvode-samples\t1e-6", 1, 1e-6}, {"cvode-samples\t1e-9", 1, 1e-9},
    {"cvode-samples\t1e-12", 1, 1e-12}, {"cvode-samples\t1e-14", 1, 1e-14},
};

static void read_scene(void)
{
    static const struct { const char *name; double *value; } quantities[] = {
        {"start", &scene.start},
        {"rate", &scene.rate},
        {"inertia", &scene.inertia},
        {"unbalance", &scene.unbalance},
        {"preload", &scene.preload},
        {"stiffness", &scene.stiffness},
        {"damping", &scene.damping},
        {"contact_stiffness", &scene.contact_stiffness},
        {"contact_damping", &scene.contact_damping},
        {"rest_angle", &scene.rest_angle},
        {"restitution", &scene.restitution},
        {"lift_off", &scene.lift_off},
    };
    char name[64];
    double value;
    while (scanf("%63s %lf", name, &value) == 2) {
        if (strcmp(name, "samples") == 0)
            break;
        for (size_t k = 0; k < sizeof quantities / sizeof *quantities; k++)
            if (strcmp(name, quantities[k].name) == 0)
                *quantities[k].value = value;
    }
    scene.count = (int)value;
    scene.samples = malloc(scene.count * sizeof *scene.samples);
    for (int k = 0; k < scene.count; k++)
        if (scanf("%lf", &scene.samples[k]) != 1)
            exit(1);
}

static int place(double t, double *part)
{
    double position = (t - scene.start) * scene.rate;
    int index = (int)position;
    if (index > scene.count - 2)
        index = scene.count - 2;
    *part = position - index;
    return index;
}

static double excitation(double t)
{
    double part;
    const double *at = scene.samples + place(t, &part);
    return at[0] + part * (at[1] - at[0]);
}

/* First time from t on at which the preload no longer holds the lever, or a negative number. */
static double lift_off_after(double t)
{
    double limit = -scene.lift_off, part;
    if (excitation(t) < limit)
        return t;
    for (int k = place(t, &part); k < scene.count - 1; k++) {
        double from = scene.samples[k], to = scene.samples[k + 1];
        if (to < limit) {
            part = (from - limit) / (from - to);
            return fmax(t, scene.start + (k + fmin(fmax(part, 0.0), 1.0)) / scene.rate);
        }
    }
    return -INFINITY;
}

struct lever {
    int in_contact;
};

static double acceleration(const struct lever *lever, double t, double angle, double velocity)
{
    double stiffness = lever->in_contact ? scene.contact_stiffness : scene.stiffness;
    double damping = lever->in_contact ? scene.contact_damping : scene.damping;
    double torque = -scene.preload - scene.unbalance * excitation(t) * cos(angle) - damping * velocity - stiffness * angle;
    return torque / scene.inertia;
}

static int slope(double t, N_Vector y, N_Vector dy, void *lever)
{
    const double *state = N_VGetArrayPointer(y);
    double *rate = N_VGetArrayPointer(dy);
    rate[0] = state[1];
    rate[1] = acceleration(lever, t, state[0], state[1]);
    return 0;
}

static int roots(double t, N_Vector y, double *g, void *lever)
{
    const double *state = N_VGetArrayPointer(y);
    (void)t, (void)lever;
    g[0] = state[0];
    g[1] = state[1];
    return 0;
}

/* Peak angle [rad]; not a number where the solver gives up. */
static double peak_angle(int soft, int at_samples, double tolerance)
{
    double end = scene.start + (scene.count - 1) / scene.rate, t = scene.start, peak = soft ? scene.rest_angle : 0.0, part;
    struct lever lever = {soft};
    int resting = !soft, restart = 0, failed = 0, directions[2] = {0, -1}, found[2];
    SUNContext context;
    SUNContext_Create(NULL, &context);
    N_Vector y = N_VNew_Serial(2, context);
    double *state = N_VGetArrayPointer(y);
    state[0] = soft ? scene.rest_angle : ASIDE;
    state[1] = 0.0;
    void *cvode = CVodeCreate(CV_ADAMS, context);
    CVodeInit(cvode, slope, t, y);
    CVodeSStolerances(cvode, tolerance, tolerance);
    SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
    CVodeSetNonlinearSolver(cvode, solver);
    CVodeSetUserData(cvode, &lever);
    CVodeRootInit(cvode, 2, roots);
    CVodeSetRootDirection(cvode, directions);
    CVodeSetNoInactiveRootWarn(cvode);
    CVodeSetErrFile(cvode, NULL);
    CVodeSetMaxNumSteps(cvode, 10000000);
    while (!failed) {
        if (resting) {
            t = lift_off_after(t);
            if (t < scene.start)
                break;
            state[0] = ASIDE, state[1] = 0.0;
            resting = 0, restart = 1;
        }
        if (end - t < INSTANT)
            break;
        if (restart)
            CVodeReInit(cvode, t, y);
        restart = 0;
        double until = end;
        if (at_samples)
            until = fmin(end, scene.start + (place(t + INSTANT, &part) + 1) / scene.rate);
        CVodeSetStopTime(cvode, until);
        int result = CVode(cvode, until, y, &t, CV_NORMAL);
        failed = result < 0;
        peak = fmax(peak, state[0]);
        if (result != CV_ROOT_RETURN) {
            /* At a sample the slope has a kink, no jump: what the method has learnt of it stays. */
            continue;
        }
        CVodeGetRootInfo(cvode, found);
        if (found[0] == 0)
            continue;
        if (soft) {
            lever.in_contact = state[1] < 0.0;
            state[0] = copysign(ASIDE, state[1]);
        } else {
            state[0] = ASIDE;
            state[1] *= -scene.restitution;
            /* A bounce lower than the tolerance is none. */
            resting = 0.5 * state[1] * state[1] <= -acceleration(&lever, t, 0.0, 0.0) * tolerance;
        }
        restart = 1;
    }
    CVodeFree(&cvode);
    SUNNonlinSolFree(solver);
    N_VDestroy(y);
    SUNContext_Free(&context);
    return failed ? NAN : peak;
}

int main(void)
{
    int method;
    read_scene();
    for (size_t k = 0; k < sizeof methods / sizeof *methods; k++)
        puts(methods[k].name);
    puts("");
    fflush(stdout);
    while (scanf("%d", &method) == 1) {
        struct timespec from, to;
        clock_gettime(CLOCK_MONOTONIC, &from);
        double rigid = peak_angle(0, methods[method].at_samples, methods[method].tolerance);
        double soft = peak_angle(1, methods[method].at_samples, methods[method].tolerance);
        clock_gettime(CLOCK_MONOTONIC, &to);
        printf("%.17e %.17e nan %.9e\n", rigid, soft, (to.tv_sec - from.tv_sec) + 1e-9 * (to.tv_nsec - from.tv_nsec));
        fflush(stdout);
    }
    return 0;
}
