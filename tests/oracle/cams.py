"""Judges of whole cam bodies: every follower's place and every blank written again from the profile's own keys.

`judges_of(data, lift, low, high, ends)` takes the plain tables of a profile and the lift over the cam angle, and gives
one `Judge` for each body. A judge measures the least signed distance of points to the follower over the whole motion
(negative: the follower cuts in there) and says which points lie on the blank. No envelope, no derivative, no package
code.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import acos, asin, cos, pi, radians, sin, sqrt, tan

import numpy as np
from scipy.spatial import cKDTree

from tests.oracle.envelope import roller_distance

GOLDEN = 0.5 * (sqrt(5.0) - 1.0)
TURN = 2.0 * pi
BODY = ("kind", "width", "bore", "keyway_width", "keyway_depth", "direction")
"""keys of a disc that all of its tracks have in common"""
FAR = 1e30


@dataclass
class Judge:
    """distance(x, phi, k): signed distance of points to follower number k at cam angle phi (all broadcast);
    loose: the same to a follower that reaches as deep as the tool, where that is deeper than the follower itself;
    blank(x): distance of points from the stock's surface, mm; floors: face groups that need no contact."""

    distance: Callable
    blank: Callable
    followers: int = 1
    loose: Callable | None = None
    floors: tuple[str, ...] = ()
    genus: int = 0
    grid: np.ndarray = field(default_factory=lambda: np.linspace(0.0, TURN, 1441))

    def least(self, x, loose=False, keep=2, rounds=44):
        """Least distance (n,) of points (n, 3) over the motion and all followers: dense samples, golden section."""
        f = self.loose if loose and self.loose else self.distance
        best = np.full(len(x), np.inf)
        ks = np.arange(self.followers)
        size = max(1, 3_000_000 // (len(self.grid) * self.followers))
        for block in np.array_split(np.arange(len(x)), max(1, -(-len(x) // size))):
            value = f(x[block][:, None, None], self.grid[None, :, None], ks[None, None, :])
            rows = np.arange(len(block))
            left = np.concatenate([value[:, :1] + 1.0, value[:, :-1]], axis=1)
            right = np.concatenate([value[:, 1:], value[:, -1:] + 1.0], axis=1)
            flat = np.where((value <= left) & (value <= right), value, np.inf).reshape(len(block), -1)
            order = np.argpartition(flat, keep, axis=1)[:, :keep]
            for j in range(keep):
                at, k = np.divmod(order[:, j], self.followers)
                lo, hi = self.grid[np.maximum(at - 1, 0)], self.grid[np.minimum(at + 1, len(self.grid) - 1)]
                found = _golden(lambda p, k=k, b=block: f(x[b], p, k), lo, hi, rounds)
                best[block] = np.minimum(best[block], np.minimum(found, flat[rows, order[:, j]]))
        return best


def _golden(f, lo, hi, rounds):
    p, q = hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo)
    fp, fq = f(p), f(q)
    best = np.minimum(fp, fq)
    for _ in range(rounds):
        low = fp < fq
        hi, lo = np.where(low, q, hi), np.where(low, lo, p)
        new_p, new_q = hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo)
        fresh = f(np.where(low, new_p, new_q))
        fp, fq = np.where(low, fresh, fq), np.where(low, fp, fresh)
        p, q = new_p, new_q
        best = np.minimum(best, fresh)
    return best


def oracle_of(one, data):
    """The oracle of a cam with one track, of a model's motion and its profile's tables."""
    program = one.setup.program
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(data, lambda phi: program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi)), low, high, ends)
    return oracle


def judges_of(data, lift, low, high, ends, others=()):
    """One judge a body. lift(phi): mm or rad; low, high: its extremes; ends: cam angles where segments end.

    others: (lift, low, high) of every further [[track]], whose tables override those of the first.
    """
    cam = data["cam"]
    if corner := data.get("cutter", {}).get("corner_radius"):
        cam = {**cam, "root_radius": corner}
    if second := data.get("return_roller"):
        cam = {**cam, "return_roller": second}
    judges = JUDGES[cam["kind"]](cam, data["follower"], data.get("roller"), lift, low, high)
    for (own, follower, roller), more in zip(_further(cam, data), others, strict=True):
        judges += JUDGES[cam["kind"]](own, follower, roller, *more)
    judges = [_one_body(judges)] if others else judges
    marks = np.unique(np.concatenate([[0.0, TURN], ends]))
    for judge in judges:
        fine = 1440 if judge.followers <= 2 else 480
        parts = [np.linspace(a, b, max(24, int(fine * (b - a) / TURN) + 2)) for a, b in zip(marks[:-1], marks[1:])]
        judge.grid = np.unique(np.concatenate(parts))
    return judges


def _further(cam, data):
    """[cam], [follower] and [roller] of every further [[track]], whose tables override those of the first."""
    found = []
    for table in data.get("track", ()):
        own = {**cam, **table.get("cam", {})}
        if own.get("form") != cam.get("form"):
            own = {key: value for key, value in cam.items() if key in BODY} | table["cam"]
        follower = table.get("follower", {})
        follower = follower if "kind" in follower else {**data["follower"], **follower}
        found.append((own, follower, table.get("roller", data.get("roller"))))
    return found


def disc_walls(data, lifts, count=4001):
    """Walls between the tracks of a disc by the rollers' centres alone: name -> mm, and what they may be off.

    A groove is all that its roller sweeps, as wide as the clearance makes it; what is left between two such swaths is
    the distance of the centres' ways less both radii, in the plane and, of both faces, along the axis too.
    """
    phi, found = np.linspace(0.0, TURN, count), {}
    tables = [(data["cam"], data["follower"], data["roller"]), *_further(data["cam"], data)]
    ways, width = [], data["cam"]["width"]
    for (cam, follower, roller), lift in zip(tables, lifts):
        turn = np.exp(-1j * _sense(data["cam"]) * phi)
        x, y = np.broadcast_arrays(*_place(cam, follower, 0.5 * roller["diameter"], lift)(phi), phi)[:2]
        ways.append((x + 1j * y) * turn)
    # Samples beside the nearest places seem further apart by what a step across adds to a distance of two radii.
    steps = max(float(np.abs(np.diff(way)).max()) for way in ways)
    thin = min(float(_swath(table, width)[1].min()) for table in tables)
    off = steps**2 / (2.0 * thin) + 1e-9 * max(float(np.abs(way).max()) for way in ways)

    def apart(i, j):
        points = [np.stack([way.real, way.imag], axis=1) for way in (ways[i], ways[j])]
        return float(cKDTree(points[0]).query(points[1])[0].min())

    grooves = [i for i, (cam, _, _) in enumerate(tables) if cam.get("form") == "groove"]
    profile = next((i for i, (cam, _, _) in enumerate(tables) if cam.get("form") != "groove"), None)
    for i in grooves:
        rim = (np.array([0.0, width]), np.zeros(2)) if profile is None else _swath(tables[profile], width)
        between = apart(i, profile) if profile is not None else 0.5 * data["cam"]["diameter"] - np.abs(ways[i]).max()
        found[f"groove {i + 1}, outer flank to rim"] = _across(_swath(tables[i], width), rim, between)
    if len(grooves) == 2:
        i, j = grooves
        one, other = (_swath(tables[k], width) for k in grooves)
        floors = [(z[-1], r[-1]) if tables[k][0].get("face") == "lower" else (z[0], r[0])
                  for k, (z, r) in zip(grooves, (one, other))]  # fmt: skip
        web = width - sum(tables[k][0]["groove_depth"] for k in grooves)
        aside = apart(i, j) - floors[0][1] - floors[1][1]
        if abs(aside) > off:
            edge = "floor to floor" if aside <= 0.0 else "edge to edge"
            found[f"groove {i + 1} to groove {j + 1}, {edge}"] = (
                web if aside <= 0.0 else _across(one, other, apart(i, j))
            )
    return found, off


def _swath(table, width):
    """Heights of a wall's lower and upper end, and how far from the way of the roller's middle it stands there, mm."""
    cam, _, roller = table
    depth, below = cam.get("groove_depth", width), cam.get("face") == "lower" and cam.get("form") == "groove"
    z = np.array([0.0, depth]) if below else np.array([width - depth, width])
    lean = radians(roller.get("half_angle", 0.0)) if roller.get("shape") == "cone" else 0.0
    length = min(roller["length"], depth)
    grooved = cam.get("form") == "groove"
    middle = (0.5 * length if below else width - 0.5 * length) if grooved else 0.5 * width
    gap = cam.get("running_clearance", 0.0) / cos(lean) if grooved else 0.0
    return z, 0.5 * roller["diameter"] + gap + (-1.0 if below else 1.0) * tan(lean) * (z - middle)


def _across(one, other, between, count=601):
    """Least distance of two walls seen along their tracks, whose rollers' middles are `between` apart, mm."""
    points = []
    for (z, r), way in ((one, 1.0), (other, -1.0)):
        share = np.linspace(0.0, 1.0, count)
        x = r[0] + (r[1] - r[0]) * share
        points.append(np.stack([x if way > 0.0 else between - x, z[0] + (z[1] - z[0]) * share], axis=1))
    low, high = max(p[0, 1] for p in points), min(p[-1, 1] for p in points)
    if low <= high:
        gaps = [np.interp(z, points[1][:, 1], points[1][:, 0]) - np.interp(z, points[0][:, 1], points[0][:, 0])
                for z in (low, high)]  # fmt: skip
        if min(gaps) <= 0.0:
            return float(gaps[0] if gaps[0] <= 0.0 else gaps[1])
    return float(cKDTree(points[0]).query(points[1])[0].min())


def _one_body(judges):
    """The judge of a body that several tools cut, one after the other."""

    def nearest(which):
        def distance(x, phi, k):
            each = [(getattr(judge, which) or judge.distance)(x, phi, 0) for judge in judges]
            return np.select([np.equal(k, i) for i in range(len(each))], np.broadcast_arrays(*each, 0.0 * k)[:-1])

        return distance

    def blank(x):
        return np.minimum.reduce([judge.blank(x) for judge in judges])

    loose = nearest("loose") if any(judge.loose for judge in judges) else None
    floors = tuple(dict.fromkeys(name for judge in judges for name in judge.floors))
    return Judge(nearest("distance"), blank, len(judges), loose, floors, judges[0].genus)


def _sense(cam):
    return -1.0 if cam.get("direction") == "cw" else 1.0


def _machine(x, phi, sense):
    """Points of the cam frame as they stand in the machine: the cam has turned by sense * phi."""
    c, s = np.cos(sense * phi), np.sin(sense * phi)
    return np.stack(np.broadcast_arrays(c * x[..., 0] - s * x[..., 1], s * x[..., 0] + c * x[..., 1], x[..., 2]), -1)


def _bore(cam, x):
    """Distance from the wall of bore and keyway."""
    r = 0.5 * cam.get("bore", 0.0)
    if not r:
        return np.full(len(x), FAR)
    found = np.abs(np.hypot(x[:, 0], x[:, 1]) - r)
    h, depth = 0.5 * cam.get("keyway_width", 0.0), cam.get("keyway_depth", 0.0)
    if h:
        slot = (x[:, 0] > 0.0) & (x[:, 0] < r + depth + h)
        found = np.minimum(found, np.where(slot, np.abs(np.abs(x[:, 1]) - h), FAR))
        found = np.minimum(found, np.where(np.abs(x[:, 1]) <= 1.001 * h, np.abs(x[:, 0] - r - depth), FAR))
    return found


def _planes(cam, z0, z1, more=None):
    def blank(x):
        found = np.minimum(np.minimum(np.abs(x[:, 2] - z0), np.abs(x[:, 2] - z1)), _bore(cam, x))
        return found if more is None else np.minimum(found, more(x))

    return blank


def _genus(cam):
    return (1 if cam.get("bore") else 0) + (1 if cam.get("mark_diameter") else 0)


def _centre_distance(place, radius, sense):
    """Signed distance in the plane to a circle of `radius` about place(phi) (machine frame)."""

    def distance(x, phi, k):
        del k
        m, c = _machine(x, phi, sense), place(phi)
        return np.hypot(m[..., 0] - c[0], m[..., 1] - c[1]) - radius

    return distance


def _place(cam, follower, radius, lift):
    """Centre of the roller in the machine over the cam angle."""
    prime = cam["base_radius"] + radius
    if follower["kind"] == "translating":
        e = follower.get("offset", 0.0)
        return lambda phi: (sqrt(prime**2 - e**2) + lift(phi), e)
    a, arm = cam["center_distance"], follower["arm"]
    way = -1.0 if follower.get("side") == "right" else 1.0
    start = acos((a * a + arm * arm - prime * prime) / (2.0 * a * arm))
    return lambda phi: (a - arm * np.cos(start + lift(phi)), way * arm * np.sin(start + lift(phi)))


def _disc(cam, follower, roller, lift, low, high):
    sense, face = _sense(cam), follower.get("face", "roller")
    radii = {"roller": 0.5 * (roller or {}).get("diameter", 0.0), "curved": follower.get("face_radius", 0.0)}
    radius = radii.get(face, 0.0)
    width = cam["width"]
    if face == "flat":
        return [Judge(_flat(cam, follower, lift, sense), _planes(cam, 0.0, width), genus=_genus(cam))]
    place = _place(cam, follower, radius, lift)
    if cam.get("form", "external") == "external":
        side = _round_side(roller, 0.5 * width, -1.0, place, radius, sense)
        return [Judge(side, _planes(cam, 0.0, width), genus=_genus(cam))]
    flat = _centre_distance(place, radius + cam.get("running_clearance", 0.0), sense)
    depth, below, root = cam["groove_depth"], cam.get("face") == "lower", cam.get("root_radius", 0.0)
    rim = None if cam.get("rim") == "profile" else lambda x: np.abs(np.hypot(x[:, 0], x[:, 1]) - 0.5 * cam["diameter"])
    if roller.get("shape") == "cone":
        # The groove opens upwards, and the roller goes in from there as far as it is long.
        middle = width - 0.5 * min(roller["length"], depth)
        grown, shape = _shape(roller, middle, True)(cam.get("running_clearance", 0.0))

        def stood(x, phi, k):
            del k
            # A groove in the lower face is the same seen from below.
            x = np.stack([x[..., 0], x[..., 1], width - x[..., 2]], -1) if below else x
            a = np.stack(np.broadcast_arrays(*place(phi), 0.0 * phi), -1)
            axis = np.array([0.0, 0.0, 1.0])
            return roller_distance(_machine(x, phi, sense), a, axis, grown, width - depth, False, shape)

        return [Judge(stood, _planes(cam, 0.0, width, rim), genus=_genus(cam))]

    def distance(x, phi, k):
        under = (x[..., 2] - depth if below else width - depth - x[..., 2]) + root
        side = flat(x, phi, k) + root
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(under, 0.0))
        return outside + np.minimum(np.maximum(side, under), 0.0) - root

    return [Judge(distance, _planes(cam, 0.0, width, rim), genus=_genus(cam))]


def _round_side(roller, middle, tip, place, radius, sense):
    """Signed distance to the side of a roller along Z, unbounded: of a cone as thick as its radius at `middle`.

    tip: +1 where its free end is above
    """
    flat = _centre_distance(place, radius, sense)
    if (roller or {}).get("shape") != "cone":
        return flat
    lean = radians(roller["half_angle"])

    def leaning(x, phi, k):
        return (flat(x, phi, k) + tip * tan(lean) * (x[..., 2] - middle)) * cos(lean)

    return leaning


def _flat(cam, follower, lift, sense):
    base = cam["base_radius"]
    if follower["kind"] == "translating":
        return lambda x, phi, k: base + lift(phi) - _machine(x, phi, sense)[..., 0]
    a, offset = cam["center_distance"], follower.get("face_offset", 0.0)
    way = -1.0 if follower.get("side") == "right" else 1.0
    start = acos((base + offset) / a)

    def distance(x, phi, k):
        del k
        m, beta = _machine(x, phi, sense), way * (start - lift(phi))
        return a * np.cos(beta) - offset - (m[..., 0] * np.cos(beta) + m[..., 1] * np.sin(beta))

    return distance


def _constant_width(cam, follower, roller, lift, low, high):
    del follower
    sense, base = _sense(cam), cam["base_radius"]
    radius = 0.5 * roller["diameter"] if roller else 0.0
    span = 2.0 * (base + radius) + high

    def distance(x, phi, k):
        m, near = _machine(x, phi, sense), base + radius + lift(phi)
        if roller:
            return np.hypot(m[..., 0] - np.where(k == 0, near, near - span), m[..., 1]) - radius
        return np.where(k == 0, near - m[..., 0], m[..., 0] - near + span)

    return [Judge(distance, _planes(cam, 0.0, cam["width"]), 2, genus=_genus(cam))]


def _conjugate(cam, follower, roller, lift, low, high):
    del low
    sense, r = _sense(cam), 0.5 * roller["diameter"]
    second = cam.get("return_roller", roller)
    q = 0.5 * second["diameter"]
    main = _place(cam, follower, r, lift)
    play, prime = follower.get("clearance", 0.0), cam["base_radius"] + r
    if follower["kind"] == "translating":
        e = follower.get("offset", 0.0)
        # Without a radius of its own the return profile has that of a main profile that is pushed all the way.
        same = sqrt((sqrt(prime**2 - e**2) + high) ** 2 + e**2) - r
        far = cam.get("return_radius", same) + q

        def back(phi):
            return -sqrt(far**2 - e**2) + lift(phi) + play, e
    else:
        a, arm = cam["center_distance"], cam.get("return_arm", follower["arm"])
        way = -1.0 if follower.get("side") == "right" else 1.0
        start = acos((a * a + follower["arm"] ** 2 - prime**2) / (2.0 * a * follower["arm"]))
        if "rocker_angle" in cam:
            rocker = radians(cam["rocker_angle"])
        else:
            rocker = start + high + acos((a * a + arm * arm - (cam["base_radius"] + q) ** 2) / (2.0 * a * arm))
        ahead = 2.0 * asin(min(1.0, play / (2.0 * arm)))

        def back(phi):
            angle = start - rocker + lift(phi) + ahead
            return a - arm * np.cos(angle), way * arm * np.sin(angle)

    mark = None
    if cam.get("mark_diameter"):
        middle, size = -sense * cam["mark_radius"], 0.5 * cam["mark_diameter"]

        def mark(x):
            return np.abs(np.hypot(x[:, 0], x[:, 1] - middle) - size)

    above = cam["width"] + cam.get("gap", 0.0)
    return [
        Judge(_round_side(one, z + 0.5 * cam["width"], tip, place, size, sense),
              _planes(cam, z, z + cam["width"], mark), genus=_genus(cam))
        for one, tip, place, z, size in ((roller, 1.0, main, 0.0, r), (second, -1.0, back, above, q))
    ]


def _shape(roller, centre, inward):
    """The oracle's words for a roller, and how it grows: (radius, shape) for a normal gap. inward: tip at low delta."""

    def grown(gap):
        r = 0.5 * roller["diameter"]
        kind = roller.get("shape", "cylinder")
        if kind == "crowned" and roller.get("flank", "straight") == "straight":
            return r + gap, None
        if kind == "cone":
            slope = tan(radians(roller["half_angle"])) * (1.0 if inward else -1.0)
            return r + gap * sqrt(1.0 + slope**2), ("cone", slope, centre)
        if kind == "crowned":
            return r + gap, ("crowned", roller["crown_radius"] + gap, centre)
        if kind == "sphere":
            return r + gap, ("sphere", None, centre)
        return r + gap, None

    return grown


def _deepest(roller, centre, wanted):
    """How far a roller can be carried on along its axis towards `wanted`: a crowned one ends with its arc."""
    if roller.get("shape") != "crowned" or roller.get("flank", "straight") == "straight":
        return wanted
    reach = 0.999 * roller["crown_radius"]
    return min(max(wanted, centre - reach), centre + reach)


def _drum(cam, follower, roller, lift, low, high):
    sense, outer, depth = _sense(cam), 0.5 * cam["diameter"], cam["groove_depth"]
    floor, gap = outer - depth, cam.get("running_clearance", 0.0)
    ball = roller.get("shape") == "sphere"
    centre = floor + 0.5 * roller["diameter"] if ball else outer - 0.5 * roller["length"]
    radius, shape = _shape(roller, centre, True)(gap)
    if cam.get("root_radius"):
        shape = ("rounded", cam["root_radius"], None)
    half = 0.5 * (cam.get("rib_thickness", 0.0) + roller["diameter"])
    offsets = np.array([0.0]) if cam.get("form", "groove") == "groove" else np.array([-half, half])

    if follower["kind"] == "translating":

        def place(phi, dz):
            return np.zeros_like(phi), cam["start"] + lift(phi) + dz
    else:
        arm, start = follower["arm"], radians(follower.get("start_angle", 0.0))
        pivot = follower.get("pivot_distance") or arm * _middle_cosine(start + low, start + high)
        height = cam["start"] - arm * sin(start)

        def place(phi, dz):
            q = start + lift(phi)
            return pivot - arm * np.cos(q) + dz * np.sin(q), height + arm * np.sin(q) + dz * np.cos(q)

    def to(end):
        def distance(x, phi, k):
            m = _machine(x, phi, sense)
            y, z = place(phi, offsets[k])
            a = np.stack(np.broadcast_arrays(0.0 * y, y, z), -1)
            return roller_distance(m, a, np.array([1.0, 0.0, 0.0]), radius, end, False, shape)

        return distance

    rims = (outer,) if len(offsets) == 1 else (outer, floor)

    def blank(x):
        rho = np.hypot(x[:, 0], x[:, 1])
        found = np.minimum(np.abs(x[:, 2]), np.abs(x[:, 2] - cam["length"]))
        return np.minimum.reduce([found, _bore(cam, x), *(np.abs(rho - r) for r in rims)])

    if len(offsets) == 1:
        return [Judge(to(floor), blank, genus=_genus(cam))]
    # A rib's walls run down to the drum, deeper than the rollers' ends.
    deep = _deepest(roller, centre, 0.0)
    return [Judge(to(outer - roller["length"]), blank, 2, to(deep), genus=_genus(cam))]


def _conical(cam, follower, roller, lift, low, high):
    """A cone: the roller's axis square to its generator, along which it slides from the lower edge."""
    del follower, low, high
    sense, outer, depth, lean = _sense(cam), 0.5 * cam["diameter"], cam["groove_depth"], radians(cam["half_angle"])
    gap, ball = cam.get("running_clearance", 0.0), roller.get("shape") == "sphere"
    centre = 0.5 * roller["diameter"] - depth if ball else -0.5 * roller["length"]
    radius, shape = _shape(roller, centre, True)(gap)
    if cam.get("root_radius"):
        shape = ("rounded", cam["root_radius"], None)
    out = np.array([cos(lean), 0.0, sin(lean)])

    def distance(x, phi, k):
        del k
        along = cam["start"] + lift(phi)
        a = np.stack(np.broadcast_arrays(outer - along * sin(lean), 0.0 * along, along * cos(lean)), -1)
        return roller_distance(_machine(x, phi, sense), a, out, radius, -depth, False, shape)

    def blank(x):
        rho = np.hypot(x[:, 0], x[:, 1])
        cone = np.abs((rho - outer) * cos(lean) + x[:, 2] * sin(lean))
        return np.minimum.reduce([np.abs(x[:, 2]), np.abs(x[:, 2] - cam["length"]), cone, _bore(cam, x)])

    return [Judge(distance, blank, genus=_genus(cam))]


def _end_face(cam, follower, roller, lift, low, high):
    sense, outer, inner = _sense(cam), 0.5 * cam["diameter"], 0.5 * cam["inner_diameter"]
    grooved = cam.get("form") == "groove"
    if roller.get("shape") == "crowned":
        roller = {"shape": "cylinder", "diameter": roller["diameter"], "length": roller["length"]}
    if grooved:
        floor, centre = inner + cam["groove_depth"], cam["start"]
        radius, shape = _shape(roller, inner + 0.5 * roller["length"], False)(cam.get("running_clearance", 0.0))
        heights = cam["web"], cam["length"], 0.0
    else:
        floor, centre = outer, cam["height"] + 0.5 * roller["diameter"]
        radius, shape = _shape(roller, 0.5 * (outer + inner), True)(0.0)
        heights = cam["web"], 0.0
    # A cone that widens inward ends with the roller; what cuts the ring does where the ring ends.
    widens = not grooved and roller.get("half_angle", 0.0) < 0.0
    own, cuts = (0.5 * (outer + inner - roller["length"]), 0.9 * inner) if widens else (0.0, 0.0)
    if follower["kind"] == "swinging":
        arm, start = follower["arm"], radians(follower.get("start_angle", 0.0))
        pivot = follower.get("pivot_distance") or arm * _middle_cosine(start + low, start + high)

    def distance(x, phi, k, end=own):
        del k
        y, z = 0.0 * phi, centre + lift(phi)
        if follower["kind"] == "swinging":
            q = start + lift(phi)
            y, z = pivot - arm * np.cos(q), centre + arm * (np.sin(q) - sin(start))
        a, m = np.stack(np.broadcast_arrays(0.0 * y, y, z), -1), _machine(x, phi, sense)
        if not grooved:
            return roller_distance(m, a, np.array([1.0, 0.0, 0.0]), radius, end, False, shape)
        # Of a tool without ends what is between the inside of the ring and the floor.
        rho = np.hypot(m[..., 0], m[..., 1])
        side = roller_distance(m, a, np.array([1.0, 0.0, 0.0]), radius, 0.0, False, shape)
        return np.maximum(side, np.maximum(inner - rho, rho - floor))

    def blank(x):
        rho = np.hypot(x[:, 0], x[:, 1])
        found = np.minimum.reduce([np.abs(x[:, 2] - z) for z in heights])
        return np.minimum.reduce([found, _bore(cam, x), *(np.abs(rho - r) for r in {inner, floor, outer})])

    loose = (lambda x, phi, k: distance(x, phi, k, end=cuts)) if widens else None
    return [Judge(distance, blank, loose=loose, genus=_genus(cam))]


def _middle_cosine(low, high):
    """Middle of the least and the greatest cosine of the angles in between."""
    grid = np.cos(np.linspace(low, high, 20001))
    most = 1.0 if low <= 0.0 <= high else float(grid.max())
    least = -1.0 if high > pi or low < -pi else float(grid.min())
    return 0.5 * (least + most)


def _turret(cam, follower, lift):
    """Turret angle of roller k from the line of centres over the cam angle, in -pi .. pi."""
    count = follower.get("rollers") or follower["stops"]
    pitch = TURN / count
    base = 0.5 * pitch if cam.get("form", "rib") == "rib" else 0.0
    return count, lambda phi, k: (lift(phi) + base + k * pitch + pi) % TURN - pi


def _barrel(cam, follower, roller, lift, low, high):
    del low, high
    sense, outer = _sense(cam), 0.5 * cam["diameter"]
    hand = -1.0 if cam.get("hand") == "left" else 1.0
    count, angle = _turret(cam, follower, lift)
    pitch_radius, gap = follower["pitch_radius"], cam.get("running_clearance", 0.0)
    ball = roller.get("shape") == "sphere"
    centre = outer if ball else outer - 0.5 * roller["length"]
    radius, shape = _shape(roller, centre, True)(gap)
    tip = outer - (0.5 * roller["diameter"] if ball else roller["length"])
    deep = tip if ball else _deepest(roller, centre, 0.0)

    def to(end):
        def distance(x, phi, k):
            m, tau = _machine(x, phi, sense), angle(phi, k)
            y, z = cam["center_distance"] - pitch_radius * np.cos(tau), hand * pitch_radius * np.sin(tau)
            a = np.stack(np.broadcast_arrays(0.0 * y, y, z), -1)
            found = roller_distance(m, a, np.array([1.0, 0.0, 0.0]), radius, end, False, shape)
            return np.where(np.cos(tau) > 0.0, found, FAR)

        return distance

    def blank(x):
        ends = np.abs(np.abs(x[:, 2]) - 0.5 * cam["width"])
        return np.minimum.reduce([ends, np.abs(np.hypot(x[:, 0], x[:, 1]) - outer), _bore(cam, x)])

    floors = () if ball else ("floor",)
    strict = to(tip) if ball else _ended(to(tip), lambda m, tau: m[..., 0] - outer, sense, angle)
    return [Judge(strict, blank, count, to(deep), floors, _genus(cam))]


def _ended(distance, beyond, sense, angle):
    """The distance to a roller that is not carried on beyond its seat; beyond(point in the machine, turret angle)."""

    def bounded(x, phi, k):
        end = beyond(_machine(x, phi, sense), angle(phi, k))
        found = distance(x, phi, k)
        return np.where(end > 0.0, np.maximum(found, end), found)

    return bounded


def _globoid(cam, follower, roller, lift, low, high):
    del low, high
    sense, far = _sense(cam), cam["center_distance"]
    hand = -1.0 if cam.get("hand") == "left" else 1.0
    count, angle = _turret(cam, follower, lift)
    gap, centre = cam.get("running_clearance", 0.0), follower["pitch_radius"]
    ball = roller.get("shape") == "sphere"
    radius, shape = _shape(roller, centre, False)(gap)
    tip = centre + (0.5 * roller["diameter"] if ball else 0.5 * roller["length"])
    deep = tip if ball else _deepest(roller, centre, far)

    def to(end):
        def distance(x, phi, k):
            m, tau = _machine(x, phi, sense), angle(phi, k)
            u = np.stack(np.broadcast_arrays(-np.cos(tau), 0.0 * tau, hand * np.sin(tau)), -1)
            found = roller_distance(m, np.array([far, 0.0, 0.0]), u, radius, end, True, shape)
            return np.where(np.cos(tau) > 0.0, found, FAR)

        return distance

    def blank(x):
        rho = np.hypot(x[:, 0], x[:, 1])
        half, hub = 0.5 * cam["width"], cam.get("hub_length", 0.0)
        found = [np.abs(np.abs(x[:, 2]) - half), np.abs(np.hypot(rho - far, x[:, 2]) - cam["globoid_radius"])]
        if hub:
            found += [np.abs(np.abs(x[:, 2]) - half - hub), np.abs(rho - 0.5 * cam["hub_diameter"])]
        return np.minimum.reduce([*found, _bore(cam, x)])

    floors = () if ball else ("floor",)
    seat = centre - 0.5 * roller["length"]

    def inward(m, tau):
        return seat - ((m[..., 0] - far) * -np.cos(tau) + m[..., 2] * hand * np.sin(tau))

    if root := cam.get("root_radius"):
        # The tool's corner begins where the arc of 60 degrees ends as deep as the floor's edges stand.
        edge = radius - root * (1.0 - 0.5)
        shape = ("rounded", root, None)
        tool = sqrt((sqrt(tip**2 + 2.0 * radius**2) + cam.get("tip_clearance", 0.5)) ** 2 - edge**2)
        deep = tool + root * (1.0 - sqrt(0.75))
    strict = to(tip) if ball else _ended(to(tip), inward, sense, angle)
    return [Judge(strict, blank, count, to(deep), floors, _genus(cam))]


def _parallel(cam, follower, roller, lift, low, high):
    """A plate's ring: every `plates`-th roller of the turret, which turns about a parallel shaft against the cam."""
    del low, high
    sense, count, plates = _sense(cam), follower.get("rollers") or follower["stops"], cam.get("plates", 2)
    c, rf, r = cam["center_distance"], follower["pitch_radius"], 0.5 * roller["diameter"]
    r, rim = r + cam.get("running_clearance", 0.0), 0.5 * cam["diameter"]

    def ring(plate):
        def distance(x, phi, k):
            m, tau = _machine(x, phi, sense), lift(phi) + (0.5 + plate + k * plates) * TURN / count
            return np.hypot(m[..., 0] - c + rf * np.cos(tau), m[..., 1] - sense * rf * np.sin(tau)) - r

        return distance

    def blank(z):
        return _planes(cam, z, z + cam["width"], lambda x: np.abs(np.hypot(x[:, 0], x[:, 1]) - rim))

    heights = [plate * (cam["width"] + cam["gap"]) for plate in range(plates)]
    return [Judge(ring(i), blank(z), count // plates, genus=_genus(cam)) for i, z in enumerate(heights)]


DRIVES = {
    "simple-harmonic": lambda x: 0.5 * (1.0 - np.cos(pi * x)),
    "cycloidal": lambda x: x - np.sin(TURN * x) / TURN,
    "3-4-5": lambda x: x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
    "4-5-6-7": lambda x: x**4 * (35.0 - 84.0 * x + 70.0 * x * x - 20.0 * x**3),
}
"""Share of the stroke over the share of the way out, of the laws that the oracle knows."""


def travel(cam, phi):
    """How far a plate is out, mm, at angles of its drive, rad."""
    law, out = DRIVES[cam.get("drive", "simple-harmonic")], radians(cam.get("drive_out", 180.0))
    phi = np.mod(phi, TURN)
    # The way back begins at the far end.
    return cam["stroke"] * np.where(phi <= out, law(np.minimum(phi / out, 1.0)),
                                    1.0 - law(np.maximum(phi - out, 0.0) / (TURN - out)))  # fmt: skip


def _linear(cam, follower, roller, lift, low, high):
    """A plate: the roller in a groove, which lies still in X but for the lean of its slide, as the plate goes by.

    Under an edge the plate goes on straight, as the roller touches it at the ends of its path.
    """
    del low, high
    if follower["kind"] == "swinging":
        arm, rest = follower["arm"], radians(follower.get("start_angle", 0.0))
        way = -1.0 if follower.get("side") == "right" else 1.0
    radius, lean = 0.5 * roller["diameter"] + cam.get("running_clearance", 0.0), radians(cam.get("inclination", 0.0))
    length, thick, edged = cam["length"], cam["thickness"], cam.get("form") == "edge"

    def place(phi):
        s = lift(phi)
        along, across = s * sin(lean), s * np.cos(lean)
        if follower["kind"] == "swinging":
            # The pivot stands arm away from the roller at zero lift; a greater angle lifts the roller towards +Y.
            along = way * arm * (np.cos(rest + s) - np.cos(rest))
            across = arm * (np.sin(rest + s) - sin(rest))
        return travel(cam, phi) + cam["start"] + along, cam["edge"] + across

    def distance(x, phi, k):
        del k
        along, across = place(phi)
        side = np.hypot(x[..., 0] - along, x[..., 1] - across) - radius
        if edged:
            return side
        under = thick - cam["groove_depth"] - x[..., 2]
        return np.hypot(np.maximum(side, 0.0), np.maximum(under, 0.0)) + np.minimum(np.maximum(side, under), 0.0)

    def rim(x):
        sides = [np.abs(x[:, 0]), np.abs(x[:, 0] - length), np.abs(x[:, 1])]
        if not edged:
            return np.minimum.reduce([*sides, np.abs(x[:, 1] - cam["width"])])
        turned = radians(cam.get("drive_out", 180.0))
        for angles, way in ((np.array([0.0, 0.02, 0.03]), -1.0), (turned - np.array([0.0, 0.02, 0.03]), 1.0)):
            t = travel(cam, angles)
            # The direction at the end of the path: of the parabola through its last three places.
            near, far = t[1] - t[0], t[2] - t[0]
            (px, py) = place(angles)
            dx, dy = ((one[1] - one[0]) / near * far / (far - near) - (one[2] - one[0]) / far * near / (far - near)
                      for one in (px, py))  # fmt: skip
            long = np.hypot(dx, dy)
            aside = (x[:, 1] - py[0]) * dx / long - (x[:, 0] - px[0]) * dy / long
            on = way * ((x[:, 0] - px[0]) * dx + (x[:, 1] - py[0]) * dy) > -1e-6 * length * long
            sides.append(np.where(on, np.abs(aside + radius), FAR))
        return np.minimum.reduce(sides)

    return [Judge(distance, _planes(cam, 0.0, thick, rim))]


JUDGES = {
    "disc": _disc,
    "constant-width": _constant_width,
    "conical": _conical,
    "conjugate": _conjugate,
    "cylindrical": _drum,
    "end-face": _end_face,
    "cylindrical-index": _barrel,
    "globoidal": _globoid,
    "linear": _linear,
    "parallel-index": _parallel,
}
"""The oracle of every kind of cam."""
