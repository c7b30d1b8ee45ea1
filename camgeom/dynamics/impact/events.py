"""Where in a step of the contact solver an event may lie: points looked at inside it, and the sign change placed."""

from __future__ import annotations

from typing import Any, NamedTuple

from camgeom.dynamics.impact.problem import StepRecord
from camgeom.dynamics.impact.stepper import Stepped

SUBPOINTS = 8


def hermite_row(u: float) -> tuple[float, float, float, float, float, float]:
    """Weights of y0, h y0', h^2 y0'', y1, h y1', h^2 y1'' in the quintic Hermite form at the share u of a step."""
    v = 1.0 - u
    u3, v3 = u * u * u, v * v * v
    return (
        v3 * (1.0 + 3.0 * u + 6.0 * u * u),
        v3 * u * (1.0 + 3.0 * u),
        0.5 * v3 * u * u,
        u3 * (1.0 + 3.0 * v + 6.0 * v * v),
        -u3 * v * (1.0 + 3.0 * v),
        0.5 * u3 * v * v,
    )


_ROWS = tuple(hermite_row(j / SUBPOINTS) for j in range(1, SUBPOINTS))


class Trial(NamedTuple):
    """A step that met its tolerance, with the rate at its end."""

    time: float
    length: float
    state: Any
    rate: Any
    powers: complex
    work: complex


def subpoints(record: StepRecord, trial: Trial) -> list[tuple[float, Any]]:
    """Shares of a step and the state there: quintic in the deviation, linear in its rate.

    The rate only serves to watch the clip, which is placed exactly.
    """
    h = trial.length
    y, k, y1, k1 = record.state, record.rate, trial.state, trial.rate
    if not isinstance(y, complex):
        y, k, y1, k1 = complex(y[0]), complex(k[0]), complex(y1[0]), complex(k1[0])
    a, b, c = y.real, h * y.imag, h * h * k.imag
    d, e, f = y1.real, h * y1.imag, h * h * k1.imag
    rise = y1.imag - y.imag
    points: list[tuple[float, Any]] = []
    for j, (ra, rb, rc, rd, re, rf) in enumerate(_ROWS, 1):
        eta = ra * a + rb * b + rc * c + rd * d + re * e + rf * f
        points.append((j / SUBPOINTS, complex(eta, y.imag + rise * j / SUBPOINTS)))
    points.append((1.0, y1))
    return points


def illinois(
    at: Any, low: float, high: float, value_low: float, value_high: float, made: Stepped, width: float
) -> tuple[float, Stepped]:
    """A sign change from not positive to positive by the Illinois rule; returns the end just past it and its step."""
    kept = 0
    for _ in range(100):
        if high - low <= width or value_high == 0.0:
            break
        tau = low + (high - low) * value_low / (value_low - value_high) if value_low < 0.0 else 0.5 * (low + high)
        if not low < tau < high:
            break
        value, trial = at(tau)
        if value > 0.0:
            if kept == 1:
                value_low *= 0.5
            kept, high, value_high, made = 1, tau, value, trial
        else:
            if kept == -1:
                value_high *= 0.5
            kept, low, value_low = -1, tau, value
            if value == 0.0:
                return tau, trial
    return high, made
