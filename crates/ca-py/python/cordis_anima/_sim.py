"""A running scene, controlled by the program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import UsageError
from ._probes import chosen, columns
from ._results import Energy, Floats, Sound, energy, number, reals

#: drives ports in a block: numbers or arrays (n,) by name, or an array (n, inputs) in the order of `Scene.inputs`
Inputs = Union[Mapping[str, "float | npt.ArrayLike"], npt.ArrayLike, None]


class Block(NamedTuple):
    """Result of a block."""

    #: sound (n, channels), within ±1
    audio: Sound
    #: force on each port with feedback, at each sample (n, ports) [N]; for a device port, the force of the last
    #: complete frame
    force: Floats

    @property
    def probes(self) -> Mapping[str, Floats]:
        """Probes of `open(probes=…)` by selector: (n,), or (n, columns) for several; positions [m], forces [N]."""
        return {}


class _Probed(Block):
    """A block of a scene that was opened with probes."""

    _heard: Mapping[str, Floats]

    @property
    def probes(self) -> Mapping[str, Floats]:
        return self._heard


@dataclass(frozen=True)
class Snapshot:
    """State of a running scene between two samples, see `Sim.state`. It can be pickled, compared and used as a key."""

    #: time in the scene [s]
    time: float
    #: complete state, including live parameters and the energy ledger
    data: bytes = field(repr=False)


class Live(MutableMapping[str, float]):
    """Live parameters of a running scene. Setting one ramps it to the value within a gesture frame."""

    def __init__(self, sim: Sim) -> None:
        self._sim = sim

    def __getitem__(self, name: str) -> float:
        if name not in self._sim._live:
            raise KeyError(name)
        return self._sim._core.get(name)

    def __setitem__(self, name: str, value: float) -> None:
        self._sim.set(name, value)

    def __delitem__(self, name: str) -> None:
        raise UsageError(f"`{name}` is a parameter of the scene; it cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter(self._sim._live)

    def __len__(self) -> int:
        return len(self._sim._live)

    def __repr__(self) -> str:
        return repr(dict(self))


class Sim:
    """A running scene: gestures in, sound and forces out, block by block.

    The sound does not depend on how it is cut into blocks, to the bit. It equals `Scene.render` if position and force
    ports get the same values at each sample. Two things differ on purpose: the built-in gestures of a model are not
    played, and a device port takes its input at the first sample of a gesture frame, while a render reads a gesture at
    the end of the frame. Threads that share a running scene wait for each other.

    >>> import cordis_anima as ca, numpy as np
    >>> scene = ca.examples.string()
    >>> with scene.open(block=100) as sim:
    ...     parts = [sim.step().audio for _ in range(48)]
    >>> whole = scene.render(0.1).audio
    >>> bool((np.concatenate(parts) == whole).all()), bool(whole.any())
    (True, True)
    """

    def __init__(self, core: _core.Scene, block: int, probes: Sequence[str] = (), double: bool = False) -> None:
        if block < 1:
            raise UsageError(f"block = {block}: must be at least 1 sample")
        about = core.about()
        #: sound rate [Hz]
        self.sr = round(about["rate"])
        self._rate = float(about["rate"])
        #: names of the sound channels
        self.channels: tuple[str, ...] = tuple(about["channels"])
        self._name = str(about["title"] or about["name"])
        self._frame = 1 / float(about["gesture_rate"])
        self._rest = np.array([[rest for _, _, rest in core.inputs]], dtype=np.float64)
        # names of live parameters, and their units
        self._live = {p[0]: p[4] for p in core.params}
        #: default number of samples in a block
        self.block = block
        self._core = core.sim()
        self._ports = tuple(self._core.ports)
        self._names = [name for name, _, _ in core.inputs]
        # current inputs; inputs that are not given keep their values
        self._held = self._rest.copy()
        #: live parameters
        self.params = Live(self)
        names, of = core.probes
        # the columns of each selector
        self._probes = columns(of, probes)
        self._columns = len(names)
        self._dtype = np.dtype(np.float64 if double else np.float32)

    @property
    def ports(self) -> tuple[str, ...]:
        """Ports that receive a force: the columns of `Block.force`."""
        return self._ports

    @property
    def time(self) -> float:
        """Time in the scene [s]."""
        return self._core.tick / self._rate

    @property
    def status(self) -> str:
        """Status of everything played: ``ok``, ``unstable``, ``clipped`` or ``refused``."""
        return self._core.status

    @property
    def energy(self) -> Energy | None:
        """The energy ledger, with `open(energy=True)`."""
        raw = self._core.energy()
        return None if raw is None else energy(raw)

    def set(self, name: str, value: float | str, *, over: float | str | None = None) -> None:
        """Ramps a live parameter to `value`, in SI units or as a quantity, within `over` seconds.

        Without `over` it takes a gesture frame.

        Raises:
            UsageError: if the parameter does not exist or the value is out of its range.
        """
        over = self._frame if over is None else number("over", over, "s")
        if not 0 <= over <= 3600:
            raise UsageError(f"over = {over}: must be 0 to 3600 seconds")
        self._core.set(name, number(f"`{name}`", value, self._live.get(name, "")), max(1, round(over * self._rate)))

    def step(
        self,
        inputs: Inputs = None,
        n: int | None = None,
        *,
        out: Sound | None = None,
        force: Floats | None = None,
    ) -> Block:
        """Plays the next samples.

        Args:
            inputs: drives ports: by name, a number for all samples or an array (n,); or an array (n, inputs) in the
                order of `Scene.inputs`. Ports that are not given keep their last value. Positions are absolute [m];
                inputs of device ports are read at the first sample of a gesture frame.
            n: number of samples; default: the length of `out` or `inputs`, or a block.
            out: float32 or float64 array (n, channels) for the sound; no new array is allocated then.
            force: float64 array (n, ports) for the forces, likewise.

        Raises:
            UsageError: if a port is unknown or an array has the wrong shape.
        """
        if out is not None:
            _writable("out", out, np.float32, np.float64)
        if force is not None:
            _writable("force", force, np.float64)
        if n is not None and n < 0:
            raise UsageError(f"n = {n}: must be at least 0 samples")
        given, n = self._given(inputs, n, out)
        audio = np.empty((n, len(self.channels)), dtype=self._dtype) if out is None else out
        forces = np.empty((n, len(self._ports)), dtype=np.float64) if force is None else force
        heard = np.empty((n, self._columns), dtype=np.float64) if self._probes else None
        self._core.step(given, audio, forces, heard)
        if len(given):
            # non-finite inputs are reported once; the last finite value stays
            last = given[-1:]
            self._held = np.where(np.isfinite(last), last, self._held)
        if heard is None:
            return Block(audio, forces)
        block = _Probed(audio, forces)
        block._heard = chosen(heard, self._probes)
        return block

    def _given(self, inputs: Inputs, n: int | None, out: Sound | None) -> tuple[Floats, int]:
        if n is None and out is not None:
            n = len(out)
        if inputs is None:
            return self._held, self.block if n is None else n
        if not isinstance(inputs, Mapping):
            rows = reals("inputs", inputs, dense=True)
            if rows.ndim != 2:
                raise UsageError(f"inputs have the shape {rows.shape}; use (n, {len(self._names)}), or give them by name")
            return rows, len(rows) if n is None else n
        curves: dict[int, Any] = {}
        for name, value in inputs.items():
            if name not in self._names:
                raise UsageError(f"no port `{name}`; this scene has {', '.join(self._names) or 'none'}")
            value = reals(name, value)
            if value.ndim > 1 or (value.ndim == 1 and n is not None and len(value) != n):
                raise UsageError(f"`{name}` has the shape {value.shape}; use a number, or one number per sample")
            if value.ndim == 1:
                n = len(value)
            curves[self._names.index(name)] = value
        n = self.block if n is None else n
        if all(v.ndim == 0 for v in curves.values()):
            rows = self._held.copy()
        else:
            rows = np.repeat(self._held, n, axis=0)
        for k, value in curves.items():
            rows[:, k] = value
        return rows, n

    def reset(self) -> None:
        """Returns to the beginning."""
        self._core.reset()
        self._held = self._rest.copy()

    def state(self) -> Snapshot:
        """Returns the state: positions, motion, memory of laws, inputs, ramps of live parameters, the energy ledger.

        >>> import cordis_anima as ca, numpy as np, pickle
        >>> scene = ca.load("hammered_string")
        >>> with scene.open(block=4800) as sim:
        ...     _ = sim.step({"key": 0.0})
        ...     struck = pickle.loads(pickle.dumps(sim.state()))
        ...     first = sim.step().audio
        ...     sim.restore(struck)
        ...     again = sim.step().audio
        >>> bool((first == again).all()), struck.time
        (True, 0.1)
        """
        return Snapshot(self.time, self._core.state())

    def restore(self, state: Snapshot) -> None:
        """Continues from a snapshot of the same scene, with the same results to the bit.

        The snapshot may come from another process or machine.

        Raises:
            UsageError: if the snapshot is damaged or of another scene (another model, values, rate, probes or
                ``energy``); nothing changes then.
        """
        if not isinstance(state, Snapshot):
            raise UsageError(f"a snapshot must come from `Sim.state()`, not {type(state).__name__}")
        self._core.restore(state.data)
        self._held = np.array([self._core.inputs], dtype=np.float64).reshape(self._rest.shape)

    def __iter__(self) -> Iterator[Block]:
        """Yields blocks without end, with the current inputs."""
        while True:
            yield self.step()

    def __enter__(self) -> Sim:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def __reduce__(self) -> Any:
        raise TypeError("a running scene cannot be pickled: pickle the scene it was opened from, and open that where it is needed")

    def __repr__(self) -> str:
        return f"<Sim of {self._name!r} at {self.time:.3f} s, {self.status}>"


def _writable(name: str, array: object, *dtypes: type[np.floating[Any]]) -> None:
    """Checks that samples can be written into an array one by one."""
    good = isinstance(array, np.ndarray) and array.ndim == 2 and array.dtype in dtypes
    good = good and array.flags.aligned and array.flags.writeable and array.dtype.isnative  # type: ignore[attr-defined]
    if good and array.size:  # type: ignore[attr-defined]
        (rows, columns), (down, along) = array.shape, array.strides  # type: ignore[attr-defined]
        item = array.itemsize  # type: ignore[attr-defined]
        apart = (columns == 1 or along >= item) and (rows == 1 or down >= (columns - 1) * abs(along) + item)
        good = apart and along % item == 0 and down % item == 0
    if not good:
        wanted = " or ".join(np.dtype(d).name for d in dtypes)
        raise UsageError(f"`{name}` must be a writable array (n, …) of {wanted}, in row-major order")
