// Architecture file for Faust: makes a peer that plays one network, with the modules of mi.lib.
#include "player.h"
#include <algorithm>
#include <cmath>

#define FAUSTFLOAT double

// types that a generated class requires; nothing is displayed or controlled here
struct Meta {
    void declare(const char *, const char *) {}
};
struct UI {
    void openVerticalBox(const char *) {}
    void closeBox() {}
};
struct dsp {
    virtual ~dsp() = default;
};

<<includeIntrinsic>>

<<includeclass>>

static void *peer_open(const char *) {
    static mydsp program;
    return &program;
}

static void peer_begin(void *peer) { static_cast<mydsp *>(peer)->init(48000); }

static void peer_play(void *peer, int ticks, double *out) {
    double *channels[] = {out};
    static_cast<mydsp *>(peer)->compute(ticks, nullptr, channels);
}
