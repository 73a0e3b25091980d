// Main function of every compiled peer: plays its network on request, and measures its time.
//
// A peer is a process that receives requests as lines on its standard input. Peers in any language and the engine can
// thus take turns without foreign calls:
//   hear N   plays N ticks from the start and writes the output, a number a line
//   time N   plays WARM ticks from the start, then N more, and writes the processor time of these [ns]
// Each request begins at the start, so that every round plays the same motion, with the same contacts and sizes of
// numbers.
#pragma once
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// Ticks before the clock starts: caches are filled, and hammers move.
#define WARM 1024
// Ticks of a call, as in a sound callback.
#define BLOCK 64

// Every peer defines these three functions.
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
