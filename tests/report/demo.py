"""A page about a plate cam with a translating roller, every number in it computed from the cycloidal motion.

It exercises each kind of block, with a long history, a blank region in a map, marks close together and markup in names.
"""

from __future__ import annotations

import numpy as np

from camgeom.drawing.content import (
    CAM_ANGLE,
    Actor,
    Axis,
    Band,
    Chapter,
    Chart,
    Circle,
    Column,
    Cost,
    Dimension,
    Drawing,
    Figure,
    Leader,
    Level,
    Limit,
    Map,
    Mark,
    Page,
    Panel,
    Path,
    Polar,
    Remark,
    Scene,
    Series,
    Shade,
    Table,
    Text,
    Zone,
)
from camgeom.drawing.sheet import number
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

BASE, ROLLER, LIFT, WIDTH, BORE = 40.0, 11.0, 24.0, 18.0, 14.0
ZONES = (Zone(0.0, 40.0, "dwell"), Zone(160.0, 200.0, "dwell"), Zone(320.0, 360.0, "dwell"))


def lift(theta: Floats) -> Floats:
    """(4, n): s, s', s'', s''' (mm per rad) of a cycloidal rise 40..160 deg, dwell, return 200..320 deg."""
    turn = 2.0 * np.pi
    degrees = np.degrees(theta) % 360.0
    beta = np.radians(120.0)
    jet = np.zeros((4, len(theta)))
    for start, sign, offset in ((40.0, 1.0, 0.0), (200.0, -1.0, 1.0)):
        x = (degrees - start) / 120.0
        on = (x >= 0.0) & (x <= 1.0)
        a = turn * x[on]
        jet[0, on] = LIFT * (offset + sign * (x[on] - np.sin(a) / turn))
        jet[1, on] = sign * LIFT / beta * (1.0 - np.cos(a))
        jet[2, on] = sign * LIFT / beta**2 * turn * np.sin(a)
        jet[3, on] = sign * LIFT / beta**3 * turn**2 * np.cos(a)
    jet[0, (degrees > 160.0) & (degrees < 200.0)] = LIFT
    return jet


def profile(theta: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Flank points (n, 2) in the cam frame, pressure angle (degrees), curvature (1/mm), pitch points (n, 2)."""
    s, v, a, _ = lift(theta)
    r = BASE + ROLLER + s
    pressure = np.arctan2(v, r)
    pitch = np.stack([r * np.cos(theta), -r * np.sin(theta)], axis=-1)
    tangent = np.stack([v * np.cos(theta) - r * np.sin(theta), -v * np.sin(theta) - r * np.cos(theta)], axis=-1)
    speed = np.hypot(r, v)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1) / speed[:, None]
    kappa = (r * r + 2.0 * v * v - r * a) / speed**3
    flank = pitch - ROLLER * normal
    return flank, np.degrees(pressure), kappa / (1.0 - ROLLER * kappa), pitch


def plate(n: int = 720) -> tuple[Mesh, dict[str, Floats]]:
    """The plate as a closed mesh and its result fields, blank off the flank."""
    theta = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    flank, pressure, kappa, _ = profile(theta)
    bore = BORE * np.stack([np.cos(theta), -np.sin(theta)], axis=-1)
    rings = [(flank, 0.0), (flank, WIDTH), (bore, WIDTH), (bore, 0.0)]
    vertices = np.vstack([np.column_stack([ring, np.full(n, z)]) for ring, z in rings])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    faces, group = [], []
    for ring, name in ((0, 0), (1, 1), (2, 2), (3, 1)):
        a, b = ring * n, (ring + 1) % 4 * n
        faces += [np.column_stack([a + j, a + i, b + i]), np.column_stack([a + j, b + i, b + j])]
        group += [np.full(2 * n, name, np.uint8)]
    mesh = Mesh(vertices, np.vstack(faces).astype(np.int32), ("flank", "end", "bore"), np.concatenate(group))
    blank = np.full(2 * n, np.nan)
    fields = {"pressure_angle": np.r_[pressure, pressure, blank], "curvature": np.r_[kappa, kappa, blank]}
    return mesh, fields


def roller_mesh(n: int = 64) -> Mesh:
    """The roller, a cylinder along Z at the origin."""
    turn = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    ring = ROLLER * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    low, high = -1.0, WIDTH + 1.0
    vertices = np.vstack(
        [np.column_stack([ring, np.full(n, z)]) for z in (low, high)] + [[[0, 0, low]], [[0, 0, high]]]
    )
    i, j = np.arange(n), (np.arange(n) + 1) % n
    one = np.ones(n, dtype=int)
    faces = np.vstack(
        [
            np.column_stack([i, j, j + n]),
            np.column_stack([i, j + n, i + n]),
            np.column_stack([j, i, 2 * n * one]),
            np.column_stack([i + n, j + n, (2 * n + 1) * one]),
        ]
    )
    return Mesh(vertices, faces.astype(np.int32))


def scene() -> Scene:
    """The plate turning under the roller."""
    angles = np.linspace(0.0, 360.0, 181)
    theta = np.radians(angles)
    s = lift(theta)[0]
    cam = np.zeros((len(theta), 3, 4))
    cam[:, 0, 0] = cam[:, 1, 1] = np.cos(theta)
    cam[:, 1, 0], cam[:, 0, 1], cam[:, 2, 2] = np.sin(theta), -np.sin(theta), 1.0
    follower = np.zeros_like(cam)
    follower[:, range(3), range(3)] = 1.0
    follower[:, 0, 3] = BASE + ROLLER + s
    mesh, fields = plate()
    return Scene(
        "The mechanism over one turn",
        angles,
        (Actor("cam", mesh, cam, "cam", fields), Actor("roller", roller_mesh(), follower, "follower")),
        (
            Shade("pressure_angle", "Pressure angle", "°", True, ("flank",)),
            Shade("curvature", "Curvature", "1/mm", True),
        ),
        ((Axis("Lift", "mm"), s),),
        speed=600.0,
    )


def motion() -> Chart:
    """s, v, a, j with their characteristic values."""
    degrees = np.linspace(0.0, 360.0, 1441)
    omega = 62.8318530718
    jet = lift(np.radians(degrees)) * np.array([1.0, omega / 1e3, omega**2 / 1e3, omega**3 / 1e3])[:, None]
    axes = (Axis("Lift s", "mm"), Axis("Velocity v", "m/s"), Axis("Acceleration a", "m/s²"), Axis("Jerk j", "m/s³"))
    panels = []
    for axis, y in zip(axes, jet):
        spots = [int(np.argmax(y)), int(np.argmin(y))] if axis.label != "Lift s" else [int(np.argmax(y))]
        marks = tuple(Mark(float(degrees[i]), float(y[i]), f"{number(y[i])} at {degrees[i]:.0f}°") for i in spots)
        panels.append(Panel(axis, (Series(axis.label, degrees, y),), marks=marks))
    return Chart("Motion over one turn at 600 r/min", CAM_ANGLE, tuple(panels), ZONES)


def pressure_angle() -> Chart:
    """Pressure angle and relative curvature with their limits."""
    degrees = np.linspace(0.0, 360.0, 721)
    _, pressure, kappa, _ = profile(np.radians(degrees))
    peak = int(np.argmax(np.abs(pressure)))
    return Chart(
        "Pressure angle and curvature of the flank",
        CAM_ANGLE,
        (
            Panel(
                Axis("Pressure angle", "°"),
                (Series("pitch radius", degrees, pressure), Series("flank edge", degrees, 0.92 * pressure)),
                limits=(Limit(30.0, "limit 30°"), Limit(-30.0, "limit −30°")),
                marks=(Mark(float(degrees[peak]), float(pressure[peak]), f"{pressure[peak]:.1f}°"),),
            ),
            Panel(Axis("Curvature", "1/mm", zero=True), (Series("flank", degrees, kappa),)),
        ),
        ZONES,
    )


def contact_map(diverging: bool = False) -> Map:
    """A made-up load over the computed curvature: Hertz line pressure along the roller, blank where unloaded."""
    degrees = np.linspace(0.0, 360.0, 181)
    along = np.linspace(-9.0, 9.0, 25)
    _, pressure, kappa, _ = profile(np.radians(degrees))
    acceleration = lift(np.radians(degrees))[2]
    load = np.clip(400.0 + 12.0 * acceleration, 0.0, None)
    tilt = 1.0 + 0.02 * along[:, None] * np.sign(acceleration)[None, :]
    relative = np.clip(kappa + 1.0 / ROLLER, 1e-4, None)
    values = 190.0 * np.sqrt(load / WIDTH * relative)[None, :] * tilt
    values[:, load < 150.0] = np.nan
    if diverging:
        values = np.broadcast_to(pressure, values.shape) + along[:, None]
    i, j = np.unravel_index(int(np.nanargmax(values)), values.shape)
    return Map(
        "Pressure angle over the flank" if diverging else "Contact pressure along turn and roller",
        CAM_ANGLE,
        Axis("Along the roller", "mm"),
        Axis("Pressure angle", "°") if diverging else Axis("Contact pressure", "MPa"),
        degrees,
        along,
        values,
        diverging,
        (Mark(float(degrees[j]), float(along[i]), f"peak {values[i, j]:.4g}"),),
    )


def polar() -> Polar:
    """Damage round the roller."""
    turn = np.linspace(0.0, 360.0, 361)
    damage = 0.02 + np.exp(-(((turn - 133.0) / 24.0) ** 2)) + 0.55 * np.exp(-(((turn - 291.0) / 40.0) ** 2))
    return Polar(
        "Damage round the roller per 1000 h",
        Axis("Damage", "1/kh"),
        (Series("middle of the roller", turn, damage), Series("end of the roller", turn, 0.7 * damage)),
        (Mark(133.0, float(damage[133]), "hot spot 133°"),),
    )


def campbell() -> Chart:
    """Natural frequencies against speed with excitation orders."""
    speed = np.linspace(0.0, 1200.0, 60)
    orders = tuple(Series(f"{k}×", speed, k * speed / 60.0, 4) for k in (1, 2, 3, 4, 6, 9, 12))
    band = Band("f₁ over the turn", speed, np.full(60, 92.0), 104.0 + 0.004 * speed, 0)
    second = Series("f₂", speed, np.full(60, 171.0), 1)
    return Chart(
        "Campbell diagram",
        Axis("Speed", "r/min", 0.0, 1200.0),
        (
            Panel(
                Axis("Frequency", "Hz", 0.0, 240.0),
                (*orders, second),
                (band,),
                (Limit(600.0, "600 r/min", vertical=True),),
                direct=True,
                height=1.2,
            ),
        ),
    )


def history() -> Chart:
    """Decaying impacts, many samples."""
    t = np.linspace(0.0, 0.4, 40_001)
    phase = t % 0.1
    y = 30.0 * np.exp(-phase / 0.012) * np.sin(2.0 * np.pi * 430.0 * phase)
    return Chart("Impact force over four turns", Axis("Time", "s"), (Panel(Axis("Force", "N"), (Series("F", t, y),)),))


def drawing() -> Drawing:
    """The plate to scale."""
    theta = np.linspace(0.0, 2.0 * np.pi, 361)
    flank, _, _, pitch = profile(theta)
    x, y = BASE + ROLLER, 0.0
    far = float(flank[:, 0].min()), 0.0
    return Drawing(
        "Plate cam at cam angle 0, seen from +Z",
        (
            Path(flank, "part", closed=True),
            Path(pitch, "axis", closed=True),
            Path(np.array([[-80.0, 0.0], [75.0, 0.0]]), "axis"),
            Path(np.array([[0.0, -70.0], [0.0, 70.0]]), "axis"),
        ),
        (Circle((0.0, 0.0), BORE, "outline"), Circle((0.0, 0.0), BASE, "hidden"), Circle((x, y), ROLLER, "ghost")),
        (
            Dimension((0.0, 0.0), (x, 0.0), "51", "below"),
            Dimension(far, (0.0, 0.0), f"{-far[0]:.4g}", "below"),
            Dimension((x - ROLLER, 0.0), (x + ROLLER, 0.0), "⌀ 22", "above"),
            Dimension((0.0, -BORE), (0.0, BORE), "⌀ 28", "left"),
            Dimension((0.0, float(flank[:, 1].min())), (0.0, float(flank[:, 1].max())), "118.3", "left"),
        ),
        (
            Leader((BASE * 0.6, -BASE * 0.8), "base circle ⌀ 80"),
            Leader((float(pitch[60, 0]), float(pitch[60, 1])), "pitch curve"),
            Leader((x, 0.0), "roller ⌀ 22, contact length 18"),
            Leader((-BORE * 0.8, BORE * 0.6), "bore ⌀ 28 H7"),
        ),
    )


def page() -> Page:
    """The whole page."""
    findings = (
        Remark("Pressure angle", Level.FAIL, 31.46, "≤ 30°", "°", "cam angle 97.5°", "Lengthen the rise to 127°."),
        Remark("Undercut", Level.PASS, 0.62, "> 0", "", "cam angle 118°"),
        Remark("Contact pressure <script>alert(1)</script>", Level.PASS, 843.0, "≤ 2450 MPa", "MPa", "cam angle 40°"),
    )  # fmt: skip
    table = Table(
        "Validation against independent ways of computing",
        (Column("Quantity"), Column("Here", "mm"), Column("Independent", "mm"), Column("Difference", "µm"), Column("")),
        (
            ("Flank point, largest deviation", 58.123456, 58.123411, 0.045, True),
            ("Enclosed area (mm²)", 9812.3, 9812.31, 0.6, True),
            ("Chord error of the mesh", 0.0049, 0.00491, 5.2, False),
        ),
    )
    parameters = Table(
        "Profile",
        (Column("Key"), Column("Value"), Column("Meaning")),
        (("cam.base_radius", 40.0, "Radius of the base circle"), ("roller.diameter", 22.0, "Roller diameter"),
         ("motion[1].law", "cycloidal", "Law of the rise")),
    )  # fmt: skip
    return Page(
        'Plate cam <b onload="alert(1)">demo</b>',
        "disc cam, translating roller follower",
        Level.FAIL,
        "One of three checks fails; the advice below says by how much to change what.",
        findings,
        (
            Figure("Largest pressure angle", 31.46, "°", "at 97.5°; limit 30°"),
            Figure("Smallest relative radius", 8.21, "mm", "at 118°"),
            Figure("Peak contact pressure", 843.2, "MPa", "at 40°, middle of the roller"),
            Figure("Roller life", 2.317e5, "h", "at 600 r/min"),
            Figure("Peak drive torque", 14.62, "N m"),
            Figure("Cam mass", 1.183, "kg"),
        ),
        (
            Chapter("design", "Design", (drawing(), scene())),
            Chapter("motion", "Motion", (Text(("Cycloidal rise and return between three dwells.",)), motion())),
            Chapter("flank", "Flank", (pressure_angle(), contact_map(True))),
            Chapter("contact", "Contact and life", (contact_map(), polar(), parameters_half())),
            Chapter("dynamics", "Dynamics", (campbell(), history())),
            Chapter("validation", "Validation", (table,)),
            Chapter("parameters", "Parameters", (parameters,)),
            Chapter("cost", "What was computed", (Cost((("flank", 0.012), ("solid", 0.31)), ("dynamics",)),)),
        ),
        (("Kind", "disc"), ("Version", "0.1.0"), ("Profile", "plate.toml"), ("Date", "2024-01-01")),
    )  # fmt: skip


def parameters_half() -> Table:
    """A table that stands beside a plot."""
    return Table("Life", (Column("Part"), Column("Life", "h")), (("roller", 2.317e5), ("cam", 8.8e5)), width="half")
