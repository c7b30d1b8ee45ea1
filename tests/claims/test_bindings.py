"""A cam's mechanism answers for every kind, and several followers on one body are judged one by one."""

from __future__ import annotations

import gc
from weakref import ref

import numpy as np
import pytest

from camgeom.cams import kinds, starter
from camgeom.checks import NEEDS, checks, findings
from camgeom.model import Model, loads
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.solid.mechanism import Drive

ONE_WAY = {"disc", "end-face"}
"""kinds whose starter pushes one way, and is held by a spring"""


@pytest.mark.parametrize("kind", kinds())
def test_a_mechanism_answers_for_every_kind(kind: str) -> None:
    mechanism = Model(parse(starter(kind))).mechanism
    assert (mechanism.drive is Drive.SHARED) == (mechanism.turret is not None)
    assert (mechanism.drive is Drive.ALONE) == (kind in ONE_WAY)
    assert len(mechanism.cutters) == len(mechanism.tracks)
    assert mechanism.parts
    assert mechanism.within(np.zeros((3, 2))).shape == (2,)
    if mechanism.touches:
        ways = {touch.way for touch in mechanism.touches}
        assert ways == ({1.0} if mechanism.drive is Drive.ALONE else {1.0, -1.0})


def test_an_elastic_follower_between_two_discs_has_no_contact_to_lose() -> None:
    elastic = '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 5e5\n'
    kinds_of = {"conjugate": "form", "disc": "force", "cylindrical": "form", "end-face": "force"}
    for kind, closure in kinds_of.items():
        model = Model(parse(starter(kind) + elastic))
        assert model.elastic_follower is not None
        assert model.elastic_follower.train.closure == closure
    assert "contact_lost" not in compute(Model(parse(starter("conjugate") + elastic)), ["dynamics"]).data["dynamics"]


def test_what_a_check_needs_is_provided() -> None:
    for one in checks().values():
        assert set(one.needs) <= set(NEEDS)


def test_a_dropped_model_is_freed_at_once() -> None:
    model = Model(parse(starter("disc")))
    assert model.solid.sound
    body = ref(model.body)
    gc.disable()
    try:
        del model
        assert body() is None
    finally:
        gc.enable()


def test_an_error_of_a_fact_is_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bug after twenty seconds of work took twenty seconds of every check that asked again."""
    calls: list[object] = []

    def broken(*asked: object) -> None:
        calls.append(asked)
        raise ValueError("a bug")

    monkeypatch.setattr(loads, "turret_duty", broken)
    model = Model(parse(starter("globoidal")))
    for _ in range(2):
        with pytest.raises(ValueError, match="a bug"):
            model.turret_duty  # noqa: B018
    assert len(calls) == 1


def test_several_followers_on_one_body_are_a_list() -> None:
    text = starter("disc")
    lone = Model(parse(text))
    assert lone.bindings == (lone,)
    assert lone.camshaft is None
    assert lone.apart is None
    model = Model(parse(text + "\n[[station]]\nangle = 180\nmass = 3\n"))
    assert [binding.number for binding in model.bindings] == [0, 1]
    assert all(binding.body is model.body for binding in model.bindings)
    assert model.bindings[1].setup.follower.mass == 3.0
    # The track is judged once, what presses it for each.
    names = ["pressure-angle", "contact-pressure"]
    found = findings(model, names)
    assert [f.where.partition(":")[0] for f in found if f.check == names[1]] == ["follower 1", "follower 2"]
    assert [f.value for f in found if f.check == names[0]] == [f.value for f in findings(lone, names[:1])]
    data = compute(model, ["flank", "contact", "checks"], names).data
    (second,) = data["followers"]
    assert data["contact"] == compute(lone, ["contact"]).data["contact"]
    assert second["contact"]["peak_force_n"] > data["contact"]["peak_force_n"]
    assert "flank" not in second
    assert second["angle_deg"] == 180.0
