// Boxed C++: an object for each module, called through a virtual function, in the order of the file. Libraries of
// modules are usually written in this way.
#include "player.h"
#include "table.h"
#include <cmath>
#include <memory>
#include <vector>

struct Point {
    double x = 0, before = 0, f = 0;
    virtual ~Point() = default;
    virtual void move() = 0;
};
struct Mass : Point {
    double m;
    void move() override {
        double next = 2 * x - before + f / m;
        before = x, x = next, f = 0;
    }
};
struct Cell : Point {
    double m, k, z;
    void move() override {
        double next = (2 - (k + z) / m) * x + (z / m - 1) * before + f / m;
        before = x, x = next, f = 0;
    }
};
struct Fixed : Point {
    void move() override { f = 0; }
};

struct Link {
    Point *a, *b;
    double p, q, d;
    virtual ~Link() = default;
    virtual void act() = 0;
    double apart() const { return b->x - a->x; }
    double step() const { return (b->x - b->before) - (a->x - a->before); }
    void pull(double F) { a->f += F, b->f -= F; }
};
struct Spring : Link {
    void act() override { pull(p * apart() + q * step()); }
};
struct Contact : Link {
    void act() override {
        double g = apart() - d;
        if (g < 0) pull(p * g + q * step());
    }
};
struct Hertz : Link {
    void act() override {
        double g = d - apart();
        if (g > 0) pull(-p * g * std::sqrt(g));
    }
};
struct Bow : Link {
    void act() override {
        double u = step() / q;
        pull(p * u * std::exp(0.5 - 0.5 * u * u));
    }
};

struct World {
    Table table;
    std::vector<std::unique_ptr<Point>> points;
    std::vector<std::unique_ptr<Link>> links;
};

static std::unique_ptr<Point> point(const Mat &m) {
    if (m.kind == MAS) {
        auto p = std::make_unique<Mass>();
        p->m = m.m;
        return p;
    }
    if (m.kind == CEL) {
        auto p = std::make_unique<Cell>();
        p->m = m.m, p->k = m.k, p->z = m.z;
        return p;
    }
    return std::make_unique<Fixed>();
}

static std::unique_ptr<Link> link(int law) {
    switch (law) {
    case REF: return std::make_unique<Spring>();
    case BUT: return std::make_unique<Contact>();
    case HRZ: return std::make_unique<Hertz>();
    case BOW: return std::make_unique<Bow>();
    }
    refuse("a law of space");
    return nullptr;
}

static void *peer_open(const char *what) {
    auto *w = new World{read_table(what), {}, {}};
    if (w->table.axes != 1) refuse("on a line only");
    for (int i = 0; i < w->table.mats; i++) w->points.push_back(point(w->table.mat[i]));
    for (int i = 0; i < w->table.lias; i++) {
        const Lia &l = w->table.lia[i];
        w->links.push_back(link(l.law));
        Link &made = *w->links.back();
        made.a = w->points[l.a].get(), made.b = w->points[l.b].get();
        made.p = l.p[0], made.q = l.p[1], made.d = l.p[2];
    }
    return w;
}

static void peer_begin(void *peer) {
    auto *w = static_cast<World *>(peer);
    for (int i = 0; i < w->table.mats; i++) {
        Point &p = *w->points[i];
        const Mat &m = w->table.mat[i];
        p.x = m.x[0], p.before = m.x[0] - m.v[0], p.f = 0;
    }
}

static void peer_play(void *peer, int ticks, double *out) {
    auto *w = static_cast<World *>(peer);
    for (int t = 0; t < ticks; t++) {
        for (auto &l : w->links) l->act();
        double sum = 0;
        for (int i = 0; i < w->table.outputs; i++) sum += w->points[w->table.output[i]]->x;
        out[t] = sum;
        for (auto &p : w->points) p->move();
    }
}
