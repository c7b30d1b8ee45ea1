"""Contact pressure and fatigue life against the limits of the profile, whoever presses the cam.

One judgement a question; its name and advice are those of the carrier: a roller, faces, a turret's rollers that share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from camgeom.checks import Need, check
from camgeom.checks.verdict import Finding, judged

if TYPE_CHECKING:
    from camgeom.model import Model


def pressure(name: str, remedy: str, model: Model) -> Iterable[Finding]:
    """Peak contact pressure: of the hardest slice along a roller, of all rollers that share, of all faces."""
    peak = model.carrier.peak_pressure if model.carrier is not None else None
    if peak is None:
        return
    material = model.profile.material
    limit = model.profile.limits.contact_pressure_mpa or min(material.cam.contact_limit, material.roller.contact_limit)
    where = peak.where or f"slice at {peak.place:.4g} mm along the roller axis"
    yield judged(name, peak.value, "<=", limit, "MPa", remedy, cam_angle=peak.cam_angle, where=where)


def life(name: str, remedy: str, model: Model) -> Iterable[Finding]:
    """Fatigue life of roller and cam, and of the roller's bearing where its rating is given."""
    limit = model.profile.limits.life_h
    if limit is None or model.carrier is None:
        return
    for body, value in model.carrier.lives.items():
        yield judged(name, value, ">=", limit, "h", remedy, where=body)


JUDGEMENTS: tuple[tuple[str, Need, Callable[[str, str, Model], Iterable[Finding]], str], ...] = (
    ("contact-pressure", "roller load", pressure, "use a longer or larger roller, a larger cam, less mass or speed"),
    ("face-pressure", "face load", pressure,
     "use a wider cam, a larger base_radius, or less mass, speed or preload"),
    ("turret-pressure", "turret load", pressure,
     "use longer or larger rollers, a larger centre distance, less inertia or speed"),
    ("life", "roller load", life, "lower the contact pressure: longer or larger roller, larger cam, less speed"),
    ("turret-life", "turret load", life, "lower the load: larger rollers or centre distance, less inertia or speed"),
)  # fmt: skip
for _name, _need, _judge, _remedy in JUDGEMENTS:
    check(_name, _need)(partial(_judge, _name, _remedy))
