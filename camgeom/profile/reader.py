"""From plain data to the typed sections of a profile, with every problem found on the way."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError

from camgeom.cams import Cam, cam_class, kinds
from camgeom.errors import Problem, ProfileError
from camgeom.keys import Section
from camgeom.profile.errors import (
    MOST_PROBLEMS,
    UNKNOWN,
    Model,
    choice_problem,
    keys_of,
    models_in,
    plain,
    translate,
    without_guessed,
)
from camgeom.profile.motion import MAX_SEGMENTS, motion_problems, program_of, split_segment
from camgeom.profile.sections import (
    MOST_STATES,
    MOST_STATIONS,
    Limits,
    Materials,
    MotionSegment,
    Operation,
    Output,
    Reproduced,
    TitleBlock,
    Units,
)
from camgeom.profile.text import Path_, beside, dotted, number_table, text_fault
from camgeom.track.follower import (
    AnyFollower,
    ConeRoller,
    CrownedRoller,
    CylinderRoller,
    FrameFollower,
    SphereRoller,
    SwingingFollower,
    TranslatingFollower,
    TurretFollower,
)

if TYPE_CHECKING:
    from camgeom.profile.duty import OperatingState
    from camgeom.profile.station import Station

FOLLOWERS: dict[str, type[AnyFollower]] = {
    "translating": TranslatingFollower,
    "swinging": SwingingFollower,
    "turret": TurretFollower,
    "frame": FrameFollower,
}
ROLLERS: dict[str, Model] = {
    "cylinder": CylinderRoller,
    "cone": ConeRoller,
    "crowned": CrownedRoller,
    "sphere": SphereRoller,
}
ROLLER_TABLES = ("roller", "return_roller")
"""the tables of rollers"""
TOP = ("name", "units", "reproduces", "cam", "follower", *ROLLER_TABLES, "motion", "duty", "station")
"""what a profile may have at its top beside its other sections"""
PLAIN_SECTIONS: dict[str, Model] = {
    "operation": Operation,
    "material": Materials,
    "output": Output,
    "limits": Limits,
    "drawing": TitleBlock,
}
OPTIONAL_SECTIONS = {
    "impact": ("camgeom.dynamics.impact.spec", "ImpactSpec"),
    "dynamics": ("camgeom.dynamics.spec", "DynamicsSpec"),
    "cutter": ("camgeom.machining.spec", "CutterSpec"),
    "tolerance": ("camgeom.tolerance.spec", "ToleranceSpec"),
    "lubricant": ("camgeom.mechanics.lubricant", "Lubricant"),
    "output_shaft": ("camgeom.mechanics.output_shaft", "OutputShaft"),
}
"""Sections whose module is imported only when a profile has them."""


@dataclass
class Reader:
    """Builds the typed sections of a profile (class `top`) one by one and gathers what is wrong with any."""

    top: Model
    data: dict[str, Any]
    file: str
    problems: list[Problem] = field(default_factory=list)
    dropped: set[Path_] = field(default_factory=set)
    sections: dict[str, list[Model]] = field(default_factory=dict)

    def parts(self) -> dict[str, Any]:
        """The typed sections by name. Raises ProfileError with every problem found."""
        parts: dict[str, Any] = {}
        models = self._models()
        parts["units"] = self._one_of("units", get_args(Units), "a unit of length") or "mm"
        if parts["units"] == "inch":
            from camgeom.profile.units import in_mm

            self.data, found = in_mm(self.data, self.sections, self.rotating, self.slides)
            self.problems += found
        self._refuse_unknown_sections()
        for name, model in models.items():
            if model is not None:
                parts[name] = self._section(name, model)
        parts["motion"] = self._motion()
        parts["duty"] = self._duty()
        parts["station"] = self._stations()
        parts["name"] = self._name()
        parts["reproduces"] = self._one_of("reproduces", get_args(Reproduced), "a source document")
        known = models["cam"] is not None and (parts.get("cam") is not None or not self.slides)
        if self.problems and parts.get("motion") and parts.get("follower") and known:
            # The motion as a whole is judged even where another section is wrong, but for that of a cam that slides,
            # whose stroke has to be known.
            whole = _motion_as_a_whole(parts["motion"], parts["follower"], self.span, self.file, parts.get("cam"))
            self.problems += whole
        if self.problems:
            raise ProfileError(first_of(without_guessed(self.problems)), self.file)
        return {name: part for name, part in parts.items() if part is not None}

    def _models(self) -> dict[str, Model | None]:
        """The model of every section that is given or needed; None where the choice itself is wrong."""
        cam = self._choice("cam", "kind", kinds(), "a cam kind", None)
        cam_model = cam_class(cam) if cam else None
        accepted = cam_model.FOLLOWERS if cam_model else tuple(FOLLOWERS)
        self.span = cam_model.MOTION_SPAN if cam_model else 360.0
        self.slides = cam_model is not None and cam_model.SLIDES
        follower = self._choice("follower", "kind", tuple(FOLLOWERS), "a follower kind", accepted[0])
        self.rotating = follower is not None and FOLLOWERS[follower].rotating
        if cam and follower and follower not in accepted:
            message = f"a {cam} cam has no such follower"
            self.problems.append(Problem("follower.kind", message, follower, ", ".join(accepted)))
        models: dict[str, Model | None] = {"cam": cam_model, "follower": FOLLOWERS.get(follower or "")}
        for table in ROLLER_TABLES:
            if table in self.data:
                shape = self._choice(table, "shape", tuple(ROLLERS), "a roller shape", "cylinder")
                models[table] = ROLLERS.get(shape or "")
        models |= {name: model for name, model in PLAIN_SECTIONS.items() if name in self.data}
        for name, (module, attribute) in OPTIONAL_SECTIONS.items():
            if name in self.data:
                models[name] = getattr(import_module(module), attribute)
        self._index(models)
        return models

    def _index(self, models: dict[str, Model | None]) -> None:
        """Where every key of a profile belongs, for hints on misplaced keys."""
        self.sections = {"profile": [self.top], "motion": [MotionSegment]}
        if "duty" in self.data:
            from camgeom.profile.duty import OperatingState

            self.sections["duty"] = [OperatingState]
        if "station" in self.data:
            from camgeom.profile.station import Station

            self.sections["station"] = [Station]
        for name, model in {"roller": CylinderRoller, **PLAIN_SECTIONS, **models}.items():
            if model is not None:
                self.sections[name] = [model]
                inner = {key: list(models_in(entry.annotation)) for key, entry in keys_of(model).items()}
                self.sections |= {f"{name}.{key}": found for key, found in inner.items() if found}

    def _choice(self, section: str, key: str, known: tuple[str, ...], what: str, default: str | None) -> str | None:
        """The value of a choosing key; None where it is wrong, which is then among the problems."""
        table = self.data.get(section)
        if table is None and default is not None:
            return default
        if not isinstance(table, dict):
            missing = Problem(section, "is missing", plain(table), f"a table [{section}]")
            self.problems.append(_no_table(section, table) if section in self.data else missing)
            return None
        if key not in table:
            if default is None and (section, key) not in self.dropped:
                self.problems.append(Problem(f"{section}.{key}", "is missing", None, ", ".join(known)))
            return default
        word = table[key]
        if isinstance(word, str) and word in known:
            return word
        self.problems.append(choice_problem(f"{section}.{key}", word, known, what))
        return None

    def _refuse_unknown_sections(self) -> None:
        """Top-level keys that are no section, with the section that they may belong to."""
        known = {*TOP, *PLAIN_SECTIONS, *OPTIONAL_SECTIONS}
        stray = dict([(key, value) for key, value in self.data.items() if key not in known][:MOST_PROBLEMS])
        if not stray:
            return
        try:
            self.top.model_validate(stray)
        except ValidationError as error:
            found = translate(error, self.top, stray, (), self.sections)
            self.problems += [problem for problem in found if problem.message == UNKNOWN]

    def _section(self, name: str, model: Model) -> Section | None:
        """A typed section; None where it is wrong."""
        table = self.data.get(name, {})
        if not isinstance(table, dict):
            self.problems.append(_no_table(name, table))
            return None
        table = dict(table)
        if name == "cam" and "kind" not in model.model_fields:
            table.pop("kind", None)
        if name == "operation":
            table = self._with_tables(table, ("operation",))
        given = set(table)
        if name in ROLLER_TABLES and isinstance(table.get("designation"), str):
            table = self._from_catalogue(table, name)
            # A ring that the catalogue has as crowned makes a crowned roller of a table that names no shape.
            model = ROLLERS.get(str(table.get("shape")), model)
        section: Section | None = self._typed(model, table, (name,))
        if section is not None and set(table) != given:
            # What a catalogue fills in is not stated: it may mean nothing where nobody asks for it.
            section = type(section).model_construct(given, **dict(section))
        return section

    def _from_catalogue(self, roller: dict[str, Any], name: str) -> dict[str, Any]:
        """A roller's table (`name`) with the figures of its designation."""
        from camgeom.profile.catalogue import filled, read, shipped

        catalogues = [shipped()]
        if isinstance(roller.get("catalogue"), str):
            key = f"{name}.catalogue"
            place = beside(roller["catalogue"], self._folder(), key)
            if isinstance(place, Problem):
                self.problems.append(place)
            else:
                try:
                    catalogues.insert(0, read(place, key))
                except ProfileError as error:
                    self.problems += [replace(p, key=f"{key}: {p.key}") for p in error.problems]
        table, found = filled(roller, catalogues, name)
        self.problems += found
        return table

    def _typed(self, model: Model, table: dict[str, Any], at: Path_) -> Any:
        try:
            return model.model_validate(table)
        except ValidationError as error:
            hidden = {dotted(path) for path in self.dropped}
            found = translate(error, model, table, at, self.sections)
            self.problems += [p for p in found if not any(_within(p.key, key) for key in hidden)]
        except ProfileError as error:
            self.problems += error.problems
        return None

    def _with_tables(self, table: dict[str, Any], at: Path_) -> dict[str, Any]:
        """A table with the data files of its forces read into tables."""
        forces = table.get("force")
        if not isinstance(forces, tuple):
            return table
        return {**table, "force": tuple(self._force(force, (*at, "force", i)) for i, force in enumerate(forces))}

    def _force(self, force: Any, at: Path_) -> Any:
        return self._from_file(force, at, "file", "table", 2, "a force")

    def _from_file(self, table: Any, at: Path_, file: str, key: str, columns: int, what: str) -> Any:
        """A table whose key `file` names a CSV file, with the file's rows under `key` instead."""
        if not isinstance(table, dict) or not isinstance(table.get(file), str):
            return table
        place = dotted((*at, file))
        rest = {name: value for name, value in table.items() if name != file}
        path = beside(table[file], self._folder(), place)
        rows = path if isinstance(path, Problem) else number_table(path, columns, place, table[file])
        if isinstance(rows, Problem):
            self.problems.append(rows)
            self.dropped.add(at)
            return rest
        if key in rest:
            self.problems.append(Problem(place, f"{what} has either a file or a {key}, not both"))
        return {**rest, key: rows if columns > 1 else tuple(row[0] for row in rows)}

    def _array(self, name: str, most: int, what: str) -> tuple[Any, ...] | None:
        """An array of tables; None where the profile has none, or one that is wrong."""
        tables = self.data.get(name)
        if tables is None:
            return None
        if not isinstance(tables, tuple):
            hint = f"write [[{name}]] in double brackets" if isinstance(tables, dict) else ""
            self.problems.append(Problem(name, f"needs an array of tables [[{name}]]", plain(tables), "", hint))
            return None
        if len(tables) > most:
            self.problems.append(Problem(name, f"too many {what}", len(tables), f"at most {most}"))
            return None
        return tables

    def _duty(self) -> tuple[OperatingState, ...] | None:
        """The typed operating states; None where the profile has none."""
        states = self._array("duty", MOST_STATES, "states")
        if states is None:
            return None
        typed = [self._state(state, ("duty", i)) for i, state in enumerate(states)]
        return tuple(state for state in typed if state is not None)

    def _stations(self) -> tuple[Station, ...] | None:
        """The typed further followers; None where the profile has none."""
        tables = self._array("station", MOST_STATIONS, "followers")
        if tables is None:
            return None
        from camgeom.profile.station import Station

        found: list[Station] = []
        for i, table in enumerate(tables):
            if not isinstance(table, dict):
                self.problems.append(Problem(f"station[{i}]", "needs a table [[station]]", plain(table)))
            elif (one := self._typed(Station, self._with_tables(table, ("station", i)), ("station", i))) is not None:
                found.append(one)
        return tuple(found)

    def _state(self, state: Any, at: Path_) -> OperatingState | None:
        if not isinstance(state, dict):
            self.problems.append(Problem(dotted(at), "needs a table [[duty]]", plain(state)))
            return None
        from camgeom.profile.duty import OperatingState

        table = self._from_file(state, at, "history_file", "history", 1, "a state")
        found: OperatingState | None = self._typed(OperatingState, self._with_tables(table, at), at)
        return found

    def _folder(self) -> Path | None:
        return Path(self.file).parent if self.file else None

    def _motion(self) -> tuple[MotionSegment, ...] | None:
        """The typed segments of the motion."""
        segments = self.data.get("motion")
        if segments is None or segments == ():
            if ("motion",) not in self.dropped:
                self.problems.append(Problem("motion", "is missing", None, "one [[motion]] table for each segment"))
            return None
        if not isinstance(segments, tuple):
            hint = "write [[motion]] in double brackets" if isinstance(segments, dict) else ""
            self.problems.append(Problem("motion", "needs an array of tables [[motion]]", plain(segments), "", hint))
            return None
        if len(segments) > MAX_SEGMENTS:
            self.problems.append(Problem("motion", "too many segments", len(segments), f"at most {MAX_SEGMENTS}",
                                         "a law of a table or a spline holds more points"))  # fmt: skip
            return None
        typed = []
        before = len(self.problems)
        for i, segment in enumerate(segments):
            typed.append(self._segment(segment, i))
            if len(self.problems) - before > MOST_PROBLEMS:
                return None
        return tuple(segment for segment in typed if segment) if all(typed) else None

    def _segment(self, segment: Any, index: int) -> MotionSegment | None:
        at: Path_ = ("motion", index)
        if not isinstance(segment, dict):
            self.problems.append(Problem(dotted(at), "needs a table [[motion]]", plain(segment)))
            return None
        own, found = split_segment(segment, dotted(at), self._folder(), self.sections)
        self.problems += found
        typed: MotionSegment | None = self._typed(MotionSegment, own, at)
        return None if found else typed

    def _one_of(self, key: str, allowed: tuple[str, ...], what: str) -> str | None:
        """The word under a key at the top; None where it is left out, or wrong, which is then among the problems."""
        if key not in self.data:
            return None
        value = self.data[key]
        if value not in allowed:
            self.problems.append(choice_problem(key, value, allowed, what))
            return None
        return str(value)

    def _name(self) -> str | None:
        """The profile's name; by default that of its file."""
        name = self.data.get("name")
        if name is None:
            if not self.file:
                return None
            stem = Path(self.file).stem[:120]
            if _is_name(stem):
                return stem
            self.problems.append(Problem("name", f"{_NAME}; the file's name is none", plain(stem)))
            return None
        if isinstance(name, str) and _is_name(name):
            return name
        self.problems.append(Problem("name", _NAME, plain(name)))
        return None


def _no_table(name: str, value: Any) -> Problem:
    hint = f"write [{name}] in single brackets: there is one of it" if isinstance(value, tuple) else ""
    return Problem(name, "wrong type", plain(value), f"a table [{name}]", hint)


_NAME = "needs a text of 1 to 120 characters that can be printed, on one line"


def _is_name(text: str) -> bool:
    # A file name of bytes that are no text comes as lone surrogates, which no file of results can hold.
    lone = any("\ud800" <= character <= "\udfff" for character in text)
    return bool(text.strip()) and len(text) <= 120 and "\n" not in text and not lone and not text_fault(text)


def first_of(problems: list[Problem]) -> list[Problem]:
    """The problems, cut to a number that can be read."""
    more = len(problems) - MOST_PROBLEMS
    if more <= 0:
        return problems
    return [*problems[:MOST_PROBLEMS], Problem("profile", f"and {more} problems more, of those looked at")]


def _motion_as_a_whole(motion: Any, follower: AnyFollower, span: float, file: str, cam: Cam | None) -> list[Problem]:
    travel = cam.travel if cam is not None else None
    found = motion_problems(motion, follower, span, travel)
    if found and (travel is not None or any(segment.until > 360.0 for segment in motion)):
        return found  # no program can be asked for more
    try:
        program_of(motion, follower, span, str(Path(file).parent) if file else "", travel)
    except ProfileError as error:
        found += error.problems
    return found


def _within(key: str, top: str) -> bool:
    return key == top or key.startswith((f"{top}.", f"{top}["))
