// Table of a network, written by `benches/src/peers/write.rs`, for the peers that play any network.
//
//   axes MATs LIAs outputs
//   per MAT  kind m k z, then for each axis its position in the first sample and the step that led there
//   per LIA  law, first end, second end, three parameters
//   per output  a MAT
// All numbers are per sample: a mass of 1, a stiffness of 0.2 and a viscosity of 0.001 are k T²/m and z T/m.
#pragma once
#include <stdio.h>
#include <stdlib.h>

enum { MAS, CEL, SOL };
enum { REF, BUT, HRZ, BOW, INSIDE, LAWS };

typedef struct {
    int kind;
    double m, k, z, x[3], v[3];
} Mat;
typedef struct {
    int law, a, b;
    double p[3];
} Lia;
typedef struct {
    int axes, mats, lias, outputs;
    Mat *mat;
    Lia *lia;
    int *output;
} Table;

static void refuse(const char *why);

static void *zeros(size_t n, size_t size) {
    void *p = calloc(n ? n : 1, size);
    if (!p) refuse("no memory");
    return p;
}

static Table read_table(const char *path) {
    Table t;
    FILE *f = fopen(path, "r");
    if (!f || fscanf(f, "%d %d %d %d", &t.axes, &t.mats, &t.lias, &t.outputs) != 4) refuse("no table");
    t.mat = (Mat *)zeros(t.mats, sizeof(Mat));
    t.lia = (Lia *)zeros(t.lias, sizeof(Lia));
    t.output = (int *)zeros(t.outputs, sizeof(int));
    for (int i = 0; i < t.mats; i++) {
        Mat *m = t.mat + i;
        if (fscanf(f, "%d %lf %lf %lf", &m->kind, &m->m, &m->k, &m->z) != 4) refuse("no MAT");
        for (int e = 0; e < t.axes; e++)
            if (fscanf(f, "%lf %lf", m->x + e, m->v + e) != 2) refuse("no place");
    }
    for (int i = 0; i < t.lias; i++) {
        Lia *l = t.lia + i;
        if (fscanf(f, "%d %d %d %lf %lf %lf", &l->law, &l->a, &l->b, l->p, l->p + 1, l->p + 2) != 6) refuse("no LIA");
    }
    for (int i = 0; i < t.outputs; i++)
        if (fscanf(f, "%d", t.output + i) != 1) refuse("no output");
    fclose(f);
    return t;
}
