// Flat C: arrays of numbers, a loop over the links of each law, and a loop over the masses: a fast and general program
// written in an afternoon.
#include "player.h"
#include "table.h"
#include <math.h>

typedef struct {
    Table t;
    // positions now and before (on a line) or the step (in space), forces, coefficients of a mass
    double *x, *y, *f, *now, *before, *c;
    // links by law: first and last of each
    int at[LAWS + 1], *a, *b;
    // in space: the previous distance
    double *p, *q, *d, *r;
} Flat;

static double distance(const double *x, int a, int b) {
    double s = 0;
    for (int e = 0; e < 3; e++) s += (x[3 * b + e] - x[3 * a + e]) * (x[3 * b + e] - x[3 * a + e]);
    return sqrt(s);
}

static void *peer_open(const char *what) {
    Flat *s = (Flat *)zeros(1, sizeof(Flat));
    Table t = s->t = read_table(what);
    size_t n = (size_t)t.mats * t.axes, l = t.lias;
    double **arrays[] = {&s->x, &s->y, &s->f, &s->now, &s->before, &s->c};
    for (int i = 0; i < 6; i++) *arrays[i] = (double *)zeros(n, sizeof(double));
    double **links[] = {&s->p, &s->q, &s->d, &s->r};
    for (int i = 0; i < 4; i++) *links[i] = (double *)zeros(l, sizeof(double));
    s->a = (int *)zeros(l, sizeof(int));
    s->b = (int *)zeros(l, sizeof(int));
    for (int i = 0; i < t.mats; i++) {
        const Mat *m = t.mat + i;
        int fixed = m->kind == SOL;
        s->c[i] = fixed ? 0 : 1 / m->m;
        s->now[i] = fixed ? 2 : 2 - (m->k + m->z) / m->m;
        s->before[i] = fixed ? -1 : m->z / m->m - 1;
    }
    int next = 0;
    for (int law = 0; law < LAWS; law++) {
        s->at[law] = next;
        for (int i = 0; i < t.lias; i++) {
            const Lia *link = t.lia + i;
            if (link->law != law) continue;
            s->a[next] = link->a, s->b[next] = link->b;
            s->p[next] = link->p[0], s->q[next] = link->p[1], s->d[next] = link->p[2];
            next++;
        }
    }
    s->at[LAWS] = next;
    return s;
}

static void peer_begin(void *peer) {
    Flat *s = (Flat *)peer;
    const Table *t = &s->t;
    int axes = t->axes;
    for (int i = 0; i < t->mats; i++) {
        const Mat *m = t->mat + i;
        for (int e = 0; e < axes; e++) {
            int j = axes * i + e;
            s->f[j] = 0;
            s->x[j] = m->x[e];
            s->y[j] = m->x[e] - m->v[e];
        }
    }
    if (axes == 1) return;
    for (int i = 0; i < t->lias; i++) s->r[i] = distance(s->y, s->a[i], s->b[i]);
    for (int j = 0; j < 3 * t->mats; j++) s->y[j] = t->mat[j / 3].v[j % 3];
}

static double heard(const Flat *s) {
    int axes = s->t.axes;
    double sum = 0;
    for (int i = 0; i < s->t.outputs; i++) sum += s->x[axes * s->t.output[i] + axes - 1];
    return sum;
}

static void line(Flat *s, int ticks, double *out) {
    double *restrict x = s->x, *restrict y = s->y, *restrict f = s->f;
    const double *restrict p = s->p, *restrict q = s->q, *restrict d = s->d;
    const double *restrict now = s->now, *restrict before = s->before, *restrict c = s->c;
    const int *restrict a = s->a, *restrict b = s->b, *at = s->at;
    for (int t = 0; t < ticks; t++) {
        for (int i = at[REF]; i < at[REF + 1]; i++) {
            double F = p[i] * (x[b[i]] - x[a[i]]) + q[i] * ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]]));
            f[a[i]] += F;
            f[b[i]] -= F;
        }
        for (int i = at[BUT]; i < at[BUT + 1]; i++) {
            double g = x[b[i]] - x[a[i]] - d[i];
            if (g < 0) {
                double F = p[i] * g + q[i] * ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]]));
                f[a[i]] += F;
                f[b[i]] -= F;
            }
        }
        for (int i = at[HRZ]; i < at[HRZ + 1]; i++) {
            double g = d[i] - (x[b[i]] - x[a[i]]);
            if (g > 0) {
                double F = -p[i] * g * sqrt(g);
                f[a[i]] += F;
                f[b[i]] -= F;
            }
        }
        for (int i = at[BOW]; i < at[BOW + 1]; i++) {
            double u = ((x[b[i]] - y[b[i]]) - (x[a[i]] - y[a[i]])) / q[i];
            double F = p[i] * u * exp(0.5 - 0.5 * u * u);
            f[a[i]] += F;
            f[b[i]] -= F;
        }
        out[t] = heard(s);
        for (int i = 0; i < s->t.mats; i++) {
            double next = now[i] * x[i] + before[i] * y[i] + c[i] * f[i];
            y[i] = x[i];
            x[i] = next;
            f[i] = 0;
        }
    }
}

static inline void pull(double *restrict f, int a, int b, double F, double X, double Y, double Z) {
    f[a] += F * X, f[a + 1] += F * Y, f[a + 2] += F * Z;
    f[b] -= F * X, f[b + 1] -= F * Y, f[b + 2] -= F * Z;
}

static void space(Flat *s, int ticks, double *out) {
    double *restrict x = s->x, *restrict y = s->y, *restrict f = s->f, *restrict r = s->r;
    const double *restrict p = s->p, *restrict q = s->q, *restrict d = s->d;
    for (int t = 0; t < ticks; t++) {
        for (int law = 0; law < LAWS; law++) {
            for (int i = s->at[law]; i < s->at[law + 1]; i++) {
                int a = 3 * s->a[i], b = 3 * s->b[i];
                double X = x[b] - x[a], Y = x[b + 1] - x[a + 1], Z = x[b + 2] - x[a + 2];
                double square = X * X + Y * Y + Z * Z, far = sqrt(square);
                double g = far - d[i];
                if (law == REF || (law == BUT && g < 0) || (law == INSIDE && g > 0))
                    pull(f, a, b, (p[i] * g + q[i] * (far - r[i])) / far, X, Y, Z);
                r[i] = far;
            }
        }
        out[t] = heard(s);
        for (int i = 0; i < s->t.mats; i++) {
            for (int j = 3 * i; j < 3 * i + 3; j++) {
                y[j] += s->c[i] * f[j];
                x[j] += y[j];
                f[j] = 0;
            }
        }
    }
}

static void peer_play(void *peer, int ticks, double *out) {
    Flat *s = (Flat *)peer;
    if (s->t.axes == 1) line(s, ticks, out);
    else space(s, ticks, out);
}
