"""Records of measurements, and checks of arguments."""

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
#: sound: float32, or float64 on request
Sound = npt.NDArray[np.floating[Any]]
#: type of samples: ``"float32"``, ``"float64"`` or the NumPy types
DType = npt.DTypeLike
Status = Literal["ok", "clipped", "unstable", "refused", "mute", "gained"]


class Param(NamedTuple):
    """A live parameter, which may change while a scene runs."""

    name: str
    #: value at load, in SI units
    value: float
    #: smallest value, in SI units
    min: float
    #: largest value, in SI units
    max: float
    #: unit; empty for a plain number
    unit: str
    #: one line of documentation
    doc: str


class Port(NamedTuple):
    """A port that a gesture can drive."""

    name: str
    #: ``position`` [m], ``force`` [N] or ``device`` [m], a key of a device
    role: str
    #: value at rest [m] or [N]
    rest: float


class Certificate(NamedTuple):
    """Stability certificate of a scene, computed before it plays."""

    #: ``proven``, ``linear part proven``, ``rule of thumb``, ``not proven`` or ``unstable``
    level: str
    #: upper bound of the largest eigenvalue of T²K + 2TC against M; the limit is 4
    bound: float
    #: lower bound of that eigenvalue
    lower: float
    #: factor by which all stiffness could grow
    margin: float
    #: true if a factorisation decided
    exact: bool
    #: range of the largest eigenvalue, with ``exact=True``
    largest: tuple[float, float] | None
    #: largest relative rise of energy in a scene whose linear part is proven
    ripple: float | None
    #: module nearest to the limit; empty if there is none
    worst: str
    #: largest kT²/m of an explicit contact; a rule of thumb keeps it below 1, but any value may let energy grow
    contact: float
    #: contact with that value
    stiffest: str
    #: power-law contact whose slope·T²/m is the first to reach 1, and the depth [m] at which it does
    depth: tuple[str, float] | None
    #: steepest friction relative to the masses, slope·T/m; above 1.5 it oscillates instead of sticking
    friction: float
    #: largest T²k/m + 2Tz/m of a closed contact; from 4 on it is unstable by itself
    closed: float
    #: link that decides if the level is ``rule of thumb``; else empty
    decides: str
    #: hardening links without a known largest elongation, judged at rest
    open: list[str]
    #: items with masses that reach no output: they are left out and not judged
    not_judged: list[str]


class Energy(NamedTuple):
    """Energy ledger [J]: ``stored = start + work − lost + made + changed + residual``."""

    #: energy at load
    start: float
    #: energy at the end
    stored: float
    #: kinetic part of `stored`
    kinetic: float
    #: heat
    lost: float
    #: error of the scheme in non-linear links; 0 if all links are linear
    made: float
    #: received from ports
    work: float
    #: received by changes of parameters
    changed: float
    #: energy that the ledger does not explain: rounding
    residual: float
    #: scale for the residual
    peak: float
    #: most that contacts in space stored off their potential (docs/numerics.md §3.4)
    off_potential: float
    #: time covered by the ledger [s]; less than the render if it diverged
    seconds: float
    #: heat of each link
    lost_by: Mapping[str, float]
    #: error of the scheme at each link
    made_by: Mapping[str, float]
    #: work received from each port
    work_by: Mapping[str, float]


def energy(raw: Mapping[str, Any]) -> Energy:
    """Converts the ledger of the engine."""
    plain: dict[str, Any] = {k: dict(v) if k.endswith("_by") else v for k, v in raw.items()}
    return Energy(**plain)


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of the linear part of a scene; arrays over modes, lowest first."""

    #: frequency in continuous time [Hz]; 0 if it does not oscillate
    f: Floats
    #: frequency of the scheme, as heard [Hz]
    heard: Floats
    #: pitch error of the scheme [cents]
    cents: Floats
    #: decay time by 60 dB [s]; infinite without damping
    t60: Floats
    #: true if the scheme makes it grow
    grows: npt.NDArray[np.bool_]
    #: displacement of each place (modes, places) [1/√kg]
    shapes: Floats
    #: motion of each port in each mode (modes, ports) [1/√kg]
    levels: Floats
    #: names of the ports
    ports: tuple[str, ...]
    #: names of the places
    places: tuple[str, ...]
    #: non-linear links, which are not included
    left_out: tuple[str, ...]
    #: true if damping that couples modes was neglected
    approximate: bool
    _derivative: Callable[[Sequence[str]], ModeDerivatives] = field(repr=False)

    def derivative(self, wrt: Sequence[str]) -> ModeDerivatives:
        """Computes derivatives of frequencies and decays by parameters, from the poles of the tick. Needs SciPy.

        Args:
            wrt: names, as for `Scene.tangents`.

        Raises:
            UsageError: as for `Scene.tangents`; also if part of the scene is not computed with masses and springs.

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
    """Derivatives of modes by parameters: arrays (modes, parameters), per unit of the parameter.

    NaN for modes that do not oscillate, or that share frequency and decay with another mode.
    """

    #: derivative of the frequency of the scheme [Hz]
    heard: Floats
    #: derivative of the decay time by 60 dB [s]; 0 for a mode that does not decay
    t60: Floats
    #: names of the parameters
    wrt: tuple[str, ...]
    #: their values
    values: Floats
    #: their SI units; empty for plain numbers
    units: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<ModeDerivatives of {len(self.heard)} modes by {', '.join(self.wrt)}>"


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Error and run time; arrays over methods of computing the scene."""

    #: name of the method
    method: tuple[str, ...]
    #: multiple of the sound rate
    times: npt.NDArray[np.uint32]
    #: ‖x − reference‖ / ‖reference‖ of the worst probe
    error: Floats
    #: the same for the spectrum
    spectrum: Floats
    #: pitch error [cents]; NaN for silence
    cents: Floats
    #: excess level of the second half [dB]
    decay: Floats
    #: energy made, relative to the energy present; NaN without a ledger
    made: Floats
    #: time of one sample on this machine [ns]
    ns: Floats
    #: stability level of the certificate
    stability: tuple[str, ...]
    #: true if no other method is both more accurate and faster
    front: npt.NDArray[np.bool_]
    #: sound rate [Hz]
    rate: float
    #: length played [s]
    seconds: float
    #: error of the reference itself
    known: float
    #: description of the reference
    against: str
    #: methods that the scene does not support, and the reasons
    refused: tuple[tuple[str, str], ...]

    def __len__(self) -> int:
        return len(self.method)

    def __repr__(self) -> str:
        return f"<Accuracy: {len(self)} ways, {self.seconds:g} s at {self.rate:g} Hz against {self.against}>"

    def cheapest(self, error: float) -> tuple[str, int] | None:
        """Returns the fastest proven method and multiple of the rate with at most this error, or ``None`` if there is none.

        Without a proven one, returns the fastest that is not unstable. Single precision does not count, because a scene
        cannot choose it. Also returns ``None`` if the error of the reference is larger; a higher ``reference`` reduces it.
        """
        good = [k for k in range(len(self)) if self.error[k] <= error and self.method[k] != "single"]
        proven = [k for k in good if self.stability[k] == "proven"]
        good = proven or [k for k in good if self.stability[k] != "unstable"]
        if self.known > error or not good:
            return None
        best = min(good, key=lambda k: float(self.ns[k]))
        return self.method[best], int(self.times[best])


def plain(value: object) -> Any:
    """Converts NumPy numbers, tuples and mappings to plain Python values."""
    # NumPy numbers are floats too, but hash differently
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
    """Checks a value of a model.

    Raises:
        UsageError: if any part of it is not a value.
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
    hint = "; leave it out instead" if given is None else ""
    raise UsageError(f"`{name}` cannot be {given!r}: use a number, a quantity, a name or a list{hint}")


def number(name: str, given: object, unit: str) -> float:
    """Converts a number in `unit`, which may be empty, or a quantity as text, e.g. ``"1.5 s"``.

    Raises:
        UsageError: if it is neither.
    """
    if isinstance(given, str):
        return _core.quantity(name, given, unit)
    try:
        return float(given)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        quantity = f', or "1.5 {unit}"' if unit else ""
        raise UsageError(f"{name} = {given!r}: write a number{quantity}") from None


def whole(name: str, value: object, low: int, high: int) -> int:
    """Converts a whole number of any integer type, between `low` and `high`."""
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise UsageError(f"{name} = {value!r}: must be a whole number") from None
    if not low <= number <= high:
        raise UsageError(f"{name} = {number}: must be {low} to {high}")
    return number


#: an array with more channels than this and fewer frames than channels is probably transposed
_CHANNELS = 64


def transposed(sound: Floats) -> None:
    """Refuses a sound of shape (channels, frames), as other libraries have it.

    Raises:
        UsageError: if it has more channels than plausible, and fewer frames.
    """
    if sound.ndim == 2 and sound.shape[1] > max(_CHANNELS, sound.shape[0]):
        frames, channels = sound.shape
        what = f"has the shape {sound.shape}, which is {frames} frames of {channels} channels"
        raise UsageError(f"the sound {what}; transpose it with `.T` to (frames, channels)")


def is_double(dtype: DType) -> bool:
    """Returns true if samples are stored in double precision.

    Raises:
        UsageError: if the type is neither float32 nor float64.
    """
    try:
        asked = np.dtype(dtype)
    except TypeError:
        asked = np.dtype(object)
    if dtype is None or asked not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise UsageError(f'dtype = {dtype!r}: must be "float32" or "float64"')
    return asked == np.dtype(np.float64)


def length(given: object) -> float:
    """Checks a length to play [s]."""
    seconds = number("seconds", given, "s")
    if not 0 < seconds < 1e9:
        raise UsageError(f"seconds = {given}: must be above 0 and below 1e9")
    return seconds


def reals(name: str, given: object, *, dense: bool = False) -> Floats:
    """Converts real numbers to an array; `dense` makes it contiguous.

    Raises:
        UsageError: if it has other contents, or rows of different lengths.
    """
    try:
        array = np.asarray(given)
    except ValueError:
        raise UsageError(f"`{name}` is not an array: its rows have different lengths") from None
    if array.dtype.kind not in "biuf":
        raise UsageError(f"`{name}` contains {_KINDS.get(array.dtype.kind, str(array.dtype))}; use real numbers")
    made: Floats = np.require(array, np.float64, ["C", "A"] if dense else ["A"])
    return made


#: array contents other than real numbers
_KINDS = {"c": "complex numbers", "U": "text", "S": "bytes", "O": "objects that are not numbers", "V": "records"}
