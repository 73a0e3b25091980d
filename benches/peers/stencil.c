// Stencils by hand: a string or a square mesh of equal masses, springs and dampers, with fixed ends or edges. This is
// the fastest way without vectors written by hand; it plays one topology, and parameters cannot differ.
//
// `string N`, `mesh N`, each `damped` or `undamped`, in one argument with colons: `mesh:20:damped`. Without dampers a
// tick is one pass over two arrays. With dampers the force on a mass is a difference of u = k x + z d, in two passes.
#include "player.h"

// for masses of 1, as in `benches/src/peers/nets.rs`
#define STIFF 0.2
#define VISCOUS 0.005
#define START 1e-3

typedef struct {
    int mesh, n, wide, damped;
    // x; the position before, or the step d; u = k x + z d
    double *x, *y, *u;
} Stencil;

static void *peer_open(const char *what) {
    char shape[8], dampers[12];
    Stencil *s = (Stencil *)calloc(1, sizeof(Stencil));
    if (sscanf(what, "%7[^:]:%d:%11s", shape, &s->n, dampers) != 3) refuse("not shape:size:dampers");
    s->mesh = strcmp(shape, "mesh") == 0;
    s->damped = strcmp(dampers, "damped") == 0;
    s->wide = s->n + 2;
    size_t all = s->mesh ? (size_t)s->wide * s->wide : (size_t)s->wide;
    s->x = (double *)calloc(all, sizeof(double));
    s->y = (double *)calloc(all, sizeof(double));
    s->u = (double *)calloc(all, sizeof(double));
    return s;
}

static int place(const Stencil *s, int i) { return s->mesh ? (i + 1) * s->wide + i + 1 : i + 1; }

static void peer_begin(void *peer) {
    Stencil *s = (Stencil *)peer;
    size_t all = s->mesh ? (size_t)s->wide * s->wide : (size_t)s->wide;
    memset(s->x, 0, all * sizeof(double));
    memset(s->y, 0, all * sizeof(double));
    s->x[place(s, s->n / 3)] = START;
    // from rest, the tick before is the mirror of the tick after: half the force away
    for (int k = 0; k < (s->mesh ? s->n * s->n : s->n); k++) {
        int i = s->mesh ? (k / s->n + 1) * s->wide + k % s->n + 1 : k + 1;
        double force = s->x[i - 1] + s->x[i + 1] - 2 * s->x[i];
        if (s->mesh) force += s->x[i - s->wide] + s->x[i + s->wide] - 2 * s->x[i];
        double step = -0.5 * STIFF * force;
        s->y[i] = s->damped ? step : s->x[i] - step;
    }
}

__attribute__((noinline)) static void string(const double *restrict x, double *restrict y, int n) {
    for (int i = 1; i <= n; i++) y[i] = (2 - 2 * STIFF) * x[i] - y[i] + STIFF * (x[i - 1] + x[i + 1]);
}

__attribute__((noinline)) static void string_damped(double *restrict x, double *restrict d, double *restrict u, int n) {
    for (int i = 1; i <= n; i++) u[i] = STIFF * x[i] + VISCOUS * d[i];
    for (int i = 1; i <= n; i++) {
        d[i] += (u[i + 1] - u[i]) - (u[i] - u[i - 1]);
        x[i] += d[i];
    }
}

__attribute__((noinline)) static void mesh(const double *restrict x, double *restrict y, int n) {
    int w = n + 2;
    for (int j = 1; j <= n; j++) {
        const double *X = x + j * w;
        double *Y = y + j * w;
        for (int i = 1; i <= n; i++)
            Y[i] = (2 - 4 * STIFF) * X[i] - Y[i] + STIFF * (X[i - 1] + X[i + 1] + X[i - w] + X[i + w]);
    }
}

__attribute__((noinline)) static void mesh_damped(double *restrict x, double *restrict d, double *restrict u, int n) {
    int w = n + 2;
    for (int i = w; i < w * (n + 1); i++) u[i] = STIFF * x[i] + VISCOUS * d[i];
    for (int j = 1; j <= n; j++) {
        double *X = x + j * w, *D = d + j * w, *U = u + j * w;
        for (int i = 1; i <= n; i++) {
            D[i] += (U[i + 1] + U[i - 1] + U[i + w] + U[i - w]) - 4 * U[i];
            X[i] += D[i];
        }
    }
}

static void peer_play(void *peer, int ticks, double *out) {
    Stencil *s = (Stencil *)peer;
    int heard = place(s, 3);
    for (int t = 0; t < ticks; t++) {
        out[t] = s->x[heard];
        if (s->damped) {
            if (s->mesh) mesh_damped(s->x, s->y, s->u, s->n);
            else string_damped(s->x, s->y, s->u, s->n);
        } else {
            if (s->mesh) mesh(s->x, s->y, s->n);
            else string(s->x, s->y, s->n);
            double *now = s->y;
            s->y = s->x;
            s->x = now;
        }
    }
}
