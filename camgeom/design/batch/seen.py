"""One touch of a planar cam at samples of the motion, of many variants: geometry, force and contact.

Curvature, pressure angle, lever and force do not hang on how far the cam has turned, so that all of it is computed in
the machine's frame: seen from the turning cam a point c has the velocity c' - i sense c. The formulas are those of the
exact model (`track.outline`, `mechanics.load`, `mechanics.hertz`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, final
from weakref import proxy

import numpy as np

from camgeom.design.batch.motion import Points
from camgeom.design.batch.touches import Slide, Touch
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.load import thrust_share
from camgeom.track.outline import Pair, face_contact, outward_normal, pitch_curvature, swung_face

if TYPE_CHECKING:
    from camgeom.design.batch.planar import Cams


@final
class Seen:
    """One touch at samples of the motion; each (P, n) or a shape that meets it."""

    def __init__(self, cams: Cams, touch: Touch, points: Points) -> None:
        # A cam has these: what they need of it must not keep it, and all its arrays, alive in turn.
        self.cams: Cams = proxy(cams)
        self.touch, self.points = touch, points
        p = points
        if touch.shift is not None:
            p = replace(p, s=p.s + touch.shift)
        if touch.turned:
            low, high = cams.motion.lift_range
            p = replace(p, s=low + high - p.s, ds=-p.ds, dds=-p.dds)
        self.moving = p

    @cached_property
    def jets(self) -> tuple[Pair, Pair, Pair]:
        """The centre of the roller, or the edge, in the machine's frame."""
        return self.touch.joint.jets(self.moving)

    @cached_property
    def d(self) -> Pair:
        """Its velocity seen from the turning cam, mm/rad."""
        (x, y), (u, v), _ = self.jets
        sense = self.cams.sense
        return u + sense * y, v - sense * x

    @cached_property
    def pace(self) -> Floats:
        """The size of that, mm/rad."""
        return np.asarray(np.sqrt(self.d[0] * self.d[0] + self.d[1] * self.d[1]))

    @cached_property
    def rolled(self) -> Floats:
        """Path that a roller's rim turns by about its pin, mm/rad."""
        return np.abs(self.turned)

    @cached_property
    def turned(self) -> Floats:
        """The same with the sign of the way in which it turns: it turns with the arm, and once less (more) a turn round
        a convex (hollow) flank than its middle's path gives."""
        r, joint = self.touch.radius, self.touch.joint
        assert r is not None
        turning = 1.0 if isinstance(joint, Slide) else 1.0 + (self.cams.sense * joint.way) * self.moving.ds
        return np.asarray(self.pace - (self.touch.material * r) * turning)

    @cached_property
    def bend(self) -> Floats:
        """Curvature of the pitch curve, 1/mm, positive where the cam's material is convex."""
        (x, y), (u, v), (du, dv) = self.jets
        sense = self.cams.sense
        dd = du + (2.0 * sense) * v - x, dv - (2.0 * sense) * u - y
        return np.asarray(self.touch.material * pitch_curvature(self.d, dd, self.pace, sense))

    @cached_property
    def face(self) -> tuple[Pair, Floats, Floats, Floats]:
        """Of a flat face: unit normal, support, place of the contact along it and radius of the profile, mm."""
        p, touch, sense = self.moving, self.touch, self.cams.sense
        joint = touch.joint
        if isinstance(joint, Slide):
            support = joint.x + p.s
            return (np.ones(1), np.zeros(1)), support, -sense * p.ds, support + p.dds
        assert touch.offset is not None
        jets = np.stack(np.broadcast_arrays(p.s, p.ds, p.dds))
        beta, h = swung_face(jets, joint.start, joint.centre, touch.offset)
        psi = joint.way * beta
        psi[1] -= sense
        along, radius = face_contact(psi, h)
        return (np.cos(psi[0]), np.sin(psi[0])), h[0], along, radius

    @cached_property
    def face_radius(self) -> Floats:
        """Radius of curvature of the profile under a flat face, mm."""
        return self.face[3]

    @cached_property
    def normal(self) -> Pair:
        """Outward normal of the profile, in the machine's frame."""
        if self.touch.radius is None:
            return self.face[0]
        return outward_normal(self.d, self.pace, self.cams.sense)

    @cached_property
    def place(self) -> Pair:
        """The point of contact, mm."""
        n = self.normal
        if self.touch.radius is None:
            _, h, along, _ = self.face
            return h * n[0] - along * n[1], h * n[1] + along * n[0]
        (x, y), _, _ = self.jets
        back = -self.touch.material * (self.touch.radius + self.touch.gap)
        return x + back * n[0], y + back * n[1]

    @cached_property
    def lever(self) -> Floats:
        """Velocity of the contact along the outward normal by the coordinate: 1 or mm/rad."""
        if self.touch.turned:
            return -np.ones(1)
        if isinstance(self.touch.joint, Slide):
            return self.normal[0]
        at = self.jets[0] if self.touch.radius is not None else self.place
        e, n = self.touch.joint.moved(at), self.normal
        return np.asarray(n[0] * e[0] + n[1] * e[1])

    @cached_property
    def half_tangent(self) -> Floats:
        """Tangent of half the pressure angle, a size: of a roller at its centre, else where it touches."""
        touch, n = self.touch, self.normal
        if touch.radius is None and isinstance(touch.joint, Slide):
            return np.zeros(1)
        if isinstance(touch.joint, Slide):
            return np.asarray(np.abs(n[1]) / (1.0 + (touch.way * touch.material) * n[0]))
        at = self.jets[0] if touch.kind == "roller" else self.place
        e = touch.joint.moved(at)
        square = touch.way * touch.material * (e[0] * n[0] + e[1] * n[1])
        return np.asarray(np.abs(e[0] * n[1] - e[1] * n[0]) / (np.sqrt(e[0] * e[0] + e[1] * e[1]) + square))

    @cached_property
    def sliding(self) -> Floats:
        """Of the cam over what does not roll, mm/rad."""
        (x, y), n, sense, ds = self.place, self.normal, self.cams.sense, self.moving.ds
        if self.touch.turned:
            return np.abs(x + 0.0 * ds)
        e = self.touch.joint.moved((x, y))
        return np.asarray(np.abs((ds * e[1] - sense * x) * n[0] - (ds * e[0] + sense * y) * n[1]))

    @cached_property
    def along_size(self) -> Floats:
        """Width that the contact needs of a flat face, or its length from the pivot on, mm."""
        joint = self.touch.joint
        if isinstance(joint, Slide):
            return np.asarray(2.0 * np.abs(self.face[2] - self.touch.way * self.cams.offset))
        (x, y), n = self.place, self.normal
        return np.asarray(np.abs(y * n[0] - (x - joint.centre) * n[1]))

    @cached_property
    def reach(self) -> Floats:
        """Square of the distance of the contact from the cam axis, mm²."""
        x, y = self.place
        return np.asarray(x * x + y * y)

    @cached_property
    def force(self) -> Floats:
        """What the follower needs along its motion, N (N mm)."""
        return self.cams.force(self.points)

    @cached_property
    def pushed(self) -> Floats:
        """The size of what this touch gives of it, with the friction of the guides: it pushes one way."""
        pushed = np.maximum(self.force if self.touch.way > 0.0 else -self.force, 0.0)
        if self.cams.guide is None:
            return pushed
        cosine = np.minimum(np.abs(self.lever), 1.0)
        share = thrust_share(self.touch.way * pushed, cosine, self.cams.guide, self.points.side)
        return np.asarray(cosine * pushed / np.where(share > 0.0, share, 1.0))

    @cached_property
    def pressing(self) -> Floats:
        """Normal force, N."""
        return np.asarray(self.pushed / np.abs(self.lever))

    @cached_property
    def needed(self) -> Floats:
        """Normal force that the follower needs, N: below zero it would have to be pulled."""
        return np.asarray(np.where(self.force > 0.0, self.pressing, self.force / self.lever))

    @cached_property
    def relative_radius(self) -> Floats:
        """One over the relative curvature of cam against follower, mm."""
        r = self.touch.radius
        return self.face_radius if r is None else np.asarray(r - (r * r) * self.bend)

    @cached_property
    def square(self) -> Floats:
        """Squared peak pressure, MPa²."""
        scale = self.cams.length * np.pi * self.cams.compliance
        return np.asarray(self.pressing / (scale * np.maximum(self.relative_radius, 1e-9)))

    @cached_property
    def signed_square(self) -> Floats:
        """The same, negative where this touch would have to pull: without a kink where the load leaves it."""
        cosine = np.minimum(np.abs(self.lever), 1.0)
        share = np.ones(1)
        if self.cams.guide is not None:
            share = thrust_share(self.force, cosine, self.cams.guide, self.points.side) / cosine
        scale = self.touch.way * self.cams.length * np.pi * self.cams.compliance * np.abs(self.lever) * share
        return np.asarray(self.force / (scale * np.maximum(self.relative_radius, 1e-9)))

    @cached_property
    def spread(self) -> Floats:
        """Square of pressure times relative radius, MPa² mm²."""
        return np.asarray(self.square * self.relative_radius * self.relative_radius)
