"""Forces applied to the follower over a range of cam angle: a table, or an expression that is never run as code.

The text of an expression is parsed to a syntax tree, of which only numbers, named variables, + - * / **, signs and
calls of the listed functions are let through; what is left is a short list of array operations. Length, depth and
exponents are bounded before anything is computed, so that no text can take long.
"""

from __future__ import annotations

import ast
import itertools
import math
import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Literal, NamedTuple, Protocol, cast, final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, panels, resolved
from camgeom.mechanics.enclosure import OF_ROUNDING, narrow_peaks, peaks_of
from camgeom.track import TURN

Interpolation = Literal["linear", "smooth"]


WIDEST = math.radians(6.0)
"""rad, of panels on which a force is followed, as `Load.panels` has them"""
ROUNDED = 1e-9
"""degrees by which a turn that was written with decimals may come out longer"""
MOST_DEGREE = 3
"""of a polynomial of the motion that samples of any motion follow: springs that stiffen, drag of air"""
CLOSING = 1e-14 * TURN
"""rad by which the end of a range may round to just past it"""


def check_table(angles: list[float]) -> None:
    """Raise ValueError where the cam angles of a force table, degrees, do not rise within one turn."""
    if len(angles) < 2:
        raise ValueError("a force table needs two rows or more")
    if any(b <= a for a, b in itertools.pairwise(angles)):
        raise ValueError("the cam angles of a force table must increase")
    if angles[-1] - angles[0] > 360.0 + ROUNDED:
        raise ValueError("a force table covers more than one turn")


@final
@immutable
class Applied:
    """A force, N (N mm on a rotating follower), on a closed range of cam angle; zero elsewhere.

    begin: rad in [0, 2 pi); length: rad, at most a turn; breaks: cam angles in [0, 2 pi], rad, where it may jump or
    kink; value: function of (cam angle in [0, 2 pi), lift, velocity, acceleration).
    """

    begin: float
    length: float
    breaks: tuple[float, ...]
    value: Callable[[Floats, Floats, Floats, Floats], Floats]
    factor: float = 1.0
    """by which an operating state multiplies it"""
    moved: bool = True
    """whether it hangs on the follower's motion too"""

    def __call__(self, theta: ArrayLike, s: ArrayLike = 0.0, v: ArrayLike = 0.0, a: ArrayLike = 0.0) -> Floats:
        """Force at cam angle theta (rad, any turn); broadcast shape of the arguments."""
        angle, *state = (np.asarray(x, dtype=np.float64) for x in (theta, s, v, a))
        turned = np.mod(angle - self.begin, TURN)
        # The closing end belongs to the range although it may round to just past it or to a whole turn.
        inside = (turned <= self.length + CLOSING) | (turned >= TURN - CLOSING)
        shape = np.broadcast_shapes(angle.shape, *(x.shape for x in state))
        force = np.zeros(shape)
        if inside.any():
            within = np.broadcast_to(inside, shape)
            angle, *state = (np.broadcast_to(x, shape)[within] for x in (angle, *state))
            force[within] = self.factor * self.value(np.mod(angle, TURN), *state)
        return force

    def followed(self, program: Motion, omega: float) -> Applied:
        """The same with breaks round its peaks under a motion at a speed, rad/s, that samples might pass by; one of the
        cam angle alone has them since it was made.

        Raises ProfileError where it has a pole, or a peak that is not resolved.
        """
        if not (self.moved and isinstance(self.value, Expression)):
            return self
        found = _peaks(self.value, self.begin, self.length, program, omega if self.fast else 1.0)
        return replace(self, breaks=(*self.breaks, *found))

    @property
    def fast(self) -> bool:
        """Whether it hangs on the speed."""
        return isinstance(self.value, Expression) and not self.value.variables.isdisjoint("va")

    @property
    def stated(self) -> tuple[float, ...]:
        """Those of its breaks that are given: ends of its range, or rows."""
        return self.breaks[:2] if isinstance(self.value, Expression) else self.breaks

    @property
    def plain(self) -> bool:
        """Whether no motion gives it peaks that samples of the motion pass by: a table, or a polynomial of lift,
        velocity and acceleration whose coefficients are numbers, and any function of the cam angle added to it. A
        polynomial of a low degree has no peak that is narrow beside the range it is taken over (Markov)."""
        return not isinstance(self.value, Expression) or self.value.degree <= MOST_DEGREE

    @property
    def anywhere(self) -> tuple[float, ...]:
        """Its breaks, and those round peaks of what a plain one adds of the cam angle alone: they do not hang on the
        motion. Raises ProfileError where they are not resolved."""
        if not (self.moved and isinstance(self.value, Expression)):
            return self.breaks
        return (*self.breaks, *_peaks_at_rest(self.value, self.begin, self.length))

    def swings(self, program: Motion, omega: float, most: int) -> int:
        """Panels that follow an expression under a motion at a speed, rad/s, beyond those of the motion; `most` + 1
        where there are more. Raises ProfileError as `followed`."""
        if not isinstance(self.value, Expression):
            return 0

        def begun(breaks: Sequence[float]) -> Panels:
            edges = np.concatenate([[0.0, TURN], breaks, program.knots])
            return panels(edges[(edges >= 0.0) & (edges <= TURN)], WIDEST)

        start, alone = begun(self.breaks), len(begun(self.stated).half)

        def at(theta: Floats) -> Floats:
            state = moving(program, omega, theta.ravel()) if self.moved else ()
            return self(theta, *(one.reshape(theta.shape) for one in state))

        try:
            return len(resolved(at, start, most=max(len(start.half), alone + most)).half) - alone
        except NotConverged:
            return most + 1


class Motion(Hashable, Protocol):
    """A motion program: derivatives of the lift (mm or rad) by the cam angle, and where they may jump, rad."""

    @cached_property
    def knots(self) -> Floats:
        """Cam angles in [0, 2 pi], rad, where a derivative may jump."""

    def jet(self, theta: Floats, order: int = 3) -> Floats:
        """Lift and its derivatives per rad of cam angle, (order + 1, n)."""


def moving(program: Motion, omega: float, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """Lift, velocity and acceleration at cam angles, rad, and a speed, rad/s, as forces are given them."""
    lift, slope, bend = program.jet(theta, 2)[:3]
    return lift, omega * slope, omega * omega * bend


@lru_cache(64)
def _peaks(value: Expression, begin: float, length: float, program: Hashable, omega: float) -> tuple[float, ...]:
    motion = cast("Motion", program)
    return peaks_of(value, begin, length, partial(moving, motion, omega), motion.knots)


@lru_cache(64)
def _peaks_at_rest(value: Expression, begin: float, length: float) -> tuple[float, ...]:
    # What the motion adds at rest may be far beyond what it does anywhere, and hides none.
    return peaks_of(value, begin, length, lambda angle: [np.zeros_like(angle)] * 3, of_largest=OF_ROUNDING)


def expression_force(text: str, begin: float, until: float, key: str = "operation.force") -> Applied:
    """A force given by an expression from cam angle `begin` to `until` (rad); past a turn where until < begin."""
    expression: Expression = compile_expression(text, key)
    moved = not expression.variables.isdisjoint(MOTION)
    start, length, ends = _range(begin, until)
    return Applied(start, length, (*ends, *narrow_peaks(expression, start, length)), value=expression, moved=moved)


def table_force(theta: ArrayLike, force: ArrayLike, interpolation: Interpolation = "linear") -> Applied:
    """A force, N, from a table over increasing cam angles (rad), within one turn; zero outside the table."""
    angle, value = np.asarray(theta, dtype=np.float64), np.asarray(force, dtype=np.float64)
    if angle.ndim != 1 or angle.shape != value.shape or not (np.isfinite(angle).all() and np.isfinite(value).all()):
        raise ProfileError([Problem("operation.force.table", "needs two columns of finite numbers")])
    try:
        check_table(np.degrees(angle).tolist())
    except ValueError as error:
        raise ProfileError([Problem("operation.force.table", str(error))]) from None
    begin, length, _ = _range(float(angle[0]), float(angle[-1]))
    local = angle - angle[0]
    curve = _linear(local, value) if interpolation == "linear" else monotone_cubic(local, value)
    inner = np.mod(angle, TURN)
    ends = (TURN,) if np.any(inner == 0.0) else ()

    def at(turn: Floats, s: Floats, v: Floats, a: Floats) -> Floats:
        del s, v, a
        x = np.mod(turn - begin, TURN)
        return curve(np.where(x > local[-1] + 1e-12, np.minimum(x - TURN, 0.0), x))

    return Applied(begin, length, tuple(float(x) for x in inner) + ends, at, moved=False)


def _range(begin: float, until: float) -> tuple[float, float, tuple[float, ...]]:
    """Start in [0, 2 pi), length and break angles of a range given by its two ends in rad."""
    length = until - begin
    if length <= 0.0:
        length = float(np.mod(length, TURN)) or TURN
    # A whole turn from anywhere may come out longer than one by a rounding.
    length = min(length, TURN)
    start = float(np.mod(begin, TURN))
    end = start + length
    # The end as it was given, where it is within the turn: a recomputed one could miss a knot of the motion.
    stop = float(until) if 0.0 <= until <= TURN else (end if end <= TURN else end - TURN)
    return start, length, (start, stop)


def _linear(x: Floats, y: Floats) -> Callable[[Floats], Floats]:
    return lambda at: np.asarray(np.interp(at, x, y), dtype=np.float64)


def monotone_cubic(x: Floats, y: Floats) -> Callable[[Floats], Floats]:
    """Piecewise cubic through (x, y) that rises and falls only where the data do (slopes after Fritsch and Butland)."""
    step, rise = np.diff(x), np.diff(y)
    chord = rise / step
    slope = np.empty_like(y)
    if len(x) == 2:
        slope[:] = chord[0]
    else:
        near, far = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
        agree = np.sign(chord[:-1]) * np.sign(chord[1:]) > 0.0
        left, right = np.where(agree, chord[:-1], 1.0), np.where(agree, chord[1:], 1.0)
        slope[1:-1] = np.where(agree, (near + far) / (near / left + far / right), 0.0)
        slope[0] = _end_slope(step[0], step[1], chord[0], chord[1])
        slope[-1] = _end_slope(step[-1], step[-2], chord[-1], chord[-2])

    def curve(at: Floats) -> Floats:
        cell = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(step) - 1)
        h = step[cell]
        u = np.clip((at - x[cell]) / h, 0.0, 1.0)
        w = 1.0 - u
        return np.asarray(w * w * ((1.0 + 2.0 * u) * y[cell] + u * h * slope[cell])
                          + u * u * ((1.0 + 2.0 * w) * y[cell + 1] - w * h * slope[cell + 1]))

    return curve


def _end_slope(h0: float, h1: float, d0: float, d1: float) -> float:
    """One-sided three-point slope, limited so that the end cell stays monotone."""
    slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
    if slope * d0 <= 0.0:
        return 0.0
    return 3.0 * d0 if d0 * d1 <= 0.0 and abs(slope) > 3.0 * abs(d0) else slope


MAX_CHARACTERS = 500
MAX_DEPTH = 40
MAX_EXPONENT = 32.0
MAX_NUMBER = 1e30

VARIABLES: dict[str, str] = {
    "phi": "cam angle, rad",
    "theta": "cam angle, rad (the same as phi)",
    "deg": "cam angle, degrees",
    "s": "lift, mm or rad",
    "v": "follower velocity, mm/s or rad/s",
    "a": "follower acceleration, mm/s² or rad/s²",
}
MOTION = ("s", "v", "a")
CONSTANTS: dict[str, float] = {"pi": math.pi, "e": math.e}
FUNCTIONS: dict[str, tuple[np.ufunc, int, int]] = {
    "sin": (np.sin, 1, 1), "cos": (np.cos, 1, 1), "tan": (np.tan, 1, 1),
    "asin": (np.arcsin, 1, 1), "acos": (np.arccos, 1, 1), "atan": (np.arctan, 1, 1), "atan2": (np.arctan2, 2, 2),
    "sinh": (np.sinh, 1, 1), "cosh": (np.cosh, 1, 1), "tanh": (np.tanh, 1, 1),
    "exp": (np.exp, 1, 1), "sqrt": (np.sqrt, 1, 1), "abs": (np.absolute, 1, 1), "sign": (np.sign, 1, 1),
    "log": (np.log, 1, 1), "log10": (np.log10, 1, 1), "hypot": (np.hypot, 2, 2),
    "floor": (np.floor, 1, 1), "ceil": (np.ceil, 1, 1),
    "min": (np.minimum, 2, 8), "max": (np.maximum, 2, 8),
}
_BINARY: dict[type[ast.operator], np.ufunc] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
}
_OPERATORS: dict[str, np.ufunc] = {"negative": np.negative} | {f.__name__: f for f in _BINARY.values()}

Step = tuple[str, str, float]
"""One step on a stack: ("number", "", value), ("variable", name, 0), ("call" | "operator", name, arguments)."""


class _Refused(Exception):
    """The text asks for something that is not let through; carries message and hint for the Problem."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


class _Part(NamedTuple):
    """What a part of an expression is: its degree in the motion, whether it hangs on the cam angle, the variable or the
    number that it is."""

    degree: float
    turning: bool
    variable: str = ""
    number: float = math.nan

    @property
    def constant(self) -> bool:
        return self.degree == 0.0 and not self.turning


def _together(name: str, parts: Sequence[_Part]) -> _Part:
    """What an operation makes of its arguments."""
    degrees, turning = [part.degree for part in parts], any(part.turning for part in parts)
    if not any(degrees):
        known = name == "negative"
        return _Part(0.0, turning, number=-parts[0].number if known else math.nan)
    found = math.inf
    if name in ("add", "subtract", "negative"):
        found = max(degrees)
    elif (name == "multiply" and (not turning or any(part.constant for part in parts))) or (
        name == "divide" and parts[1].constant
    ):
        found = sum(degrees)
    elif name == "power" and not turning and parts[1].number >= 1.0 and parts[1].number.is_integer():
        found = degrees[0] * parts[1].number
    elif name == "abs" and parts[0].variable == "v":
        found = 1.0
    return _Part(found, turning)


@final
@immutable(eq=True)
class Expression:
    """A function of the cam angle and the follower's motion; call it with arrays. Made by `compile_expression`."""

    text: str
    key: str
    steps: tuple[Step, ...]

    @property
    def variables(self) -> frozenset[str]:
        """Names of the variables that the expression uses."""
        return frozenset(name for kind, name, _ in self.steps if kind == "variable")

    @cached_property
    def degree(self) -> float:
        """Degree of the polynomial of lift, velocity and acceleration, with numbers for coefficients, that it is beside
        what it adds of the cam angle alone; abs(v) counts as v. Infinite where it is none."""
        stack: list[_Part] = []
        for kind, name, number in self.steps:
            if kind == "number":
                stack.append(_Part(0.0, False, number=number))
            elif kind == "variable":
                stack.append(_Part(float(name in MOTION), name not in MOTION, name))
            else:
                count = int(number)
                found = _together(name, stack[-count:])
                del stack[-count:]
                stack.append(found)
        return stack[0].degree

    def of(self, known: Mapping[str, Floats]) -> Floats:
        """Value for variables of other names, as they were given to `compile_expression`; what has none is not finite.
        """
        return _run(self.steps, known)

    def __call__(self, phi: ArrayLike, s: ArrayLike = 0.0, v: ArrayLike = 0.0, a: ArrayLike = 0.0) -> Floats:
        """Value at cam angle phi (rad), lift s, velocity v, acceleration a; their broadcast shape.

        Raises ProfileError where the value is not a finite number (division by zero, logarithm of a negative).
        """
        angle = np.asarray(phi, dtype=np.float64)
        known = {"phi": angle, "theta": angle, "deg": np.degrees(angle), "s": np.asarray(s, dtype=np.float64),
                 "v": np.asarray(v, dtype=np.float64), "a": np.asarray(a, dtype=np.float64)}
        # Division by zero and the like become one clear error below, not a warning on stderr.
        with np.errstate(all="ignore"):
            value = self.of(known)
        shape = np.broadcast_shapes(*(array.shape for array in known.values()))
        result = np.array(np.broadcast_to(value, shape), dtype=np.float64)
        bad = ~np.isfinite(result)
        if bad.any():
            where = float(np.degrees(np.broadcast_to(angle, shape)[bad].ravel()[0]))
            raise ProfileError([Problem(self.key, f"the expression has no finite value at cam angle {where:.6g} deg",
                                        self.text, hint="limit its range of cam angle or rewrite it")])
        return result


def compile_expression(text: str, key: str = "expression", variables: Mapping[str, str] = VARIABLES) -> Expression:
    """The expression as an array function; ProfileError, naming the key, where the text is not plain arithmetic.

    variables  names that it may use, each with its meaning
    """
    try:
        if len(text) > MAX_CHARACTERS:
            raise _Refused(f"the expression is {len(text)} characters long", f"at most {MAX_CHARACTERS} are allowed")
        steps: list[Step] = []
        _emit(_parse(text), steps, 0, variables)
    except _Refused as refused:
        raise ProfileError([Problem(key, str(refused), text, hint=refused.hint)]) from None
    return Expression(text, key, tuple(steps))


_WARNED_OF = re.compile(r"""['"]|(?<![A-Za-z_])\d[\w.]*(?:and|else|for|if|in|is|not|or)\b""")
"""What Python's parser warns of, texts and words that follow a number at once (1or 2): no arithmetic either."""


def _parse(text: str) -> ast.expr:
    if _WARNED_OF.search(text):
        raise _Refused("not an arithmetic expression", "write for example 12.5 * sin(2*phi) + 3")
    try:
        return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise _Refused(f"not an arithmetic expression: {reason}", "write for example 12.5 * sin(2*phi) + 3") from None
    except (MemoryError, RecursionError):
        raise _Refused("the expression is nested too deeply", f"at most {MAX_DEPTH} levels are allowed") from None


def _emit(node: ast.expr, steps: list[Step], depth: int, variables: Mapping[str, str]) -> None:
    """Append the steps that leave the value of the node on the stack."""
    if depth > MAX_DEPTH:
        raise _Refused("the expression is nested too deeply", f"at most {MAX_DEPTH} levels are allowed")
    if isinstance(node, ast.Constant):
        steps.append(("number", "", _number(node)))
    elif isinstance(node, ast.Name):
        steps.append(_name(node.id, variables))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        _emit(node.operand, steps, depth + 1, variables)
        if isinstance(node.op, ast.USub):
            steps.append(("operator", "negative", 1.0))
    elif isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        # A chain of terms nests to the left as deep as it is long, which MAX_CHARACTERS bounds.
        _emit(node.left, steps, depth, variables)
        before = len(steps)
        _emit(node.right, steps, depth + 1, variables)
        if isinstance(node.op, ast.Pow):
            _check_exponent(steps[before:])
        steps.append(("operator", _BINARY[type(node.op)].__name__, 2.0))
    elif isinstance(node, ast.Call):
        _call(node, steps, depth, variables)
    else:
        raise _Refused(f"{type(node).__name__} is not allowed here",
                       "only numbers, variables, + - * / **, parentheses and the known functions are")


def _call(node: ast.Call, steps: list[Step], depth: int, variables: Mapping[str, str]) -> None:
    if not isinstance(node.func, ast.Name):
        raise _Refused("only the known functions can be called", ", ".join(FUNCTIONS))
    name = node.func.id
    if name not in FUNCTIONS:
        raise _Refused(f"unknown function {name!r}", _nearest(name, FUNCTIONS))
    _, least, most = FUNCTIONS[name]
    if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
        raise _Refused(f"{name} takes plain arguments only")
    if not least <= len(node.args) <= most:
        wanted = str(least) if least == most else f"{least} to {most}"
        raise _Refused(f"{name} takes {wanted} argument(s), not {len(node.args)}")
    for argument in node.args:
        _emit(argument, steps, depth + 1, variables)
    steps.append(("call", name, float(len(node.args))))


def _number(node: ast.Constant) -> float:
    if isinstance(node.value, bool) or not isinstance(node.value, int | float):
        raise _Refused(f"{type(node.value).__name__} is not a number")
    # Compared as they are: a very long integer does not fit a float.
    if not -MAX_NUMBER <= node.value <= MAX_NUMBER:
        raise _Refused("a number is too large", f"at most {MAX_NUMBER:g} is allowed")
    return float(node.value)


def _name(name: str, variables: Mapping[str, str]) -> Step:
    if name in CONSTANTS:
        return ("number", "", CONSTANTS[name])
    if name in variables:
        return ("variable", name, 0.0)
    raise _Refused(f"unknown name {name!r}", _nearest(name, [*variables, *CONSTANTS]))


def _check_exponent(steps: list[Step]) -> None:
    """An exponent is a constant of bounded size; exp() is there for the rest."""
    if any(kind == "variable" for kind, _, _ in steps):
        raise _Refused("an exponent must be a constant", "write exp(x*log(base)) for a variable exponent")
    with np.errstate(all="ignore"):
        value = float(_run(tuple(steps), {}))
    if not abs(value) <= MAX_EXPONENT:
        raise _Refused(f"the exponent {value:.6g} is too large", f"at most {MAX_EXPONENT:g} is allowed")


def _run(steps: tuple[Step, ...], known: Mapping[str, Floats]) -> Floats:
    stack: list[Floats] = []
    for kind, name, number in steps:
        if kind == "number":
            stack.append(np.asarray(number, dtype=np.float64))
        elif kind == "variable":
            stack.append(known[name])
        else:
            operation = _OPERATORS[name] if kind == "operator" else FUNCTIONS[name][0]
            count = int(number)
            arguments = stack[-count:]
            del stack[-count:]
            value = operation(*arguments[:2])
            for argument in arguments[2:]:
                value = operation(value, argument)
            stack.append(np.asarray(value, dtype=np.float64))
    return stack[0]


def _nearest(name: str, known: Mapping[str, object] | list[str]) -> str:
    from difflib import get_close_matches

    close = get_close_matches(name, list(known), n=1)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
