/* The smallest device in C: a damped finger of 100 g that the force of the engine moves.
 *
 *   cc -Icrates/ca-haptic/c/include device.c -Ltarget/release -lca_device -o device && ./device finger 3000
 *
 * It sends its position 1000 times a second, moves under the force of ca_device_force, and prints statistics. */
#define _POSIX_C_SOURCE 200809L
#include "ca_device.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define M 0.1    /* mass of the finger [kg] */
#define Z 2.0    /* its viscosity [N s/m] */
#define DT 0.001 /* time between frames [s] */

static int fail(void) {
    fprintf(stderr, "error: %s\n", ca_device_error());
    return 1;
}

int main(int argc, char **argv) {
    const char *name = argc > 1 ? argv[1] : "finger";
    long frames = argc > 2 ? atol(argv[2]) : 3000;
    CaAbout about;
    if (ca_device_about(&about, name, 1, 1, (uint32_t)(1.0 / DT)) != 0) return fail();
    about.low[0] = -0.02f;
    about.high[0] = 0.02f;
    about.force[0] = about.continuous[0] = 10.0f;
    uint64_t device = ca_device_open(NULL, &about);
    if (device == 0) return fail();

    CaDeviceFrame frame = {0};
    CaForceFrame last = {0};
    double x = 0, v = 0, most = 0, force[CA_DOF];
    long felt = 0;
    frame.n = 1;
    frame.mask = 1;
    frame.status = CA_STATUS_CONNECTED | CA_STATUS_POWERED | CA_STATUS_CALIBRATED | CA_STATUS_SIMULATED;
    struct timespec due;
    clock_gettime(CLOCK_MONOTONIC, &due);
    for (long i = 0; i < frames; i++) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        frame.t_device_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
        frame.pos[0] = x;
        if (ca_device_send(device, &frame) < 0) return fail();
        /* the force is zero unless it is fresh, for this device and switched on */
        if (ca_device_force(device, force, &last) < 0) return fail();
        v = (v + force[0] / M * DT) / (1 + Z / M * DT);
        x += v * DT;
        felt += force[0] != 0;
        most = fmax(most, fabs(force[0]));
        due.tv_nsec += (long)(DT * 1e9);
        if (due.tv_nsec >= 1000000000) {
            due.tv_nsec -= 1000000000;
            due.tv_sec++;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
    }
    static const char *modes[] = {"off", "ramp", "on", "damp", "fault"};
    printf("sent %ld seen %llu felt %ld most %.3f x %.6f mode %s\n", frames, (unsigned long long)last.seq, felt, most, x,
           last.seq == 0 ? "none" : modes[last.mode < 4 ? last.mode : 4]);
    return ca_device_close(device) == 0 ? 0 : fail();
}
