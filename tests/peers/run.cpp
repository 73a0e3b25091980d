// Plays the program that Faust inserts below. `run N` reads N frames of inputs from standard input and writes N frames
// of outputs to standard output, as interleaved doubles in native byte order.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#define FAUSTFLOAT double

// interfaces that a generated class requires; the controls do nothing
struct Meta {
    void declare(const char*, const char*) {}
};
struct UI {
    void openVerticalBox(const char*) {}
    void closeBox() {}
};
struct dsp {
    virtual ~dsp() = default;
};

<<includeIntrinsic>>

<<includeclass>>

int main(int argc, char** argv) {
    const int frames = argc > 1 ? std::atoi(argv[1]) : 0;
    static mydsp program;
    program.init(48000);
    const int ins = program.getNumInputs(), outs = program.getNumOutputs();
    std::vector<double> in(std::max(1, ins)), out(outs);
    std::vector<double*> reads, writes;
    for (int i = 0; i < ins; i++) reads.push_back(&in[i]);
    for (int i = 0; i < outs; i++) writes.push_back(&out[i]);
    for (int n = 0; n < frames; n++) {
        if (std::fread(in.data(), sizeof(double), ins, stdin) != static_cast<size_t>(ins)) return 1;
        program.compute(1, reads.data(), writes.data());
        if (std::fwrite(out.data(), sizeof(double), outs, stdout) != static_cast<size_t>(outs)) return 1;
    }
    return 0;
}
