"""What is measured of a scene, as plain records of numbers and arrays."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import UsageError

Floats = npt.NDArray[np.float64]
#: sound: float32, unless float64 was asked for
Sound = npt.NDArray[np.floating[Any]]
#: how samples are kept: ``"float32"``, ``"float64"`` or the types of NumPy
DType = npt.DTypeLike
Status = Literal["ok", "clipped", "unstable", "refused", "mute", "gained"]


class Param(NamedTuple):
    """A live parameter: one that may change while a scene runs."""

    #: its name
    name: str
    #: its value at load, in SI units
    value: float
    #: least value, in SI units
    min: float
    #: greatest value, in SI units
    max: float
    #: its unit; empty for a plain number
    unit: str
    #: one line for people
    doc: str


class Port(NamedTuple):
    """A port that a gesture can drive."""

    #: its name
    name: str
    #: ``position`` [m], ``force`` [N] or ``device`` [m], a key of a device
    role: str
    #: its value before anybody moves it [m] or [N]
    rest: float


class Certificate(NamedTuple):
    """What is proven of a scene's stability before anything moves."""

    #: ``proven``, ``linearised``, ``rule of thumb``, ``not proven`` or ``unstable``
    level: str
    #: upper bound of the largest eigenvalue of T²K + 2TC against M; the limit is 4
    bound: float
    #: lower bound of the same
    lower: float
    #: how many times stiffer everything could be
    margin: float
    #: whether a factorisation decided
    exact: bool
    #: the largest eigenvalue, from … to, where ``exact=True`` asked for it
    largest: tuple[float, float] | None
    #: share by which energy may rise in a linearised scene
    ripple: float | None
    #: the module nearest to the limit; empty where nothing has one
    worst: str
    #: largest kT²/m of an explicit contact; a rule of thumb keeps it below 1, and no value is without growth
    contact: float
    #: the contact it belongs to
    stiffest: str
    #: of contacts by a power of their depth, the one whose slope·T²/m reaches 1 first, and the depth [m] at which it does
    depth: tuple[str, float] | None
    #: steepest friction against the masses, slope·T/m; above 1.5 what should stick rings
    friction: float
    #: largest T²k/m + 2Tz/m of a contact while it presses; from 4 on it is unstable by itself
    closed: float
    #: the link that decides where the level is ``rule of thumb``; else empty
    decides: str
    #: hardening links with an unknown largest elongation: judged at rest
    open: list[str]
    #: items with masses that nothing hears: they are left out, and nothing is said of them
    not_judged: list[str]


class Energy(NamedTuple):
    """The energy ledger [J]: ``stored = start + work − lost + made + changed + residual``."""

    #: energy at load
    start: float
    #: energy at the end
    stored: float
    #: its part in motion
    kinetic: float
    #: heat
    lost: float
    #: error of the scheme in non-linear links; 0 where all is linear
    made: float
    #: received from ports
    work: float
    #: received by changes of parameters
    changed: float
    #: residual, what the ledger does not explain: rounding
    residual: float
    #: the scale of the residual
    peak: float
    #: how much time the ledger covers [s]; less than the render where it diverged
    seconds: float
    #: heat of each link
    lost_by: Mapping[str, float]
    #: error of the scheme at each link
    made_by: Mapping[str, float]
    #: work received from each port
    work_by: Mapping[str, float]


def energy(raw: Mapping[str, Any]) -> Energy:
    """An energy ledger from what the engine says."""
    plain: dict[str, Any] = {k: dict(v) if k.endswith("_by") else v for k, v in raw.items()}
    return Energy(**plain)


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of the linear part of a scene; arrays over modes, lowest first."""

    #: frequency without the scheme [Hz]; 0 where it does not swing
    f: Floats
    #: frequency as it is heard [Hz]
    heard: Floats
    #: how far the scheme moves the pitch [cents]
    cents: Floats
    #: time to fall by 60 dB [s]; infinite without damping
    t60: Floats
    #: whether the scheme makes it grow
    grows: npt.NDArray[np.bool_]
    #: displacement of each place (modes, places) [1/√kg]
    shapes: Floats
    #: how much each mode moves each port (modes, ports) [1/√kg]
    levels: Floats
    #: names of the ports
    ports: tuple[str, ...]
    #: names of the places
    places: tuple[str, ...]
    #: links that are not linear, and so not part of it
    left_out: tuple[str, ...]
    #: whether damping that couples modes was left out
    approximate: bool
    _derivative: Callable[[Sequence[str]], ModeDerivatives] = field(repr=False)

    def derivative(self, wrt: Sequence[str]) -> ModeDerivatives:
        """How frequencies and decays change with parameters, by the derivatives of the poles of the tick. Needs SciPy.

        Args:
            wrt: names as for `Scene.tangents`.

        Raises:
            UsageError: as `Scene.tangents`; also where a part of the scene is not computed by masses and springs.

        >>> import cordis_anima as ca
        >>> m = ca.examples.string().modes()
        >>> d = m.derivative(["low.f", "low.t60"])
        >>> d.heard.shape == (len(m), 2), bool(abs(d.heard[1, 0] - 1) < 1e-3)
        (True, True)
        """
        return self._derivative(wrt)

    def __len__(self) -> int:
        return len(self.f)

    def __repr__(self) -> str:
        first = ", ".join(f"{f:.2f}" for f in self.heard[:4])
        return f"<Modes: {len(self)}, heard at {first}{' …' if len(self) > 4 else ''} Hz>"


@dataclass(frozen=True, eq=False)
class ModeDerivatives:
    """How modes change with parameters: arrays (modes, parameters), per unit of the parameter.

    Not a number where a mode does not swing, or has the frequency and decay of another one.
    """

    #: of the frequency as it is heard [Hz]
    heard: Floats
    #: of the time to fall by 60 dB [s]; 0 of a mode that does not decay
    t60: Floats
    #: names of the parameters
    wrt: tuple[str, ...]
    #: their values
    values: Floats
    #: their units, of SI; empty for plain numbers
    units: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<ModeDerivatives of {len(self.heard)} modes by {', '.join(self.wrt)}>"


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Error against run time; arrays over ways to compute the scene."""

    #: name of the method
    method: tuple[str, ...]
    #: multiple of the sound rate
    times: npt.NDArray[np.uint32]
    #: ‖x − reference‖ / ‖reference‖ of the worst probe
    error: Floats
    #: the same of the spectrum
    spectrum: Floats
    #: pitch error [cents]; NaN of silence
    cents: Floats
    #: how much more the second half is than it should be [dB]
    decay: Floats
    #: energy made, as a share of what there was; NaN where no ledger is kept
    made: Floats
    #: time of one sample on this machine [ns]
    ns: Floats
    #: what is certified
    stability: tuple[str, ...]
    #: whether nothing is both more exact and quicker
    front: npt.NDArray[np.bool_]
    #: sound rate [Hz]
    rate: float
    #: how long it was played [s]
    seconds: float
    #: the error of the reference itself
    known: float
    #: what the reference is, in words
    against: str
    #: methods the scene cannot take, and why
    refused: tuple[tuple[str, str], ...]

    def __len__(self) -> int:
        return len(self.method)

    def __repr__(self) -> str:
        return f"<Accuracy: {len(self)} ways, {self.seconds:g} s at {self.rate:g} Hz against {self.against}>"

    def cheapest(self, error: float) -> tuple[str, int] | None:
        """The quickest method and multiple of the rate with at most this error; ``None`` where there is none.

        There is none either where the reference is not known as well as that: a higher ``reference`` is.
        """
        good = [k for k in range(len(self)) if self.error[k] <= error and self.stability[k] != "unstable"]
        if self.known > error or not good:
            return None
        best = min(good, key=lambda k: float(self.ns[k]))
        return self.method[best], int(self.times[best])


def plain(value: object) -> Any:
    """Numbers of NumPy, tuples and the like as the engine takes them."""
    # numbers of NumPy are floats too, and not the same to a hash
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (bool, float, int, str)):
        return value
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    return value


def value(name: str, given: object) -> Any:
    """A value that a model can have.

    Raises:
        UsageError: it is none, anywhere in it.
    """
    return _value(name, plain(given))


def _value(name: str, given: Any) -> Any:
    if isinstance(given, (bool, float, str)):
        return given
    if isinstance(given, int):
        try:
            return float(given)
        except OverflowError:
            raise UsageError(f"`{name}` cannot be {given}: it is too large for a number") from None
    if isinstance(given, list):
        return [_value(name, v) for v in given]
    if isinstance(given, dict):
        return {k: _value(name, v) for k, v in given.items()}
    hint = "; leave it out where nothing is meant" if given is None else ""
    raise UsageError(f"`{name}` cannot be {given!r}: numbers, quantities, names and lists are values{hint}")


def number(name: str, given: object, unit: str) -> float:
    """A number in `unit`, which may be none, or a quantity as text, e.g. ``"1.5 s"``.

    Raises:
        UsageError: it is neither.
    """
    if isinstance(given, str):
        return _core.quantity(name, given, unit)
    try:
        return float(given)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        quantity = f', or "1.5 {unit}"' if unit else ""
        raise UsageError(f"{name} = {given!r}: write a number{quantity}") from None


def whole(name: str, value: object, low: int, high: int) -> int:
    """A whole number, of Python, NumPy or whoever has some."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise UsageError(f"{name} = {value!r}: a whole number is wanted") from None
    if not low <= number <= high:
        raise UsageError(f"{name} = {number}: {low} to {high}")
    return number


#: more channels than these in fewer frames than channels are a sound that lies on its side
_CHANNELS = 64


def transposed(sound: Floats) -> None:
    """Refuses a sound (channels, frames), as others have it.

    Raises:
        UsageError: it has more channels than a sound can have, and fewer frames.
    """
    if sound.ndim == 2 and sound.shape[1] > max(_CHANNELS, sound.shape[0]):
        frames, channels = sound.shape
        what = f"has the shape {sound.shape}, which is {frames} frames of {channels} channels"
        raise UsageError(f"the sound {what}: it is (frames, channels); transpose it, `.T`")


def is_double(dtype: DType) -> bool:
    """Whether samples are kept in double precision.

    Raises:
        UsageError: they are kept as something else.
    """
    try:
        asked = np.dtype(dtype)
    except TypeError:
        asked = np.dtype(object)
    if dtype is None or asked not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise UsageError(f'dtype = {dtype!r}: "float32" or "float64"')
    return asked == np.dtype(np.float64)


def length(given: object) -> float:
    """How long something is played [s]."""
    seconds = number("seconds", given, "s")
    if not 0 < seconds < 1e9:
        raise UsageError(f"seconds = {given}: a length above 0, below 1e9")
    return seconds


def reals(name: str, given: object, *, dense: bool = False) -> Floats:
    """Real numbers as an array; `dense`, one behind the other.

    Raises:
        UsageError: it holds anything else, or its rows are of several lengths.
    """
    try:
        array = np.asarray(given)
    except ValueError:
        raise UsageError(f"`{name}` is no array: its rows are of several lengths") from None
    if array.dtype.kind not in "biuf":
        raise UsageError(f"`{name}` holds {_KINDS.get(array.dtype.kind, str(array.dtype))}: real numbers are wanted")
    made: Floats = np.require(array, np.float64, ["C", "A"] if dense else ["A"])
    return made


#: what arrays can hold that is no number
_KINDS = {"c": "complex numbers", "U": "text", "S": "bytes", "O": "something that is no number", "V": "records"}
