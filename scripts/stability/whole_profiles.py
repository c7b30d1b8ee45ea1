"""Whole random profiles: every kind, follower, roller, section, key and format, sound and unsound, from a seed alone.

Nothing here knows what makes a good cam but rough proportions: most numbers are ordinary, some are far off, and some
sections contradict the cam. Further keys and sections come from the schema (`whole_keys.py`). What the reader refuses
is taken away where the schema gave it, else drawn again, nine times in ten.
"""

from __future__ import annotations

import os
import random
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camgeom.errors import Problem

from whole_keys import FILES, Data, Keys, Path_

KINDS = ("disc", "constant-width", "conjugate", "cylindrical", "globoidal", "cylindrical-index", "parallel-index",
         "end-face", "linear", "conical")  # fmt: skip
SYMMETRIC = (
    "cycloidal",
    "modified-sine",
    "modified-trapezoid",
    "3-4-5",
    "4-5-6-7",
    "5-6-7-8-9",
    "simple-harmonic",
    "parabolic",
    "trapezoidal-acceleration",
    "modified-constant-velocity",
    "gutman-1-3",
    "freudenstein-1-3",
    "scca",
)
ODD = (
    "constant-velocity",
    "cubic-1",
    "double-harmonic",
    "trapezoidal-velocity",
    "universal-asymmetric",
    "triple-harmonic",
)
MESHES = ("3mf", "stl", "ply", "obj", "glb", "vtu")
DATA = (
    "step",
    "stp",
    "ap214.step",
    "assembly.step",
    "dxf",
    "points.csv",
    "points.ply",
    "points.npz",
    "cmm.csv",
    "outline.csv",
    "cutter.csv",
    "apt",
    "gcode",
    "rest.csv",
    "rest.vtu",
    "ecam.csv",
    "plcopen.xml",
    "polydyne.csv",
    "sheet.svg",
    "sheet.pdf",
    "history.csv",
    "history.parquet",
    "impact.csv",
    "impact.parquet",
)
VOLUMES = ("volume.bdf", "volume.inp", "volume.msh", "volume.vtu", "volume.xdmf")
PICTURES = ("png", "gif", "mp4", "webm", "pdf")


class Dice(random.Random):
    """Random numbers as people write them."""

    def near(self, value: float, spread: float = 0.25) -> float:
        """A value about another; one in twelve is far off."""
        if self.random() < 1.0 / 12.0:
            spread = 1.5
        found = value * (1.0 + spread) ** self.uniform(-1.0, 1.0)
        return round(found, self.choice((1, 2, 3))) if found > 1.0 else float(f"{found:.3g}")

    def any_of(self, low: float, high: float) -> float:
        """A value between two, in equal ratios."""
        return float(f"{low * (high / low) ** self.random():.3g}")

    def likely(self, share: float) -> bool:
        """True in so many cases."""
        return self.random() < share


@cache
def beside() -> str:
    """A profile's place in a folder that holds what profiles name; it lasts as long as the process."""
    folder = Path(tempfile.gettempdir()) / "camgeom-whole-profiles"
    folder.mkdir(exist_ok=True)
    lay(folder)
    return str(folder / "profile.toml")


def lay(folder: Path) -> None:
    """Lay the files that profiles may name into a folder."""
    for name, text in FILES.items():
        fresh = folder / f".{name}.{os.getpid()}"
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(folder / name)


def accepted(seed: int, pictures: float = 0.03) -> Data:
    """The profile of a seed that its reader accepts, as far as one is found; one in ten is the first that is drawn."""
    from camgeom.errors import ProfileError
    from camgeom.profile import parse

    data: Data = {}
    for draw in range(30):
        data, added = drawn(seed, pictures, draw)
        for _ in range(12):
            try:
                parse(toml(data), beside())
                return data
            except ProfileError as error:
                if seed // len(KINDS) % 10 == 9:
                    return data
                problems = error.problems
            idle = [problem.key for problem in problems if problem.message == "means nothing here"]
            told = [path for problem in problems if (path := _added(problem, added))]
            if not idle and not told:
                break
            for key in idle:
                _drop(data, _path(key))
            for path in told:
                _drop(data, path)
                added = [one for one in added if one[: len(path)] != path]
    return data


def _path(key: str) -> Path_:
    """The path of a key as messages write it: duty[0].share."""
    return tuple(int(word) if word.isdigit() else word for word in re.findall(r"[A-Za-z0-9_]+", key))


def _added(problem: Problem, added: list[Path_]) -> Path_:
    """What the schema gave of a problem's key: itself, the table or entry it stands in, or what stands in it."""
    path = _path(problem.key)
    within = [one for one in added if path[: len(one)] == one]
    if within:
        return max(within, key=len)
    beneath = [one for one in reversed(added) if one[: len(path)] == path]
    said = [one for one in beneath if re.search(rf"\b{one[-1]}\b", f"{problem}")]
    return next(iter(said or beneath), ())


def _drop(data: Any, path: Path_) -> None:
    head, *rest = path
    if isinstance(head, int):
        if isinstance(data, list) and head < len(data) and rest:
            _drop(data[head], tuple(rest))
    elif isinstance(data, dict) and rest:
        _drop(data.get(head), tuple(rest))
        if data.get(head) == {} and head != "output":
            del data[head]
    elif isinstance(data, dict):
        data.pop(head, None)


def profile(seed: int, pictures: float = 0.03, draw: int = 0) -> Data:
    """A draw of a seed; `pictures`: how often each kind of picture, film or printed page is asked for."""
    return drawn(seed, pictures, draw)[0]


def drawn(seed: int, pictures: float, draw: int) -> tuple[Data, list[Path_]]:
    """A draw of a seed, and the places of what comes from the schema."""
    dice = Dice(31 * seed + 1_000_003 * draw)
    kind = KINDS[seed % len(KINDS)]
    size = dice.any_of(20.0, 400.0)
    if dice.likely(0.06):
        size = dice.choice((0.1, 1.0, 3e3, 1e4))
    data: Data = {"name": f"{kind} {seed}"}
    makers = {"disc": _disc, "constant-width": _width, "conjugate": _pair, "cylindrical": _drum, "end-face": _ring,
              "linear": _plate, "conical": _cone}  # fmt: skip
    data |= makers.get(kind, _turret)(dice, kind, size)
    data |= _operation(dice, size, data["follower"]["kind"])
    data |= _sections(dice, kind, size, data)
    data["output"] = _output(dice, size, pictures)
    further = Keys(dice, data, size)
    further.everywhere()
    return data, further.added


def _law(dice: Dice, lift: bool = True) -> Data:
    law: Data = {"law": dice.choice(SYMMETRIC if dice.likely(0.85) else ODD)}
    if law["law"] == "modified-sine" and dice.likely(0.3):
        law["share"] = round(dice.uniform(0.05, 0.45), 3)
    return law


def _program(dice: Dice, stroke: float) -> list[Data]:
    """Rises, dwells and returns that close."""
    count = dice.choice((2, 3, 4, 4, 4, 5, 6))
    cuts = sorted(dice.sample(range(2, 36), count - 1))
    ends = [10.0 * cut for cut in cuts] + [360.0]
    segments: list[Data] = []
    level = 0.0
    for i, end in enumerate(ends):
        last = i == count - 1
        if last and level == 0.0:
            segments.append({"until": end})
        elif last or (level and dice.likely(0.4)):
            level = 0.0
            segments.append({"until": end, "to": 0.0, **_law(dice)})
        elif dice.likely(0.3):
            segments.append({"until": end})
        else:
            level = round(stroke * dice.uniform(0.3, 1.0), 2)
            segments.append({"until": end, "to": level, **_law(dice)})
    if all("to" not in segment for segment in segments):
        segments[0] |= {"to": stroke, **_law(dice)}
        segments[-1] |= {"to": 0.0, **_law(dice)}
    return segments


def _roller(dice: Dice, diameter: float, length: float, shapes: str = "cylinder") -> Data:
    shape = dice.choice(("cylinder", "cylinder", "crowned", "cone", "sphere")) if dice.likely(0.5) else shapes
    roller: Data = {"shape": shape, "diameter": diameter, "length": length}
    if shape == "cone":
        roller["half_angle"] = round(dice.uniform(-20.0, 25.0), 1)
    if shape == "crowned" and dice.likely(0.6):
        roller["crown_radius"] = dice.any_of(diameter, 200.0 * diameter)
    elif shape == "crowned":
        roller["crown"] = "logarithmic"
    if shape == "crowned" and dice.likely(0.2):
        roller["flank"] = "conforming"
    if shape == "sphere" and dice.likely(0.7):
        del roller["length"]
    if dice.likely(0.3):
        roller["dynamic_rating"] = dice.any_of(1e3, 1e5)
        if dice.likely(0.5):
            roller["static_rating"] = dice.any_of(1e3, 1e5)
    return roller


def _bore(dice: Dice, cam: Data, radius: float) -> None:
    if dice.likely(0.6):
        cam["bore"] = dice.near(0.8 * radius)
        if dice.likely(0.4):
            cam["keyway_width"], cam["keyway_depth"] = dice.near(0.2 * radius), dice.near(0.08 * radius)


def _disc(dice: Dice, kind: str, size: float) -> Data:
    base, stroke = dice.near(size), dice.near(0.35 * size)
    cam: Data = {"kind": kind, "base_radius": base, "width": dice.near(0.3 * size)}
    cam["direction"] = dice.choice(("cw", "ccw"))
    face = dice.choice(("roller", "roller", "roller", "flat", "curved", "knife"))
    swinging = dice.likely(0.4)
    follower: Data = {"kind": "swinging" if swinging else "translating"}
    if face != "roller":
        follower["face"] = face
    if swinging:
        cam["center_distance"] = dice.near(2.6 * size)
        follower |= {"arm": dice.near(2.2 * size), "inertia": dice.any_of(1e-4, 1.0)}
        stroke = round(dice.uniform(5.0, 30.0), 1)
    else:
        follower["mass"] = dice.any_of(0.1, 10.0)
        if dice.likely(0.3):
            follower["offset"] = round(dice.uniform(-0.4, 0.4) * size, 1)
    if face == "curved":
        follower["face_radius"] = dice.near(size)
    if face in ("flat", "curved") and dice.likely(0.5):
        follower["face_width"] = dice.near(2.0 * size)
    _bore(dice, cam, base)
    data: Data = {"cam": cam, "follower": follower, "motion": _program(dice, stroke)}
    if face != "roller":
        return data
    data["roller"] = _roller(dice, dice.near(0.6 * size), dice.near(0.3 * size))
    if dice.likely(0.3):
        cam |= {"form": "groove", "diameter": dice.near(4.2 * size), "groove_depth": dice.near(0.15 * size)}
        cam["running_clearance"] = dice.choice((0.0, 0.02))
        if dice.likely(0.4):
            # A second groove in the other face, and a plate that has room for both.
            cam["width"] = round(2.5 * cam["groove_depth"] + 0.1 * size, 3)
            track: Data = {"angle": float(dice.randrange(0, 360, 15)), "cam": {"face": "lower"}}
            data["track"] = [track | {"motion": _program(dice, stroke)}]
    elif dice.likely(0.3):
        roller: Data = {"shape": "cone", "diameter": dice.near(0.6 * size), "length": dice.near(0.3 * size)}
        data["roller"] = roller | {"half_angle": round(dice.uniform(-30.0, 30.0), 1)}
    return data


def _width(dice: Dice, kind: str, size: float) -> Data:
    cam: Data = {"kind": kind, "base_radius": dice.near(size), "width": dice.near(0.3 * size)}
    _bore(dice, cam, size)
    follower: Data = {"kind": "frame", "mass": dice.any_of(0.1, 20.0), "clearance": dice.choice((0.0, 0.02, 0.1))}
    data: Data = {"cam": cam, "follower": follower}
    if dice.likely(0.25):
        data["roller"] = _roller(dice, dice.near(0.4 * size), dice.near(0.3 * size))
    elif dice.likely(0.5):
        follower["face_width"] = dice.near(3.0 * size)
    rise = float(dice.randrange(60, 175, 5))
    segments = [{"until": rise, "to": dice.near(0.5 * size), **_law(dice)}, {"until": 180.0}]
    if dice.likely(0.3):
        segments = [{"until": 180.0 - rise}, {"until": 180.0, "to": dice.near(0.5 * size), **_law(dice)}]
    return {**data, "motion": segments}


def _pair(dice: Dice, kind: str, size: float) -> Data:
    cam: Data = {"kind": kind, "base_radius": dice.near(size), "width": dice.near(0.2 * size), "gap": dice.near(4.0)}
    cam["direction"] = dice.choice(("cw", "ccw"))
    follower: Data = {"clearance": dice.choice((0.0, 0.02, 0.05, 0.2))}
    stroke = dice.near(18.0)
    if dice.likely(0.8):
        cam["center_distance"] = dice.near(1.7 * size, 0.1)
        follower |= {"kind": "swinging", "arm": dice.near(0.75 * size, 0.1), "inertia": dice.any_of(1e-3, 1.0)}
    else:
        follower |= {"kind": "translating", "mass": dice.any_of(0.1, 10.0)}
        stroke = dice.near(0.2 * size)
    _bore(dice, cam, 0.6 * size)
    roller = _roller(dice, dice.near(0.3 * size), dice.near(0.18 * size))
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _program(dice, stroke)}


def _drum(dice: Dice, kind: str, size: float) -> Data:
    form = dice.choice(("groove", "groove", "rib"))
    radius, stroke, diameter = size, dice.near(0.4 * size), dice.near(0.3 * size)
    cam: Data = {"kind": kind, "form": form, "diameter": dice.near(2.0 * radius, 0.05)}
    cam["direction"] = dice.choice(("cw", "ccw"))
    follower: Data = {"kind": "translating", "mass": dice.any_of(0.1, 10.0)}
    middle = 0.5 * stroke
    if dice.likely(0.35):
        arm = dice.near(1.2 * size)
        follower = {"kind": "swinging", "arm": arm, "inertia": dice.any_of(1e-4, 1.0)}
        if dice.likely(0.6):
            follower["start_angle"] = round(dice.uniform(-20.0, 5.0), 1)
        stroke = round(dice.uniform(5.0, 30.0), 1)
        middle = 0.2 * arm
    cam["start"] = dice.near(0.6 * size)
    cam["length"] = round(2.2 * (cam["start"] + middle), 1)
    depth = dice.near(0.16 * size)
    if form == "groove":
        cam["groove_depth"] = depth
    else:
        cam |= {"groove_depth": depth, "rib_thickness": dice.near(0.16 * size)}
    if dice.likely(0.15):
        cam["run_out"] = True
    if dice.likely(0.3):
        cam["running_clearance"] = dice.choice((0.01, 0.05))
    _bore(dice, cam, 0.6 * radius)
    roller = _roller(dice, diameter, round(0.9 * depth, 2))
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _program(dice, stroke)}


def _ring(dice: Dice, kind: str, size: float) -> Data:
    inner, width = dice.near(0.8 * size), dice.near(0.35 * size)
    cam: Data = {"kind": kind, "diameter": 2.0 * (inner + width), "inner_diameter": 2.0 * inner}
    cam |= {"web": dice.near(0.2 * size), "direction": dice.choice(("cw", "ccw"))}
    follower, stroke = {"kind": "translating", "mass": dice.any_of(0.1, 10.0)}, dice.near(0.4 * size)
    travel, diameter, length = stroke, dice.near(0.3 * size), round(0.7 * width, 2)
    if dice.likely(0.35):
        follower = {"kind": "swinging", "arm": dice.near(1.2 * size), "inertia": dice.any_of(1e-4, 1.0)}
        stroke = round(dice.uniform(5.0, 30.0), 1)
        travel = 0.6 * size
    if dice.likely(0.4):
        # The edge of the roller's end, a third of its radius beyond the inside, has to stay within the floor.
        length = round(0.4 * width, 2)
        cam |= {"form": "groove", "groove_depth": dice.near(0.7 * width, 0.05), "start": dice.near(0.5 * size)}
        cam |= {"length": dice.near(0.8 * size + travel), "running_clearance": dice.choice((0.0, 0.0, 0.02))}
    else:
        cam["height"] = dice.near(0.6 * size)
    _bore(dice, cam, 0.8 * inner)
    roller = _roller(dice, diameter, length)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _program(dice, stroke)}


def _cone(dice: Dice, kind: str, size: float) -> Data:
    stroke, diameter = dice.near(0.4 * size), dice.near(0.3 * size)
    lean = round(dice.uniform(-30.0, 30.0) if dice.likely(0.7) else dice.uniform(-85.0, 85.0), 1)
    cam: Data = {"kind": kind, "diameter": dice.near(2.0 * size, 0.05), "half_angle": lean}
    cam |= {"length": dice.near(stroke + 1.5 * diameter), "start": dice.near(0.75 * diameter)}
    cam |= {"groove_depth": dice.near(0.6 * diameter), "running_clearance": dice.choice((0.0, 0.0, 0.02))}
    cam["direction"] = dice.choice(("cw", "ccw"))
    _bore(dice, cam, 0.4 * size)
    follower = {"kind": "translating", "mass": dice.any_of(0.1, 10.0)}
    roller = _roller(dice, diameter, round(0.55 * diameter, 2))
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _program(dice, stroke)}


def _plate(dice: Dice, kind: str, size: float) -> Data:
    stroke, depth = dice.near(2.0 * size), dice.near(0.15 * size)
    cam: Data = {"kind": kind, "stroke": stroke, "length": round(1.6 * stroke, 3), "width": dice.near(1.6 * size)}
    cam |= {"thickness": 2.0 * depth, "groove_depth": depth, "start": round(0.3 * stroke, 3)}
    cam["edge"] = dice.near(0.6 * size)
    if dice.likely(0.7):
        cam |= {"running_clearance": round(1e-3 * size, 6), "drive": dice.choice(SYMMETRIC)}
    if dice.likely(0.5):
        cam |= {"moving_mass": dice.any_of(0.1, 20.0), "drive_out": round(dice.uniform(90.0, 270.0), 1)}
    if dice.likely(0.3):
        cam["inclination"] = round(dice.uniform(-30.0, 30.0), 1)
    follower = {"kind": "translating", "mass": dice.any_of(0.1, 10.0)}
    roller = _roller(dice, dice.near(0.25 * size), round(0.9 * depth, 3))
    motion = _program(dice, dice.near(0.4 * size))
    for segment in motion:
        segment["until"] = round(segment["until"] / 360.0 * stroke, 6)
    motion[-1]["until"] = stroke
    if dice.likely(0.4):
        cam["form"] = "edge"
        for key in ("width", "groove_depth", "running_clearance"):
            cam.pop(key, None)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}


def _turret(dice: Dice, kind: str, size: float) -> Data:
    size = max(size, 60.0)
    stops = dice.choice((2, 3, 4, 4, 6, 6, 8, 8, 10, 12, 16))
    pitch = dice.near(0.5 * size, 0.1)
    follower: Data = {"kind": "turret", "stops": stops, "pitch_radius": pitch, "inertia": dice.any_of(1e-3, 10.0)}
    width = 6.28 * pitch / max(stops, 6)
    roller = _roller(dice, dice.near(0.42 * width), dice.near(0.3 * width))
    if kind == "parallel-index":
        plates = dice.choice((2, 2, 3, 4))
        follower["rollers"] = dice.choice((2, 3, 4)) * plates if dice.likely(0.5) else 2 * stops
        cam: Data = {
            "kind": kind,
            "center_distance": dice.near(0.9 * size, 0.1),
            "diameter": dice.near(1.3 * size, 0.1),
        }
        cam |= {"width": dice.near(0.1 * size), "gap": dice.near(0.14 * size)}
        if plates > 2:
            cam["plates"] = plates
    else:
        form = dice.choice(("rib", "groove"))
        cam = {"kind": kind, "form": form, "hand": dice.choice(("right", "left")), "width": dice.near(0.5 * size)}
        if kind == "globoidal":
            cam["center_distance"] = dice.near(size, 0.05)
            cam["globoid_radius"] = round(cam["center_distance"] - pitch - dice.near(0.1 * pitch, 0.3), 2)
        else:
            cam |= {"center_distance": dice.near(0.98 * pitch, 0.02), "diameter": dice.near(pitch, 0.1)}
        if dice.likely(0.3):
            cam["relief"] = dice.choice((0.005, 0.02))
    cam["direction"] = dice.choice(("cw", "ccw"))
    if dice.likely(0.6):
        cam["bore"] = dice.near(0.2 * size)
    first = float(dice.randrange(10, 160, 10))
    last = float(dice.randrange(200, 360, 10))
    motion: list[Data] = [{"until": first}, {"until": last, "to": 360.0 / stops, **_law(dice)}, {"until": 360.0}]
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}


def _operation(dice: Dice, size: float, follower: str) -> Data:
    if dice.likely(0.1):
        return {}
    turning = follower in ("swinging", "turret")
    operation: Data = {"speed": dice.any_of(1.0, 3000.0) if dice.likely(0.9) else dice.any_of(1e-3, 1e5)}
    if dice.likely(0.4):
        operation["friction"] = dice.any_of(0.1, 1e4)
    if dice.likely(0.5) and follower != "turret":
        operation |= {"spring_rate": dice.any_of(0.1, 200.0), "spring_preload": dice.any_of(1.0, 5e3)}
    if dice.likely(0.2) and not turning:
        operation["gravity"] = 9.81
    if dice.likely(0.2) and not turning:
        operation["guide_friction"] = round(dice.uniform(0.02, 0.3), 2)
    if dice.likely(0.2):
        operation["load_inertia" if turning else "load_mass"] = dice.any_of(1e-3, 50.0)
    if dice.likely(0.2):
        start = float(dice.randrange(0, 300, 10))
        force: Data = {"table": [[start, 0.0], [start + 20.0, dice.any_of(1.0, 1e4)], [start + 50.0, 0.0]]}
        if dice.likely(0.5):
            words = dice.choice(("100 * sin(theta)", "50 + 2 * s", "10 / (s - 1)", "1e3 * v", "sqrt(s)"))
            force = {"from": start, "until": start + 50.0, "expression": words}
        operation["force"] = [force]
    return {"operation": operation}


def _sections(dice: Dice, kind: str, size: float, data: Data) -> Data:
    turret = data["follower"]["kind"] == "turret"
    found: Data = {}
    if dice.likely(0.4):
        found["dynamics"] = _indexing(dice) if turret != dice.likely(0.05) else _elastic(dice)
    if dice.likely(0.2):
        found["impact"] = {"turns": dice.choice((2, 3, 4)), "restitution": round(dice.uniform(0.1, 1.0), 2)}
        if dice.likely(0.5):
            found["impact"]["clearance"] = dice.any_of(0.001, 0.5)
        if dice.likely(0.2):
            found["impact"] |= {"static_friction": 0.1, "dynamic_friction": 0.05}
    if dice.likely(0.3):
        found["cutter"] = _cutter(dice, data)
    if dice.likely(0.4):
        limits = {
            "pressure_angle_deg": round(dice.uniform(5.0, 80.0), 1),
            "min_wall_mm": dice.near(3.0),
            "undercut_margin": 0.1,
            "contact_pressure_mpa": dice.any_of(100.0, 3000.0),
            "life_h": dice.any_of(100.0, 1e6),
        }
        found["limits"] = {key: limits[key] for key in dice.sample(sorted(limits), dice.randrange(1, 4))}
    if dice.likely(0.4):
        found["material"] = {}
        for body in ("cam", "roller"):
            material = {
                "elastic_modulus": dice.any_of(2e3, 4e5), "poisson": round(dice.uniform(0.1, 0.45), 2),
                "contact_limit": dice.any_of(50.0, 3000.0), "contact_cycles": 1e7, "exponent": dice.choice((3, 6, 9.5)),
                "hardness": round(dice.uniform(10.0, 66.0), 0), "density": dice.any_of(1200.0, 8000.0),
            }  # fmt: skip
            found["material"][body] = {
                key: material[key] for key in dice.sample(sorted(material), dice.randrange(1, 5))
            }
    return found


def _indexing(dice: Dice) -> Data:
    spec: Data = {
        "kind": "indexing",
        "input_stiffness": dice.any_of(1e3, 1e6),
        "output_stiffness": dice.any_of(1e3, 1e6),
    }
    for key, low, high in (("cam_inertia", 1e-4, 1.0), ("turret_inertia", 1e-3, 1.0), ("load_inertia", 1e-3, 10.0)):
        if dice.likely(0.7):
            spec[key] = dice.any_of(low, high)
    if dice.likely(0.7):
        spec |= {"input_damping": dice.any_of(0.1, 50.0), "output_damping": dice.any_of(0.1, 50.0)}
    if dice.likely(0.3):
        spec["contact_stiffness"] = dice.any_of(1e3, 1e7)
    if dice.likely(0.15):
        spec["exact_contact"] = True
    if dice.likely(0.2):
        spec |= {"sweep": [dice.any_of(10.0, 60.0), dice.any_of(100.0, 1000.0)], "sweep_points": dice.choice((5, 20))}
    if dice.likely(0.1):
        spec |= {"fluctuation": round(dice.uniform(0.01, 0.2), 3)}
    return spec


def _elastic(dice: Dice) -> Data:
    spec: Data = {"kind": "follower", "linkage_stiffness": dice.any_of(10.0, 1e6)}
    if dice.likely(0.7):
        spec["linkage_damping"] = dice.any_of(0.1, 1e3)
    if dice.likely(0.3):
        spec["return_stiffness"] = dice.any_of(0.1, 100.0)
    if dice.likely(0.2):
        spec["mass"] = dice.any_of(0.01, 10.0)
    if dice.likely(0.2):
        spec |= {"tappet_mass": dice.any_of(0.01, 1.0), "tappet_stiffness": dice.any_of(1e3, 1e6)}
    if dice.likely(0.2):
        spec["polydyne"] = True
    if dice.likely(0.15):
        spec |= {"shaft_inertia": dice.any_of(1e-4, 0.1), "shaft_stiffness": dice.any_of(1e2, 1e5)}
    if dice.likely(0.2):
        spec |= {"sweep": [dice.any_of(10.0, 60.0), dice.any_of(100.0, 1000.0)], "sweep_points": 10}
    return spec


def _cutter(dice: Dice, data: Data) -> Data:
    like = data.get("roller", {}).get("diameter", 20.0)
    cutter: Data = {"kind": dice.choice(("roller", "flat", "flat", "ball", "wheel"))}
    if cutter["kind"] != "roller":
        cutter["diameter"] = dice.near(0.8 * like)
    if cutter["kind"] == "ball":
        cutter["scallop"] = dice.choice((0.01, 0.05, 0.2))
    if cutter["kind"] == "flat" and dice.likely(0.4):
        cutter["path"] = dice.choice(("flank", "centre", "shifted", "radial"))
    if dice.likely(0.2):
        cutter["allowance"] = 0.2
    if dice.likely(0.2):
        cutter["gouge_limit"] = 0.05
    return cutter


@cache
def _data() -> tuple[str, ...]:
    """The formats that are neither bodies nor pictures; those that are not known here come last."""
    from camgeom.report.files import format_rows

    known = {*MESHES, *DATA, *VOLUMES, *PICTURES}
    return *DATA, *sorted(row["format"] for row in format_rows() if row["format"] not in known)


def _output(dice: Dice, size: float, pictures: float) -> Data:
    output: Data = {"tolerance": dice.choice((0.02, 0.05, 0.05, 0.1, 0.2))}
    if dice.likely(0.05):
        output["tolerance"] = dice.choice((1e-6, 1e-5, 1e-4, 1.0))
    formats = [*dice.sample(MESHES, dice.randrange(0, 4)), *dice.sample(_data(), dice.randrange(0, 5))]
    formats += [name for name in VOLUMES if dice.likely(0.06)]
    formats += [name for name in PICTURES if dice.likely(pictures)]
    output["formats"] = formats or ["stl"]
    if dice.likely(0.1):
        output["undercut_solid"] = True
    if dice.likely(0.1):
        output["free_tolerance"] = min(1.0, 10.0 * output["tolerance"])
    return output


def toml(data: Data) -> str:
    """The profile as text."""
    lines: list[str] = []

    def value(item: Any) -> str:
        if isinstance(item, bool):
            return "true" if item else "false"
        if isinstance(item, str):
            return f'"{item}"'
        if isinstance(item, list):
            return f"[{', '.join(map(value, item))}]"
        if isinstance(item, dict):
            return f"{{ {', '.join(f'{name} = {value(one)}' for name, one in item.items())} }}"
        return repr(item)

    def table(head: str, items: Data) -> None:
        lines.append(head)
        nested = {key: item for key, item in items.items() if isinstance(item, dict)}
        tables = {
            key: item for key, item in items.items() if isinstance(item, list) and item and isinstance(item[0], dict)
        }
        lines.extend(f"{k} = {value(v)}" for k, v in items.items() if k not in nested and k not in tables)
        name = head.strip("[]")
        for key, item in nested.items():
            table(f"[{name}.{key}]" if name else f"[{key}]", item)
        for key, entries in tables.items():
            for entry in entries:
                table(f"[[{name}.{key}]]" if name else f"[[{key}]]", entry)

    table("", data)
    return "\n".join(lines).strip() + "\n"
