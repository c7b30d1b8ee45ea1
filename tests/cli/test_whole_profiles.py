"""The generator of whole random profiles reaches every key of the schema and every format; the reader takes them."""

from __future__ import annotations

import sys

from camgeom.profile import parse
from camgeom.report.files import format_rows
from tests.places import ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))
import whole_keys  # type: ignore[import-not-found]
import whole_profiles  # type: ignore[import-not-found]

SEEDS = 6500


def test_every_key_and_format_is_drawn() -> None:
    drawn, formats, kinds = set(), set(), set()
    for seed in range(SEEDS):
        data = whole_profiles.profile(seed, pictures=0.3)
        drawn |= whole_keys.reached(data)
        formats |= set(data["output"]["formats"])
        kinds.add(data["cam"]["kind"])
    keys = whole_keys.keys()
    ends = {key for key in keys if key.startswith("motion.") and key.rpartition(".")[2] in whole_keys.RATES}
    # End values are drawn for every law, and mean something for those that join their neighbours.
    assert keys - drawn - ends == set()
    assert {key for key in ends if key.split(".")[1] in whole_keys.JOINING} <= drawn
    assert kinds == set(whole_profiles.KINDS)
    assert formats == {row["format"] for row in format_rows()}


def test_what_the_schema_adds_is_read_and_what_it_spoils_is_taken_away() -> None:
    for seed in range(8):
        data = whole_profiles.accepted(11 * seed)
        profile = parse(whole_profiles.toml(data), whole_profiles.beside())
        assert profile.cam.kind == whole_profiles.KINDS[11 * seed % len(whole_profiles.KINDS)]
