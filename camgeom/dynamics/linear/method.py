"""Equations of motion that are linear and periodic in the cam angle, and the one-step methods that solve them, as data.

An equation of motion is written in the cam angle theta instead of the time, a dash meaning d/dtheta:

    q'' = F(theta) - D(theta) q' - S(theta) q          D = M^-1 C, S = M^-1 K, F = M^-1 f, all per cam angle

so that one grid of cam angles serves every speed of a sweep. Arrays carry the speeds on the first axis (b), the cam
angles on the second (n) and the m coordinates last. A method is a frozen record of its coefficients; its *one-step
map* is the affine map [P | r] with y(theta + h) = P y(theta) + r, y = (q, q') or (q, q', q'') stacked. Maps are
formed for all steps and all speeds at once; who needs a steady state composes them, who needs a transient walks along
them.

Gauss stages are what everything is solved with: stable at every step, of order 2 s, and cheap where only the contact
varies. The Newmark family is there to repeat what papers computed with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import factorial, sqrt
from types import MappingProxyType
from typing import Literal, Protocol

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, gauss_rule
from camgeom.maths.frozen import cached_property

Side = Literal["left", "right"]


class DrivenMotion(Protocol):
    """What drives a system: lift or turret angle over the cam angle in rad, exact to any derivative."""

    @property
    def knots(self) -> Floats: ...

    def jet(self, theta: Floats, order: int = 3, side: Side = "right") -> Floats:
        """Value and derivatives per rad (order + 1, ...) at cam angles theta; at a knot the limit from the side."""
        ...


WILSON_BOUND = (1.0 + sqrt(3.0)) / 2.0
"""1.3660254: below it Wilson-theta is only conditionally stable (papers round it to 1.37)."""
AUTO = "gauss8"
"""what "auto" takes: at every tolerance as fast as the best of the others, or faster (docs/benchmarks.md)"""


@immutable
class VaryingContact:
    """The one direction of an equation of motion that varies: it adds u r^T to D and u p^T to S.

    push u (b, n, m), rate r (b, n, m), place p (b, n, m); an axis of length 1 stands for all.
    """

    push: Floats
    rate: Floats
    place: Floats

    @classmethod
    def on_cam(
        cls, slope: Floats, bend: Floats, stiffness: Floats | float, damping: float, speed: Floats, mass: Floats
    ) -> VaryingContact:
        """Spring and damper between a cam (first of the coordinates of mass (m,)) and what it drives (second).

        Elongation g = q2 - s' q1, its rate omega (q2' - s' q1' - s'' q1) at the speed omega (b, 1 or n) in rad/s; slope
        s' and bend s'' (1 or b, n) of the motion, stiffness (1, n) and damping of g in SI.
        """
        along = np.zeros((*slope.shape, len(mass)))
        along[..., 0], along[..., 1] = -slope, 1.0
        place = np.asarray(stiffness)[..., None] * along / (speed**2)[..., None]
        place[..., 0] -= damping * bend / speed
        return cls(along / mass, damping * along / speed[..., None], place)


@immutable
class Coefficients:
    """The equation of motion q'' = F - D q' - S q at given cam angles, per radian of cam angle.

    fixed_damping (b, n, m, m), fixed_stiffness (b, n, m, m) and force F (b, n, m); an axis of length 1 stands for all.
    D and S are the fixed ones and what the contact adds.
    """

    fixed_damping: Floats
    fixed_stiffness: Floats
    force: Floats
    contact: VaryingContact | None = None

    @cached_property
    def damping(self) -> Floats:
        """D (b, n, m, m)."""
        if self.contact is None:
            return self.fixed_damping
        return self.fixed_damping + self.contact.push[..., None] * self.contact.rate[..., None, :]

    @cached_property
    def stiffness(self) -> Floats:
        """S (b, n, m, m)."""
        if self.contact is None:
            return self.fixed_stiffness
        return self.fixed_stiffness + self.contact.push[..., None] * self.contact.place[..., None, :]

    def acceleration(self, position: Floats, rate: Floats) -> Floats:
        """q'' (b, n, m) for q and q' (b, n, m)."""
        pull = _times(self.fixed_damping, rate) + _times(self.fixed_stiffness, position)
        if self.contact is not None:
            effort = (self.contact.place * position).sum(-1) + (self.contact.rate * rate).sum(-1)
            pull = pull + self.contact.push * effort[..., None]
        return np.asarray(self.force - pull)


def _times(matrix: Floats, vector: Floats) -> Floats:
    """Products (b, n, m) of matrices (b, n or 1, m, m) with vectors (b, n, m)."""
    if matrix.shape[1] == 1:
        return np.asarray(vector @ np.swapaxes(matrix[:, 0], -1, -2))
    return np.asarray((matrix @ vector[..., None])[..., 0])


Correction = Callable[[Floats, Floats], Floats]
"""(b, n, m) from q and q' (b, n, m)"""


class System(Protocol):
    """An equation of motion with coefficients of period one turn; `size` coordinates, `batch` speeds.

    It may carry a small non-linear correction on top of the linear terms; `linear` says that there is none.
    """

    @property
    def size(self) -> int: ...

    @property
    def batch(self) -> int: ...

    @property
    def linear(self) -> bool: ...

    def coefficients(self, theta: Floats, side: Side = "right") -> Coefficients:
        """D, S, F at cam angles theta (1 or b, n) in rad; at a knot the limit from the given side."""
        ...

    def correction(self, theta: Floats, side: Side = "right") -> Correction:
        """What the exact q'' has beyond the linear one at these cam angles, of any number of states."""
        ...


@immutable(eq=True)
class Collocated:
    """A method of the Newmark family, second order: equilibrium demanded at one weighted instant of the step.

    theta stretches the step (Wilson), alpha_m and alpha_f weigh inertia and forces between its ends (generalized-
    alpha), beta and gamma are Newmark's; dispersion is the period elongation divided by (omega h)^2.
    """

    name: str
    beta: float
    gamma: float
    theta: float = 1.0
    alpha_m: float = 0.0
    alpha_f: float = 0.0
    dispersion: float = 1.0 / 12.0
    caution: str = ""
    order: int = 2
    rows: int = 3


@immutable(eq=True)
class RungeKutta:
    """An implicit Runge-Kutta method given by its tableau a (s, s), b (s,), c (s,).

    dispersion is the phase error per radian over (omega h)^order.
    """

    name: str
    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    order: int
    dispersion: float
    caution: str = ""
    rows: int = 2


Method = Collocated | RungeKutta


def wilson(theta: float = 1.40) -> Collocated:
    """Wilson-theta with stretch theta (no unit); carries a caution below 1.3660254, where large steps grow.

    Period elongation (omega h)^2 (1/24 + theta (theta - 1)/4). Raises ProfileError below 1.
    """
    if not 1.0 <= theta <= 10.0:
        raise ProfileError([Problem("dynamics.wilson_theta", "is outside the range of the method", theta, "1 to 10")])
    caution = ""
    if theta < WILSON_BOUND:
        caution = f"Wilson theta = {theta:g} is below (1 + sqrt 3)/2 = 1.3660: stable only for small steps; use 1.40"
    return Collocated(
        "wilson", 1.0 / 6.0, 0.5, theta=theta, dispersion=1.0 / 24.0 + theta * (theta - 1.0) / 4.0, caution=caution
    )


def newmark(beta: float = 0.25, gamma: float = 0.5) -> Collocated:
    """Newmark's method (no unit), by default the average acceleration (beta 1/4, gamma 1/2: no amplitude loss)."""
    if not (gamma >= 0.5 and beta >= 0.25 * (gamma + 0.5) ** 2):
        raise ProfileError(
            [
                Problem(
                    "dynamics.newmark",
                    "is not unconditionally stable",
                    (beta, gamma),
                    "gamma >= 1/2, beta >= (gamma + 1/2)^2/4",
                )
            ]
        )
    order = 2 if gamma == 0.5 else 1
    return Collocated("newmark", beta, gamma, dispersion=beta / 2.0 - 1.0 / 24.0 or 1e-9, order=order)


def generalized_alpha(rho: float = 0.8) -> Collocated:
    """Generalized-alpha (Chung and Hulbert 1993) with spectral radius rho (no unit, 0..1) at infinite frequency."""
    if not 0.0 <= rho <= 1.0:
        raise ProfileError([Problem("dynamics.spectral_radius", "is outside its range", rho, "0 to 1")])
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    return Collocated("generalized-alpha", beta, gamma, alpha_m=alpha_m, alpha_f=alpha_f, dispersion=0.088)


def gauss_legendre(stages: int) -> RungeKutta:
    """Gauss-Legendre collocation with 1 to 10 stages: order twice the stages, stable at every step, symplectic.

    Phase error of the diagonal Pade approximation: s!^2 / ((2s)! (2s+1)!).
    """
    _vet_stages(stages, 1)
    c = (gauss_rule(stages)[0] + 1.0) / 2.0
    a, b = _collocation(c)
    pade = factorial(stages) ** 2 / (factorial(2 * stages) * factorial(2 * stages + 1))
    return RungeKutta(f"gauss{stages}", a, b, _row(c), 2 * stages, pade)


def radau(stages: int) -> RungeKutta:
    """Radau IIA collocation with 2 to 10 stages: order 2 s - 1, damps what the step cannot resolve (L-stable).

    Error of the subdiagonal Pade approximation: s! (s-1)! / ((2s-1)! (2s)!).
    """
    _vet_stages(stages, 2)
    # Beside the end, the zeros of the Jacobi polynomial (1, 0): eigenvalues of its recurrence (Golub and Welsch 1969).
    k = np.arange(stages - 1)
    beside = np.sqrt(k * (k + 1.0))[1:] / (2.0 * k[1:] + 1.0)
    inner = np.diag(-1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0))) + np.diag(beside, 1) + np.diag(beside, -1)
    c = np.append((np.linalg.eigvalsh(inner) + 1.0) / 2.0, 1.0)
    a, _ = _collocation(c)
    pade = factorial(stages) * factorial(stages - 1) / (factorial(2 * stages - 1) * factorial(2 * stages))
    # stiffly accurate: the end of the step is the last stage
    return RungeKutta(f"radau{stages}", a, a[-1], _row(c), 2 * stages - 1, pade)


def _vet_stages(stages: int, least: int) -> None:
    if not least <= stages <= 10:
        raise ProfileError(
            [Problem("dynamics.method", "stages of a collocation out of range", stages, f"{least} to 10")]
        )


def _row(values: Floats) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _collocation(c: Floats) -> tuple[tuple[tuple[float, ...], ...], tuple[float, ...]]:
    """Tableau a, b of the collocation at nodes c: a_ij integrates the j-th Lagrange polynomial from 0 to c_i, b_j to 1.

    Quadrature of the polynomials is exact and needs no ill-conditioned Vandermonde matrix (Hairer, Lubich and Wanner,
    Geometric Numerical Integration, II.1.2).
    """
    stages = len(c)
    nodes, weights = gauss_rule(stages)
    ends = np.append(c, 1.0)
    points = ends[:, None] * (nodes + 1.0) / 2.0
    lagrange = np.ones((stages + 1, stages, stages))
    for j in range(stages):
        for k in range(stages):
            if k != j:
                lagrange[:, :, j] *= (points - c[k]) / (c[j] - c[k])
    table = ends[:, None] * np.einsum("p,ipj->ij", weights / 2.0, lagrange)
    return tuple(_row(row) for row in table[:-1]), _row(table[-1])


_ALL: tuple[Method, ...] = (
    wilson(),
    newmark(),
    generalized_alpha(),
    *(gauss_legendre(stages) for stages in range(1, 9)),
    *(radau(stages) for stages in (2, 3, 5)),
)
INTEGRATORS: Mapping[str, Method] = MappingProxyType({method.name: method for method in _ALL})
"""Every integrator by name: wilson, newmark, generalized-alpha, gauss1 .. gauss8, radau2, radau3, radau5"""


def find(method: str | Method) -> Method:
    """The method (no unit) of that name, or the method itself; ProfileError names the allowed names."""
    if not isinstance(method, str):
        return method
    name = AUTO if method == "auto" else method
    if name not in INTEGRATORS:
        allowed = "auto, " + ", ".join(INTEGRATORS)
        raise ProfileError([Problem("dynamics.method", "no such integrator", method, allowed)])
    return INTEGRATORS[name]
