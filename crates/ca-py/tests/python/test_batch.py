"""Many instances in one array, and sound in double precision."""

import numpy as np
import pytest

import cordis_anima as ca

STRING = ca.examples.string()


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("dtype", ["float32", "float64", np.float64])
def test_an_instance_has_the_bits_of_a_render(dtype, threads):
    values = {"low.f": [110, "150 Hz", 220.0, 331.5], "hammer.m": np.array([0.01, 0.02, 0.03, 0.02])}
    b = ca.batch(STRING, values, 0.05, probes=["low[8]", "low[*]"], dtype=dtype, threads=threads)
    assert b.audio.shape == (4, 2400, 1) and b.audio.dtype == np.dtype(dtype) and b.sr == 48000
    assert b.ok.all() and b.message == ("",) * 4 and b.failed == (None,) * 4
    for i in range(4):
        alone = STRING.replace({name: column[i] for name, column in values.items()})
        r = alone.render(0.05, probes=["low[8]", "low[*]"], dtype=dtype)
        assert r.audio.dtype == np.dtype(dtype) and r.audio.any()
        assert np.array_equal(b.audio[i], r.audio) and b.peak[i] == r.peak.max()
        for selector in ("low[8]", "low[*]"):
            assert np.array_equal(b.probes[selector][i], r.probes[selector].astype(dtype))


def test_double_precision_rounds_to_single():
    double, single = (STRING.render(0.2, dtype=d).audio for d in ("float64", "float32"))
    assert np.array_equal(double.astype(np.float32), single) and not np.array_equal(double, single)
    assert np.array_equal(double[:, 0], STRING.tangents(["hammer.v"], 0.2).audio[:, 0])
    with STRING.open(block=4800, dtype="float64") as sim:
        assert np.array_equal(sim.step().audio, double[:4800])
        out = np.empty((4800, 1), np.float32)
        assert sim.step(out=out).audio is out and np.array_equal(out, single[4800:9600])


def test_a_bad_instance_ends_nothing():
    bad = ca.parse(
        "[MAS]\na = { m = '1 g', v = '1 cm/s' }\n[RES]\nk = { between = ['a', 'o'], k = '100 N/m' }\n[SOL]\no = {}\n"
        "[SOX]\nout = { from = 'a', gain = 100 }\n"
    )
    b = ca.batch(bad, {"k.k": [100, 1e9, "nonsense", -5, 200]}, 0.02)
    assert b.status.tolist()[0] == b.status.tolist()[4] == "ok"
    assert b.status[1] == "unstable" and b.failed[1][0] < 0.02 and "diverged" in b.message[1]
    assert b.status[2] == "invalid" and b.message[2] and not b.audio[2].any()
    assert b.audio[0].any() and b.audio[4].any() and np.isfinite(b.audio).all()
    assert "2 ok" in repr(b) and len(b) == 5


def test_columns_and_gestures():
    key = ca.load("hammered_string")
    blow = {"key": [(0, -0.008), (0.02, 0)]}
    b = ca.batch(key, {"hammer.m": ["20 g", "30 g"]}, 0.1, gesture=blow)
    assert np.array_equal(b.audio[0], key.replace({"hammer.m": "20 g"}).render(0.1, gesture=blow).audio)
    assert len(ca.batch(STRING, {"low.f": []}, 0.1)) == 0
    done = []
    ca.batch(STRING, {"low.f": [110.0] * 7}, 0.01, progress=lambda n, of: done.append((n, of)))
    assert done[-1] == (7, 7)


def test_a_number_of_a_list_and_one_with_a_unit():
    glass = ca.load("glass")
    b = ca.batch(glass, {"rim.f[0]": [500.0, 523.25]}, 1.0)
    assert b.ok.all() and np.array_equal(b.audio[1], glass.render(1.0).audio) and not np.array_equal(b.audio[0], b.audio[1])
    stiff = ca.parse(
        "[param]\nstiff = { value = '3 kN/m', min = '1 kN/m', max = '9 kN/m' }\n[MAS]\na = { m = '1 g', v = 1 }\n[SOL]\no = {}\n"
        "[REF]\nk = { between = ['a', 'o'], k = 'stiff', z = 0 }\n[SOX]\nout = { from = 'a' }\n"
    )
    b = ca.batch(stiff, {"stiff": [3000.0, "4 kN/m", 4000.0]}, 0.05)
    assert b.ok.all() and np.array_equal(b.audio[0], stiff.render(0.05).audio) and np.array_equal(b.audio[1], b.audio[2])


@pytest.mark.parametrize(
    ("values", "options", "says"),
    [
        ({}, {}, "needs at least one parameter"),
        ([110], {}, "columns by name"),
        ({"low.f": [110], "hammer.m": [0.01, 0.02]}, {}, "has 2 values, but `low.f` has 1"),
        ({"low.f": 110}, {}, "one value per instance"),
        ({"low.f": "110 Hz"}, {}, "one value per instance"),
        ({"low.ff": [110]}, {}, "no parameter `ff`"),
        ({"low.f": [None]}, {}, "leave it out"),
        ({"rim.f[9]": [1.0]}, {}, "the model has no"),
        ({"rate.sound": [44100]}, {}, "one rate"),
        ({"model.seconds": [1.0, 2.0]}, {}, "equally long"),
        ({"low.f": [110]}, {"dtype": "int16"}, "float32"),
        ({"low.f": [110]}, {"dtype": None}, "float32"),
        ({"low.f": [110]}, {"dtype": "no such"}, "float32"),
        ({"low.f": [110]}, {"threads": 0}, "threads = 0"),
        ({"low.f": [110]}, {"gesture": {"nobody": 1.0}}, "is not a port or live parameter"),
        ({"low.f": [110.0] * 100_000}, {"seconds": 1e6}, "do not fit into memory"),
    ],
)
def test_what_makes_no_sense_is_refused(values, options, says):
    with pytest.raises(ca.UsageError, match=says):
        ca.batch(STRING, values, **{"seconds": 0.01, **options})


def test_what_is_too_loud_says_by_how_much():
    b = ca.batch(STRING, {"out.gain": [1e6, 1.0]}, 0.05)
    assert b.status.tolist() == ["clipped", "ok"] and b.peak.shape == (2,)
    above = float(b.message[0].partition("the loudest is ")[2].partition(" dB")[0])
    assert abs(above - 20 * np.log10(b.peak[0])) < 0.06 and "lower `gain`" in b.message[0]


def test_what_a_callback_raises_ends_it():
    def stop(done, of):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ca.batch(STRING, {"low.f": [110.0] * 1000}, 5.0, progress=stop)


def test_an_instance_on_a_channel_of_its_own_takes_none_of_another() -> None:
    two = ca.parse("[CEL]\na = { m = '1 g', f = 300, v = '1 cm/s' }\n[SOX]\nout = { from = 'a', gain = 9, channel = 0 }\n")
    b = ca.batch(two, {"out.channel": [0, 1, 0]}, 0.02, threads=1)
    assert b.status.tolist() == ["ok", "invalid", "ok"] and "2 channels and 0 probes" in b.message[1]
    assert np.array_equal(b.audio[0], two.render(0.02).audio) and np.array_equal(b.audio[2], b.audio[0])
    kalimba = ca.load("kalimba")
    b = ca.batch(kalimba, {"wood_left.gain": [14, 7]}, 1.0)
    assert np.array_equal(b.audio[0], kalimba.render(1.0).audio) and not np.array_equal(b.audio[1], b.audio[0])


SHARED = """
[CEL]
a = { m = "0.2 g", f = "220 Hz", t60 = "0.3 s" }
[ENX]
b = {}
c = {}
[BOW]
r = { between = ["a", ["b","c"]], f = "0.3 N", METHOD }
[SOX]
o = { from = "a", gain = 1000 }
[gesture]
b = [[0, 0], [1, "0.1 m"]]
c = [[0, 0], [1, "-0.05 m"]]
"""


@pytest.mark.parametrize("method", ['v0 = "20 mm/s", method = "newton"', 'v0 = "20 mm/s", method = "secant"', 'curve = "coulomb", method = "set-valued"'])
def test_contacts_that_are_solved_at_once_know_nothing_of_other_instances(method: str) -> None:
    scene = ca.parse(SHARED.replace("METHOD", method))
    values = [220.0, 221.0, 300.0, 222.0]
    b = ca.batch(scene, {"a.f": values}, 0.1, dtype="float64", threads=1)
    for row, f in zip(b.audio, values, strict=True):
        assert row.any() and np.array_equal(row, scene.replace({"a.f": f}).render(0.1, dtype="float64").audio)
