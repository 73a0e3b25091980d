"""The linear part of a scene as sparse matrices, and motion of its masses."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import UsageError, needed
from .._results import Floats, Status


@dataclass(frozen=True, eq=False)
class Linear:
    """The linear part of a scene at load, as matrices (``scipy.sparse.csr_array``) over `places`.

    With x the displacements, d the motion of the last tick and F forces, a tick solves::

        (M / T² + N) u = F + C − K x − Z d / T,    d ← d + u,    x ← x + d

    with C the `constant` forces of weight and of springs that are not at their rest length.

    The scene computes with the same coefficients, so `tick` equals a tick of the scene to rounding. Non-linear links
    are not included: `left_out` names them, and `acts` gives the places of their forces.
    """

    #: length of a tick T [s]
    T: float
    #: names of the places: one for each axis of each mass
    places: tuple[str, ...]
    #: names of the places moved by position ports
    driven: tuple[str, ...]
    #: names of the links, one per row
    links: tuple[str, ...]
    #: stored coefficient of each place, T²/m [m/N]
    mobility: Floats
    #: spring of each place to ground [N/m], and its viscosity [N per m/tick]
    own_k: Floats
    own_z: Floats
    #: stored coefficients of each link: stiffness [N/m] and viscosity [N per m/tick]
    link_k: Floats
    link_z: Floats
    #: elongation of each link by places, then driven places (links, places + driven)
    B: Any
    #: mass (places, places) [kg]
    M: Any
    #: stiffness [N/m]
    K: Any
    #: viscosity [N s/m]
    Z: Any
    #: inertia added by implicit methods, over T² [N/m]
    N: Any
    #: stiffness [N/m] and viscosity [N s/m] between places and driven places (places, driven)
    K_driven: Any
    Z_driven: Any
    #: constant force on each place [N]: weight, and springs that are stretched at rest
    constant: Floats
    #: names and places of force ports (ports, places): weights of a force
    pushes: tuple[tuple[str, ...], Any]
    #: names and places of displacement outputs, before their gain (outputs, places)
    hears: tuple[tuple[str, ...], Any]
    #: names and places of non-linear links (links, places): elongation
    acts: tuple[tuple[str, ...], Any]
    #: displacement [m] of each place at load, its motion in the tick before [m], and its speed [m/s]
    x: Floats
    d: Floats
    v: Floats
    #: non-linear links, which are not included
    left_out: tuple[str, ...]
    #: method of a part of the model that does not follow these matrices, if any
    other_scheme: str | None

    @classmethod
    def _of(cls, raw: dict[str, Any]) -> Linear:
        sparse: Any = needed("scipy.sparse", "linear")
        places, driven = tuple(raw["places"]), tuple(name for name in raw["driven"])
        n, T = len(places), float(raw["tick"])

        def rows(parts: Any) -> Any:
            return sparse.csr_array(parts, shape=(len(parts[2]) - 1, n + len(driven)))

        def named(parts: tuple[list[str], Any]) -> tuple[tuple[str, ...], Any]:
            return tuple(parts[0]), rows(parts[1])[:, :n]

        B = rows(raw["elongation"])
        moving = B[:, :n]

        def between(by: Floats, own: Floats) -> Any:
            return sparse.csr_array(moving.T @ sparse.diags_array(by) @ moving + sparse.diags_array(own))

        def across(by: Floats) -> Any:
            return sparse.csr_array(moving.T @ sparse.diags_array(by) @ B[:, n:])

        k, z = raw["link_k"], raw["link_z"]
        return cls(
            T=T,
            places=places,
            driven=tuple("" if name is None else name for name in driven),
            links=tuple(raw["links"]),
            mobility=raw["mobility"],
            own_k=raw["own_k"],
            own_z=raw["own_z"],
            link_k=k,
            link_z=z,
            B=B,
            M=sparse.csr_array(sparse.diags_array(T * T / raw["mobility"])),
            K=between(k, raw["own_k"]),
            Z=between(T * z, T * raw["own_z"]),
            N=between(raw["link_implicit"], raw["own_implicit"]),
            K_driven=across(k),
            Z_driven=across(T * z),
            constant=raw["constant"],
            pushes=named(raw["pushes"]),
            hears=named(raw["hears"]),
            acts=named(raw["acts"]),
            x=raw["x"],
            d=raw["d"],
            v=raw["v"],
            left_out=tuple(raw["left_out"]),
            other_scheme=raw["other_scheme"],
        )

    def __len__(self) -> int:
        return len(self.places)

    def __repr__(self) -> str:
        return f"<Linear: {len(self)} places, {len(self.links)} links, {len(self.driven)} driven, {len(self.left_out)} left out>"

    def tick(
        self,
        x: npt.ArrayLike,
        d: npt.ArrayLike,
        force: npt.ArrayLike = 0.0,
        driven: tuple[npt.ArrayLike, npt.ArrayLike] = (0.0, 0.0),
    ) -> tuple[Floats, Floats]:
        """Computes one tick: displacements and motion after it.

        Args:
            x: displacements [m] (places,), or of several states side by side (places, states).
            d: motion in the tick before [m], in the same shape; at load `Linear.d`.
            force: force on each place [N], in addition to `constant`.
            driven: displacement of each driven place [m], and its motion in this tick [m].

        Raises:
            UsageError: if part of the scene has another scheme, see `other_scheme`; or if an array has the wrong shape.
        """
        if self.other_scheme is not None:
            raise UsageError(f"a part of this scene has `{self.other_scheme}`, whose tick does not follow these matrices")
        at: Floats = np.asarray(x, dtype=np.float64)
        motion: Floats = np.asarray(d, dtype=np.float64)
        if at.ndim not in (1, 2) or len(at) != len(self) or motion.shape != at.shape:
            places = f"({len(self)},) or ({len(self)}, states)"
            raise UsageError(f"`x` and `d` must both have the shape {places}, not {at.shape} and {motion.shape}")
        given = [np.asarray(v, dtype=np.float64) for v in (force, *driven)]
        for name, v, n in zip(("force", "driven[0]", "driven[1]"), given, (len(self), len(self.driven), len(self.driven)), strict=False):
            if v.ndim and v.shape not in ((n,), (n, *at.shape[1:])):
                raise UsageError(f"`{name}` must be a number for all, or have the shape {(n, *at.shape[1:])}, not {v.shape}")
        # values per place apply to all states
        given = [v[:, None] if v.ndim == 1 and at.ndim == 2 else v for v in given]
        shape = (len(self.driven), *at.shape[1:])
        port, moves = (np.broadcast_to(v, shape) for v in given[1:])
        pull = self.K @ at + self.Z @ motion / self.T + self.K_driven @ port + self.Z_driven @ moves / self.T
        total: Floats = given[0] + (self.constant if at.ndim == 1 else self.constant[:, None]) - pull
        if self.N.count_nonzero():
            solve: Any = import_module("scipy.sparse.linalg").spsolve
            more: Floats = np.asarray(solve((self.M / self.T**2 + self.N).tocsc(), total)).reshape(at.shape)
        else:
            more = (total.T * self.mobility).T
        after: Floats = motion + more
        return at + after, after


@dataclass(frozen=True, eq=False)
class Rollout:
    """Positions of masses at each sample."""

    #: names of the columns
    places: tuple[str, ...]
    #: displacement from rest (n, places) [m]
    x: Floats
    #: sound rate [Hz]
    rate: float
    #: status, as of a `Render`
    status: Status

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        return f"<Rollout: {len(self)} samples of {len(self.places)} places at {self.rate:g} Hz, {self.status}>"
