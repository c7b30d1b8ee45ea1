"""Errors of a plate that slides: displaced grooves measured from the keys alone, ends, limits, and what is sampled."""

from __future__ import annotations

from math import acos, cos, pi, radians, sin

import numpy as np
import pytest

from camgeom.checks import findings, judge
from camgeom.cli.tolerance import summary
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.sections.tolerance import tolerance
from camgeom.tolerance.causes import ARCMIN, CAUSES, default_pivots
from camgeom.tolerance.order import second_order
from camgeom.tolerance.study import tolerance_data
from camgeom.tolerance.worst import Worst
from camgeom.track import TURN

STROKE, START, EDGE, FIRST, LAST, GAP = 100.0, 30.0, 22.0, 10.0, 85.0, 0.06
TEXT = """
[cam]
kind = "linear"
stroke = 100
length = 170
width = 90
thickness = 20
start = 30
edge = 22
groove_depth = 10
running_clearance = {gap}
{cam}
[follower]
{follower}
[roller]
diameter = 18
length = 9
[[motion]]
until = 10
[[motion]]
until = 85
to = {rise}
law = "cycloidal"
[[motion]]
until = 100
{more}
"""
ARM, REST = 70.0, -12.0
FOLLOWERS = {
    "slide": ('kind = "translating"', "", 30.0),
    "leaning": ('kind = "translating"', "inclination = 20", 25.0),
    "arm": (f'kind = "swinging"\narm = {ARM}\nstart_angle = {REST}', "", 20.0),
    "arm, right": (f'kind = "swinging"\narm = {ARM}\nstart_angle = {REST}\nside = "right"', "", 20.0),
}


def plate(kind: str, more: str = "", gap: float = GAP) -> Model:
    follower, cam, rise = FOLLOWERS[kind]
    return Model(parse(TEXT.format(follower=follower, cam=cam, rise=rise, more=more, gap=gap)))


def crank(theta: np.ndarray) -> np.ndarray:
    return 0.5 * STROKE * (1.0 - np.cos(theta))


class Groove:
    """Roller and groove from the keys: where its middle stands, and how far that is from the groove's middle line."""

    def __init__(self, kind: str) -> None:
        _, _, self.rise = FOLLOWERS[kind]
        self.swings, self.way = kind.startswith("arm"), -1.0 if kind.endswith("right") else 1.0
        lean = radians(20.0) if kind == "leaning" else 0.0
        self.slide, self.home = np.array([sin(lean), cos(lean)]), np.array([START, EDGE])
        self.rest = radians(REST)
        self.unit = pi / 180.0 if self.swings else 1.0
        x = np.linspace(0.0, STROKE, 20_001)
        self.line = np.stack([x, np.zeros_like(x)], -1) + self.middle(self.lift(x))

    def lift(self, x: np.ndarray) -> np.ndarray:
        u = np.clip((x - FIRST) / (LAST - FIRST), 0.0, 1.0)
        return self.unit * self.rise * (u - np.sin(TURN * u) / TURN)

    def middle(self, q: np.ndarray) -> np.ndarray:
        """Machine frame, (..., 2), at coordinates q."""
        q = np.asarray(q)
        if not self.swings:
            return self.home + q[..., None] * self.slide
        turned = np.stack([self.way * np.cos(self.rest + q), np.sin(self.rest + q)], -1)
        return self.home + ARM * (turned - np.array([self.way * cos(self.rest), sin(self.rest)]))

    def off(self, point: np.ndarray) -> float:
        """Distance of a point of the plate from the middle line, with the sign of its side: above it positive."""
        i = int(np.argmin(np.hypot(*(self.line - point).T)))
        a, b = self.line[max(i - 1, 0)], self.line[min(i + 1, len(self.line) - 1)]
        along = (b - a) / np.hypot(*(b - a))
        rest = point - self.line[i]
        t = float(rest @ along)
        if (i == 0 and t < 0.0) or (i == len(self.line) - 1 and t > 0.0):
            return float(np.copysign(np.hypot(*rest), along[0] * rest[1] - along[1] * rest[0]))
        return float(along[0] * rest[1] - along[1] * rest[0])

    def seen(self, theta: float, psi: float, e: dict[str, float]) -> np.ndarray:
        """The roller's middle as the displaced plate sees it."""
        place = self.middle(self.lift(crank(np.array(theta))) + psi + e.get("roller_place", 0.0))
        place = place + np.array([-e.get("side_shift", 0.0), e.get("center_distance", 0.0)])
        x = _turned(place - self.home, -e.get("squareness_arcmin", 0.0)) + self.home
        x = x + np.array([float(crank(np.array(theta + e.get("phase_arcmin", 0.0)))), 0.0])
        return _turned(x - self.home, -e.get("cam_yaw_arcmin", 0.0)) + self.home

    def stood(self, theta: float, e: dict[str, float], force: float) -> tuple[float, float]:
        """Between what coordinates the follower stands beyond its program, one where a force presses it."""
        unit = 1.0 / ARM if self.swings else 1.0
        low, high = (self.bound(theta, e, side, side * GAP * unit) for side in (-1.0, 1.0))
        return (low, low) if force > 0.0 else (high, high) if force < 0.0 else (low, high)

    def bound(self, theta: float, e: dict[str, float], side: float, guess: float) -> float:
        """Coordinate beyond the program at which the roller touches the wall above (1) or below (-1) the line."""
        room = GAP + e.get("running_clearance", 0.0) - 0.5 * e.get("roller_diameter", 0.0)
        room -= e.get("above" if side > 0.0 else "below", 0.0)
        unit = 1.0 if not self.swings else 1.0 / ARM

        def rest(psi: float) -> float:
            return self.off(self.seen(theta, psi, e)) - side * room

        a, b = guess - 0.02 * unit, guess + 0.02 * unit
        fa, fb = rest(a), rest(b)
        for _ in range(12):
            if abs(fb) < 1e-10 or fa == fb:
                break
            a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
            fb = rest(b)
        assert abs(fb) < 1e-8
        return b


def _turned(x: np.ndarray, angle: float) -> np.ndarray:
    c, s = cos(angle), sin(angle)
    return np.array([c * x[0] - s * x[1], s * x[0] + c * x[1]])


FORCED = "[operation]\nspeed = 10\nforce = [{{ expression = \"{force}\" }}]\n"


@pytest.mark.parametrize("kind", FOLLOWERS)
@pytest.mark.parametrize("force", [0, 900, -900])
def test_all_errors_in_the_plane_move_follower_and_play_as_the_displaced_groove_does(kind: str, force: float) -> None:
    """At 20 um and its turns together: within 1 % of the largest, on the wall that the load presses, and the play."""
    made = plate(kind, (FORCED.format(force=force) if force else "") + "[tolerance]\nside_shift = 0.01\n")
    groove, theta = Groove(kind), np.radians([9.0, 55.0, 70.0, 100.0, 171.0, 240.0, 305.0])
    loaded = made.tolerances.loaded
    seated = loaded.at(theta)
    at, rng, size = seated.contacts, np.random.default_rng(5), 0.02
    largest, wrong, played = 0.0, 0.0, 0.0
    unit = ARM if groove.swings else 1.0
    for _ in range(6):
        e = {key: float(rng.uniform(-1.0, 1.0)) * size for key in
             ("center_distance", "side_shift", "roller_place", "roller_diameter", "running_clearance")}  # fmt: skip
        e |= {key: float(rng.uniform(-1.0, 1.0)) * size / 80.0 for key in
              ("squareness_arcmin", "cam_yaw_arcmin", "phase_arcmin")}  # fmt: skip
        if groove.swings:
            e.pop("roller_place")
        errors = sum(value * seated.approaches.of(CAUSES[key])[0] for key, value in e.items())
        walls = dict(zip(("above", "below"), rng.uniform(-1.0, 1.0, 2) * size))
        growth = seated.approaches.of(CAUSES["flank_growth"])[0]
        errors = errors + np.where(at.lever > 0.0, walls["above"], walls["below"]) * growth
        e |= walls
        stand, base = seated.walls.stand(seated.flat(errors)), seated.nominal
        for i, one in enumerate(theta.tolist()):
            low, high = (groove.bound(one, e, side, float(end[i]))
                         for side, end in ((-1.0, stand.low - stand.play * (force < 0.0)),
                                           (1.0, stand.high + stand.play * (force > 0.0))))  # fmt: skip
            wanted = {0: (low, high), 900: (low, low), -900: (high, high)}[force]
            wrong = max(wrong, *(unit * abs(w - f[i]) for w, f in zip(wanted, (stand.low, stand.high))))
            played = max(played, unit * abs((high - low) - float(stand.play[i])))
        largest = max(largest, unit * float(seated.deviation(stand).max()))
        assert np.isfinite(base.play).all()
    assert largest > 0.02
    assert wrong < 0.01 * largest
    assert played < 0.01 * largest


@pytest.mark.parametrize("kind", FOLLOWERS)
@pytest.mark.parametrize("error", ["side_shift", "center_distance", "squareness_arcmin", "cam_yaw_arcmin"])
def test_a_roller_goes_into_the_end_of_its_groove_up_to_the_clearance(kind: str, error: str) -> None:
    """Where errors use up 0.999 of the room some place of the follower is free, beyond 1.002 of it none is (turns, and
    shifts as far as an arm has to go to them, have a second order of up to 1 % of it)."""
    groove, gap = Groove(kind), 0.01
    ends = plate(kind, "[tolerance]\nside_shift = 0.01\n", gap).tolerances.machines({error: (0.0, 1.0, "worst")}).ends
    reach = max(float(np.abs(end.way).max()) for end in ends)
    if reach < 1e-9:
        return
    size, free = gap / reach, {}
    least, most = (0.999, 1.002) if error == "side_shift" else (0.99, 1.01)
    for share in (least, most):
        fits = []
        for way in (1.0, -1.0):
            for theta in (0.0, pi):
                about = np.linspace(-0.2, 0.2, 4001) / (ARM if groove.swings else 1.0)
                points = np.array([groove.seen(theta, psi, {error: way * share * size}) for psi in about.tolist()])
                end = groove.line[0 if theta == 0.0 else -1]
                inward = points[:, 0] - end[0] if theta == 0.0 else end[0] - points[:, 0]
                away = np.where(inward > 0.0, np.abs(points[:, 1] - end[1]), np.hypot(*(points - end).T))
                fits.append(bool((away <= gap).any()))
        free[share] = all(fits)
    assert free == {least: True, most: False}, (kind, error, free)


@pytest.mark.parametrize("kind", FOLLOWERS)
@pytest.mark.parametrize("force", [0, 900, -900])
def test_beside_an_end_the_follower_stands_as_the_round_groove_lets_it(kind: str, force: float) -> None:
    """Errors along the travel of up to 0.9 of the clearance, growth of roller and wall, against the groove itself."""
    made = plate(kind, (FORCED.format(force=force) if force else "") + "[tolerance]\nside_shift = 0.01\n")
    groove, keys = Groove(kind), ("side_shift", "center_distance", "roller_diameter", "running_clearance")
    machines = made.tolerances.machines(dict.fromkeys(keys, (0.0, 1.0, "worst")))
    unit, rng, moved = ARM if groove.swings else 1.0, np.random.default_rng(2), 0.0
    for position in machines.positions:
        if position.end is None or abs(position.theta % pi) > 1e-12:
            continue
        nominal = groove.stood(position.theta, {}, force)
        for _ in range(6):
            e = dict(zip(keys, (rng.uniform(-1.0, 1.0, 4) * np.array([0.8, 0.1, 0.2, 0.1]) * GAP).tolist()))
            x = np.array([[e[column.cause.key]] for column in machines.columns], dtype=np.float32)
            low, high, _ = machines._stand(position, x)
            wanted = groove.stood(position.theta, e, force)
            for found, one, base in zip((low, high), wanted, nominal):
                assert unit * float(found[0]) == pytest.approx(unit * (one - base), abs=5e-4)
            moved = max(moved, *(unit * abs(one - base) for one, base in zip(wanted, nominal)))
    assert moved > 0.01


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_what_the_end_of_a_groove_takes_is_in_its_dwell(share: float, level: str) -> None:
    """0.8 of the clearance c along the travel leave 0.6 of it across: the follower stands nearer to the middle."""
    both = f'side_shift = {{ value = {0.8 * GAP}, distribution = "worst" }}\ndwell_limit = {400.0 * GAP / share}\n'
    (found,) = findings(plate("slide", FORCED.format(force=900) + f"[tolerance]\n{both}"), ["dwell-tolerance"])
    assert (found.level, found.value) == (level, pytest.approx(400.0 * GAP, rel=1e-4))
    worst = plate("slide", f"[tolerance]\n{both}").tolerances.worst
    assert worst.dwell.value == pytest.approx(0.4 * GAP, rel=1e-6)


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_the_room_at_the_grooves_ends_is_judged(share: float, level: str) -> None:
    limit = "backlash_limit = 1000\n"
    made = plate("slide", f'[tolerance]\n{limit}side_shift = {{ value = {share * GAP}, distribution = "worst" }}\n')
    (found,) = findings(made, ["groove-end-tolerance"])
    assert (found.level, found.unit) == (level, "um")
    assert found.value == pytest.approx(1e3 * share * GAP, rel=1e-5)
    assert made.tolerances.share() == (1.0 if level == "pass" else 0.0), "a machine that jams keeps no limit"
    told = "\n".join(summary(tolerance_data(made.tolerances)))
    assert f"worst case {1e3 * share * GAP:.4g} um; its running clearance leaves 60 um" in told
    (none,) = findings(plate("slide", "[tolerance]\ncenter_distance = 0.09\n", gap=0.0), ["groove-end-tolerance"])
    assert (none.level, none.value) == ("pass", 0.0), "across the travel nothing reaches the ends"


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
@pytest.mark.parametrize("kind", ["slide", "arm"])
def test_limits_are_um_of_a_slide_and_seconds_of_arc_of_an_arm(kind: str, share: float, level: str) -> None:
    """In a dwell a follower off across the travel by e stands e off, an arm e / (arm cos of its angle); along it by e
    the steepest slope moves it; stock on both walls takes as much play."""
    e, both = 0.02, 'distribution = "worst"\nsamples = 2000\nyield = 0.99\nside_shift = 0\n'
    arm = kind == "arm"
    seconds = 648000.0 / pi / ARM
    across = seconds / cos(radians(REST)) if arm else 1e3  # 20 deg up the arm stands at 8 deg
    play = 2.0 * (GAP + e) * across
    for key, error, figure in (("dwell_limit", "center_distance", e * across),
                               ("backlash_limit", "running_clearance", play)):  # fmt: skip
        made = plate(kind, f"[tolerance]\n{both}{error} = {e}\n{key} = {figure / share}\n")
        (found,) = findings(made, [key.replace("_limit", "-tolerance")])
        assert found.level == level, (key, found)
    groove, x = Groove(kind), np.linspace(0.0, STROKE, 200_001)
    q = groove.lift(x)
    slope = np.gradient(q, x)  # off along the travel by e an arm too stands where it stands e further on
    figure = e * float(slope.max()) * (648000.0 / pi if arm else 1e3)
    more = f'[tolerance]\n{both.replace("side_shift = 0", f"side_shift = {e}")}motion_limit = {figure / share}\n'
    study = plate(kind, more).tolerances
    told = study.loaded.shown(study.worst.motion.value)
    assert told == pytest.approx(figure, rel=2e-3)
    assert study.loaded.shown(float(study.drawn.motion.max())) == pytest.approx(figure, rel=5e-3)


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_a_pressure_that_no_error_raises_is_the_nominal_one(share: float, level: str) -> None:
    forced, error = FORCED.format(force=900), "[tolerance]\nside_shift = 0.01\n"
    peak = plate("arm", forced + error).tolerances.peak
    (found,) = findings(plate("arm", f"{forced}{error}pressure_limit = {share * peak}\n"), ["yield-tolerance"])
    assert found.level == level


@pytest.mark.parametrize(("limit", "held"), [(131.0, True), (119.0, False)])
def test_widest_tolerances_leave_the_play_that_the_groove_has_anyhow(limit: float, held: bool) -> None:
    """Of 120 um of nominal play the errors may use what the limit leaves; a limit below it no tolerances hold."""
    errors = "center_distance = 0.01\nrunning_clearance = 0.004\nroller_diameter = 0.004\nsamples = 20000\n"
    made = plate("slide", f"[tolerance]\n{errors}backlash_limit = {limit}\ndwell_limit = 20\n")
    study, found = made.tolerances, made.machine_tolerances.widest
    assert (found is not None) is held
    if found is None:
        return
    spreads = {key: (0.0, value, "normal") for key, value in found.values.items() if value}
    wider = {key: (mean, 1.02 * value, how) for key, (mean, value, how) in spreads.items()}
    assert set(spreads) == {"center_distance", "running_clearance", "roller_diameter"}
    assert study.share(study.machines(spreads).drawn(20000)) >= 0.99
    assert study.share(study.machines(wider).drawn(20000)) < 0.99


ALL = """[tolerance]
samples = 4000
distribution = "{how}"
center_distance = 0.01
side_shift = 0.01
axial_shift = 0.05
crossing_arcmin = 1
skew_arcmin = 1
squareness_arcmin = 1
phase_arcmin = 2
cam_yaw_arcmin = 0.5
roller_diameter = 0.005
roller_axial = 0.05
roller_tilt_arcmin = 2
flank_form = 0.004
flank_growth = {{ value = 0.004, mean = 0.002 }}
running_clearance = 0.004
"""


@pytest.mark.parametrize("how", ["uniform", "worst"])
@pytest.mark.parametrize(("kind", "force"), [("slide", 0), ("slide", 900), ("leaning", -900), ("arm", 900), ("arm", 0)])
def test_no_machine_goes_beyond_the_worst_case(kind: str, force: float, how: str) -> None:
    study = plate(kind, (FORCED.format(force=force) if force else "") + ALL.format(how=how)).tolerances
    drawn, worst = study.drawn, study.worst
    for figure, end in ((drawn.dwell, worst.dwell), (drawn.motion, worst.motion), (drawn.backlash, worst.backlash)):
        assert float(figure.max()) <= 1.0013 * end.value
    assert drawn.ended is not None
    assert float(drawn.ended.max()) <= (1.0 + 1e-6) * study.worst_end
    if how == "worst":
        assert float(drawn.motion.max()) > 0.7 * worst.motion.value
        assert float(drawn.ended.max()) > 0.7 * study.worst_end


def test_an_end_at_which_the_follower_moves_is_no_dwell() -> None:
    text = TEXT.replace("until = 10\n", 'until = 40\nto = 12\nlaw = "cycloidal"\n')
    text = text.replace("until = 85\n", "until = 60\n[[motion]]\nuntil = 100\n", 1).rpartition("[[motion]]")[0]
    more = f'[tolerance]\nside_shift = {{ value = {0.8 * GAP}, distribution = "worst" }}\n'
    text = text.format(follower='kind = "translating"', cam="", rise=30, gap=GAP, more="")
    study = Model(parse(text + more)).tolerances
    assert float(study.drawn.dwell.max()) == study.worst.dwell.value == 0.0
    assert float(study.drawn.motion.max()) == pytest.approx(study.worst.motion.value, rel=3e-3)
    ends = study.worst.curve[[0, -1]]
    assert ends == pytest.approx(0.4 * GAP, rel=1e-6)


def test_both_sides_of_every_knot_of_the_path_are_sampled_out_and_back() -> None:
    theta = plate("slide").tolerances.sensitivities.theta
    for x in (FIRST, LAST):
        out = acos(1.0 - 2.0 * x / STROKE)
        for knot in (out, TURN - out):
            off = theta - knot
            assert 0.0 < off[off > 0.0].min() < 1e-9
            assert -1e-9 < off[off < 0.0].max() < 0.0


def test_the_plate_has_one_flank_out_and_back() -> None:
    """Its form, like every error but those of the drive, is the same on both ways."""
    seated = plate("arm").tolerances.loaded.at(np.array([1.1, TURN - 1.1]))
    for key in ("flank_form", "squareness_arcmin", "cam_yaw_arcmin", "side_shift", "skew_arcmin"):
        out, back = seated.approaches.of(CAUSES[key]).swapaxes(0, 1)
        assert out == pytest.approx(back, abs=1e-9), key
    out, back = seated.approaches.of(CAUSES["phase_arcmin"])[0]
    assert out == pytest.approx(-back, abs=1e-9)
    assert np.abs(out).max() > 1.0


def test_a_yaw_is_seen_at_the_ends_of_its_dwells() -> None:
    """Of a plate turned by w on its slide the dwell at x stands off by w x: at its end by 0.4 % more than at 0.98."""
    yaw = 'cam_yaw_arcmin = { value = 1, distribution = "worst" }'
    made = plate("slide", f"[tolerance]\n{yaw}\naxes_pivot = [130, 22, 15]\n")
    wanted = ARCMIN * STROKE
    assert made.tolerances.worst.dwell.value == pytest.approx(wanted, rel=1e-6)
    assert float(made.tolerances.drawn.dwell.max()) == pytest.approx(wanted, rel=1e-6)


def test_pivots_are_the_rollers_place_at_zero_travel() -> None:
    for kind in FOLLOWERS:
        assert default_pivots(plate(kind).mechanism).axes == pytest.approx((START, EDGE, 15.5))
    beside = plate("slide", "[tolerance]\nsquareness_arcmin = 1\naxes_pivot = [130, 22, 15]\n").tolerances
    # 100 mm further along, the dwells move by as much as a yaw of that lever.
    resting = int(np.argmin(np.abs(beside.sensitivities.theta - 0.3)))
    assert beside.worst.curve[resting] == pytest.approx(ARCMIN * 100.0, rel=2e-6)


@pytest.mark.parametrize("angle", [60.0, 300.0])
def test_what_the_first_order_leaves_of_a_drive_that_is_ahead(angle: float) -> None:
    """s(x(theta + w)) - s - s' w: told by at least as much, and at most twice."""
    made = plate("slide", f"[tolerance]\nphase_arcmin = {angle}\n")
    study, groove, w = made.tolerances, Groove("slide"), angle * ARCMIN
    theta, table = np.linspace(0.0, TURN, 20001), study.sensitivities
    spreads = {"phase_arcmin": (0.0, w, "normal")}
    curve = Worst.of(table.seated, study.causes, spreads).curve
    told, key = second_order(table.seated, study.causes, spreads, curve)
    s = [groove.lift(crank(theta + way * w)) for way in (-1.0, 0.0, 1.0)]
    bent = 0.5 * float(np.abs(s[0] + s[2] - 2.0 * s[1]).max())
    assert key == "phase_arcmin"
    assert bent * 0.98 <= told <= 2.0 * bent


def test_report_and_verdict_have_them() -> None:
    made = plate("arm", FORCED.format(force=900) + ALL.format(how="normal") + "dwell_limit = 100\n")
    blocks = tolerance(made)
    assert any("groove's end" in str(row) for block in blocks for row in getattr(block, "rows", ()))
    said = judge(made, ["dwell-tolerance", "backlash-tolerance", "groove-end-tolerance"])
    assert {one.check for one in said.findings} == {"dwell-tolerance", "groove-end-tolerance"}
    assert [one.check for one in said.not_judged] == ["backlash-tolerance"]
