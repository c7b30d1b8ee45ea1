"""Groove and rib drums with cylindrical rollers on a sliding follower: figures of many variants at once.

At the distance R from the drum's axis the groove is the offset of a pitch curve with s' and s'', in closed form
(`mechanics.groove`): pressure angle, margin, curvature and contact are functions of (R, s', s''). A rib's walls are
those of a groove, each with a roller of its own: the one that pushes the follower up stands on the upper.
Arrays are (P, n), P samples of the cam angle and n variants; a leading axis of slices where there is one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from math import pi
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from camgeom.cams.cylindrical import Cylindrical
from camgeom.design.batch import Batch
from camgeom.design.batch.legs import motion_reason
from camgeom.design.batch.motion import LEAST, Motion, Points, motion_figures, motion_of, vertex
from camgeom.design.batch.variants import Variants
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import MILLI
from camgeom.mechanics.hertz import SHEAR_DEPTH, SHEAR_SHARE, flexibility
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import Demand, thrust_share
from camgeom.mechanics.pressing import SLICES
from camgeom.model import ALIKE
from camgeom.track.follower import CylinderRoller, TranslatingFollower
from camgeom.track.survey import STATIONS

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 1024
TURNS = 4
"""times that flexibilities and slice loads are computed in turn: each leaves about a tenth of the error before"""
ROUNDS = 5
"""Newton's steps towards the roller that stands nearest a point of a rib"""
STEEP = float(np.sqrt(2.0))
"""s' / R from which on the sharpest curvature may stand above the foot of the wall: R / (R² + s'²)^1.5 is largest at
R = s' / sqrt(2)"""

GEOMETRY = (
    "motion.stroke_mm",
    *motion_figures("mm", "rad"),
    "blank.diameter_mm",
    "blank.length_mm",
    "blank.volume_mm3",
    "flank.max_pressure_angle_deg",
    "flank.max_axis_pressure_angle_deg",
    "flank.pitch_radius_mm",
    "flank.pitch_pressure_angle_deg",
    "flank.undercut_margin",
    "flank.min_relative_radius_mm",
    "checks.relative-curvature",
    "checks.run-out",
    "checks.floor-gap",
)
RIB = "flank.rib_thickness_mm"
LOADED = (
    *motion_figures("mm", "s"),
    "contact.peak_pressure_mpa",
    "contact.peak_force_n",
    "contact.peak_torque_n_m",
    "contact.mean_torque_n_m",
    "contact.peak_slice_pressure_mpa",
    "contact.contact_length_mm",
    "contact.half_width_mm",
    "contact.peak_shear_mpa",
    "contact.shear_depth_mm",
    "fatigue.cam_life_h",
    "fatigue.cam_slice_life_h",
)


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives."""
    cam = profile.cam
    rib = (RIB,) if isinstance(cam, Cylindrical) and cam.form == "rib" else ()
    return GEOMETRY + rib + (LOADED if profile.operation is not None else ())


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where the closed forms hold; else why not."""
    cam = profile.cam
    assert isinstance(cam, Cylindrical)
    if cam.run_out:
        return "cam.run_out = true: what presses where is followed through the end face"
    if not isinstance(profile.follower, TranslatingFollower):
        return f"follower.kind = {profile.follower.kind!r}: the closed forms are those of a sliding follower"
    if not isinstance(profile.roller, CylinderRoller):
        shape = profile.roller.shape if profile.roller is not None else None
        return f"roller.shape = {shape!r}: the closed forms are those of a cylinder"
    for table, given in (("cutter", profile.cutter), ("impact", profile.impact)):
        if given is not None:
            return f"[{table}]: what it says is held against every variant by the exact model"
    if found := motion_reason(profile, varied):
        return found
    forced = profile.operation is not None and profile.operation.force
    for key in varied:
        if key.startswith("operation.force"):
            return f"{key}: every value makes another force"
        if forced and key.startswith("motion") and key.endswith("until"):
            return f"{key}: applied forces stay at their cam angles, elsewhere in every variant's motion"
        if (key == "cam.bore" and not cam.bore) or (key == "cam.pitch_radius" and cam.pitch_radius is None):
            return f"{key}: the profile gives none"
    return None


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants; all of them are smooth, so that none hangs on the level."""
    del level
    variants = Variants(profile, columns)
    forces = profile.operation.force if profile.operation is not None else ()
    cuts = tuple(angle for force in forces for angle in force.applied().breaks)
    drum = Groove(variants, motion_of(variants, cuts, _rest_under_force(profile)))
    drum.refuse()
    with np.errstate(all="ignore"):
        values = {name: variants.full(drum.figure(name)) for name in figures}
        variants.refusals.add(drum.margin <= 0.0, "undercut")
        if profile.operation is not None:
            variants.refusals.add(drum.jams, "the follower jams in its guides")
    return variants.refusals.batch(values)


@lru_cache(maxsize=8)
def _rest_under_force(profile: Profile) -> bool:
    """Whether an applied force acts while the follower rests, so that dwells have to be sampled."""
    forces = profile.operation.force if profile.operation is not None else ()
    rests = [span for span in profile.setup().program.spans if span.law == "dwell"]
    for force in (force.applied() for force in forces):
        for span in rests:
            inner = np.linspace(span.start, span.end, 361)[1:-1]
            if np.any(np.mod(inner - force.begin, 2.0 * pi) < force.length):
                return True
    return False


@final
@immutable
class Slices:
    """The contact in slices along the roller: its square of pressure, MPa², (m, P, n), and the length that touches."""

    square: Floats
    curvature: Floats
    touching: Floats


@final
@immutable
class Hard:
    """The hardest contacts of n variants, (n,) each.

    quoted, slice  largest pressure at the quoted radius and of all slices, MPa
    curvature, touching  relative curvature, 1/mm, and the length that touches, mm, at the hardest slice
    """

    quoted: Floats
    slice: Floats
    curvature: Floats
    touching: Floats

    @property
    def figures(self) -> tuple[Floats, ...]:
        """All of it in turn."""
        return self.quoted, self.slice, self.curvature, self.touching

    @property
    def peak(self) -> Floats:
        """The larger of both pressures, MPa."""
        return np.maximum(self.slice, self.quoted)


@final
class Groove:
    """The grooves or ribs of n variants; numbers are (n,) or (1,)."""

    def __init__(self, variants: Variants, motion: Motion) -> None:
        number = variants.number
        self.variants, self.motion, self.profile = variants, motion, variants.profile
        self.radius = 0.5 * number("cam.diameter")
        self.floor = self.radius - number("cam.groove_depth")
        self.roller = 0.5 * number("roller.diameter")
        self.length = number("roller.length")
        self.low = self.radius - self.length
        self.cutter = self.roller + number("cam.running_clearance")
        quoted = variants.optional("cam.pitch_radius")
        self.middle = 0.5 * (self.low + self.radius)
        self.pitch = self.middle if quoted is None else quoted
        assert isinstance(variants.profile.cam, Cylindrical)
        self.rib = variants.profile.cam.form == "rib"
        """Whether two rollers embrace a rib."""
        # Without a wall at the pitch radius the contact is quoted in the middle of what has one.
        self.quoted = np.where((self.low <= self.pitch) & (self.pitch <= self.radius), self.pitch, self.middle)

    def refuse(self) -> None:
        """Give what `Cylindrical.problems` has against a variant, in its order."""
        number, refusals = self.variants.number, self.variants.refusals
        depth, bore = number("cam.groove_depth"), number("cam.bore")
        width, deep = number("cam.keyway_width"), number("cam.keyway_depth")
        cannot = "cannot be built"
        refusals.add(depth >= self.radius, f"cam.groove_depth: {cannot}")
        if self.variants.optional("cam.bore") is not None and np.all(bore > 0.0):
            reach = np.where(width > 0.0, np.hypot(0.5 * bore + deep, 0.5 * width), 0.5 * bore)
            refusals.add(width >= bore, f"cam.keyway_width: {cannot}")
            refusals.add((width > 0.0) != (deep > 0.0), f"cam.keyway_depth: {cannot}")
            refusals.add(reach >= self.floor, f"cam.bore: {cannot}")
        refusals.add(self.length > depth, f"roller.length: {cannot}")
        refusals.add((self.pitch < self.low) | (self.pitch > self.radius), f"cam.pitch_radius: {cannot}")
        start, (least, most) = number("cam.start"), self.motion.lift_range
        meets = (start > -most - self.half) & (start < number("cam.length") - least + self.half)
        refusals.add(~meets, f"cam.start: {cannot}")

    @property
    def half(self) -> Floats:
        """From the pitch curve to the wall of a dwell, mm: half the rib, or the roller's radius in a groove."""
        return 0.5 * self.variants.number("cam.rib_thickness") if self.rib else self.roller

    def figure(self, name: str) -> Floats:
        """One of the figures, (n,) or (1,)."""
        if name.startswith("motion."):
            return self.motion.figure(name, 1.0, self.speed if self.profile.operation is not None else 0.0)
        return FIGURES[name](self)

    # Geometry

    def angle(self, radius: Floats) -> Floats:
        """Largest pressure angle, deg, at a distance from the drum's axis."""
        return np.asarray(np.degrees(np.arctan2(self.motion.peaks[0], radius)))

    def folding(self, radius: Floats, points: Points) -> Floats:
        """r k of the pitch surface towards the wall that it undercuts first, k its larger curvature."""
        # With q = 1 / (R² + s'²) that curvature is q (w + sqrt(w² + 4 s'²)) / 2, w = R |s''| sqrt q.
        slope = points.ds * points.ds
        q = 1.0 / (radius * radius + slope)
        w = np.sqrt(q)
        w *= radius * np.abs(points.dds)
        root = w * w
        root += 4.0 * slope
        np.sqrt(root, out=root)
        root += w
        root *= q
        return np.asarray(root * (0.5 * self.cutter))

    def effective_radius(self, sign: float, radius: Floats, points: Points) -> Floats:
        """Relative radius times sign, mm: +1 on the wall where it is larger, -1 where it is less (a cusp has none)."""
        q = 1.0 / (radius * radius + points.ds * points.ds)
        turned = q * (self.roller * points.ds)
        turned *= turned
        q *= np.sqrt(q)
        bent = q * ((sign * radius * self.roller) * np.abs(points.dds))
        bent += 1.0
        bent -= turned
        turned += 1.0
        bent /= turned
        bent *= sign * self.roller
        return bent

    def _across(self, signed: Floats, twist2: Floats) -> Floats:
        """Relative curvature of a wall whose pitch curve is curved by `signed` away from it, 1/mm.

        The denominator is kept from zero, as that of the exact flank is.
        """
        rest = self.roller * signed
        rest += 1.0
        rest -= twist2
        rest[np.abs(rest) <= 1e-12] = 1e-12
        rest *= self.roller
        return np.asarray((1.0 + twist2) / rest)

    def _worst(self, what: Callable[[Floats, Points], Floats], low: Floats) -> Floats:
        """Largest of a quantity over the turn and over the stations from `low` to the land, (n,)."""
        motion = self.motion
        if np.all(self.motion.peaks[0] <= STEEP * low):
            return motion.largest(partial(what, low))
        share = np.linspace(0.0, 1.0, STATIONS)
        radii = low + (self.radius - low) * share[:, None]
        values = np.array(what(low, motion.samples))
        # The others matter on steep flanks alone.
        rows = np.flatnonzero((np.abs(motion.samples.ds) > STEEP * low).any(axis=1))
        steep = motion.samples.of(rows)
        values[rows] = np.max([values[rows], *(what(radius, steep) for radius in radii[[STATIONS // 2, -1]])], axis=0)
        piece, step = motion.peak(values)
        near = motion.around(piece, step)
        height = np.stack([what(radius, near)[1] for radius in radii])
        best = np.broadcast_to(radii, height.shape)[height.argmax(axis=0), np.arange(motion.size)]
        return motion.top(partial(what, best), values)[1]

    @cached_property
    def margin(self) -> Floats:
        """Least margin against undercut over the wall, 1: from the tool's end up, of a rib from the drum beside it."""
        if not self.rib:
            return np.asarray(1.0 - self._worst(self.folding, self.floor))
        shares = (0.0,) if np.all(self.motion.peaks[0] <= STEEP * self.floor) else (0.0, 0.5, 1.0)
        folds = [self.motion.largest(partial(self._rib_folding, share)) for share in shares]
        return np.asarray(1.0 - np.max(folds, axis=0))

    def _rib_folding(self, share: float, points: Points) -> Floats:
        """The same as `folding` at a share of a rib's wall from its foot up."""
        foot = self._under(self.floor, self.cutter, points)
        return self.folding(foot + share * (self.radius - foot), points)

    @property
    def thickness(self) -> Floats:
        """Least normal thickness of a rib, mm, at its tip and its foot: how far points of either wall are from all
        places of the other's roller."""
        places = [(radius, way) for radius in (self.radius, self.floor) for way in (1.0, -1.0)]
        return np.asarray(np.min([self.motion.smallest(partial(self._thick, *place)) for place in places], axis=0))

    def _thick(self, radius: Floats, way: float, points: Points) -> Floats:
        """Distance, mm, of the wall of the upper, 1, or lower, -1, roller from the other one where that is nearest."""
        half = self.half + self.roller
        place = self._under(radius, self.cutter, points)
        far = np.hypot(place, points.ds)
        sine, cosine = points.ds / far, place / far
        angle = points.theta + np.arctan2(way * self.cutter * sine, place)
        height = points.s + way * (half - self.cutter * cosine)
        at = points.theta + np.arctan2(2.0 * way * half * cosine * sine, place)
        for _ in range(ROUNDS):
            other = self.motion.whenever(at)
            lag, up = angle - at, height - other.s + way * half
            # of half the square of the distance
            slope = -0.5 * radius**2 * np.sin(2.0 * lag) - up * other.ds
            bend = radius**2 * np.cos(2.0 * lag) + other.ds**2 - up * other.dds
            at = at - np.clip(slope / np.maximum(np.abs(bend), LEAST), -0.1, 0.1)
        other = self.motion.whenever(at)
        return np.asarray(np.hypot(radius * np.sin(angle - at), height - other.s + way * half) - self.cutter)

    @property
    def least_radius(self) -> Floats:
        """Smallest relative radius, mm; 0 of a cusp."""
        return np.maximum(-self._worst(partial(self.effective_radius, -1.0), self.low), 0.0)

    @property
    def dullest(self) -> Floats:
        """Smallest relative curvature, 1/mm."""
        return np.asarray(1.0 / self._worst(partial(self.effective_radius, 1.0), self.low))

    @property
    def run_out(self) -> Floats:
        """From the roller's contact to the nearer end of the drum, mm."""
        (least, most), number = self.motion.lift_range, self.variants.number
        return np.asarray(np.minimum(number("cam.start") + least, number("cam.length") - number("cam.start") - most)
                          - self.half)

    # Load

    @cached_property
    def demand(self) -> Demand:
        """What acts on the follower."""
        number, operation = self.variants.number, self.profile.operation
        assert operation is not None
        mass = number("follower.mass") + number("operation.load_mass")
        return Demand(
            self.speed, mass, number("operation.friction"), number("operation.spring_preload"),
            number("operation.spring_rate"), mass * number("operation.gravity"),
            tuple(force.applied() for force in operation.force),
        )  # fmt: skip

    @cached_property
    def speed(self) -> Floats:
        """Cam speed, rad/s."""
        return np.asarray(self.variants.number("operation.speed") * (2.0 * pi / 60.0))

    def force(self, points: Points) -> Floats:
        """Force that the follower needs, N."""
        return self.demand.force(points.theta, (points.s, points.ds, points.dds), points.side)[0]

    @cached_property
    def _force(self) -> Floats:
        return self.force(self.motion.samples)

    @cached_property
    def guided(self) -> bool:
        """Whether the follower's guides have friction."""
        return bool(np.any(self.variants.number("operation.guide_friction") != 0.0))

    def _share(self, force: Floats, points: Points, radius: Floats | None = None) -> Floats:
        """Normal force at a radius, mm, over the follower's force is 1 over this; in the middle where none is given."""
        radius = self.middle if radius is None else radius
        cosine = radius / np.sqrt(radius * radius + points.ds * points.ds)
        if not self.guided:
            return np.asarray(cosine)
        return thrust_share(force, cosine, self.variants.number("operation.guide_friction"), points.side)

    @cached_property
    def jams(self) -> NDArray[np.bool_]:
        """Whether the follower jams in its guides."""
        if not self.guided:
            return np.zeros(1, dtype=bool)
        return np.asarray((self._share(self._force, self.motion.samples) <= 0.0).any(axis=0))

    def normal(self, points: Points, force: Floats | None = None) -> Floats:
        """Normal force in the middle of the contact, N, positive on the wall behind."""
        force = self.force(points) if force is None else force
        return np.asarray(force / self._share(force, points))

    def pushed(self, points: Points, force: Floats | None = None) -> Floats:
        """Force along the motion with the friction of the guides, N."""
        force = self.force(points) if force is None else force
        if not self.guided:
            return force
        cosine = self.middle / np.sqrt(self.middle * self.middle + points.ds * points.ds)
        return np.asarray(cosine * self.normal(points, force))

    @cached_property
    def peak_force(self) -> Floats:
        """Largest normal force at the quoted radius, N."""

        def normal(points: Points, force: Floats | None = None) -> Floats:
            force = self.force(points) if force is None else force
            return np.abs(force / self._share(force, points, self.quoted))

        return self.motion.largest(normal, normal(self.motion.samples, self._force))

    @cached_property
    def peak_torque(self) -> Floats:
        """Largest torque of the camshaft, N m."""

        def torque(points: Points, force: Floats | None = None) -> Floats:
            return np.abs(self.pushed(points, force) * points.ds)

        return MILLI * self.motion.largest(torque, torque(self.motion.samples, self._force))

    @cached_property
    def mean_torque(self) -> Floats:
        """Mean torque of the camshaft, N m: inertia, springs and weight give back what they take."""
        d, points = self.demand, self.motion.samples
        lost = d.friction * np.abs(points.ds)
        for one in d.applied:
            lost = lost + d.of(one, points.theta, (points.s, points.ds, points.dds)) * points.ds
        work = self.motion.integral(lost)
        if self.guided:
            # The side thrust has a kink where the force changes walls.
            work = work + self.motion.fine_integral(lambda p: (self.pushed(p) - self.force(p)) * p.ds)
        return MILLI * work / (2.0 * pi)

    # Contact

    @cached_property
    def pair(self) -> Floats:
        """Compliance of the two bodies, 1/MPa."""
        return self.compliance("roller") + self.compliance("cam")

    def compliance(self, body: str) -> Floats:
        """Plane-strain compliance of a body, 1/MPa."""
        poisson = self.variants.number(f"material.{body}.poisson")
        return np.asarray((1.0 - poisson * poisson) / self.variants.number(f"material.{body}.elastic_modulus"))

    def square(self, points: Points, force: Floats | None = None) -> Floats:
        """Square of the pressure at the quoted radius, MPa²."""
        force = self.force(points) if force is None else force
        normal = force / self._share(force, points, self.quoted)
        q = 1.0 / (self.quoted * self.quoted + points.ds * points.ds)
        kappa = self.quoted * points.dds * q * np.sqrt(q)
        turned = self.roller * points.ds * q
        turned *= turned
        k = self._across(np.copysign(1.0, normal) * kappa, turned)
        k *= np.abs(normal)
        return np.asarray(k / (self.length * pi * self.pair))

    @property
    def pressure(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of the hardest pressed roller."""
        return self.hardest.quoted

    def stretch(self, points: Points) -> Floats:
        """Length of the roller that touches, mm.

        On a steep flank the contact line leaves the land below its edge: with x the square of the place along the axis
        x² + (s'² - R²) x + s'² (r² - R²) = 0.
        """
        return np.asarray(np.clip(self._under(self.radius, self.roller, points) - self.low, 0.0, self.length))

    @staticmethod
    def _under(radius: Floats, roller: Floats, points: Points) -> Floats:
        """Place on a roller's axis, mm from the drum's, of the contact that lies so far from the drum's axis."""
        outer, slope = radius * radius, points.ds * points.ds
        both = outer + slope
        root = np.sqrt(np.maximum(both * both - 4.0 * slope * (roller * roller), 0.0))
        return np.asarray(np.sqrt(np.maximum(0.5 * (outer - slope + root), 0.0)))

    def slices(self, points: Points, which: Sequence[int] | None = None) -> Slices:
        """The contact of slices that approach alike (default all of them); with `which`, as if alike flexible."""
        touching = self.stretch(points)
        share = (np.arange(SLICES) if which is None else np.array(which)) + 0.5
        place = self.low + touching * (share[:, None, None] / SLICES)
        square = place * place + points.ds * points.ds
        cosine = place / np.sqrt(square)
        force = self.pushed(points)
        kappa = cosine * points.dds / square
        turned = self.roller * points.ds / square
        k = self._across(np.where(force >= 0.0, kappa, -kappa), turned * turned)
        k = np.where(k > 0.0, k, 1.0 / self.roller)
        size, width = np.abs(force), touching / SLICES
        if which is not None:
            # cos² along the line by Simpson's rule
            ends = [(x * x) / (x * x + points.ds * points.ds)
                    for x in (self.low, self.low + 0.5 * touching, self.low + touching)]
            line = size * cosine / (touching * (ends[0] + 4.0 * ends[1] + ends[2]) / 6.0)
        else:
            line = np.broadcast_to(size / (width * cosine.sum(axis=0)), cosine.shape)
            least = np.maximum(1e-6 * line, 1e-30)
            for _ in range(TURNS):
                line = self._shared(line, least, k, cosine, size, width)
        return Slices(line * k / (pi * self.pair), k, touching)

    def _shared(self, line: Floats, least: Floats, k: Floats, cosine: Floats, size: Floats, width: Floats) -> Floats:
        """Load per length of slices (m, P, n) whose flexibility is that under a load per length; see `share_load`."""
        half = 2.0 * np.sqrt(np.maximum(line, least) * self.pair / (pi * k))
        far = np.log(4.0 * self.roller / half)
        soft = flexibility(far, far, self.compliance("roller"), self.compliance("cam"),
                           self.variants.number("material.cam.poisson"))  # fmt: skip
        stiff = cosine / soft
        return np.asarray(stiff * (size / (width * (stiff * cosine).sum(axis=0))))

    @cached_property
    def hardest(self) -> Hard:
        """The hardest contact: of a rib's rollers, one pressed upwards and one downwards, that of the harder."""
        if not self.rib:
            return self._hards[0]
        lower, upper = self._hards
        mine = lower.peak >= (1.0 - ALIKE) * np.maximum(lower.peak, upper.peak)
        return Hard(*(np.where(mine, one, other) for one, other in zip(lower.figures, upper.figures)))

    @cached_property
    def _hards(self) -> tuple[Hard, ...]:
        """Of every roller."""
        return tuple(self._hard(way) for way in ((-1.0, 1.0) if self.rib else (0.0,)))

    @property
    def wearing(self) -> Floats:
        """Largest pressure at the quoted radius, MPa, of any roller: what the cam's life is quoted with."""
        return np.asarray(np.max([one.quoted for one in self._hards], axis=0))

    def _hard(self, way: float) -> Hard:
        """The hardest contact where the follower is pushed up, 1, down, -1, or either way, 0."""
        on, size = self.motion, self.variants.size

        def pushed(values: Floats, points: Points, force: Floats | None = None) -> Floats:
            if way == 0.0:
                return values
            force = self.force(points) if force is None else force
            return np.where(np.copysign(1.0, force) == way, values, 0.0)

        quoted = on.largest(lambda p: pushed(self.square(p), p),
                            pushed(self.square(on.samples, self._force), on.samples, self._force))  # fmt: skip
        ends = pushed(self.slices(on.samples, (0, SLICES - 1)).square.max(axis=0), on.samples, self._force)
        piece, _ = on.peak(ends)
        within = on.piece(piece)
        step = on.step_in(pushed(self.slices(within).square.max(axis=0), within))
        points = on.around(piece, step)
        near = self.slices(points)
        square = pushed(near.square, points)
        rows = square[:, 1].argmax(axis=0), np.arange(size)
        at, value = vertex(*(square[rows[0], k, rows[1]] for k in range(3)))
        k, touching = (one[1] + 0.5 * at * (one[2] - one[0])
                       for one in (near.curvature[rows[0], :, rows[1]].T, near.touching))
        return Hard(np.sqrt(np.maximum(quoted, 0.0)), np.sqrt(value), k, touching)

    @property
    def peak_slice(self) -> Floats:
        """Largest pressure of all slices and the quoted place, MPa."""
        return self.hardest.peak

    @property
    def half_width(self) -> Floats:
        """Half-width of the hardest slice's contact, mm."""
        return np.asarray(2.0 * self.hardest.slice * self.pair / self.hardest.curvature)

    def cam_life(self, pressure: Floats) -> Floats:
        """Fatigue life of the cam's wall under a pressure once in a turn, h."""
        limit, cycles, exponent = (
            self.variants.number(f"material.cam.{key}") for key in ("contact_limit", "contact_cycles", "exponent")
        )
        return hours((pressure / limit) ** exponent / cycles, self.speed)


FIGURES: dict[str, Callable[[Groove], Floats]] = {
    "blank.diameter_mm": lambda g: 2.0 * g.radius,
    "blank.length_mm": lambda g: g.variants.number("cam.length"),
    "blank.volume_mm3": lambda g: pi * g.radius**2 * g.variants.number("cam.length"),
    "flank.max_pressure_angle_deg": lambda g: g.angle(g.low),
    "flank.max_axis_pressure_angle_deg": lambda g: g.angle(g.low),
    "flank.pitch_radius_mm": lambda g: g.pitch,
    "flank.pitch_pressure_angle_deg": lambda g: g.angle(g.pitch),
    "flank.undercut_margin": lambda g: g.margin,
    RIB: lambda g: g.thickness,
    "flank.min_relative_radius_mm": lambda g: g.least_radius,
    "checks.relative-curvature": lambda g: g.dullest,
    "checks.run-out": lambda g: g.run_out,
    "checks.floor-gap": lambda g: g.low - g.floor,
    "contact.peak_pressure_mpa": lambda g: g.pressure,
    "contact.peak_force_n": lambda g: g.peak_force,
    "contact.peak_torque_n_m": lambda g: g.peak_torque,
    "contact.mean_torque_n_m": lambda g: g.mean_torque,
    "contact.peak_slice_pressure_mpa": lambda g: g.peak_slice,
    "contact.contact_length_mm": lambda g: g.hardest.touching,
    "contact.half_width_mm": lambda g: g.half_width,
    "contact.shear_depth_mm": lambda g: g.half_width * SHEAR_DEPTH,
    "contact.peak_shear_mpa": lambda g: g.hardest.slice * SHEAR_SHARE,
    "fatigue.cam_life_h": lambda g: g.cam_life(g.wearing),
    "fatigue.cam_slice_life_h": lambda g: g.cam_life(g.peak_slice),
}
