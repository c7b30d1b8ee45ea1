"""What one tool makes of a cam's flanks, as numbers: stock left, gouges, the opposite wall, and ways that go wrong."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from math import degrees, inf
from typing import Any, final

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.machining.contour import ContourPath
from camgeom.machining.path import AlongTrack, CentrePath, FlankPath, ToolPath
from camgeom.machining.plan import Machining, Sag, seconds
from camgeom.machining.plate import PlatePath
from camgeom.machining.rest import RestExtreme, RestField, extreme_of
from camgeom.machining.rows import RowPath
from camgeom.machining.tool import Tool
from camgeom.machining.wall import SAME, cosine_of, is_radial, narrowest, roller_at, wall_ends
from camgeom.maths.frozen import cached_property
from camgeom.track import Straight, Track
from camgeom.track.runout import Within

ROWS_LOOKED_AT = 3


@immutable(eq=True)
class Cut:
    """A deepest cut into a finished flank, mm (negative: so much stock is left), its cam angle, rad, and by how much
    the chords of the path alone may cut, mm."""

    deep: float
    cam_angle: float
    chords: float

    def advice(self, limit: float, other: str) -> str:
        """What to do against a cut deeper than the limit, mm; nothing within it."""
        if self.deep <= limit:
            return ""
        return "use a smaller cutter.tolerance" if self.deep - self.chords <= limit else other


@final
@immutable
class Outcome:
    """The tool's work on a cam; `inside` tells the blank from the air (indexing cams)."""

    machining: Machining
    within: Within | None = None

    @cached_property
    def fields(self) -> tuple[RestField, ...]:
        """Stock on every flank after all passes. Empty for discs."""
        found = []
        for track, tool in self._tools:
            for side in track.sides:
                # A tool that stays within the roller's body is never nearer to a flank than beside it.
                far = () if self.certain or len(track.sides) == 1 else self._beside(track, -side)
                paths = self._beside(track, side) + far
                rows = tuple(p for p in self._along(track, side) if isinstance(p, RowPath))
                bound = self.machining.spec.allowance if self.certain else -inf
                found.append(RestField(track, side, tool, tuple(dict.fromkeys(paths)), self.within, rows, bound))
        return tuple(found)

    @property
    def _tools(self) -> list[tuple[Track, Tool]]:
        """Every track with its tool."""
        return [(track, self.machining.tool_along(track)) for track in self.machining.tracks]

    def _beside(self, track: Track, side: float) -> tuple[ToolPath, ...]:
        """Passes that make one flank: of a ball the lowest, middle and highest row."""
        paths = self._along(track, side)
        if len(paths) > ROWS_LOOKED_AT and isinstance(paths[0], RowPath):
            return paths[0], paths[len(paths) // 2], paths[-1]
        return paths

    def _along(self, track: Track, side: float) -> tuple[ToolPath, ...]:
        """Passes that make one flank of a track."""
        along = (path for path in self.machining.paths if isinstance(path, AlongTrack))
        return tuple(path for path in along if path.track is track and path.makes(side))

    @property
    def certain(self) -> bool:
        """True where the tool cannot gouge: it stays within a cylindrical roller's own body, or round a disc."""
        machining, spec = self.machining, self.machining.spec
        if not machining.tracks or spec.kind == "roller":
            return True
        if spec.half_angle:
            # A cone within the cone beside which it stands.
            each = [(roller_at(t, t.meridian.parameter(t.tip))[1], tool.radius) for t, tool in self._tools]
            stock = spec.allowance * max(1.0 / cosine_of(track) for track in machining.tracks)
            return all(own + stock <= wide + SAME for wide, own in each)
        cylinders = all(_cylinder(track) for track in machining.tracks)
        upright = spec.axis == "roller" and machining.tool.kind != "disc"
        reach = machining.tool.radius + spec.allowance
        return cylinders and upright and all(reach <= narrowest(t) + SAME for t in machining.tracks)

    @cached_property
    def least(self) -> RestExtreme | None:
        """The smallest stock (negative: the deepest gouge)."""
        return extreme_of(self.fields, -1.0)

    @cached_property
    def most(self) -> RestExtreme | None:
        """The largest stock; of a ball that is often at the wall's foot, where it does not reach."""
        return extreme_of(self.fields, 1.0)

    @cached_property
    def opposite(self) -> RestExtreme | None:
        """Least distance of a tool on one flank from the opposite wall of its groove; None without such a wall."""
        fields = []
        for track, tool in self._tools:
            for side in track.sides:
                far = [p for p in self._beside(track, -side) if not isinstance(p, CentrePath)]
                if len(track.sides) > 1 and far:
                    fields.append(RestField(track, side, tool, tuple(far), self.within))
        return extreme_of(fields, -1.0)

    @cached_property
    def into_profile(self) -> Cut | None:
        """Deepest cut of the straight ways between blocks into a profile that a tool runs round, the ways in and out
        among them; None where there is no profile."""
        found = []
        for path, tool in zip(self.machining.paths, self.machining.tools):
            laid = path.along if isinstance(path, PlatePath) else path
            if not isinstance(laid, ContourPath):
                continue
            (made,) = replace(self.machining, paths=(path,), tools=(tool,)).passes("cam")
            moves = [move.positions for move in made.moves if move.kind != "rapid"]
            places = np.concatenate([one.tip[:2] for one in moves], axis=1)
            deep, at = laid.cut(places, tool.radius)
            found.append(Cut(deep, float(np.concatenate([one.phi for one in moves])[at]), made.chord_error))
        if found:
            sag = self.sag_on_profile
            found.append(Cut(sag.cut - self.machining.spec.allowance, sag.cut_at, sag.cut))
        return max(found, key=lambda one: one.deep, default=None)

    @cached_property
    def into_flank(self) -> Cut:
        """Deepest cut into a flank along a roller's track: of the exact path, and of its chords beyond that."""
        least, sag = self.least, self.sag
        if least is None:
            return Cut(sag.cut - self.machining.spec.allowance, sag.cut_at, sag.cut)
        return Cut(sag.cut - least.value, least.cam_angle if least.value < 0.0 else sag.cut_at, sag.cut)

    @cached_property
    def sag(self) -> Sag:
        """What the chords of the passes along tracks, or down the middle of a plate's groove, do to the flanks."""
        stock = self.machining.spec.allowance
        least, most = (stock if one is None else one.value for one in (self.least, self.most))
        return self._sag(False, -least, most - stock)

    @cached_property
    def sag_on_profile(self) -> Sag:
        """What the chords of the passes round profiles do to them."""
        return self._sag(True, -self.machining.spec.allowance, 0.0)

    def _sag(self, contours: bool, cut: float, left: float) -> Sag:
        """Of the CL data; of the G-code too, whose chords are others, where those may yet break the limit.

        cut, left  mm, of the exact path
        """
        machining, limit, most = self.machining, self.machining.spec.gouge_limit, self.machining.spec.tolerance
        paths = [p for p in machining.paths if _is_contour(p) == contours and not isinstance(p, RowPath)]
        for rows in () if contours else machining.rows:
            paths += dict.fromkeys(rows.paths[k] for k in (0, len(rows.paths) // 2, -1))
        found = Sag.worst([machining.sag(path) for path in paths])
        if cut + found.cut <= limit < cut + most or left + found.left <= limit < left + most:
            with suppress(DesignError, NotConverged):  # The machine's axes may not hold the tool.
                found = Sag.worst([found, *(machining.sag(path, "machine") for path in paths)])
        return found

    def refuse_gouges(self) -> None:
        """Raise DesignError where the tool cuts deeper into a finished flank than spec.gouge_limit allows."""
        limit, about = self.machining.spec.gouge_limit, self.machining.tool.about
        if (profile := self.into_profile) is not None and profile.deep > limit + SAME:
            raise DesignError(
                f"the {about} cuts {profile.deep:.4g} mm into the profile at cam angle "
                f"{degrees(profile.cam_angle) % 360.0:.6g} deg (cutter.gouge_limit {limit:g} mm); "
                f"{profile.advice(limit, 'use a smaller tool')}"
            )
        if self.certain and self.machining.spec.tolerance <= limit:
            return
        flank, least = self.into_flank, self.least
        if flank.deep > limit + SAME:
            wall = "the flank" if least is None else self._wall(least)
            # A point inside a thin wheel is near one of its sides: the wall loses more than that.
            size = "at least " if self.machining.tool.kind == "disc" else ""
            along = "" if least is None or least.value >= 0.0 else f", {least.delta:.6g} mm along the roller"
            raise DesignError(
                f"the {about} cuts {size}{flank.deep:.4g} mm into {wall} at cam angle "
                f"{degrees(flank.cam_angle) % 360.0:.6g} deg{along} "
                f"(cutter.gouge_limit {limit:g} mm); {flank.advice(limit, self.advice)}"
            )

    def _wall(self, least: RestExtreme) -> str:
        far = self.opposite
        return "the opposite wall" if far is not None and far.value <= least.value + SAME else "the flank"

    @cached_property
    def advice(self) -> str:
        """What to do against a gouge."""
        spec = self.machining.spec
        wall = "the flank" if self.certain or self.least is None else self._wall(self.least)
        if spec.kind == "wheel":
            return "use a smaller or narrower wheel" if wall != "the flank" else "use a smaller wheel, or its rim"
        if spec.kind == "ball":
            return "use a smaller ball, or a larger cutter.neck where the groove is narrower above"
        if spec.axis != "roller":
            return "use a smaller tool, axis = 'roller', or leave an allowance"
        return "use a smaller tool, or axis = 'fitted' where the roller is no cylinder"

    def shop_errors(self) -> list[dict[str, Any]]:
        """What the same tool leaves where it only follows the roller's path, by the ways that shops take.

        centre   the roller's path, once: every wall stands proud by what the tool is smaller
        shifted  the roller's path moved along the follower's motion: right in dwells, too narrow on slopes
        radial   along the flank's normal at the middle of the wall, but with the axis through the cam's
        """
        machining, spec = self.machining, self.machining.spec
        if spec.kind not in ("flat", "wheel") or machining.tool.kind == "disc" or not machining.tracks:
            return []
        pairs = [(t, tool) for t, tool in self._tools if len(t.sides) > 1]
        if not pairs or (spec.path == "flank" and all(isinstance(path, CentrePath) for path in machining.paths)):
            return []
        found = []
        least: RestExtreme | None
        most: RestExtreme | None
        for way in ("centre", "shifted", "radial"):
            if way == "radial" and not all(is_radial(track) for track, _ in pairs):
                continue
            if way == "centre" and all(_cylinder(track) for track, _ in pairs):
                # Both surfaces are parallel to the pitch surface: the same stock everywhere.
                stocks = [narrowest(track) - tool.radius for track, tool in pairs]
                least, most = (RestExtreme(f(stocks), 0.0, pairs[0][0].contact[0], 1.0) for f in (min, max))
            else:
                fields = [self._shop_field(way, t, side, tool) for t, tool in pairs for side in t.sides]
                least, most = extreme_of(fields, -1.0), extreme_of(fields, 1.0)
            if least is not None and most is not None:
                found.append({"path": way, **least.data("least"), **most.data("most")})
        return found

    def _shop_field(self, way: str, track: Track, side: float, tool: Tool) -> RestField:
        reach = tool.radius
        path: ToolPath = CentrePath(track)
        if way == "shifted":
            path = FlankPath(track, side, reach, "shifted")
        elif way == "radial":
            path = FlankPath(track, side, reach, "flank", "radial")
        bound = 0.0 if way == "shifted" and _cylinder(track) else -inf
        return RestField(track, side, tool, (path,), self.within, (), bound)

    def data(self) -> dict[str, Any]:
        """As plain data for result.json. Raises DesignError where the tool gouges."""
        return dict(self._figures)

    @cached_property
    def _figures(self) -> dict[str, Any]:
        machining, spec = self.machining, self.machining.spec
        self.refuse_gouges()
        data: dict[str, Any] = {
            "tool": "; ".join(tool.about for tool in machining.different),
            "tool_diameter_mm": 2.0 * machining.tool.radius,
            "passes": len(machining.paths),
            "blocks": {"cl": machining.blocks_about("cam"), "gcode": self._gcode_blocks()},
            "chord_tolerance_mm": spec.tolerance,
            **self._times(),
            "within_roller": self.certain,
        }
        if machining.rows:
            data["rows"] = sum(len(rows.paths) for rows in machining.rows)
            data["scallop_mm"] = max(rows.scallop for rows in machining.rows)
            data["foot_left_mm"] = max(rows.foot_left for rows in machining.rows)
        if machining.room is not None:
            data |= {"head_room_mm": machining.room.length, "head_over_web_mm": machining.room.below}
            data |= {} if spec.length is None else {"head_left_mm": machining.room.length - spec.length}
        data |= {"standing_mm": machining.standing} if machining.standing else {}
        data |= {"largest_tool_diameter_mm": self._largest_tool}
        profile = self.into_profile
        if not machining.tracks:  # a contour leaves the stock asked for
            cut, sag = (self.into_flank, self.sag) if profile is None else (profile, self.sag_on_profile)
            return data | {"least_rest_mm": -cut.deep, "most_rest_mm": spec.allowance + sag.left}
        data |= self.least.data("least_rest") if self.least else {}
        data |= self.most.data("most_rest") if self.most else {}
        if mouth := self.mouth():
            data["mouth_gouge_mm"] = mouth
        if self.opposite is not None:
            data["opposite_wall_mm"] = self.opposite.value
        if shop := self.shop_errors():
            data["shop_errors"] = shop
        return data

    def mouth(self) -> float:
        """By how much a tool that is thicker below cuts into its groove's mouth where it comes down or leaves, mm."""
        machining, found = self.machining, [0.0]
        for path, tool in zip(machining.paths, machining.tools):
            if isinstance(path, AlongTrack) and path.closed and path.between and tool.kind != "disc":
                aside = (path.room or 0.0) - machining.lead(path)
                found.append(aside + tool.thickest(path.height) - roller_at(path.track, wall_ends(path.track)[1])[1])
        most = max(found)
        return most if most > SAME else 0.0

    def _gcode_blocks(self) -> int | None:
        """Blocks of the G-code; None where the machine's axes cannot hold the tool."""
        try:
            return self.machining.blocks_about("machine")
        except DesignError:
            return None

    def _times(self) -> dict[str, float]:
        """Time at the feeds and largest chord error of the CL data: of a ball's many rows scaled from a few passes."""
        machining = self.machining
        paths = machining.paths
        picked = paths if len(paths) <= 2 * ROWS_LOOKED_AT else paths[:: max(1, len(paths) // ROWS_LOOKED_AT)]
        chosen = replace(machining, paths=tuple(picked))
        total, error = 0.0, 0.0
        for made in chosen.passes("cam"):
            total += sum(float(times.sum()) for times in seconds(made.moves, machining.spec))
            error = max(error, made.chord_error)
        return {"cutting_time_min": total / 60.0 * len(paths) / len(picked), "chord_error_mm": error}

    @property
    def _largest_tool(self) -> float | None:
        """Diameter of the largest tool, less the stock it leaves, for every groove and hollow, mm; None without one."""
        spec = self.machining.spec
        sizes = [2.0 * spec.largest(track) for track in self.machining.tracks if len(track.sides) > 1]
        for path in self.machining.paths:
            laid = path.along if isinstance(path, PlatePath) else path
            sizes += [laid.largest_diameter()] if isinstance(laid, ContourPath) else []
        size = min(sizes, default=inf) - 2.0 * spec.stock_across
        return size if size < inf else None


def _cylinder(track: Track) -> bool:
    return isinstance(track.meridian, Straight) and track.meridian.slope == 0.0


def _is_contour(path: ToolPath) -> bool:
    return isinstance(path.along if isinstance(path, PlatePath) else path, ContourPath)
