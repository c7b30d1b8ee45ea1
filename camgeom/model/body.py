"""The cam as a workpiece, whoever runs on it: bodies, solids, walls and mass, each computed when asked for, once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, final
from weakref import ref

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths.frozen import Ledger, Sealed, fact, frozen
from camgeom.profile import Profile
from camgeom.solid import UNION, Part, Solid

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.solid.blank import Wall
    from camgeom.solid.mechanism import Mechanism

COARSE = 1e-3
"""share of a body's size: chord error of the mesh on which crossings are looked for first"""
MARGIN = 2.0
"""chord errors by which two surfaces of one mesh may run into each other without crossing"""
FEWEST = "output.fewest_triangles"
WEIGHED = 1e-5
"""share of a turret's radius: chord error of the meshes that it is weighed by, which loses 3e-5 of its inertia"""
MILLI = 1e-3


@immutable(eq=True)
class MassProperties:
    """Volume mm³, mass kg, centroid mm and inertia tensor about it, kg m² (uniform density)."""

    volume: float
    mass: float
    centroid: tuple[float, float, float]
    inertia: tuple[tuple[float, float, float], ...]


@final
class Body(Sealed):
    """What the followers of one cam share; `bindings` are the models that see it, one a follower."""

    profile: Profile
    tolerance: float
    ledger: Ledger
    _seen_by: tuple[ref[Model], ...]

    def __init__(self, profile: Profile, tolerance: float, ledger: Ledger) -> None:
        vars(self).update(profile=profile, tolerance=tolerance, ledger=ledger, _seen_by=())

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_seen_by": ()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(frozen(state))

    def seen_by(self, *models: Model) -> None:
        """Name the models of all followers, once, as the first of them is made; it keeps the others."""
        # Weak, so that a model that is dropped frees its meshes at once.
        vars(self)["_seen_by"] = tuple(ref(model) for model in models)

    @property
    def bindings(self) -> tuple[Model, ...]:
        """The models of all followers."""
        return tuple(model for seen in self._seen_by if (model := seen()) is not None)

    @property
    def free_tolerance(self) -> float:
        """Of the faces that no follower touches, mm."""
        return max(self.tolerance, self.profile.output.free_tolerance or 0.0)

    @property
    def _free(self) -> float | None:
        return self.free_tolerance if self.free_tolerance > self.tolerance else None

    @fact
    def parts(self) -> tuple[Part, ...]:
        """The recipes of the bodies."""
        mechanisms = self._mechanisms
        return mechanisms[0].parts if len(mechanisms) == 1 else self._joined

    @property
    def _mechanisms(self) -> list[Mechanism]:
        """One a track: followers on one track ask for the same body."""
        return [one.mechanism for one in self.bindings[0].grooves]

    @fact
    def _joined(self) -> tuple[Part, ...]:
        return self.profile.cam.joined(self._mechanisms)

    @fact
    def solids(self) -> tuple[Solid, ...]:
        """The finished bodies within the tolerance. Raises DesignError where the cam is undercut or crosses itself."""
        try:
            for one in self.bindings[0].grooves:
                one.refuse_folded()
        except DesignError:
            solid = self._undercut_solid() if self.profile.output.undercut_solid else None
            if solid is None:
                raise
            return (solid,)
        return tuple(self._made(part) for part in self.parts)

    @fact
    def gridded(self) -> tuple[Solid, ...]:
        """The bodies, each as one regular grid: its rows carry results on flanks, of which the fewest triangles have
        no vertices between their edges."""
        if not self._few or self.solids[0].method == UNION:
            return self.solids
        return tuple(part.solid(self.tolerance, self._free) for part in self.parts)

    @property
    def _few(self) -> bool:
        """Whether bodies are to have the fewest triangles, where that can be made."""
        asked, seen = self.profile.output.fewest_triangles, self.bindings[0]
        return FEWEST not in seen.cam.idle(seen.setup) if asked is None else asked

    def _made(self, part: Part) -> Solid:
        """A body that does not cross itself; as a regular grid where the fewest triangles cannot be made unasked."""
        if self._few:
            from camgeom.solid.fewest import fewest
            from camgeom.solid.lands import NotOneSurface

            try:
                solid = fewest(part, self.tolerance, self._free)
                refuse_overlap(part, solid)
                return solid
            except (NotOneSurface, NotConverged, DesignError) as error:
                if self.profile.output.fewest_triangles is not None:
                    if isinstance(error, NotOneSurface):
                        why = f"{error}: leave out output.fewest_triangles, the body is cut by a boolean"
                        raise DesignError(why) from error
                    raise
        solid = part.solid(self.tolerance, self._free)
        refuse_overlap(part, solid)
        return solid

    def _undercut_solid(self) -> Solid | None:
        """What the tools really leave of an undercut drum; None for other cams."""
        from camgeom.solid.cut import RollerUnion

        drum, blank = self.bindings[0].mechanism.drum, self.bindings[0].mechanism.blank
        if drum is None or drum.depth is None or blank is None:
            return None
        beyond = drum.radius + max(0.05 * drum.radius, 0.25 * drum.depth)
        cutters = tuple(cutter for one in self.bindings[0].grooves for cutter in one.cutters)
        return RollerUnion("cam", cutters, blank, beyond).solid(self.tolerance, self._free)

    @fact
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest walls of the bodies."""
        mechanisms = self._mechanisms
        return mechanisms[0].walls if len(mechanisms) == 1 else self.profile.cam.joined_walls(mechanisms, self._joined)

    @fact
    def mass(self) -> tuple[MassProperties, ...]:
        """Mass properties of every body from its mesh and the cam material's density."""
        from camgeom.maths.mesh import mass_properties

        density = self.profile.material.cam.density
        return tuple(MassProperties(*mass_properties(solid.mesh, density)) for solid in self.solids)

    @fact
    def turret_moment(self) -> float | None:
        """Moment of inertia of the turret's discs and rollers about its axis, kg m2 for a density of 1 kg/m3.

        None where the follower is no turret.

        Within the solids' tolerance, and no closer than its inertia is ever known.
        """
        from camgeom.maths.mesh import mass_properties
        from camgeom.track import Swing

        mechanism = self.bindings[0].mechanism
        if mechanism.turret is None:
            return None
        body, joint = mechanism.turret.body, mechanism.tracks[0].joint
        assert isinstance(joint, Swing)
        axis, moment = np.array(joint.axis), 0.0
        for mesh, alike in body.shares(max(self.tolerance, WEIGHED * body.size)):
            _, mass, centre, inertia = mass_properties(mesh, 1.0)
            away = np.array(centre) - np.array(joint.centre)
            across = away - away @ axis * axis
            moment += alike * float(axis @ np.array(inertia) @ axis + mass * MILLI**2 * (across @ across))
        return moment


def refuse_overlap(part: Part, solid: Solid) -> None:
    """Raise DesignError where a finished body crosses itself by more than its chord errors.

    A closed mesh may hold some regions twice or turned inside out, and is then no body: grooves or ribs that overlap,
    or passes of one groove, make such meshes, each triangle right by itself. The outlines of a prism, or a coarse mesh
    of any other body, tell it in a part of the time; where they do, the body's own mesh has the last word.
    """
    from camgeom.maths.crossing import crossings, outline, outlines_cross

    if not solid.mesh.watertight:
        return
    edges = outline(solid.mesh)
    coarse = COARSE * float(np.ptp(solid.mesh.vertices, axis=0).max())
    if edges is not None:
        if not outlines_cross(solid.mesh, edges, MARGIN * solid.largest_error):
            return
    elif coarse > 2.0 * solid.largest_error:
        try:
            rough = part.rough(coarse)
        except (DesignError, NotConverged):
            rough = solid
        if not len(crossings(rough.mesh, MARGIN * rough.largest_error)):
            return
    pairs = crossings(solid.mesh, MARGIN * solid.largest_error)
    if not len(pairs):
        return
    x, y, z = solid.mesh.vertices[solid.mesh.faces[pairs[0]]].mean(axis=(0, 1))
    radius, azimuth = np.hypot(x, y), np.degrees(np.arctan2(y, x)) % 360.0
    raise DesignError(
        f"the surface of {solid.name!r} crosses itself ({len(pairs)} pairs of faces, as at radius {radius:.4g} mm, "
        f"azimuth {azimuth:.4g} deg, z = {z:.4g} mm): grooves or ribs overlap, so it bounds no body; see wall and "
        "rib-thickness"
    )
