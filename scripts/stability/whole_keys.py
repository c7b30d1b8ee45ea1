"""Any key of the profile's schema, drawn from the schema itself: ordinary, at a bound of its range, or far off.

Whole profiles (`whole_profiles.py`) say what belongs together; this adds what the schema knows beside: sections that
stand for themselves, and keys of those that are there. What is added comes back as paths, so that it can be taken away.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from copy import deepcopy
from functools import cache
from typing import Any

Data = dict[str, Any]
Path_ = tuple[str | int, ...]

FILES = {
    "lift.csv": "angle,lift\n" + "".join(f"{10 * i},{(i / 12) ** 3 * (10 - 15 * (i / 12) + 6 * (i / 12) ** 2):.6f}\n"
                                         for i in range(13)),
    "force.csv": "0,0\n90,120\n200,20.5\n360,0\n",
    "history.csv": "".join(f"{0.6 + 0.4 * ((7 * i) % 11) / 11:.3f}\n" for i in range(60)),
    "rollers.toml": '[[follower]]\ndesignation = "OWN 26"\ntype = "stud"\ndiameter = 26\nbore = 10\nwidth = 12\n'
                    "dynamic_rating = 9000\nstatic_rating = 12000\npitch_diameter = 18\nfatigue_load_limit = 1400\n"
                    "max_radial_load = 6000\nmax_static_load = 9000\nlimiting_speed = 5000\n",
}  # fmt: skip
"""files that stand beside every profile, for keys that name one"""

ANGLES = ("start_angle", "load_angle_deg", "rocker_angle", "face_offset", "offset", "mean", "start")
ORDINARY: dict[str, tuple[float, float] | tuple[Any, ...]] = {
    "lubricant.viscosity_40": (15.0, 460.0),
    "lubricant.viscosity_100": (3.0, 30.0),
    "lubricant.temperature": (-10.0, 90.0),
    "lubricant.density": (700.0, 1000.0),
    "lubricant.pressure_viscosity": (10.0, 30.0),
    "lubricant.friction": (0.02, 0.2),
    "station.angle": (40.0, 320.0),
    "station.mass": (0.1, 10.0),
    "station.inertia": (0.001, 1.0),
    "duty.temperature": (-10.0, 90.0),
    "duty.speed": (1.0, 1000.0),
    "duty.load_factor": (0.3, 2.0),
    "duty.hours": (1.0, 1e4),
    "duty.starts": (0.01, 60.0),
    "duty.turns": (1.0, 100.0),
    "roller.end_radius": (0.1, 2.0),
    "roller.misalignment_deg": (0.005, 0.1),
    "roller.crown_factor": (1e-4, 1e-3),
    "roller.contamination": (0.1, 0.9),
    "roller.fatigue_load_limit": (100.0, 5000.0),
    "roller.limiting_speed": (100.0, 2e4),
    "roller.designation": ("CF 10-1 WBUUR/SG", "CF 6 WBUUR/SG", "OWN 26", "XXX 1"),
    "roller.catalogue": ("rollers.toml", "rollers.toml", "none.toml"),
    "material.grade": ("45C", "20Cr", "GCr15", "38CrMnAl", "HT250", "QT600-3", "lead"),
    "material.bending_limit": (50.0, 800.0),
    "material.roughness_um": (0.05, 3.0),
    "material.wear_rate": (1e-10, 1e-6),
    "material.case_depth_mm": (0.1, 3.0),
    "cam.root_radius": (0.2, 3.0),
    "cam.tip_clearance": (0.1, 2.0),
    "cam.running_clearance": (0.005, 0.2),
    "cam.relief": (0.002, 0.05),
    "cam.preload": (0.001, 0.02),
    "cam.mark_diameter": (2.0, 10.0),
    "follower.side": ("left", "right"),
    "output.table_points": (3, 2000),
    "output.table_tolerance": (1e-5, 0.1),
    "output.load_angle_deg": (0.0, 360.0),
    "impact.study": (0.005, 0.3),
    "impact.laws": ("cycloidal", "modified-sine", "3-4-5", "none"),
    "impact.tolerance": (1e-10, 1e-5),
    "impact.turns": (2, 6),
    "impact.settle": (0, 2),
    "impact.clearance": (0.005, 0.3),
    "impact.damping_depth": (0.001, 0.2),
    "impact.stiffness": (1e3, 1e7),
    "impact.damping": (0.1, 100.0),
    "impact.roller_inertia": (1.0, 1e4),
    "impact.static_friction": (0.05, 0.3),
    "impact.dynamic_friction": (0.02, 0.2),
    "dynamics.sweep": (20.0, 1500.0),
    "dynamics.sweep_points": (2, 40),
    "dynamics.steps": (100, 20_000),
    "dynamics.tolerance": (1e-8, 1e-2),
    "dynamics.fluctuation": (0.005, 0.3),
    "dynamics.fluctuation_order": (1, 6),
    "dynamics.settling_band": (0.001, 0.5),
    "cutter.feed": (50.0, 2000.0),
    "cutter.max_feed": (200.0, 2e4),
    "cutter.tolerance": (1e-4, 0.05),
    "cutter.scallop": (0.005, 0.5),
    "cutter.spindle": (200.0, 2e4),
    "cutter.retract": (1.0, 50.0),
    "tolerance.samples": (1000, 200_000),
    "tolerance.yield": (0.5, 0.999),
    "tolerance.dwell_limit": (5.0, 500.0),
    "tolerance.motion_limit": (5.0, 500.0),
    "tolerance.backlash_limit": (5.0, 500.0),
    "tolerance.preload_limit": (0.1, 10.0),
    "tolerance.pressure_limit": (300.0, 3000.0),
    "tolerance.fit": ("H7/k6", "H7/h6", "H7/g6", "F8/h6", "h6", "h9", "X1/y2"),
    "tolerance.cost": (0.1, 10.0),
    "limits.film_ratio": (0.1, 3.0),
    "limits.wear_um": (0.1, 100.0),
    "operation.guide_friction": (0.02, 0.3),
    "operation.gravity": (1.0, 10.0),
    "operation.speed": (1.0, 1500.0),
    "force.expression": ("100 * sin(phi)", "50 + 2 * s", "10 / (s - 1)", "abs(v)", "sqrt(a)"),
}
"""what is ordinary: two ends in equal ratios, or words; of other keys their default times 1/3 to 3, or a share of the
size"""
ROLLERS = ("roller", "return_roller")
TEXTS = ("A-17", "Ødegård & Söhne <b>", "凸轮", "x" * 60, "0")
JOINING = ("polynomial", "spline", "b-spline", "table", "optimal")
"""laws that join their neighbours: only they take velocity, acceleration and jerk at their end"""
RATES = ("velocity", "acceleration", "jerk")
KNOWN = frozenset({"name", "units", "reproduces", "cam", "follower", *ROLLERS, "motion", "duty", "operation", "limits",
                   "material", "output", "drawing", "impact", "dynamics", "cutter", "tolerance", "lubricant"})
"""sections that are drawn with what belongs to them; any other is drawn as its schema says, no more"""
FEWEST = ("cylindrical", "conical", "end-face", "globoidal", "cylindrical-index")
"""kinds of cam that may be meshed with fewer triangles"""
ERRORS = 22
"""errors of [tolerance] come first in it"""
PAIRS: dict[str, tuple[tuple[str, ...], ...]] = {
    "cam": (("mark_diameter", "mark_radius"), ("keyway_width", "keyway_depth", "bore"), ("hub_diameter", "hub_length"),
            ("relief", "relief_angle")),
    "roller": (("dynamic_rating", "static_rating", "fatigue_load_limit", "contamination", "pitch_diameter",
                "max_radial_load", "max_static_load", "limiting_speed", "bearing_type"),
               ("misalignment_deg", "end_radius", "free_ends"), ("crown", "crown_factor")),
    "impact": (("static_friction", "dynamic_friction", "stick_speed", "slip_speed"), ("law", "stiffness", "exponent"),
               ("damping", "damping_depth")),
    "dynamics": (("cam_mass", "turret_mass", "load_mass", "cam_bending", "cam_axial", "turret_bending", "load_bending",
                  "cross_bending", "output_axial"), ("method", "steps", "wilson_theta"),
                 ("method", "steps", "spectral_radius"), ("fluctuation", "fluctuation_order"),
                 ("tappet_mass", "tappet_contact", "tappet_damping"),
                 ("shaft_inertia", "shaft_stiffness", "shaft_damping"), ("sweep", "sweep_points")),
    "cutter": (("contact", "width", "diameter", "corner_radius"), ("machine", "rotary", "reversed_rotary", "feed_mode"),
               ("axis", "pivot")),
    "tolerance": (("crossing_arcmin", "axes_pivot"), ("cam_wobble_arcmin", "wobble_pivot"),
                  ("turret_wobble_arcmin", "turret_pivot"), ("roller_tilt_arcmin", "roller_pivot"),
                  ("flank_form", "flank_waves")),
    "limits": (("film_ratio", "warn_film_ratio"), ("wear_um", "life_h")),
}  # fmt: skip
"""keys that mean little without each other"""


@cache
def _schema() -> Data:
    from camgeom.profile.schema import schema

    return schema()


def _whole(entry: Data) -> Data:
    """An entry of the schema with what it refers to."""
    if "$ref" in entry:
        return {**_schema()["$defs"][entry["$ref"].rpartition("/")[2]], **entry}
    return entry


def _variant(section: str, table: Data) -> Data:
    """Properties of a section as this table's choosing keys have it."""
    entry = _whole(_schema()["properties"][section])
    if "items" in entry:
        entry = _whole(entry["items"])
    if "oneOf" not in entry:
        return dict(entry["properties"])
    word = _word(section, table)
    return dict(next(one["properties"] for one in entry["oneOf"] if one["title"] == word))


def _word(section: str, table: Data) -> str:
    """The kind, shape or law of a table."""
    tag, default = {"motion": ("law", "dwell")}.get(section, ("kind", "translating"))
    if section in ROLLERS:
        tag, default = "shape", "cylinder"
    return str(table.get(tag, default))


def keys() -> set[str]:
    """Every key of the schema: cam.disc.width, roller.cone.half_angle, motion.scca.b, duty.force.table, ..."""
    found: set[str] = set()
    for section, entry in _schema()["properties"].items():
        entry = _whole(entry)
        entry = _whole(entry.get("items", entry))
        if "oneOf" in entry:
            found |= {f"{section}.{one['title']}.{key}" for one in entry["oneOf"] for key in one["properties"]}
        elif "properties" in entry:
            found |= {f"{section}.{key}" for key in _inner(entry["properties"])}
        else:
            found.add(section)
    return found


def _inner(properties: Data) -> Iterator[str]:
    """Keys of a table, those of tables in it behind a dot; a table of every error is told once, as `error`."""
    for key, entry in properties.items():
        inner = _table_of(entry)
        if inner is None:
            yield key
        else:
            yield from ({key} if "anyOf" in entry else set())
            yield from (f"{'error' if 'anyOf' in entry else key}.{name}" for name in inner["properties"])


def _table_of(entry: Data) -> Data | None:
    """The table that a key may hold, alone or in a list; None where it holds none."""
    for one in (entry, *entry.get("anyOf", ()), entry.get("items", {})):
        one = _whole(one)
        if "properties" in one:
            return one
    return None


def reached(data: Data) -> set[str]:
    """The keys of the schema that a profile has, named as by `keys`."""
    found: set[str] = set()
    for section, held in data.items():
        for table in held if isinstance(held, list) else [held]:
            if not isinstance(table, dict):
                found.add(section)
                continue
            head = section
            if section in ("cam", "follower", *ROLLERS, "motion"):
                head = f"{section}.{_word(section, table)}"
            for key, value in table.items():
                found.add(f"{head}.{key}")
                for one in value if isinstance(value, list) else [value]:
                    if isinstance(one, dict):
                        single = section == "tolerance" and key != "cost"
                        found |= {f"{head}.{'error' if single else key}.{name}" for name in one}
    return found


class Keys:
    """Draws keys for one profile, and remembers where it put them."""

    def __init__(self, dice: random.Random, data: Data, size: float) -> None:
        self.dice, self.data, self.size = dice, data, size
        self.added: list[Path_] = []

    def likely(self, share: float) -> bool:
        """True in so many cases."""
        return self.dice.random() < share

    def everywhere(self) -> None:
        """Sections that stand for themselves, and further keys of those that are there."""
        for section, share in (("lubricant", 0.3), ("drawing", 0.25), ("limits", 0.3), ("tolerance", 0.25)):
            if section not in self.data and self.likely(share):
                self.data[section] = {}
                self.added.append((section,))
        if "lubricant" in self.data:
            self._lubricant()
        if "tolerance" in self.data:
            self._tolerance()
        if "operation" in self.data and self.likely(0.25):
            self._duty()
        if self.likely(0.15):
            self._rough()
        if self.data["cam"]["kind"] == "conjugate" and self.likely(0.4):
            self._second(self.data["roller"])
        for section in ("cam", "follower", *ROLLERS, "operation", "limits", "drawing", "impact", "dynamics", "cutter",
                        "output", "lubricant"):  # fmt: skip
            if section in self.data:
                share = {"drawing": 0.4, "impact": 0.12, "dynamics": 0.1, "cutter": 0.1}.get(section, 0.07)
                self._further(section, self.data[section], (section,), share)
        if self.data["cam"]["kind"] in FEWEST and self.likely(0.15):
            self._put(self.data["output"], "fewest_triangles", False, ("output",))
        for section in ROLLERS:
            if section in self.data:
                self._bearing(section, self.data[section])
        for body in self.data.get("material", {}):
            self._further(f"material.{body}", self.data["material"][body], ("material", body), 0.08)
        for i, segment in enumerate(self.data["motion"]):
            if "to" in segment:
                self._law(i, segment)
        for section, entry in _schema()["properties"].items():
            if section not in KNOWN and self.likely(0.08):
                self._plain(section, entry)
        if self.likely(0.05):
            self._put(self.data, "units", self.dice.choice(("mm", "inch")), ())
        if self.likely(0.02):
            self._put(self.data, "reproduces", self.dice.choice(("S1", "S2", "S3", "S4", "S5")), ())

    def _plain(self, section: str, entry: Data) -> None:
        """A section of which nothing is known but its schema: one table, or a list of a few."""
        many = "items" in _whole(entry)
        tables: list[Data] = [{} for _ in range(self.dice.choice((1, 2, 3)) if many else 1)]
        self.data[section] = tables if many else tables[0]
        self.added.append((section,))
        needed = _whole(_whole(entry).get("items", entry)).get("required", ())
        for i, table in enumerate(tables):
            properties = _variant(section, table)
            for key in needed:
                table[key] = self.value(f"{section}.{key}", properties[key])
            self._further(section, table, (section, i) if many else (section,), 0.3)

    def _put(self, table: Data, key: str, value: Any, at: Path_) -> None:
        table[key] = value
        self.added.append((*at, key))

    def _further(self, section: str, table: Data, at: Path_, share: float) -> None:
        """Keys of a section that are not there yet, some alone and some with those that they go with."""
        head = section.partition(".")[0]
        properties = _variant(head, table)
        like = "roller" if head in ROLLERS else head
        if "." in section:
            properties = _whole(properties[section.partition(".")[2]])["properties"]
        wanted = [key for key in properties if key not in table and self.likely(share)]
        for group in PAIRS.get(like, ()):
            if self.likely(2.0 * share):
                wanted += [key for key in group if self.likely(0.8)]
        for key in dict.fromkeys(wanted):
            if key in properties and key not in table and key != "force":
                self._put(table, key, self.value(f"{like}.{key}", properties[key]), at)
        if "force" in properties and "force" not in table and self.likely(share):
            self._put(table, "force", self._forces(), at)

    def _like(self, name: str) -> float | None:
        """What a key is about as large as, or the same as, in this profile; None where nothing says."""
        cam, follower = self.data["cam"], self.data["follower"]
        if name == "cam.pitch_radius":
            inner = cam.get("inner_diameter", cam["diameter"] - 2.0 * cam.get("groove_depth", 0.0))
            return 0.25 * float(inner + cam["diameter"])
        arm = follower.get("arm", self.size)
        moving = follower.get("mass", follower.get("inertia"))
        return {"cam.return_arm": arm, "follower.face_offset": 0.1 * arm, "cutter.neck": 0.1 * self.size,
                "cam.rocker_angle": 90.0, "cam.mark_radius": 0.7 * cam.get("base_radius", 0.0) or None,
                "follower.pivot_distance": 0.5 * cam.get("diameter", 0.0) or None,
                "dynamics.mass": moving, "impact.inertia": moving}.get(name)  # fmt: skip

    def value(self, name: str, entry: Data) -> Any:
        """A value of a key: in three of four ordinary, else at a bound of its range, its default, or far off."""
        entry, dice = _whole(entry), self.dice
        if (like := self._like(name)) is not None and self.likely(0.8):
            same = name in ("dynamics.mass", "impact.inertia")
            return like if same else float(f"{like * dice.uniform(0.9, 1.1):.5g}")
        if "const" in entry:
            return entry["const"]
        if "enum" in entry:
            return dice.choice(entry["enum"])
        if "anyOf" in entry:
            return self.value(name, dice.choice(entry["anyOf"]))
        kind = entry["type"]
        if kind == "boolean":
            return dice.choice((True, False))
        known = ORDINARY.get(name)
        if kind == "string":
            return dice.choice(known or TEXTS)
        if kind == "array":
            return self._list(name, entry, known)
        if kind == "object" and "properties" not in entry:
            # A table of keys that differ from a section's own: some of those, and whole now and then.
            own = dict(self.data.get(name.rpartition(".")[2], {}))
            share = dice.choice((0.3, 1.0))
            return {key: deepcopy(value) for key, value in own.items() if self.likely(share)}
        if kind == "object":
            return {key: self.value(name, one) for key, one in entry["properties"].items() if self.likely(0.5)}
        return self.number(name, entry, known)

    def number(self, name: str, entry: Data, known: tuple[Any, ...] | None) -> float:
        """A number of a key's range."""
        dice = self.dice
        low = entry.get("minimum", entry.get("exclusiveMinimum", 0.0))
        high = entry.get("maximum", entry.get("exclusiveMaximum", 1e9))
        draw = dice.random()
        if draw < 0.06:
            found = low if "minimum" in entry else low + (1e-9 if low == 0.0 else 1e-6 * abs(low))
        elif draw < 0.12:
            found = high if "maximum" in entry else high * (1.0 - 1e-9)
        elif draw < 0.16:
            found = entry.get("default", low) if isinstance(entry.get("default", low), int | float) else low
        elif known is not None:
            found = known[0] * (known[1] / known[0]) ** dice.random() if known[0] > 0.0 else dice.uniform(*known)
        elif isinstance(entry.get("default"), int | float) and entry["default"]:
            found = entry["default"] * 3.0 ** dice.uniform(-1.0, 1.0)
        elif low >= 0.0 and high <= 1.0:
            found = dice.uniform(low, high)
        else:
            found = self.size * 10.0 ** dice.uniform(-2.0, 0.3)
            if low < 0.0 and dice.random() < 0.5:
                found = -found
        found = min(max(found, low), high)
        if entry["type"] == "integer":
            return round(found)
        short = float(f"{found:.6g}")
        above = short > low if "exclusiveMinimum" in entry else short >= low
        return short if above and (short < high if "exclusiveMaximum" in entry else short <= high) else found

    def _list(self, name: str, entry: Data, known: tuple[Any, ...] | None) -> list[Any]:
        if "prefixItems" in entry:
            found = [self.number(name, one, known) for one in entry["prefixItems"]]
            return sorted(found) if name == "dynamics.sweep" else found
        if entry["items"].get("type") == "object":
            return deepcopy(self.data.get(name.rpartition(".")[2], []))
        count = self.dice.choice((1, 2, 3)) if self.likely(0.9) else min(int(entry.get("maxItems", 100)), 400)
        if entry["items"].get("type") == "string":
            return [self.dice.choice(known or TEXTS) for _ in range(min(count, 50))]
        return [self.number(name, entry["items"], known) for _ in range(count)]

    def _forces(self) -> list[Data]:
        """Applied forces: an expression, a table, a file."""
        found = []
        for _ in range(self.dice.choice((1, 1, 2))):
            start = float(self.dice.randrange(0, 300, 10))
            draw = self.dice.random()
            if draw < 0.4:
                force: Data = {"from": start, "until": start + 50.0,
                               "expression": self.dice.choice(ORDINARY["force.expression"])}  # fmt: skip
            elif draw < 0.8:
                high = self.number("operation.force", {"type": "number", "minimum": 1.0, "maximum": 1e6}, (1.0, 1e3))
                force = {"table": [[start, 0.0], [start + 20.0, high], [start + 50.0, 0.0]]}
            else:
                force = {"file": "force.csv"}
            if "expression" not in force and self.likely(0.4):
                force["interpolation"] = self.dice.choice(("linear", "smooth"))
            found.append(force)
        return found

    def _second(self, roller: Data) -> None:
        """The return roller of a pair: of any shape, about as large as the main one."""
        second: Data = {"shape": self.dice.choice(("cylinder", "cylinder", "crowned", "cone", "sphere"))}
        second["diameter"] = float(f"{roller['diameter'] * self.dice.uniform(0.6, 1.5):.4g}")
        second["length"] = float(f"{roller.get('length', 0.3 * roller['diameter']) * self.dice.uniform(0.6, 1.3):.4g}")
        if second["shape"] == "cone":
            second["half_angle"] = round(self.dice.uniform(-20.0, 25.0), 1)
        elif second["shape"] == "crowned":
            second |= {"crown_radius": float(f"{second['diameter'] * self.dice.uniform(2.0, 100.0):.4g}")} if (
                self.likely(0.6)) else {"crown": "logarithmic", "crown_factor": 0.0005}  # fmt: skip
        self._put(self.data, "return_roller", second, ())

    def _bearing(self, section: str, roller: Data) -> None:
        """A roller of a catalogue, or all that ISO 281 takes of a bearing."""
        draw, at, entries = self.dice.random(), (section,), _variant(section, roller)
        if draw < 0.08:
            name = self.value("roller.designation", entries["designation"])
            self._put(roller, "designation", name, at)
            for key in ("diameter", "dynamic_rating", "static_rating") if self.likely(0.9) else ():
                roller.pop(key, None)
            roller["length"] = round(self.dice.uniform(0.2, 1.1) * (11.0 if "6" in name else 12.0), 1)
            if name == "OWN 26" or self.likely(0.1):
                self._put(roller, "catalogue", "rollers.toml", at)
        elif draw < 0.2 and "designation" not in roller:
            for key in PAIRS["roller"][0]:
                if key not in roller and self.likely(0.9):
                    self._put(roller, key, self.value(f"roller.{key}", entries[key]), at)
            if "lubricant" not in self.data and "operation" in self.data:
                self.data["lubricant"] = {}
                self.added.append(("lubricant",))
                self._lubricant()

    def _lubricant(self) -> None:
        table, entries = self.data["lubricant"], _variant("lubricant", {})
        for key in ("viscosity_40", "viscosity_100", "temperature"):
            table[key] = self.value(f"lubricant.{key}", entries[key])
        for key in ("density", "pressure_viscosity", "friction"):
            if self.likely(0.6):
                self._put(table, key, self.value(f"lubricant.{key}", entries[key]), ("lubricant",))

    def _rough(self) -> None:
        """What film, wear and the body want together: both bodies and limits."""
        material = self.data.setdefault("material", {})
        for body in ("cam", "roller"):
            table = material.setdefault(body, {})
            entries = _whole(_variant("material", {})[body])["properties"]
            chosen = ("roughness_um", "wear_rate", "grade", "case_depth_mm", "name") if body == "roller" else (
                "roughness_um", "wear_rate", "bending_limit", "grade", "case_depth_mm", "name")  # fmt: skip
            for key in chosen:
                if self.likely(0.7):
                    self._put(table, key, self.value(f"material.{key}", entries[key]), ("material", body))
        limits, entries = self.data.setdefault("limits", {}), _variant("limits", {})
        for key in ("film_ratio", "warn_film_ratio", "wear_um", "life_h", "bearing_reliability"):
            if self.likely(0.5):
                self._put(limits, key, self.value(f"limits.{key}", entries[key]), ("limits",))

    def _duty(self) -> None:
        """States by share or hours, starts on top; forces, histories and temperatures of their own."""
        dice, entries = self.dice, _variant("duty", {})
        count = dice.choice((1, 2, 2, 3, 4)) if self.likely(0.95) else 64
        shares = [dice.uniform(0.1, 1.0) for _ in range(count)]
        rounded = [round(share / sum(shares), 4) for share in shares[:-1]]
        rounded.append(round(1.0 - sum(rounded), 10))
        by_hours = self.likely(0.4)
        self.data["duty"] = states = []
        self.added.append(("duty",))
        for share in rounded:
            hours = self.value("duty.hours", entries["hours"])
            states.append({"hours": hours} if by_hours else {"share": share})
        if self.likely(0.4):
            states.append({"starts": self.value("duty.starts", entries["starts"])})
        for i, state in enumerate(states):
            at: Path_ = ("duty", i)
            if "starts" in state and self.likely(0.7):
                self._put(state, "turns", self.value("duty.turns", entries["turns"]), at)
            for key in ("name", "speed", "temperature"):
                if self.likely(0.5 if count < 10 else 0.1):
                    self._put(state, key, self.value(f"duty.{key}", entries[key]), at)
            draw = dice.random()
            if draw < 0.4:
                self._put(state, "load_factor", self.value("duty.load_factor", entries["load_factor"]), at)
            elif draw < 0.55 and count < 10:
                self._put(state, "history", [round(dice.uniform(0.0, 1.5), 3) for _ in range(dice.choice((2, 9, 40)))],
                          at)  # fmt: skip
            elif draw < 0.65 and count < 10:
                self._put(state, "history_file", "history.csv", at)
            if self.likely(0.2):
                self._put(state, "force", self._forces(), at)

    def _tolerance(self) -> None:
        """Errors as numbers, tables and fits; what they turn about; limits; weights."""
        dice, table, entries = self.dice, self.data["tolerance"], _variant("tolerance", {})
        names = list(entries)
        at: Path_ = ("tolerance",)
        level = self.likely(0.3)
        for key in dice.sample(names[:ERRORS], dice.choice((1, 3, 6, 12, 20))):
            if level and ("tilt" in key or "wobble" in key or key in ("crossing_arcmin", "skew_arcmin")):
                continue
            self._put(table, key, self._error(key), at)
            if self.likely(0.15):
                self._put(table.setdefault("cost", {}), key,
                          self.value("tolerance.cost", {"type": "number", "exclusiveMinimum": 0.0, "maximum": 1e6}),
                          ("tolerance", "cost"))  # fmt: skip
        for group in PAIRS["tolerance"]:
            if self.likely(0.3) and not level:
                for key in group:
                    if key not in table:
                        error = names.index(key) < ERRORS
                        found = self._error(key) if error else self.value(f"tolerance.{key}", entries[key])
                        self._put(table, key, found, at)
        for key in names[ERRORS:]:
            if key not in table and key != "cost" and not key.endswith("pivot") and self.likely(0.25):
                self._put(table, key, self.value(f"tolerance.{key}", entries[key]), at)

    def _error(self, key: str) -> Any:
        """An error: +- a number, a table, a fit."""
        low, high = {"arcmin": (0.1, 10.0), "arcsec": (1.0, 60.0)}.get(key.rpartition("_")[2], (0.001, 0.1))
        value = self.number(key, {"type": "number", "minimum": 0.0, "maximum": 1e5}, (low, high))
        draw = self.dice.random()
        if draw < 0.6:
            return value
        if draw < 0.75 or key not in ("cam_eccentricity", "turret_eccentricity", "running_clearance",
                                      "roller_diameter"):  # fmt: skip
            found: Data = {"value": value}
            if self.likely(0.5):
                found["mean"] = round(self.dice.uniform(-1.0, 1.0) * value, 6)
            if self.likely(0.6):
                found["distribution"] = self.dice.choice(("normal", "uniform", "worst"))
            return found
        return {"fit": self.dice.choice(ORDINARY["tolerance.fit"])} | (
            {"size": round(self.size * self.dice.uniform(0.1, 1.0), 1)} if self.likely(0.5) else {}
        )

    def _law(self, i: int, segment: Data) -> None:
        """Parameters of a segment's law, and now and then any other law."""
        dice, at = self.dice, ("motion", i)
        if self.likely(0.15):
            titles = [one["title"] for one in _schema()["properties"]["motion"]["items"]["oneOf"]]
            for key in set(segment) - {"until", "to"}:
                del segment[key]
            laws = [title for title in titles if title != "dwell"]
            segment["law"] = dice.choice(laws) if self.likely(0.8) else "optimal"
            before = [one["to"] for one in self.data["motion"][:i] if "to" in one]
            self._made_of_data(segment, before[-1] if before else 0.0)
        share = 0.4 if segment["law"] in ("universal-asymmetric", "table") else 0.15
        joining = segment["law"] in JOINING
        if segment["law"] == "optimal":
            share = 0.02
        for key, entry in _variant("motion", segment).items():
            ends = key in RATES
            if key not in segment and key not in ("control", "points", "rows", "file") and self.likely(
                (0.3 if joining else 0.01) if ends else share
            ):
                self._put(segment, key, self._parameter(key, entry), at)
        if segment["law"] == "scca" and self.likely(0.7):
            b, c = round(dice.uniform(0.0, 0.5), 3), round(dice.uniform(0.0, 0.5), 3)
            segment |= {"b": b, "c": c, "d": round(1.0 - b - c, 10)}

    def _made_of_data(self, segment: Data, before: float) -> None:
        """What the laws need that are made of data: points, rows, a requirement."""
        dice, rise = self.dice, float(segment["to"]) - before
        lifts = [round(rise * (k / 9) ** 2 * (3.0 - 2.0 * k / 9), 4) for k in range(10)]
        if segment["law"] == "b-spline":
            segment["control"] = lifts[2:8:2]
        elif segment["law"] == "spline":
            segment["points"] = [[round(k / 9, 3), lifts[k]] for k in (2, 4, 7)]
        elif segment["law"] == "table" and self.likely(0.7):
            segment["rows"] = [[10.0 * k, lift] for k, lift in enumerate(lifts)]
            segment["rows"][-1][1] = rise
        elif segment["law"] == "table":
            segment |= {"file": "lift.csv", "to": before + 1.0}
        elif segment["law"] == "optimal":
            segment["minimise"] = dice.choice(("peak-acceleration", "jerk", "rms-acceleration", "residual"))
            if segment["minimise"] != "jerk" or self.likely(0.05):
                segment["jerk_limit"] = round(dice.uniform(35.0, 200.0), 1)
            if self.likely(0.4):
                segment["velocity_limit"] = round(dice.uniform(1.4, 2.2), 2)
            if self.likely(0.3):
                segment["acceleration_limit"] = round(dice.uniform(4.5, 9.0), 2)
            if segment["minimise"] == "residual" or self.likely(0.3):
                if segment["minimise"] != "residual":
                    segment["residual_limit"] = round(dice.uniform(0.005, 0.1), 3)
                segment |= {"natural_frequency": 40.0, "speeds": [50.0, 200.0]} if self.likely(0.5) else {
                    "band": sorted(round(dice.uniform(1.5, 8.0), 2) for _ in range(2))}  # fmt: skip
                if self.likely(0.4):
                    segment["damping"] = 0.05
            if self.likely(0.3):
                segment |= {"monotone": True, "order": 1}

    def _parameter(self, key: str, entry: Data) -> Any:
        """A law's parameter; end values join what is ordinary."""
        if key in RATES:
            return round(self.dice.uniform(-0.3, 0.3) / 50.0 ** RATES.index(key), 8)
        if key == "exponents":
            return sorted(self.dice.sample(range(2, 16), self.dice.choice((2, 3, 4, 5))))
        if key.endswith("_limit") or key == "natural_frequency":
            return round(self.dice.uniform(0.0, 60.0), 2)
        if key in ("band", "speeds"):
            return sorted(round(self.dice.uniform(1.0, 8.0), 2) for _ in range(2))
        return self.value(f"motion.{key}", entry)
