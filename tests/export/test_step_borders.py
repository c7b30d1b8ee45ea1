"""Where edges run in the parameters of their faces: what is written, read back here without any CAD kernel.

Between a groove's flank and its floor runs the sweep of the roller's edge: faces tens of millimetres long and a few
thousandths wide, which end in a point where the groove goes straight round. A reader that projects their edges gets
the parameter across wrong near the point, and calls the face one that crosses itself.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline

from camgeom.export.step import Brep, step_text, write_step
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.geometry import MEET, WORLD, Circle, Cone, SplineCurve, SplineSurface
from camgeom.export.step.recognise import EXACT, NARROW, surface_of
from camgeom.export.step.spline import fit_bands
from camgeom.maths.splines import Basis, clamped
from camgeom.model import Model
from camgeom.profile import parse
from scripts.judge_step import judged

SLIVERS = {
    # an edge sweep that ends in a point at both ends
    "crowned roller on a cone": """name = "crowned roller on a cone"
motion = [
{to = 0.8525, law = "freudenstein-1-3-5", until = 191.4}, {until = 275.0},
{to = 0.0, law = "simple-harmonic", until = 360.0}]
cam = {kind = "conical", diameter = 120.0, half_angle = -0.004118, length = 13.65, start = 3.598, \
groove_depth = 3.237, bore = 40.31, direction = "cw"}
follower = {kind = "translating"}
roller = {shape = "crowned", diameter = 4.677, length = 3.0, crown_radius = 8.619, flank = "conforming"}
""",
    # edge sweeps a ten thousandth of a millimetre wide
    "cone on an arm": """name = "cone on an arm"
motion = [
{to = 0.09213, law = "scca", until = 227.6}, {to = 0.0, law = "modified-trapezoid", share = 0.1027, until = 360.0}]
cam = {kind = "cylindrical", form = "groove", diameter = 120.0, groove_depth = 1.604, start = 5.523, \
length = 11.32, running_clearance = 0.001767, bore = 52.92, direction = "cw"}
follower = {kind = "swinging", arm = 169.0, start_angle = -0.04607}
roller = {shape = "cone", diameter = 5.343, length = 0.9756, half_angle = -14.92}
""",
    # dwells whose edge sweep is 1e-10 mm wide
    "crowned on an arm": """name = "crowned on an arm"
motion = [
{until = 11.35}, {to = 0.08184, law = "triple-harmonic", until = 53.32}, {until = 55.12},
{to = 0.478, law = "gutman-1-3", until = 135.0}, {until = 137.5},
{to = 0.2025, law = "simple-harmonic", until = 233.6}, {to = 0.1285, law = "cubic-1", until = 287.9},
{until = 293.6}, {to = 0.0, law = "simple-harmonic", until = 360.0}]
cam = {kind = "cylindrical", form = "groove", diameter = 120.0, groove_depth = 24.25, start = 19.65, \
length = 40.09, bore = 19.03, direction = "cw"}
follower = {kind = "swinging", arm = 91.47, start_angle = -0.2473}
roller = {shape = "crowned", diameter = 29.19, length = 21.41, crown_radius = 28.73, flank = "conforming"}
""",
    # a groove that runs out of an end
    "groove that runs out": """name = "groove that runs out"
motion = [
{until = 44.25}, {to = 0.08174, law = "gutman-1-3", until = 197.5}, {until = 207.2},
{to = 0.0, law = "modified-constant-velocity", until = 360.0}]
cam = {kind = "cylindrical", form = "groove", diameter = 120.0, groove_depth = 5.341, start = 6.538, \
length = 13.16, bore = 32.47, keyway_width = 8.935, keyway_depth = 3.077, direction = "cw"}
follower = {kind = "translating"}
roller = {shape = "cone", diameter = 11.87, length = 4.594, half_angle = 22.3}
""",
}
"""drums of which OpenCASCADE called faces wrong while it had to find the parameters of their edges"""


@dataclass(frozen=True)
class Written:
    """The DATA section of a file: entity by number, and what is needed of it evaluated."""

    entities: dict[int, str]

    @classmethod
    def of(cls, solid: Brep) -> Written:
        lines = re.findall(r"^#(\d+)=(.*);$", step_text(solid), re.MULTILINE)
        return cls({int(number): line for number, line in lines})

    def all(self, kind: str) -> list[int]:
        return [number for number, line in self.entities.items() if line.startswith(kind + "(")]

    def links(self, number: int) -> list[int]:
        return [int(found) for found in re.findall(r"#(\d+)", re.sub(r"'(?:''|[^'])*'", "", self.entities[number]))]

    def kind(self, number: int) -> str:
        return self.entities[number].split("(", 1)[0]

    def point(self, number: int) -> list[float]:
        return [float(value) for value in self.entities[number].split("(")[2].rstrip(")").split(",")]

    def spline(self, number: int) -> tuple[list[BSpline], np.ndarray]:
        """The basis along each parameter, as scipy has it, and the poles (n, 3) or (n, m, 3)."""
        head, *_ = self.entities[number].split(",.UNSPECIFIED.", 1)
        tail = self.entities[number].split(".F.,", 1)[1].split(",.UNSPECIFIED.")[0].replace(".F.,", "")
        groups = [[float(x) for x in group.split(",")] for group in re.findall(r"\(([^()]*)\)", tail)]
        half = len(groups) // 2
        knots = [np.repeat(breaks, np.array(counts, dtype=int)) for counts, breaks in zip(groups[:half], groups[half:])]
        degrees = [int(word) for word in re.findall(r"(?<=,)\d+(?=,)", head.split("#")[0])]
        sizes = [len(t) - k - 1 for t, k in zip(knots, degrees)]
        poles = np.array([self.point(link) for link in self.links(number)]).reshape(*sizes, 3)
        return [BSpline(t, np.eye(size), k) for t, size, k in zip(knots, sizes, degrees)], poles

    def faces(self) -> list[tuple[int, list[list[tuple[int, bool]]]]]:
        """Surface of each face, and its loops of edges with the way they are run."""
        found = []
        for face in self.all("ADVANCED_FACE"):
            *bounds, surface = self.links(face)
            loops = [
                [(self.links(use)[0], ".T." in self.entities[use]) for use in self.links(self.links(bound)[0])]
                for bound in bounds
            ]
            found.append((surface, loops))
        return found

    def lines(self, edge: int, surface: int) -> list[int]:
        """PCURVEs of an edge on a surface."""
        curve = self.links(edge)[2]
        if self.kind(curve) != "SURFACE_CURVE":
            return []
        return [link for link in self.links(curve)[1:] if self.links(link)[0] == surface]

    def gap(self, edge: int, surface: int, line: int) -> float:
        """Largest distance in mm of an edge's curve from the surface at the parameters that the file says."""
        (basis,), poles = self.spline(self.links(self.links(edge)[2])[0])
        across, net = self.spline(surface)
        t = np.linspace(basis.t[0], basis.t[-1], 301)
        (straight,) = self.links(self.links(line)[1])[:1]
        origin, vector = self.links(straight)
        at = np.array(self.point(origin)) + t[:, None] * np.array(self.point(self.links(vector)[0]))
        u, v = (b(np.clip(x, b.t[0], b.t[-1])) for b, x in zip(across, at.T))
        assert all(b.t[0] <= x.min() and x.max() <= b.t[-1] for b, x in zip(across, at.T))
        return float(np.abs(np.einsum("ni,nj,ijc->nc", u, v, net) - basis(t) @ poles).max())


def solid_of(name: str) -> Brep:
    solid = model_bodies(Model(parse(SLIVERS[name])))
    assert isinstance(solid, Brep)
    return solid


@pytest.mark.parametrize("name", [name for name in SLIVERS if "runs out" not in name])
def test_every_edge_of_a_spline_face_says_where_in_the_face_it_runs(name: str) -> None:
    written = Written.of(solid_of(name))
    splines = 0
    for surface, loops in written.faces():
        if written.kind(surface) != "B_SPLINE_SURFACE_WITH_KNOTS":
            continue
        splines += 1
        for edge, _ in (use for loop in loops for use in loop):
            (line,) = written.lines(edge, surface)
            assert written.gap(edge, surface, line) < 2.0 * MEET
    assert splines > 8


def test_edges_along_the_bands_of_a_groove_that_runs_out_say_it_too() -> None:
    written = Written.of(solid_of("groove that runs out"))
    told = crossings = 0
    for surface, loops in written.faces():
        for edge, _ in (use for loop in loops for use in loop):
            lines = written.lines(edge, surface)
            assert len(lines) <= 1
            told += len(lines)
            crossings += not lines and written.kind(surface) == "B_SPLINE_SURFACE_WITH_KNOTS"
            assert all(written.gap(edge, surface, line) < 2.0 * MEET for line in lines)
    assert told > 4 * crossings > 0


@pytest.mark.opencascade
@pytest.mark.parametrize("name", SLIVERS)
def test_opencascade_finds_faces_that_end_in_points_valid(name: str, tmp_path: Path) -> None:
    write_step(tmp_path / "a.step", solid_of(name))
    (verdict,) = judged([tmp_path / "a.step"])
    assert (verdict.solids, verdict.free_shells, verdict.valid) == (1, 0, True), verdict.complaints
    assert verdict.tolerance < 1e-5


def patch() -> SplineSurface:
    """A wavy patch over u from 1 to 3."""

    def point(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.stack([u[:, None] + 0.0 * v, v + 0.0 * u[:, None], np.sin(2.0 * u[:, None] + v)], axis=-1)

    (fit,) = fit_bands([point], [3], (1.0, 3.0), 1e-6)
    return SplineSurface(fit.u, fit.v, fit.poles)


def test_a_curve_is_a_border_within_what_ought_to_meet() -> None:
    surface = patch()
    for axis, basis, end, value in ((1, surface.u, 0, 0.0), (1, surface.u, -1, 1.0), (0, surface.v, -1, 3.0)):
        poles = surface.poles.take(end, axis)
        for share, found in ((0.999, (axis, value, 1)), (1.002, None)):
            away = np.array([0.0, 0.0, share * MEET])
            assert surface.border(SplineCurve(basis, poles + away)) == found
    other = Basis(3, clamped(np.array([0.4]), 3))
    assert surface.border(SplineCurve(other, surface.poles[0, : other.size])) is None


def test_a_border_may_be_run_backwards() -> None:
    surface = patch()
    back = Basis(surface.u.degree, -surface.u.knots[::-1])
    assert surface.border(SplineCurve(back, surface.poles[::-1, 0])) == (1, 0.0, -1)
    assert surface.border(SplineCurve(surface.u, surface.poles[::-1, 0])) is None


@pytest.mark.parametrize(("share", "kind"), [(0.999, SplineSurface), (1.002, Cone)])
def test_a_strip_of_no_width_is_no_cone(share: float, kind: type) -> None:
    """Two circles about one axis so near one another that rounding says how steep the cone between them is."""

    def point(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        radius, high = 30.0 + 0.6 * NARROW * share * v, 0.8 * NARROW * share * v
        return np.stack([radius * np.cos(u)[:, None], radius * np.sin(u)[:, None], high + 0.0 * u[:, None]], axis=-1)

    (fit,) = fit_bands([point], [1], (0.0, 1.0), 0.1 * EXACT)
    spline = SplineSurface(fit.u, fit.v, fit.poles)
    rails = Circle(WORLD, 30.0), Circle(WORLD, 30.0 + 0.6 * NARROW * share)
    assert type(surface_of(spline, fit.exact.reshape(-1, 3), rails, ())) is kind
