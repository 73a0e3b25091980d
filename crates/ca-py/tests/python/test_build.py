"""Building models by calls, and findings about wrong ones."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import cordis_anima as ca
from conftest import KEY


def built() -> ca.Model:
    return (
        ca.Model("A key")
        .param("grip", "2 kN/m", live=True, min="100 N/m", max="9 kN/m", doc="how hard it holds")
        .add("TGR", "key", device="tgr12", dof=0, x="-6 mm")
        .add("ENX", "hand")
        .add("ENF", "push", to="low[20]")
        .add("STRING", "low", n=40, f="110 Hz", t60="4 s", m="1 g")
        .add("BUT", "strike", between=["key", "low[8]"], k="grip", z="0.2 N s/m")
        .add("REF", "hold", between=("hand", "low[30]"), k="50 N/m", z=np.float64(0.01))
        .add("SOX", "left", from_="low[3]", gain=np.int64(100))
        .add("SOX", "right", from_="low@0.7", gain=100)
    )


def test_calls_write_what_an_author_writes(tmp_path: Path) -> None:
    written = ca.Model.parse(KEY.replace('z = "0.01 N s/m"', "z = 0.01"))
    assert built() == written
    assert ca.Model.parse(built().to_toml()) == written
    built().save(tmp_path / "key.ca.toml")
    assert ca.Model.load(tmp_path / "key.ca.toml") == written
    assert built().set("low.m", "2 g") != written
    again = pickle.loads(pickle.dumps(built()))
    assert again == built() == copy.copy(built()) == copy.deepcopy(built())
    assert again.items[0] == ("TGR", "key")
    with pytest.raises(TypeError):
        hash(built())


def test_groups_spaces_gestures() -> None:
    m = (
        ca.Model("A room", seconds=0.2)
        .group("room", dim=3, gravity="9.81 m/s^2")
        .add("MAS", "room.ball", m="10 g", x=[0, 0, "1 m"])
        .add("SOL", "room.floor", x=[0, 0, 0])
        .add("RES", "room.thread", between=["room.floor", "room.ball"], k="100 N/m")
        .add("SOX", "out", from_="room.ball", along="z")
    )
    scene = m.compile()
    assert scene.n_mat == 2
    # the group may be added later
    late = ca.Model("A room", seconds=0.2).add("MAS", "room.ball", m="10 g", x=[0, 0, "1 m"])
    late.add("SOL", "room.floor", x=[0, 0, 0]).add("RES", "room.thread", between=["room.floor", "room.ball"], k="100 N/m")
    late.add("SOX", "out", from_="room.ball", along="z").group("room", dim=3, gravity="9.81 m/s^2")
    assert late == m and late.compile() == scene and late.compile().render().audio.any()
    with pytest.raises(ca.UsageError, match="already"):
        late.group("room", dim=2)
    r = scene.render()
    assert r.audio.shape == (9600, 1)
    assert ca.Model.parse(m.to_toml()).compile().render().audio.tobytes() == r.audio.tobytes()


def test_values_are_set_as_they_are(tmp_path: Path) -> None:
    m = built().set("hold.between", ["hand", "low[10]"]).set("low.n", np.int64(50)).set("hold.k", "60 N/m").set("grip", "3 kN/m")
    text = m.to_toml()
    assert '"low[10]"' in text and "n = 50" in text and '"60 N/m"' in text
    assert m.compile().params["grip"].value == 3000
    # files are read when they are needed
    (tmp_path / "body.csv").write_text("x,y,z\n0,0,0\n0.01,0,0\n0,0.01,0\n0,0,0.01\n")
    body = ca.Model().group("room", dim=3)
    body.add("CLOUD", "room.c", file=str(tmp_path / "body.csv"), m="1 g", k="1 kN/m", reach="2 cm")
    body.add("SOX", "out", from_="room.c[0]", along="x")
    scene = body.compile()
    assert scene.n_mat == 4
    # and are part of a pickle
    data = pickle.dumps(scene)
    (tmp_path / "body.csv").unlink()
    assert pickle.loads(data).n_mat == 4 and pickle.loads(data).hash == scene.hash


def test_what_has_errors_has_no_bytes() -> None:
    wrong = ca.Model.parse("[MAS]\nbob = { m = 1, dxo = 3 }\n[SOX]\nout = { from = 'bob' }\n")
    with pytest.raises(ca.ModelError):
        pickle.dumps(wrong)
    assert wrong == wrong and wrong != wrong.copy()
    # findings of a pickled model have no place in a file
    good = ca.Model.parse("# one\n# two\n[MAS]\nbob = { m = 1, v = 1 }\n[SOX]\nout = { from = 'bob' }\nunused = 1\n", "x.ca.toml")
    assert not good.check()
    warned = ca.parse("[MAS]\nbob = { m = 1, v = 1 }\nidle = { m = 1 }\n[SOX]\nout = { from = 'bob' }\n", file="x.ca.toml")
    assert warned.diagnostics and warned.diagnostics[0].file == "x.ca.toml"
    assert pickle.loads(pickle.dumps(warned)).diagnostics[0].file == ""


def test_all_kinds_are_known() -> None:
    kinds = ca.kinds()
    assert {"MAS", "REF", "STRING", "LPR", "WAVEGUIDE", "TGR"} <= set(kinds)
    assert {k.family for k in kinds.values()} == {"MAT", "LIA", "port", "generator"}
    assert ("k", "N/m", "stiffness") in kinds["RES"].params


def test_models_of_others() -> None:
    text = "@g ground 0.\n@m1 mass 1. 0. 0.1\n@s spring @m1 @g 0.01 0.0001\n@out posOutput @m1\n"
    scene = ca.Model.from_mims(text).compile()
    assert np.abs(scene.render(0.1).audio).max() > 0
    with pytest.raises(ca.ModelError):
        ca.Model.from_mims("@m1 mass\n").compile()


def test_findings_are_exceptions() -> None:
    text = "[MAS]\nbob = { m = '20 gr', mm = 3 }\n[SOX]\nout = { from = 'bop' }\n"
    with pytest.raises(ca.ModelError) as e:
        ca.parse(text, file="bob.ca.toml")
    found = e.value
    assert [d.code for d in found.diagnostics] == ["E007", "E004", "E013"]
    assert (found.code, found.location) == ("E007", "bob.ca.toml:2:17")
    assert "did you mean `bob`?" in str(found) and "bob.ca.toml:2" in str(found)
    assert isinstance(found, ca.CaError) and isinstance(found, ValueError)
    again = pickle.loads(pickle.dumps(found))
    assert again.diagnostics == found.diagnostics and str(again) == str(found)
    check = ca.Model.parse(text).check()
    assert not check and len(check.diagnostics) == 3
    # a built model has no text, so its findings have no line
    with pytest.raises(ca.ModelError) as e:
        ca.Model().add("MAS", "bob", m=-1).compile()
    assert e.value.diagnostics[0].line is None


def test_what_makes_no_sense_is_refused() -> None:
    for wrong in [
        lambda: ca.load("hamered_string"),
        lambda: ca.load("hammered_string", {"hamer.m": 1}),
        lambda: ca.Model().put("modle", "title", "x"),
        lambda: ca.Model().put("rate", "sond", 96000),
        lambda: ca.Model().put("model", "titel", "x"),
        lambda: ca.Scene(ca.Model()),
        lambda: ca.load("hammered_string").render(0.1, on_unstable="rasie"),  # type: ignore[arg-type]
        lambda: ca.load("hammered_string").render(0.1, gesture=[1, 2]),  # type: ignore[arg-type]
        lambda: ca.load("hammered_string").accuracy(1e12),
        lambda: ca.load("hammered_string").accuracy(float("inf")),
        lambda: ca.load("hammered_string").accuracy(float("nan")),
        lambda: ca.load("hammered_string").accuracy(-1),
        lambda: ca.load("hammered_string").accuracy(0.1, times=[-1]),
        lambda: ca.load("hammered_string").accuracy(0.1, reference=-4),
        lambda: ca.load("hammered_string").render(-1),
        lambda: ca.load("hammered_string").render(float("nan")),
        lambda: ca.load("hammered_string").render(1e8),
        lambda: ca.load("hammered_string").render(0.1, gesture={"key": np.zeros((3, 3))}),
        lambda: ca.load("hammered_string").accuracy(times=[]),
    ]:
        with pytest.raises(ca.UsageError):
            wrong()  # type: ignore[no-untyped-call]
    with pytest.raises(ca.UsageError, match="did you mean `hammered_string`"):
        ca.load("hamered_string")
    with pytest.raises(ca.ModelError, match="nothing"):
        ca.load("hammered_string").render(0.1, probes="nothing")
    with pytest.raises(AttributeError):
        ca.examples.nothing
    with pytest.raises(ca.UsageError):
        ca.Model().add("MAS", "bob", m=object())


def test_what_is_added_is_looked_at_at_once() -> None:
    m = ca.Model().group("hall", dim=3).param("felt", 1).add("MAS", "bob", m="1 g").add("MAS", "hall.ball", m=1)
    before = m.to_toml()
    for wrong, what in [
        (lambda: m.add("MSA", "other"), "unknown kind `MSA`; did you mean `MAS`"),
        (lambda: m.add("Nothing of the kind", "other"), "`kinds\\(\\)` lists all kinds"),
        (lambda: m.add("MAS", "other", dxo=1), "no parameter `dxo`; did you mean `dx0`"),
        (lambda: m.add("MAS", "other", colour=1), "it has m, "),
        (lambda: m.add("SOL", "bob"), "`bob` is already a `MAS` module"),
        (lambda: m.add("SOL", "hall.ball"), "`hall.ball` is already a `MAS` module"),
        (lambda: m.add("SOL", "hall"), "`hall` is already a group"),
        (lambda: m.add("SOL", "felt"), "`felt` is already a parameter"),
        (lambda: m.group("hall"), "all of its properties in one call"),
        (lambda: m.group("bob"), "`bob` is already a `MAS` module"),
        (lambda: m.param("bob", 1), "`bob` is already a `MAS` module"),
    ]:
        with pytest.raises(ca.UsageError, match=what):
            wrong()
    assert m.to_toml() == before, "nothing of it was added"
    # a refused name stays free, in this model and in copies
    for model in (m, m.copy(), pickle.loads(pickle.dumps(m.copy().add("SOX", "ear", from_="bob")))):
        model.add("SOL", "other")
        with pytest.raises(ca.UsageError, match="`other` is already a `SOL` module"):
            model.add("SOL", "other")
    # a parameter may be replaced by name
    assert "felt = 2" in m.param("felt", 2).to_toml()
    # names of a loaded model are in use too
    with pytest.raises(ca.UsageError, match="`hammer` is already a "):
        ca.Model.load("hammered_string").add("SOL", "hammer")


@pytest.mark.parametrize("name", ["é", "a b", "1st", "", "a.", ".a", "low[3]", "a-b", "ﬁ"])
def test_a_name_is_what_selectors_can_say(name: str) -> None:
    m = ca.Model()
    for wrong in [
        lambda: m.add("MAS", name, m=1),
        lambda: m.group(name, dim=3),
        lambda: m.param(name, 1),
        lambda: m.gesture(name, [[0, 0]]),
    ]:
        with pytest.raises(ca.UsageError, match="is not a valid name"):
            wrong()
    assert m.items == () and m == ca.Model()


def test_what_is_no_value_is_said_by_its_name() -> None:
    for wrong, name in [
        (lambda: ca.Model().add("MAS", "bob", m=None), "bob.m"),
        (lambda: ca.Model().add("SOX", "out", from_=None), "out.from"),
        (lambda: ca.Model().add("RES", "r", between=["a", None]), "r.between"),
        (lambda: ca.Model().add("MAS", "bob", m=1 + 2j), "bob.m"),
        (lambda: ca.Model().add("MAS", "bob", m=np.array([1j])), "bob.m"),
        (lambda: ca.Model().add("MAS", "bob", m=b"1 g"), "bob.m"),
        (lambda: ca.Model().add("MAS", "bob", m=10**400), "bob.m"),
        (lambda: ca.Model().group("hall", gravity=None), "hall.gravity"),
        (lambda: ca.Model().param("k", None), "k"),
        (lambda: ca.Model().param("k", 1, max=None), "k"),
        (lambda: ca.Model().gesture("k", [[0, None]]), "k"),
        (lambda: ca.Model().put("model", "title", None), "title"),
        (lambda: built().set("low.m", None), "low.m"),
        (lambda: built().compile().replace({"low.m": None}), "low.m"),
        (lambda: ca.load("hammered_string", {"hammer.m": None}), "hammer.m"),
    ]:
        with pytest.raises(ca.UsageError, match=f"^`{name}` cannot be") as e:
            wrong()
        assert "Given" not in str(e.value) and "extract" not in str(e.value)
    with pytest.raises(ca.UsageError, match="leave it out"):
        ca.Model().add("MAS", "bob", m=None)


def test_times_and_rates_are_quantities_too() -> None:
    string = ca.examples.string()
    assert string.render("100 ms").audio.tobytes() == string.render(0.1).audio.tobytes()
    assert string.render("0.1").audio.shape == (4800, 1)
    assert ca.load("hammered_string", rate="96 kHz").rate == 96000 and string.replace(rate="44.1 kHz").sr == 44100
    assert "seconds = 2" in ca.Model(seconds="2 s").to_toml()
    assert ca.sweep(string, {"low.m": ["1 g"]}, seconds="10 ms")["frames"][0] == 480
    for wrong, what in [
        (lambda: string.render("1 m"), r'seconds = "1 m": it is not in s; write a number, or "1.5 s"'),
        (lambda: string.render("a while"), r'seconds = "a while": .*write a number, or "1.5 s"'),
        (lambda: string.render("1 sec"), "did you mean `s`"),
        (lambda: string.render("-1 s"), "above 0"),
        (lambda: string.render([1]), "write a number"),
        (lambda: string.render(1j), "write a number"),
        (lambda: ca.load("hammered_string", rate="48"  " kg"), "not in Hz"),
        (lambda: string.accuracy("1 kg"), "not in s"),
        (lambda: ca.Model(seconds="long"), "write a number"),
    ]:
        with pytest.raises(ca.UsageError, match=what):
            wrong()
