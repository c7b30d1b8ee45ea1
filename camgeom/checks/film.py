"""The film between roller or face and cam against the roughness, and what wears off over the life that is asked for."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from camgeom.checks import check, no_stress
from camgeom.checks.verdict import Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.model import Model

THICKER = "a thicker oil, a lower temperature, smoother surfaces or more speed; below 1 the surfaces touch"
KNIFE = "neither film nor wear is known of a knife edge, which touches along no width"
CREEPS = (
    "a crown on a disc or plate slides only by what its places are thinner than its crest, which is not computed: "
    "neither wear nor the heat of friction is known ({} do nothing)"
)
SLIDES = "a harder pair or a better oil (a smaller wear_rate), a wider cam, less load or sliding"


@check("film", "operation")
def film(model: Model) -> Iterable[Finding | NotJudged]:
    """Least ratio lambda of film to roughness over the turn; without a limit a warning at most."""
    if not model.carriers:
        return
    if model.mechanism.carriage is not None:
        yield NotJudged("film", "where the plate turns round nothing draws oil in: no film of a linear cam is known")
        return
    if _knife(model):
        yield NotJudged("film", KNIFE)
        return
    if missing := _missing(model):
        yield NotJudged("film", f"give {', '.join(missing)}: nothing is known of the film between roller and cam"
                        if model.setup.roller is not None else f"give {', '.join(missing)}")  # fmt: skip
        return
    from camgeom.mechanics.film import FITTED

    found = model.film
    if found is None:
        lost = no_stress(model.carriers)
        yield NotJudged("film", lost or "nothing presses a sound wall: see the checks of load and pressure")
        return
    limits, least = model.profile.limits, found.least
    if found.ellipse is not None and found.ellipse < FITTED[0]:
        yield NotJudged("film", f"the contact ellipse is longer along the motion than across it (ratio "
                        f"{found.ellipse:.3g}), for which the formula was not fitted")  # fmt: skip
        return
    where = least.where or f"at {least.place:.4g} mm along the roller axis"
    beyond = "" if found.fitted else f"; ellipse {found.ellipse:.3g}, beyond the {FITTED[1]:g} of the formula's fit"
    yield judged("film", least.value, ">=", limits.film_ratio, "1", THICKER, warn=limits.warn_film_ratio,
                 cam_angle=least.cam_angle, where=f"{where}, {1e3 * found.thickness:.3g} um thick{beyond}")  # fmt: skip


def _knife(model: Model) -> bool:
    """Whether a knife edge touches the cam: the follower without a roller that has no contact pressure."""
    return model.setup.roller is None and model.carriers[0].peak_pressure is None


def _missing(model: Model) -> list[str]:
    """The keys that a film takes and the profile leaves out."""
    oil, material = model.profile.oil, model.profile.material
    missing = ["[lubricant]"] if oil is None else []
    missing += ["lubricant.pressure_viscosity"] if oil is not None and oil.pressure_viscosity is None else []
    for body, one in (("cam", material.cam), ("roller", material.roller)):
        missing += [f"material.{body}.roughness_um"] if one.roughness_um is None else []
    return missing


@check("wear", "operation", summed=True, slow=True)
def wear(model: Model) -> Iterable[Finding | NotJudged]:
    """Depth that wears off either surface over life_h, over all operating states."""
    if not model.carriers:
        return
    if _knife(model):
        yield NotJudged("wear", KNIFE)
        return
    if model.creeps:
        material, oil = model.profile.material, model.profile.oil
        given = [f"material.{body}.wear_rate" for body, one in (("cam", material.cam), ("roller", material.roller))
                 if one.wear_rate is not None]  # fmt: skip
        given += ["lubricant.friction"] if oil is not None and oil.friction is not None else []
        if given:
            yield NotJudged("wear", CREEPS.format(", ".join(given)))
        return
    limits, hourly = model.profile.limits, model.wear_per_hour
    if model.setup.roller is None and not hourly:
        yield NotJudged("wear", "the face slides: give material.cam.wear_rate and material.roller.wear_rate")
    for body, depth in hourly.items():
        if limits.life_h is None or limits.wear_um is None:
            missing = [key for key in ("life_h", "wear_um") if dict(limits)[key] is None]
            told = f"give {' and '.join(f'limits.{key}' for key in missing)}: the {body} wears {1e6 * depth:.4g} um"
            yield NotJudged("wear", f"{told} in 1 000 h")
            continue
        value = 1e3 * depth * limits.life_h
        yield judged("wear", value, "<=", limits.wear_um, "um", SLIDES,
                     where=f"{body}, in {limits.life_h:.6g} h")  # fmt: skip
