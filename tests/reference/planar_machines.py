"""Planar cams that several tests look at: the reference disc, mechanism B1, the paper's press, an elastic follower."""

from __future__ import annotations

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid, refined_maximum
from camgeom.model import Model
from camgeom.motion.program import Program
from camgeom.profile import parse

REFERENCE = [(120, 20, "cycloidal"), (150, None, None), (270, 0, "cycloidal"), (360, None, None)]
HARMONIC = [(180, 50.8, "simple-harmonic"), (360, 0, "simple-harmonic")]
B1 = """
name = "B1"
[cam]
kind = "conjugate"
center_distance = 205
base_radius = {base}
width = 20
gap = 4
bore = 60
{cam}
[follower]
kind = "swinging"
arm = 90
inertia = 0.14
{follower}
[roller]
diameter = 40
length = 20
[[motion]]
until = 70
to = 24
law = "{law}"
[[motion]]
until = 140
to = 0
law = "{law}"
[[motion]]
until = 360
[operation]
speed = 600
[output]
tolerance = {tolerance}
"""
PAPER = """
name = "pressing mechanism"
[cam]
kind = "constant-width"
base_radius = 40
width = 16
bore = 24
[follower]
kind = "frame"
mass = 1.2
{follower}
{roller}
[[motion]]
until = 140
to = 30
law = "{law}"
[[motion]]
until = 180
[operation]
speed = 60
"""
ELASTIC = """
name = "elastic follower"
[cam]
kind = "disc"
base_radius = 50
width = 15
[follower]
kind = "translating"
mass = 2
[roller]
diameter = 20
length = 14
[[motion]]
until = 100
to = 12
law = "{law}"
[[motion]]
until = 150
[[motion]]
until = 250
to = 0
law = "{law}"
[[motion]]
until = 360
[operation]
speed = 900
spring_rate = 20
spring_preload = 400
[dynamics]
kind = "follower"
linkage_stiffness = 400
tolerance = 1e-9
polydyne = true
"""


def toml(cam="", follower='kind = "translating"', roller="diameter = 20\nlength = 12", motion=REFERENCE, rest=""):
    lines = ['name = "disc"', "[cam]", 'kind = "disc"', "width = 12"]
    lines += [cam if "base_radius" in cam else f"base_radius = 30\n{cam}", "[follower]", follower]
    lines += ["[roller]", roller] if roller else []
    for until, to, law in motion:
        lines += ["[[motion]]", f"until = {until}"] + ([f'to = {to}\nlaw = "{law}"'] if to is not None else [])
    return "\n".join([*lines, rest])


def disc(*args, **kwargs) -> Model:
    return Model(parse(toml(*args, **kwargs)))


def flat(kind="translating", cam="", follower="", motion=REFERENCE, rest="") -> Model:
    arm = "" if kind == "translating" else "arm = 90"
    return disc(cam, f'kind = "{kind}"\nface = "flat"\n{arm}\n{follower}', "", motion, rest)


def b1(base: float = 130, cam: str = "", follower: str = "", law: str = "3-4-5", tolerance: float = 0.005) -> Model:
    return Model(parse(B1.format(base=base, cam=cam, follower=follower, law=law, tolerance=tolerance)))


def machine(law: str = "simple-harmonic", roller: str = "", follower: str = "") -> Model:
    return Model(parse(PAPER.format(law=law, roller=roller, follower=follower)))


def smallest_flat_base(program: Program, radius: float = 0.0) -> float:
    """Smallest base radius, mm, of a translating flat face whose profile keeps a radius of curvature (mm).

    rho = base + s + s'', so base is the largest of radius - s - s'' over the turn.
    """

    def needed(phi: Floats) -> Floats:
        s, _, dds = program.jet(phi, 2)
        return np.asarray(radius - s - dds)

    phi, owner = piece_grid(program.knots, 720)
    return max(0.0, refined_maximum(needed, phi, owner, needed(phi))[0])
