// What every compiled peer does: it plays its network when it is asked to, and times itself.
//
// Decides for a process that is asked by lines on its standard input, so that peers of any language and the engine take
// turns without a foreign call:
//   hear N   plays N ticks from the start and writes what is heard, a number a line
//   time N   plays WARM ticks from the start, then N more, and writes the processor time of these [ns]
// Each begins at the start, so that every round plays the same motion, with the contacts it has, at the same size of numbers.
#pragma once
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// Ticks before the clock starts: the caches are filled, hammers are under way.
#define WARM 1024
// Ticks of a call, as of a sound callback.
#define BLOCK 64

// A peer has these three.
static void *peer_open(const char *what);
static void peer_begin(void *peer);
static void peer_play(void *peer, int ticks, double *out);

static void refuse(const char *why) {
    fprintf(stderr, "%s\n", why);
    exit(1);
}

static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

int main(int argc, char **argv) {
    void *peer = peer_open(argc > 1 ? argv[1] : "");
    double out[BLOCK];
    char word[8];
    int ticks;
    while (scanf("%7s %d", word, &ticks) == 2) {
        if (ticks % BLOCK != 0) refuse("ticks come in whole blocks");
        peer_begin(peer);
        if (strcmp(word, "hear") == 0) {
            for (int t = 0; t < ticks; t += BLOCK) {
                peer_play(peer, BLOCK, out);
                for (int i = 0; i < BLOCK; i++) printf("%.17g\n", out[i]);
            }
        } else if (strcmp(word, "time") == 0) {
            for (int t = 0; t < WARM; t += BLOCK) peer_play(peer, BLOCK, out);
            double begin = processor_time();
            for (int t = 0; t < ticks; t += BLOCK) peer_play(peer, BLOCK, out);
            printf("%.0f\n", processor_time() - begin);
        } else {
            refuse("not `hear` and not `time`");
        }
        fflush(stdout);
    }
    return 0;
}
