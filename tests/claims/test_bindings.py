"""A cam's mechanism answers for every kind, and several followers on one body are judged one by one."""

from __future__ import annotations

import gc
from weakref import ref

import numpy as np
import pytest

from camgeom.cams import kinds, starter
from camgeom.checks import NEEDS, checks, findings
from camgeom.model import Model
from camgeom.profile import Profile, parse
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
    assert mechanism.inside(np.zeros((3, 2))).shape == (2,)
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


def test_several_followers_on_one_body_are_a_list(monkeypatch: pytest.MonkeyPatch) -> None:
    lone = Model(parse(starter("disc")))
    assert lone.bindings == (lone,)
    further = lone.profile.follower.model_copy(update={"offset": 4.0})
    monkeypatch.setattr(Profile, "followers", property(lambda profile: (profile.follower, further)))
    model = Model(lone.profile)
    assert [binding.setup.follower for binding in model.bindings] == [lone.profile.follower, further]
    assert all(binding.body is model.body for binding in model.bindings)
    names = ["pressure-angle", "undercut"]
    found = findings(model, names)
    assert [f.where.partition(":")[0] for f in found] == ["follower 1", "follower 2"] * 2
    alone = [f.value for f in findings(lone, names)]
    assert [f.value for f in found[::2]] == alone
    data = compute(model, ["flank", "checks"], names).data
    (second,) = data["followers"]
    assert data["flank"] == compute(lone, ["flank"]).data["flank"]
    assert second["flank"]["max_pressure_angle_deg"] > data["flank"]["max_pressure_angle_deg"]
