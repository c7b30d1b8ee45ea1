"""The indexing drive: inertias, stiffnesses and dampings of its 11 degrees of freedom, and its matrices. SI throughout.

Coordinates: torsion theta1 (cam), theta2 (turret), theta3 (load plate), taken as deviations q1 = theta1 - theta,
q2 = theta2 - tau(theta), q3 = theta3 - tau(theta) from the rigid motion; cam displacements x1, y1, z1; turret x2, y2
and load plate x3, y3 on one output shaft; its axial displacement z23. The matrices are assembled from the energies,
so the contact keeps the terms tau'^2 K12 and C12 tau'' omega that published row-by-row forms lose.

A quadratic energy is a sum of terms c/2 (g . x)^2 (a spring, an inertia, a damper along one direction g) or c (g .
x)(h . x) (a mixed term). The matrices are sums of dyads, so they are symmetric by construction and a coupling that no
energy names is exactly zero: the blocks found from that pattern are independent to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from math import sqrt

import numpy as np

from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import frozen

NAMES = ("theta1", "theta2", "theta3", "x1", "y1", "z1", "x2", "y2", "x3", "y3", "z23")
TORSION = NAMES[:3]
LABELS: Mapping[tuple[str, ...], tuple[str, ...]] = {
    ("x1",): ("cam_bending_x",),
    ("y1",): ("cam_axial_y",),
    ("z1",): ("cam_bending_z",),
    ("x2", "x3"): ("turret_bending", "load_bending", "cross_bending"),
    ("y2", "y3"): ("turret_bending", "load_bending", "cross_bending"),
    ("z23",): ("output_axial",),
}
DEFINITE = 1e-12
"""smallest eigenvalue of a block scaled to a unit diagonal that counts as positive"""


@immutable(eq=True)
class Term:
    """One quadratic energy c/2 (g . x)^2, or c (g . x)(h . x) when h is given; names of coordinates to weights."""

    coefficient: float
    g: tuple[tuple[str, float], ...]
    h: tuple[tuple[str, float], ...] = ()

    def matrix(self, names: Sequence[str]) -> Floats:
        """Second derivative (m, m) of the energy."""
        g = _vector(self.g, names)
        if not self.h:
            return self.coefficient * np.outer(g, g)
        h = _vector(self.h, names)
        return self.coefficient * (np.outer(g, h) + np.outer(h, g))


def _vector(weights: tuple[tuple[str, float], ...], names: Sequence[str]) -> Floats:
    out = np.zeros(len(names))
    for name, weight in weights:
        out[list(names).index(name)] = weight
    return out


def along(name: str, weight: float = 1.0) -> tuple[tuple[str, float], ...]:
    """The direction of one coordinate."""
    return ((name, weight),)


def between(first: str, second: str) -> tuple[tuple[str, float], ...]:
    """The difference first - second of two coordinates."""
    return ((first, 1.0), (second, -1.0))


def assemble(terms: Sequence[Term], names: Sequence[str]) -> Floats:
    """Matrix (m, m) of a sum of energies."""
    total = np.zeros((len(names), len(names)))
    for term in terms:
        total += term.matrix(names)
    return total


def decoupled(names: Sequence[str], *matrices: Floats) -> tuple[tuple[str, ...], ...]:
    """Blocks of coordinates that no matrix (m, m) couples, in the order of their first coordinate."""
    coupled = np.zeros((len(names), len(names)), dtype=bool)
    for matrix in matrices:
        coupled |= (matrix != 0.0) | (matrix.T != 0.0)
    left = list(range(len(names)))
    blocks = []
    while left:
        block, reach = set(), {left[0]}
        while reach:
            block |= reach
            reach = {int(j) for i in reach for j in np.flatnonzero(coupled[i])} - block
        blocks.append(tuple(names[i] for i in sorted(block)))
        left = [i for i in left if i not in block]
    return tuple(blocks)


@immutable(eq=True)
class Indefinite:
    """A stiffness block that is no stiffness: some displacement lowers its energy, so a disturbance grows without
    bound.

    scaled_eigenvalue has no unit (unit diagonal), eigenvalue N/m or N m/rad, growth_rate 1/s, frequencies_squared
    (rad/s)^2 with their sign (a negative one is the divergence, never the root of its magnitude), admissible says
    which data would do.
    """

    block: tuple[str, ...]
    scaled_eigenvalue: float
    eigenvalue: float
    growth_rate: float
    frequencies_squared: tuple[float, ...]
    admissible: str

    def __str__(self) -> str:
        unit = "N m/rad" if self.block == TORSION else "N/m"
        return (
            f"stiffness of {', '.join(self.block)} is indefinite: eigenvalue {self.eigenvalue:.6e} {unit}, scaled "
            f"{self.scaled_eigenvalue:.6f}, a disturbance grows with {self.growth_rate:.6f} 1/s; "
            f"needs {self.admissible}"
        )


def definiteness(
    block: tuple[str, ...], mass: Floats, stiffness: Floats, labels: Sequence[str] = ()
) -> Indefinite | None:
    """None for a positive definite stiffness (m, m), else what is wrong with it, with the admissible range of its
    entries.

    Checked on the matrix scaled to a unit diagonal, so that units and sizes do not matter.
    """
    diagonal = np.diag(stiffness)
    if np.all(diagonal > 0.0):
        scale = 1.0 / np.sqrt(diagonal)
        scaled = float(np.linalg.eigvalsh(stiffness * scale[:, None] * scale)[0])
    else:
        scaled = float(diagonal.min() / max(float(np.abs(stiffness).max()), 1e-300))
    if scaled > DEFINITE:
        return None
    squared = squared_frequencies(mass, stiffness)
    return Indefinite(
        block,
        scaled,
        float(np.linalg.eigvalsh(stiffness)[0]),
        sqrt(max(0.0, -float(squared[0]))),
        tuple(float(value) for value in squared),
        _admissible(stiffness, labels or block),
    )


def _admissible(stiffness: Floats, labels: Sequence[str]) -> str:
    """The range of the entries of a 1x1 or 2x2 block that makes it definite, the rule for larger ones."""
    if len(stiffness) == 1:
        return f"{labels[0]} > 0"
    if len(stiffness) == 2 and np.all(np.diag(stiffness) > 0.0):
        first, second, cross = stiffness[0, 0], stiffness[1, 1], abs(stiffness[0, 1])
        # The keys of a profile are in N/mm.
        keys = len(labels) == 3
        names, unit = (labels, " N/mm") if keys else (("first diagonal", "second diagonal", "coupling"), "")
        least, other, most = (
            f"{value * (1e-3 if keys else 1.0):.6e}{unit}"
            for value in (cross * cross / first, cross * cross / second, sqrt(first * second))
        )
        return f"{names[1]} > {least} or {names[0]} > {other} or |{names[2]}| < {most}"
    return "a positive diagonal and positive leading minors"


def squared_frequencies(mass: Floats, stiffness: Floats) -> Floats:
    """Squares of the natural frequencies (..., m), (rad/s)^2 with sign, ascending, of K x = omega^2 M x, K (..., m,
    m).
    """
    return np.asarray(np.linalg.eigvalsh(_normalised(mass, stiffness)))


def modes(mass: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Squared frequencies (..., m) with sign and mass-normalised mode shapes (..., m, m) in columns, largest entry
    positive.
    """
    values, vectors = np.linalg.eigh(_normalised(mass, stiffness))
    shapes = np.linalg.solve(np.linalg.cholesky(mass).T, vectors)
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(-2)[..., None, :], -2)
    return values, np.asarray(shapes * np.sign(largest))


def _normalised(mass: Floats, stiffness: Floats) -> Floats:
    """L^-1 K L^-T with M = L L^T: symmetric, with the squared frequencies as eigenvalues."""
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    out = inverse @ stiffness @ inverse.T
    return np.asarray((out + np.swapaxes(out, -1, -2)) / 2.0)


@immutable(eq=True, kw_only=True)
class IndexingDrive:
    """Masses (kg), inertias (kg m2), stiffnesses (N m/rad torsional, N/m else), dampings (N m s/rad, N s/m) of the
    drive.

    contact_stiffness is N m/rad at the turret (a linear contact stiffness k in N/m gives k rp^2); where it varies
    over the cam angle give `contact_table`, equal steps over a turn, and leave it at the mean. cam_friction,
    turret_friction are viscous.
    """

    cam_inertia: float
    turret_inertia: float
    load_inertia: float
    input_stiffness: float
    output_stiffness: float
    contact_stiffness: float
    input_damping: float = 0.0
    output_damping: float = 0.0
    contact_damping: float = 0.0
    cam_friction: float = 0.0
    turret_friction: float = 0.0
    contact_table: tuple[float, ...] = ()
    cam_mass: float = 0.0
    turret_mass: float = 0.0
    load_mass: float = 0.0
    cam_bending_x: float = 0.0
    cam_axial_y: float = 0.0
    cam_bending_z: float = 0.0
    turret_bending: float = 0.0
    load_bending: float = 0.0
    cross_bending: float = 0.0
    output_axial: float = 0.0
    cam_damping_x: float = 0.0
    cam_damping_y: float = 0.0
    cam_damping_z: float = 0.0
    output_axial_damping: float = 0.0

    def __post_init__(self) -> None:
        problems = []
        for item in fields(self):
            value = getattr(self, item.name)
            values = np.asarray(value, dtype=float)
            if not np.isfinite(values).all():
                problems.append(Problem(f"dynamics.{item.name}", "must be finite", value))
            elif item.name != "cross_bending" and (values < 0.0).any():
                problems.append(Problem(f"dynamics.{item.name}", "must not be negative", value, ">= 0"))
        for name in (
            "cam_inertia",
            "turret_inertia",
            "load_inertia",
            "input_stiffness",
            "output_stiffness",
            "contact_stiffness",
        ):
            if getattr(self, name) == 0.0:
                problems.append(Problem(f"dynamics.{name}", "must be positive", 0.0, "> 0"))
        if self.contact_table and (len(self.contact_table) < 4 or min(self.contact_table) <= 0.0):
            problems.append(
                Problem("dynamics.contact_table", "needs four positive values or more", len(self.contact_table))
            )
        if problems:
            raise ProfileError(problems)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates of the model: the torsion, and of the lateral ones those that have a mass."""
        mass = {"1": self.cam_mass, "2": self.turret_mass, "3": self.load_mass}
        out = [name for name in NAMES[3:10] if mass[name[-1]] > 0.0]
        if self.turret_mass + self.load_mass > 0.0:
            out.append("z23")
        return (*TORSION, *out)

    def inertia_terms(self) -> tuple[Term, ...]:
        """Kinetic energy."""
        return (
            Term(self.cam_inertia, along("theta1")),
            Term(self.turret_inertia, along("theta2")),
            Term(self.load_inertia, along("theta3")),
            *(Term(self.cam_mass, along(name)) for name in ("x1", "y1", "z1")),
            *(Term(self.turret_mass, along(name)) for name in ("x2", "y2")),
            *(Term(self.load_mass, along(name)) for name in ("x3", "y3")),
            Term(self.turret_mass + self.load_mass, along("z23")),
        )

    def spring_terms(self) -> tuple[Term, ...]:
        """Potential energy without the contact."""
        lateral = [
            term
            for a, b in (("x2", "x3"), ("y2", "y3"))
            for term in (
                Term(self.turret_bending, along(a)),
                Term(self.cross_bending, along(a), along(b)),
                Term(self.load_bending, along(b)),
            )
        ]
        return (
            Term(self.input_stiffness, along("theta1")),
            Term(self.output_stiffness, between("theta3", "theta2")),
            Term(self.cam_bending_x, along("x1")),
            Term(self.cam_axial_y, along("y1")),
            Term(self.cam_bending_z, along("z1")),
            *lateral,
            Term(self.output_axial, along("z23")),
        )

    def damping_terms(self) -> tuple[Term, ...]:
        """Dissipation without the contact."""
        return (
            Term(self.input_damping, along("theta1")),
            Term(self.cam_friction, along("theta1")),
            Term(self.turret_friction, along("theta2")),
            Term(self.output_damping, between("theta3", "theta2")),
            Term(self.cam_damping_x, along("x1")),
            Term(self.cam_damping_y, along("y1")),
            Term(self.cam_damping_z, along("z1")),
            Term(self.output_axial_damping, along("z23")),
        )

    def matrix(self, terms: tuple[Term, ...], names: tuple[str, ...]) -> Floats:
        """Matrix (m, m) of an energy on the chosen coordinates."""
        kept = [term for term in terms if all(name in names for name, _ in (*term.g, *term.h))]
        return assemble(kept, names)

    def contact_stiffness_at(self, theta: Floats) -> Floats:
        """K12 in N m/rad at cam angles theta (rad): the constant, or the periodic cubic spline through the table."""
        if not self.contact_table:
            return np.full(np.shape(theta), self.contact_stiffness)
        return periodic_spline(self.contact_table, theta)

    def contact_stiffness_slope_at(self, theta: Floats) -> Floats:
        """Derivative of K12 in the cam angle, N m/rad², at cam angles theta (rad)."""
        if not self.contact_table:
            return np.zeros(np.shape(theta))
        return periodic_spline(self.contact_table, theta, slope=True)

    def stiffness(self, theta: Floats, motion: DrivenMotion, names: tuple[str, ...] | None = None) -> Floats:
        """Stiffness matrices (n, m, m) at cam angles theta (n,) rad, for a cam at rest (no velocity terms)."""
        names = names or self.coordinates
        fixed = self.matrix(self.spring_terms(), names)
        slope = motion.jet(theta, 1)[1]
        return fixed + self.contact_stiffness_at(theta)[:, None, None] * contact_dyad(slope, names)

    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """The coordinates in blocks that no energy couples."""
        names = self.coordinates
        coupled = contact_dyad(np.array([1.0]), names)[0]
        spring = self.matrix(self.spring_terms(), names)
        return decoupled(
            names, self.matrix(self.inertia_terms(), names), spring + coupled, self.matrix(self.damping_terms(), names)
        )

    def indefinite(self, motion: DrivenMotion, theta: Floats | None = None) -> tuple[Indefinite, ...]:
        """The blocks whose stiffness is not positive definite, at the worst of the cam angles theta (rad)."""
        angles = np.linspace(0.0, 2.0 * np.pi, 361) if theta is None else theta
        out = []
        for block in self.blocks():
            mass = self.matrix(self.inertia_terms(), block)
            if block == TORSION:
                slope = motion.jet(angles, 1)[1]
                angle = angles[[int(np.abs(slope).argmax())]]
            else:
                angle = angles[:1]
            wrong = definiteness(block, mass, self.stiffness(angle, motion, block)[0], LABELS.get(block, ()))
            if wrong is not None:
                out.append(wrong)
        return tuple(out)


def contact_dyad(slope: Floats, names: tuple[str, ...]) -> Floats:
    """g g^T (n, m, m) of the contact elongation g = theta2 - tau' theta1, for slopes tau' (n,)."""
    direction = np.zeros((len(slope), len(names)))
    if "theta1" in names:
        direction[:, names.index("theta1")] = -slope
        direction[:, names.index("theta2")] = 1.0
    return np.asarray(direction[:, :, None] * direction[:, None, :])


@lru_cache(maxsize=16)
def _spline(table: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Values (k,) of a table over one turn and the second derivatives of the periodic cubic spline through them.

    These solve a circulant system, so a Fourier transform inverts it exactly.
    """
    values, count = np.array(table), len(table)
    h = 2.0 * np.pi / count
    wave = np.cos(2.0 * np.pi * np.arange(count) / count)
    curve = np.fft.ifft(np.fft.fft(values) * (2.0 * wave - 2.0) / (h * h) * 6.0 / (4.0 + 2.0 * wave)).real
    return frozen((values, np.ascontiguousarray(curve)))


def periodic_spline(table: tuple[float, ...], theta: Floats, slope: bool = False) -> Floats:
    """Periodic cubic spline through the values of a table at equal steps over one turn, at cam angles theta (rad), or
    its slope there.
    """
    (values, curve), count = _spline(table), len(table)
    h = 2.0 * np.pi / count
    place = np.mod(theta, 2.0 * np.pi) / h
    left = np.minimum(place.astype(int), count - 1)
    u = place - left
    w = 1.0 - u
    right = (left + 1) % count
    if slope:
        bend = ((3.0 * u**2 - 1.0) * curve[right] - (3.0 * w**2 - 1.0) * curve[left]) * h / 6.0
        return np.asarray((values[right] - values[left]) / h + bend)
    bend = ((w**3 - w) * curve[left] + (u**3 - u) * curve[right]) * h * h / 6.0
    return np.asarray(w * values[left] + u * values[right] + bend)
