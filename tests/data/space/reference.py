"""Reference motions in space: masses, springs and one-sided contacts in continuous time.

What it decides: the reference knows nothing of sampling. It integrates Newton's equations by DOP853, an adaptive
Runge-Kutta of order 8, at a relative tolerance of 1e-13, and shares neither formulas nor code with the scheme it is
to judge. A contact switches its stiffness on and off, which no Runge-Kutta may step across: each switching instant is
found as an event, refined by Newton on the flow itself, and the integration starts anew from it. (A fixed step a
hundred times finer was the alternative: it would lose the order at every switch, which is what is to be measured.)

    python reference.py            writes reference.json beside this file and prints the balances
    python reference.py --check    computes all of it again and compares with reference.json, to 1e-9 m

Needs numpy and scipy (made with numpy 2 and scipy 1.16). SI units throughout; z points up.

The laws, for two ends i and j (D = x_j - x_i, an end that is not a mass is the fixed origin):
    spring   F = k (|D| - l0) + z d|D|/dt                         along D; F > 0 pulls the ends together
    outside  F = k (|D| - d) + z d|D|/dt   while |D| < d          along D, not clipped
    inside   the same                      while |D| > d
    plane    F = k h + z dh/dt             while h < 0, h the height of the mass above z = 0; along z, not clipped

What it writes, per case: `id`; `seconds`, its length; `blows`, how many contacts it has, each at another corner or
wall; `m` [kg], `gravity` [m/s^2]; `springs` [i, j, k, z, l0], `outside` and `inside` [i, j, k, z, d], `plane`
[i, k, z], where i = -1 is the origin; `x0` [m] and `v0` [m/s], one row of three per mass; `per_second`, how often
positions are kept; `contacts`, [place in outside + inside + plane, from, to] in seconds, in order; `x` [m], a row per
kept instant, from 1/per_second on, of the coordinates of all masses one after the other.
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

HERE = Path(__file__).resolve().parent
PER_SECOND = 80  # a whole number of ticks at 12 kHz and all its multiples
FINE = 1e-13, 2e-4  # relative tolerance; longest step [s], so that no contact is stepped over
COARSE = 1e-10, 6e-4  # what the result is compared with
G = [0.0, 0.0, -9.81]


class Scene:
    """The right-hand side of a case, and what stays constant in it."""

    def __init__(self, case):
        self.m = np.array(case["m"])
        self.n = len(self.m)
        self.g = np.array(case["gravity"])
        self.springs = case["springs"]
        self.contacts = (
            [("outside", *c) for c in case["outside"]]
            + [("inside", *c) for c in case["inside"]]
            + [("plane", -1, *c, 0.0) for c in case["plane"]]
        )

    def split(self, y):
        n = 3 * self.n
        return y[:n].reshape(-1, 3), y[n : 2 * n].reshape(-1, 3)

    def link(self, x, v, i, j):
        """Unit vector from i to j, distance and its rate."""
        a, va = (x[i], v[i]) if i >= 0 else (np.zeros(3), np.zeros(3))
        diff = x[j] - a
        length = math.sqrt(diff @ diff)
        u = diff / length
        return u, length, float(u @ (v[j] - va))

    def gap(self, x, v, c):
        """Direction, gap (negative while in contact), its rate, and the sign of the gap within e - d."""
        sense, i, j, _, _, d = c
        if sense == "plane":
            return np.array([0.0, 0.0, 1.0]), x[j][2], v[j][2], 1.0
        u, length, rate = self.link(x, v, i, j)
        side = 1.0 if sense == "outside" else -1.0
        return u, side * (length - d), side * rate, side

    def slope(self, y, active):
        """d/dt of (positions, velocities, heat) with exactly the contacts in `active` acting."""
        x, v = self.split(y)
        f = self.m[:, None] * self.g
        heat = 0.0

        def pull(i, j, u, force):
            f[j] -= force * u
            if i >= 0:
                f[i] += force * u

        for i, j, k, z, l0 in self.springs:
            u, length, rate = self.link(x, v, i, j)
            pull(i, j, u, k * (length - l0) + z * rate)
            heat += z * rate * rate
        for n in active:
            c = self.contacts[n]
            u, gap, rate, side = self.gap(x, v, c)
            pull(c[1], c[2], u, side * (c[3] * gap + c[4] * rate))
            heat += c[4] * rate * rate
        return np.concatenate([v.ravel(), (f / self.m[:, None]).ravel(), [heat]])

    def energy(self, y, active):
        """Kinetic, elastic and potential energy, and the heat so far [J]."""
        x, v = self.split(y)
        e = 0.5 * float(self.m @ (v * v).sum(axis=1)) - float(self.m @ (x @ self.g)) + y[-1]
        for i, j, k, _, l0 in self.springs:
            e += 0.5 * k * (self.link(x, v, i, j)[1] - l0) ** 2
        for n in active:
            e += 0.5 * self.contacts[n][3] * self.gap(x, v, self.contacts[n])[1] ** 2
        return e

    def momenta(self, y):
        """Momentum and angular momentum about the origin."""
        x, v = self.split(y)
        p = self.m[:, None] * v
        return np.concatenate([p.sum(axis=0), np.cross(x, p).sum(axis=0)])


def flow(scene, t0, t1, y, active, fine, events=None):
    """From t0 to t1, or to the first event, with a fixed set of contacts."""
    got = solve_ivp(
        lambda _, y: scene.slope(y, active),
        (t0, t1),
        y,
        method="DOP853",
        rtol=fine[0],
        atol=1e-15,
        max_step=fine[1],
        events=events,
    )
    assert got.success, got.message
    return got.t[-1], got.y[:, -1], got.status == 1


def run(case, fine=FINE):
    """Kept positions, contacts, and the largest misses: of the energy, over the kinetic energy at the start, and of
    each component of momentum and angular momentum, over the largest of them."""
    scene = Scene(case)
    y = np.concatenate([np.ravel(case["x0"]), np.ravel(case["v0"]), [0.0]])
    gap = lambda y, n: scene.gap(*scene.split(y), scene.contacts[n])
    active = [n for n in range(len(scene.contacts)) if gap(y, n)[1] < 0.0]
    assert not active, "a case starts free"
    start = {}
    kept, contacts, energies, momenta = [], [], [scene.energy(y, active)], [scene.momenta(y)]
    t = 0.0
    for row in range(1, round(case["seconds"] * PER_SECOND) + 1):
        end = row / PER_SECOND
        while t < end:
            # each contact may only cross towards its other side, so that the one just crossed does not fire again
            events = []
            for n in range(len(scene.contacts)):
                event = lambda _, y, n=n: gap(y, n)[1]
                event.terminal, event.direction = True, 1.0 if n in active else -1.0
                events.append(event)
            at, found, crossed = flow(scene, t, end, y, active, fine, events)
            if not crossed:
                t, y = at, found
                continue
            n = min(range(len(events)), key=lambda n: abs(gap(found, n)[1]))
            for _ in range(4):
                # the event comes from an interpolant; put the instant where the flow itself crosses
                _, found, _ = flow(scene, t, at, y, active, fine)
                _, g, rate, _ = gap(found, n)
                at -= g / rate
            _, y, _ = flow(scene, t, at, y, active, fine)
            t = at
            assert t < end, "a switch on a kept instant: move the case"
            energies.append(scene.energy(y, active))
            if n in active:
                active.remove(n)
                contacts.append([n, start.pop(n), t])
            else:
                active.append(n)
                start[n] = t
        kept.append(y[: 3 * scene.n].copy())
        energies.append(scene.energy(y, active))
        momenta.append(scene.momenta(y))
    assert not start, "the run ends within a contact"
    drift = np.abs(np.array(energies) - energies[0]).max()
    turn = np.abs(np.array(momenta) - momenta[0]).max(axis=0) / np.abs(momenta[0]).max()
    return np.array(kept), contacts, drift / kinetic(case), turn


def kinetic(case):
    """Kinetic energy at the start [J]."""
    return 0.5 * sum(m * sum(c * c for c in v) for m, v in zip(case["m"], case["v0"]))


def tetrahedron(edge, turn, centre, velocity, omega):
    """Corners and velocities of a regular tetrahedron turned by the rotation vector `turn`."""
    x = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * edge / math.sqrt(8.0)
    turn = np.array(turn)
    a = math.sqrt(turn @ turn)
    n = turn / a
    x = x * math.cos(a) + np.cross(n, x) * math.sin(a) + np.outer(x @ n, n) * (1.0 - math.cos(a))
    v = np.array(velocity) + np.cross(omega, x)
    # twelve decimals: what the file says is what was integrated
    return np.round(x + centre, 12).tolist(), np.round(v, 12).tolist()


def case(ident, seconds, blows, m, x0, v0, gravity=(0.0, 0.0, 0.0), springs=(), outside=(), inside=(), plane=()):
    return {
        "id": ident,
        "seconds": seconds,
        "blows": blows,
        "per_second": PER_SECOND,
        "m": m,
        "gravity": list(gravity),
        "springs": list(springs),
        "outside": list(outside),
        "inside": list(inside),
        "plane": list(plane),
        "x0": x0,
        "v0": v0,
    }


def shift(drop, stride):
    """A time below a tick at 12 kHz [s], for the drop-th of several similar blows.

    Where its switches fall between two ticks decides the error of a sampled contact. As DROPS is a prime, the shifts
    lie evenly over the tick at 12 kHz and over that of every rate made from it by doubling; another stride gives them
    in another order, for what is to vary by itself.
    """
    return drop * stride % DROPS / DROPS / 12000.0


def later(drop, speed):
    """How much farther off to start [m], for a blow at `speed` [m/s] that comes later by a shift."""
    return shift(drop, 1) * speed


def softer(drop, stride, k, lasts):
    """A stiffness near k [N/m], for a blow of about `lasts` seconds that lasts longer by a shift."""
    return round(k * (1.0 + shift(drop, stride) / lasts) ** -2, 9)


def pairs(k, z, l0):
    return [[i, j, k, z, l0] for i in range(4) for j in range(i + 1, 4)]


def cases():
    # an elastic pendulum, pushed out of the plane in which it hangs
    yield case(
        "pendulum", 1.0, 0, [0.01], [[0.12, 0.0, -0.18]], [[0.0, 0.9, 0.1]], G, springs=[[-1, 0, 40.0, 0.0, 0.2]]
    )
    # a tetrahedron that turns about 5 times a second about no axis of its own, from its unstretched shape
    for name, z in [("tetrahedron", 0.0), ("tetrahedron_damped", 0.01)]:
        omega = 2.0 * math.pi * np.array([3.0, -2.0, 3.5])
        x0, v0 = tetrahedron(0.02, [0.3, 0.5, -0.2], [0.0, 0.0, 0.0], [0.3, -0.2, 0.1], omega)
        yield case(name, 0.5, 0, [1e-3] * 4, x0, v0, springs=pairs(200.0, z, 0.02))
    # a tumbling pyramid that falls on a plane and bounces once, on one corner
    for name, z, zc in [("pyramid", 0.0, 0.0), ("pyramid_damped", 0.01, 0.05)]:
        for drop in range(DROPS):
            height = 0.03 + later(drop, 0.977)
            x0, v0 = tetrahedron(0.02, TURN, [0.0, 0.0, height], [0.1, 0.05, -0.7], SPIN)
            yield case(
                f"{name}_{drop}",
                0.125,
                1,
                [1e-3] * 4,
                x0,
                v0,
                G,
                springs=pairs(500.0, z, 0.02),
                plane=[[i, softer(drop, 5, 500.0, 9.2e-3), zc] for i in range(4)],
            )
    # a ball between a core and a shell, both about the origin: one glancing blow on each
    for drop in range(DROPS):
        away = 0.02 + later(drop, 0.887)
        yield case(
            f"rattle_{drop}",
            0.075,
            2,
            [1e-3],
            [[round(away, 12), 0.003, -0.004]],
            [[-0.9, 0.1, 0.2]],
            outside=[[-1, 0, softer(drop, 5, 500.0, 4.3e-3), 0.0, 0.01]],
            inside=[[-1, 0, softer(drop, 7, 800.0, 3.5e-3), 0.0, 0.035]],
        )


DROPS = 17
TURN = [0.2, 1.1, -0.2]
SPIN = 2.0 * math.pi * np.array([1.5, -1.0, 2.0])


def text(done):
    """One line per case and per kept instant, in metres to fifteen decimals."""
    blocks = []
    for c in done:
        head = ", ".join(f"{json.dumps(k)}: {json.dumps(v)}" for k, v in c.items() if k != "x")
        rows = ",\n".join("[" + ", ".join(f"{v:.15f}" for v in row) + "]" for row in c["x"])
        blocks.append(f'{{{head}, "x": [\n{rows}]}}')
    return '{"made_by": "reference.py", "cases": [\n' + ",\n".join(blocks) + "\n]}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with reference.json instead of writing it")
    check = parser.parse_args().check
    path = HERE / "reference.json"
    old = {c["id"]: c for c in json.loads(path.read_text())["cases"]} if check else {}
    done, worst = [], 0.0
    print(f"{'case':<22} {'energy':>9} {'momentum':>9} {'coarser':>9}  contacts [ms]")
    for c in cases():
        x, contacts, energy, turn = run(c)
        coarse = np.abs(run(c, COARSE)[0] - x).max()
        # momentum is kept where nothing holds and nothing falls
        free = not (any(c["gravity"]) or any(-1 in s[:2] for s in c["springs"] + c["outside"] + c["inside"]))
        momentum = f"{turn.max():9.1e}" if free else f"{'-':>9}"
        shown = " ".join(f"{n}: {1e3 * a:.4f}-{1e3 * b:.4f}" for n, a, b in contacts)
        print(f"{c['id']:<22} {energy:9.1e} {momentum} {coarse:9.1e}  {shown}")
        assert energy < 1e-11, "energy, with heat, over the kinetic energy at the start"
        assert not free or turn.max() < 1e-11, "momentum and angular momentum"
        assert coarse < 1e-10, "position [m] beside a coarser integration"
        blows = len({n for n, _, _ in contacts})
        assert blows == len(contacts) == c["blows"], "each corner or wall is struck once at most, as the case says"
        c["contacts"], c["x"] = contacts, x.tolist()
        done.append(c)
        if check:
            worst = max(worst, np.abs(x - np.array(old[c["id"]]["x"])).max())
    if check:
        assert list(old) == [c["id"] for c in done]
        print(f"largest difference from {path.name}: {worst:.1e} m")
        assert worst < 1e-9
    else:
        path.write_text(text(done))


if __name__ == "__main__":
    main()
