"""The `camgeom` command: arguments, exit statuses, messages. The only place that prints or exits.

Exit status: 0 good; 1 the design fails a check or a file asked for cannot be made (all others are written); 2 bad input
or usage; 3 a numerical method, the memory or the disk failed; 130 interrupted.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from math import inf, isfinite
from typing import Any, NoReturn, TextIO

from camgeom.errors import NEED_LESS, CamgeomError, memory_limits, one_line, starved, visible
from camgeom.immutable import immutable
from camgeom.version import __version__

EPILOG = (
    "exit status: 0 good; 1 the design fails a check or a file asked for cannot be made; 2 bad input or usage; 3 a "
    "numerical method, the memory or the disk failed"
)


LEAST_ROOM = 500_000_000
"""bytes of address space and of data, where they are limited, that Python and the libraries of the geometry need"""


class UsageError(CamgeomError):
    """Wrong arguments; the text says which and what is allowed."""

    exit_status = 2


@immutable(eq=True)
class Command:
    """One subcommand: `handler` is "module:function" of (arguments, Console) -> exit status, imported when it runs;
    `options` names functions of this module that add its arguments."""

    name: str
    help: str
    handler: str
    options: tuple[str, ...] = ()


_MODEL = ("profile", "laws", "delivery")
COMMANDS: tuple[Command, ...] = (
    Command("run", "everything the profile asks for: solid, checks, solvers, exports, report",
            "camgeom.cli.model:run", _MODEL),
    Command("build", "the solid and its files", "camgeom.cli.model:run", _MODEL),
    Command("check", "judge the design; nothing is written without --out", "camgeom.cli.model:run", _MODEL),
    Command("solve", "contact, life and dynamics; nothing is written without --out", "camgeom.cli.model:run", _MODEL),
    Command("report", "the report page", "camgeom.cli.model:run", _MODEL),
    Command("serve", "the local page that answers while you drag",
            "camgeom.cli.serve:run", ("profile", "laws", "serve")),
    Command("study", "one row per variant of a profile, CSV and plot",
            "camgeom.cli.study:run", ("profile", "laws", "study")),
    Command("optimise", "the variants that no other beats in every aim, each judged by the exact model",
            "camgeom.cli.optimise:run", ("profile", "laws", "optimise")),
    Command("tolerance", "what errors of assembly and manufacture cost: sensitivities, worst case, yield, widest "
            "tolerances", "camgeom.cli.tolerance:run", ("profile", "laws", "tolerance")),
    Command("law", "the best motion law for a requirement, its lower bound and its front", "camgeom.cli.law:run",
            ("law",)),
    Command("laws", "the motion laws with their characteristic values", "camgeom.cli.tables:laws", ("laws", "json")),
    Command("materials", "cam and roller materials by name, with treatment, hardness and limit",
            "camgeom.cli.tables:materials", ("json",)),
    Command("rollers", "track rollers by designation, with what their bearings bear", "camgeom.cli.tables:rollers",
            ("catalogue", "json")),
    Command("new", "a commented starter profile that runs as it is", "camgeom.cli.tables:new", ("new",)),
    Command("design", "a checked profile from stops, motion, size, speed, load and life, with its reasons",
            "camgeom.cli.design:run", ("laws", "design")),
    Command("formats", "the file formats with what each is for", "camgeom.cli.tables:formats", ("json",)),
    Command("inspect", "form deviation of measured points after their best fit to the flanks",
            "camgeom.cli.inspect:run", ("profile", "laws", "inspect")),
    Command("validate", "every printed result of the sources beside ours, with a verdict",
            "camgeom.cli.validate:run", ("validate",)),
    Command("schema", "JSON Schema of the profile, or of result.json", "camgeom.cli.tables:schema", ("laws", "schema")),
    Command("completion", "completion of commands and options for a shell", "camgeom.cli.completion:run", ("shell",)),
)
"""Every subcommand; one line adds one."""


class Console:
    """Where a command writes: results to stdout, everything else to stderr."""

    @property
    def lively(self) -> bool:
        """True where stderr is a terminal, so that progress may be shown."""
        return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()

    def out(self, text: str) -> None:
        """A line of the result, nothing unseen in it; lost where the reader has gone: that changes no exit status."""
        try:
            print(visible(text))
        except BrokenPipeError:
            _discard(sys.stdout)

    def toml(self, text: str) -> None:
        """A profile, which is UTF-8 whatever else is written there."""
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8")
        self.out(text)

    def err(self, text: str) -> None:
        """A message for the user, nothing unseen in it; lost where nobody hears: that changes no exit status."""
        if sys.stderr is None:
            return
        try:
            print(visible(text), file=sys.stderr, flush=True)
        except (OSError, ValueError):
            _discard(sys.stderr)

    def told(self, text: str) -> None:
        """What a command did beside its result, in one line on stderr."""
        self.progress("")
        self.err(f"camgeom: {one_line(text)}")

    def progress(self, text: str) -> None:
        """A passing line on the terminal that the next one replaces; an empty text clears it."""
        if self.lively:
            width = max(20, min(200, _terminal_width())) - 1
            print(f"\r\x1b[K{text[:width]}", end="", file=sys.stderr, flush=True)


def _terminal_width() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns
    except (OSError, ValueError):
        return 80


def aligned(rows: Sequence[Sequence[str]], right: Iterable[int] = ()) -> list[str]:
    """Rows of cells as lines with aligned columns, two blanks between them; `right` columns are set right."""
    if not rows:
        return []
    set_right = set(right)
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    return [
        "  ".join(cell.rjust(w) if c in set_right else cell.ljust(w) for c, (cell, w) in enumerate(zip(row, widths)))
        .rstrip()
        for row in rows
    ]


def number(value: Any, digits: int = 6) -> str:
    """A number in a few significant digits; a dash where there is none."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def number_in(text: str | None, option: str, unit: str = "", low: float = -inf, high: float = inf) -> float | None:
    """The number given for an option, None where none is. Raises UsageError where it is no number in the range."""
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if isfinite(value) and low <= value <= high:
        return value
    allowed = f"; allowed: {low:g} to {high:g} {unit}" if high < inf else f"; allowed: at least {low:g} {unit}"
    allowed = allowed.rstrip() if low > -inf else ""
    raise UsageError(f"{option}: needs a number{unit and f' of {unit}'} (found {text[:60]!r}){allowed}")


def whole(text: str | None, option: str, low: int, high: int, things: str = "") -> int | None:
    """The whole number given for an option, None where none is. Raises UsageError where it is none of the range."""
    if text is None:
        return None
    if not text.isdecimal() or not low <= int(text[:9]) <= high:
        of = f" of {things}" if things else ""
        raise UsageError(f"{option}: needs a whole number{of} (found {text[:60]!r}); allowed: {low} to {high}")
    return int(text)


FORMATS, BESIDE = "<formats>", "<formats beside a report>"
"""what a help text leaves open until it is printed"""


class _Parser(argparse.ArgumentParser):
    """argparse that raises instead of exiting, with the nearest spelling of what it does not know.

    How wide the terminal is it asks for its help alone: each argument that is added asks for it otherwise.
    """

    def __init__(self, **given: Any) -> None:
        super().__init__(**given, formatter_class=partial(argparse.HelpFormatter, width=80))

    def format_help(self) -> str:
        """The help, with the formats of the registry, whose writers are imported for it alone."""
        self.formatter_class = argparse.HelpFormatter
        for action in self._actions:
            if action.help and FORMATS in action.help:
                from camgeom.report.files import EXTRAS, format_rows

                named = ", ".join(row["format"] for row in format_rows())
                action.help = action.help.replace(FORMATS, named).replace(BESIDE, ", ".join(EXTRAS))
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{_plainer(message)}; see {self.prog} --help")


def _plainer(message: str) -> str:
    from camgeom.errors import did_you_mean

    unknown = re.match(r"argument COMMAND: invalid choice: '(.*?)' \(choose", message, re.DOTALL)
    if unknown:
        names = [command.name for command in COMMANDS]
        hint = did_you_mean(unknown[1], names)
        return f"unknown command {unknown[1][:60]!r}; {hint or 'known: ' + ', '.join(names)}"
    return message.replace("the following arguments are required:", "missing:")


def parser(chosen: str | None = None) -> argparse.ArgumentParser:
    """The argument parser; where a command is chosen, with that one alone."""
    top = _Parser(prog="camgeom", description="Exact cam geometry from one profile.", epilog=EPILOG, allow_abbrev=False)
    top.add_argument("--version", action="version", version=f"camgeom {__version__}")
    below = top.add_subparsers(metavar="COMMAND", dest="command", required=True, parser_class=_Parser)
    for command in [command for command in COMMANDS if command.name == chosen] or COMMANDS:
        sub = below.add_parser(
            command.name, help=command.help, description=command.help, epilog=EPILOG, allow_abbrev=False
        )
        for option in command.options:
            _OPTIONS[option](sub)
    return top


def _parsed(words: list[str], chosen: str | None) -> argparse.Namespace:
    """The arguments. A FILE that may be left out may stand after the options too, as the help shows it."""
    top = parser(chosen)
    arguments, rest = top.parse_known_args(words)
    if len(rest) == 1 and not rest[0].startswith("-") and getattr(arguments, "file", "") is None:
        arguments.file = rest.pop()
    if rest:
        top.error(f"unrecognized arguments: {' '.join(rest)}")
    return arguments


def _add_profile(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("profile", metavar="PROFILE", help="the TOML profile; - reads standard input")


def _add_laws(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--laws", metavar="FILE", action="append",
                     help="a Python file with your own motion laws, each under @camgeom.law(...); repeat for more")


def _add_json(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--json", action="store_true", help="print the result as JSON and nothing else")


def _add_delivery(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--out", metavar="DIR", help="output folder, default exports/<profile name>")
    sub.add_argument("--tolerance", metavar="MM", help="chord error of the mesh, mm, instead of the profile's")
    sub.add_argument("--formats", metavar="LIST",
                     help=f"file formats, comma between, instead of the profile's: {FORMATS}; `list` says what each "
                          f"is; report: {BESIDE}")
    sub.add_argument("--only", metavar="NAME,...",
                     help="only these products (solid, checks, contact, ...); report: these sections")
    sub.add_argument("--explain", action="store_true", help="say what was computed, what it cost, what was skipped")
    _add_json(sub)


def _add_serve(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--port", metavar="N", help="port on 127.0.0.1, default any free one")
    sub.add_argument("--no-browser", action="store_true", help="print the address only")


def _add_study(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--vary", metavar="KEY=A:B:N", action="append", required=True,
                     help="a profile key and its values: N from A to B (A:B:N:log in equal ratios), or a list "
                          "KEY=a,b,c; repeat for a grid; KEY=A:B draws between both, with --sample")
    _add_tie(sub)
    sub.add_argument("--sample", metavar="HOW", default="grid",
                     help="grid (default), list (the n-th values of all keys together), sobol:N[:SEED] or "
                          "latin:N[:SEED] (N points of a Sobol sequence, of a Latin hypercube)")
    sub.add_argument("--figures", metavar="NAME,...", help="only these columns of figures")
    sub.add_argument("--exact", action="store_true", help="every variant by the exact model, also where the batch can")
    sub.add_argument("--batch", action="store_true", help="by the batch, also where the variants are few")
    sub.add_argument("--pressure-error", metavar="SHARE",
                     help="of an indexer's pressures by the batch, at most: 0.01 (default), or 0.003, a third slower")
    sub.add_argument("--out", metavar="DIR", help="output folder, default exports/<profile name>")
    sub.add_argument("--only", metavar="NAME,...", help="only these products (checks, contact, fatigue, ...)")
    sub.add_argument("--parquet", action="store_true",
                     help="rows as study.parquet instead of study.csv, written as they come; a run that ended early "
                          "goes on (needs pyarrow)")
    _add_workers(sub)
    _add_json(sub)


def _add_tolerance(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--samples", metavar="N", help="machines drawn, instead of the profile's")
    sub.add_argument("--yield", metavar="SHARE", dest="share", help="share that has to keep the limits, 0 to 1")
    sub.add_argument("--limit", metavar="NAME=VALUE", action="append",
                     help="dwell, motion, backlash: um of a slide, seconds of arc of what turns; preload: um at least; "
                          "pressure: MPa; instead of the profile's; repeat for more")
    _add_json(sub)


def _add_optimise(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--free", metavar="KEY=A:B", action="append", required=True,
                     help="a profile key and its range, or its values: A:B:N, a,b,c; repeat for more keys")
    _add_tie(sub)
    for name, what in (("least", "small"), ("most", "large")):
        sub.add_argument(f"--{name}", metavar="FIGURE", action="append", default=[],
                         help=f"a figure to be made {what}, as camgeom study names it (size: the blank's volume)")
    for name, what in (("under", "at most"), ("over", "at least")):
        sub.add_argument(f"--{name}", metavar="FIGURE=VALUE", action="append", default=[],
                         help=f"a figure that must be {what} so much; the profile's own limits hold anyway")
    sub.add_argument("--points", metavar="N", help="points to search, default 25600 (768 where exact models search)")
    sub.add_argument("--members", metavar="N", help="members of the front to judge and show, default 24")
    sub.add_argument("--out", metavar="DIR", help="output folder, default exports/<profile name>")
    _add_workers(sub)
    _add_json(sub)


def _add_tie(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--tie", metavar="KEY=EXPRESSION", action="append", default=[],
                     help="a key that follows others, for example cam.bore=0.4*cam.base_radius")


def _add_workers(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--jobs", metavar="N", help="worker processes, default one per core")
    sub.add_argument("--on", metavar="ADDRESS",
                     help="compute on the workers of a Dask scheduler, tcp://host:port (needs distributed)")


def _add_new(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("kind", metavar="KIND", help="the cam kind")
    sub.add_argument("file", metavar="FILE", nargs="?", help="where to write it; default stdout")


def _add_shell(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("shell", metavar="SHELL", help="bash, zsh or fish")


def _add_catalogue(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("file", metavar="FILE", nargs="?", help="a TOML file of your own, listed first")


def _add_schema(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--json", action="store_true", help="accepted for symmetry; the schema is JSON anyway")
    sub.add_argument("--result", action="store_true", help="the schema of result.json instead of the profile's")


def _add_inspect(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("points", metavar="POINTS", help="CSV with columns x, y, z or angle, radius, z; mm, deg")
    sub.add_argument("--probe-radius", metavar="MM", help="where the points are centres of the probe's ball; default 0")
    sub.add_argument("--fit", metavar="WHAT", help="none, angle (about the axis), axial (angle and shift along it; "
                     "default), travel (of a plate, its default: shifts along travel and height), rigid (all six)")
    sub.add_argument("--limit", metavar="MM", help="largest deviation allowed; beyond it the exit status is 1")
    sub.add_argument("--out", metavar="DIR", help="write inspection.json and inspection.csv there")
    _add_json(sub)


def _add_design(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("kind", metavar="KIND", help="globoidal, disc, conjugate, constant-width or end-face")
    sub.add_argument("file", metavar="FILE", nargs="?", help="where to write the profile; default stdout")
    sub.add_argument("--stops", metavar="N", help="globoidal: stops in one turn of the turret")
    sub.add_argument("--motion-angle", metavar="DEG", help="globoidal: cam angle of the motion")
    sub.add_argument("--ratio", metavar="KD", help="globoidal: time of motion over time of dwell, instead of the angle")
    sub.add_argument("--center-distance", metavar="MM", help="globoidal: cam axis to turret axis")
    sub.add_argument("--envelope", metavar="MM", help="globoidal: length that cam and turret may take, instead")
    sub.add_argument("--speed", metavar="RPM", help="globoidal: cam speed, default 60 r/min")
    sub.add_argument("--inertia", metavar="KGM2", help="globoidal: turret and load, default 0.1 kg m2")
    sub.add_argument("--torque", metavar="NM", help="globoidal: load on the turret against the motion, default 0")
    sub.add_argument("--life", metavar="H", help="globoidal: life of rollers, bearings and cam, default 20000 h")
    sub.add_argument("--name", metavar="TEXT", help="globoidal: the profile's name")
    sub.add_argument("--law", metavar="NAME", help="globoidal: the motion law; default by load and speed")
    sub.add_argument("--accurate-dwell", action="store_true",
                     help="globoidal: a law that slows down for longer than it speeds up")
    sub.add_argument("--pressure-angle", metavar="DEG", help="largest pressure angle, default 50 or the profile's")
    sub.add_argument("--contact-pressure", metavar="MPA", help="largest contact pressure, default the material's")
    sub.add_argument("--profile", metavar="FILE", help="all others: motion and follower to design for; or the starter")
    sub.add_argument("--convex-radius", metavar="MM", help="planar cams: smallest convex radius, default no undercut")
    sub.add_argument("--best-offset", action="store_true", help="planar cams: choose the slide's offset as well")
    _add_json(sub)


def _add_law(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--least", metavar="WHAT", default="acceleration",
                     help="acceleration (default), jerk, residual or rms; all for unit lift over unit travel")
    sub.add_argument("--vmax", metavar="V", help="limit of the velocity")
    sub.add_argument("--amax", metavar="A", help="limit of the acceleration")
    sub.add_argument("--jmax", metavar="J", help="limit of the jerk")
    sub.add_argument("--band", metavar="A:B", help="rise time over natural period, where the residual counts")
    sub.add_argument("--residual", metavar="E", help="limit of the vibration left behind, a share of the lift")
    sub.add_argument("--damping", metavar="Z", help="share of critical damping of the vibration, default 0")
    sub.add_argument("--monotone", action="store_true", help="the motion may never turn back")
    sub.add_argument("--order", metavar="N", help="1: the acceleration may jump at the ends; 2: it may not; default 2 "
                                                  "where the jerk is limited or least, else 1")
    sub.add_argument("--front", action="store_true", help="with --band: the least residual over the peak acceleration")
    sub.add_argument("--out", metavar="DIR", help="write law.toml, law.csv and law.html (with the front) there")
    _add_json(sub)


def _add_validate(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("name", metavar="NAME", nargs="?", help="one source: S1 to S5, or its name; default all")
    sub.add_argument("--out", metavar="DIR",
                     help="write validation.html, with the figures, validation.md and validation.json there")
    _add_json(sub)


_OPTIONS: dict[str, Callable[[argparse.ArgumentParser], None]] = {
    "profile": _add_profile,
    "laws": _add_laws,
    "delivery": _add_delivery,
    "json": _add_json,
    "serve": _add_serve,
    "catalogue": _add_catalogue,
    "study": _add_study,
    "optimise": _add_optimise,
    "tolerance": _add_tolerance,
    "new": _add_new,
    "schema": _add_schema,
    "shell": _add_shell,
    "design": _add_design,
    "inspect": _add_inspect,
    "law": _add_law,
    "validate": _add_validate,
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit status; every error is one message on stderr."""
    console = Console()
    try:
        # Plugins of pydantic are for its own extensions; looking for them reads every installed package.
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                # A name in letters that the terminal lacks must not end the command.
                stream.reconfigure(errors="backslashreplace")
        status = _run(list(sys.argv[1:] if argv is None else argv), console)
        if sys.stdout is not None:
            with suppress(BrokenPipeError):
                sys.stdout.flush()
                return status
            _discard(sys.stdout)
        return status
    except CamgeomError as error:
        return _failed(console, f"camgeom: {error}", error.exit_status)
    except KeyboardInterrupt as stop:
        # With its name by SIGTERM, see camgeom.__main__.
        return _failed(console, *(("camgeom: terminated", 143) if stop.args else ("camgeom: interrupted", 130)))
    except OSError as error:
        _discard(sys.stdout)
        where = f"{error.filename}: " if error.filename else ""
        return _failed(console, f"camgeom: {where}{error.strerror or error}", 3)
    except Exception as error:
        if starved(error):
            return _failed(console, f"camgeom: out of memory; a larger --tolerance, {NEED_LESS}", 3)
        if os.environ.get("CAMGEOM_DEBUG") == "1":
            raise
        reason = " ".join(str(error).split())[:200]
        hint = "set CAMGEOM_DEBUG=1 to see where"
        return _failed(console, f"camgeom: {type(error).__name__}: {reason}; this is a bug ({hint})", 3)


def _room() -> None:
    """Load the linear algebra before anything else where the process may not have all memory: where none is left for
    it, its library tries for ever, or ends the process. Raises CamgeomError where the limit is too low."""
    limits = memory_limits()
    for given, limit in limits.items():
        if limit < LEAST_ROOM:
            raise CamgeomError(f"{given} is too little; at least {LEAST_ROOM // 10**6} MB")
    if limits:
        with suppress(ImportError):
            import scipy.linalg  # noqa: F401


def _discard(stream: TextIO | None) -> None:
    """Point a stream that nobody reads or that cannot be written elsewhere: the interpreter flushes it once more."""
    if stream is not None:
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _failed(console: Console, text: str, status: int) -> int:
    console.progress("")
    console.err(text)
    return status


def _run(words: list[str], console: Console) -> int:
    chosen = next((word for word in words if not word.startswith("-")), None)
    try:
        arguments = _parsed(words, chosen)
    except SystemExit as leaving:  # --help and --version
        return int(leaving.code or 0)
    command = next(command for command in COMMANDS if command.name == arguments.command)
    if not {"profile", "design", "law", "validate"}.isdisjoint(command.options):
        _room()
    if files := getattr(arguments, "laws", None):
        from camgeom.motion.own import load_all

        load_all(files)
    module, _, function = command.handler.partition(":")
    status: int = getattr(import_module(module), function)(arguments, console)
    return status
