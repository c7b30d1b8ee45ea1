"""The lateral and axial coordinates of the indexing drive: integrated only where the scene gives a force or a start.

They share no energy with the torsion and have no forcing of their own, so from rest they stay exactly zero: nothing
is computed for a block that nobody disturbs, and its zero is not an approximation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import TORSION, Indefinite, IndexingDrive
from camgeom.dynamics.indexing.response import refuse_indefinite
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy, solved, watch_position
from camgeom.dynamics.linear.method import DrivenMotion, Side
from camgeom.dynamics.linear.solve import Solution, transient
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from tests.reference.integrators_constant import ConstantSystem, ForceLaw


@dataclass(frozen=True)
class Start:
    """Initial displacement in m and velocity in m/s of one coordinate."""

    position: float = 0.0
    velocity: float = 0.0


@dataclass(frozen=True, eq=False)
class Lateral:
    """Motion of the disturbed blocks: coordinates to solutions; skipped blocks are exactly at rest; indefinite ones
    are named.
    """

    blocks: Mapping[tuple[str, ...], Solution]
    skipped: tuple[tuple[str, ...], ...]
    indefinite: tuple[Indefinite, ...]

    def position(self, name: str) -> Floats:
        """Displacement (1, n + 1) in m of a coordinate; a skipped one is a single zero."""
        for block, solution in self.blocks.items():
            if name in block:
                return solution.position[..., block.index(name)]
        return np.zeros((1, 1))


def lateral_transient(
    drive: IndexingDrive,
    motion: DrivenMotion,
    speed: float,
    starts: Mapping[str, Start] | None = None,
    forces: Mapping[str, ForceLaw] | None = None,
    turns: int = 1,
    accuracy: Accuracy = STANDARD,
) -> Lateral:
    """Free and forced motion of the lateral blocks at an input speed in rad/s; a force gives (., n, 1) in N.

    Raises DesignError when a disturbed block is indefinite, ProfileError for a coordinate that the drive has not.
    """
    starts, forces = starts or {}, forces or {}
    lateral = [block for block in drive.blocks() if block != TORSION]
    known = {name for block in lateral for name in block}
    strange = sorted((set(starts) | set(forces)) - known)
    if strange:
        raise ProfileError([Problem("dynamics", "no such lateral coordinate", strange, ", ".join(sorted(known)))])
    active = [block for block in lateral if any(name in starts or name in forces for name in block)]
    refuse_indefinite(drive, motion, tuple(active))
    solved = {block: _block(drive, motion, speed, block, starts, forces, turns, accuracy) for block in active}
    skipped = tuple(block for block in lateral if block not in active)
    return Lateral(solved, skipped, tuple(item for item in drive.indefinite(motion) if item.block in lateral))


def _block(
    drive: IndexingDrive,
    motion: DrivenMotion,
    speed: float,
    block: tuple[str, ...],
    starts: Mapping[str, Start],
    forces: Mapping[str, ForceLaw],
    turns: int,
    accuracy: Accuracy,
) -> Solution:
    """Transient of one block."""

    def force(theta: npt.NDArray[np.float64], side: Side) -> Floats:
        out = np.zeros((*np.atleast_2d(theta).shape, len(block)))
        for k, name in enumerate(block):
            if name in forces:
                out[..., k] = forces[name](theta, side)[..., 0]
        return out

    system = ConstantSystem(
        drive.matrix(drive.inertia_terms(), block),
        drive.matrix(drive.damping_terms(), block),
        drive.matrix(drive.spring_terms(), block),
        np.array([speed]),
        force if any(name in forces for name in block) else None,
    )
    begin = np.zeros((1, 2 * len(block)))
    for k, name in enumerate(block):
        start = starts.get(name, Start())
        begin[0, k], begin[0, len(block) + k] = start.position, start.velocity / speed
    return solved(
        system,
        np.asarray(motion.knots),
        accuracy,
        lambda grid, method: transient(system, grid, method, begin, turns),
        watch_position,
    )
