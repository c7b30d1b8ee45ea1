"""A table of lifts in a file is read once, with the profile: what becomes of the file later changes no design."""

from __future__ import annotations

from pathlib import Path

import pytest

from camgeom.cams import starter
from camgeom.cli import main
from camgeom.errors import ProfileError
from camgeom.export.folder import read_manifest
from camgeom.model import read
from camgeom.profile import Profile
from camgeom.profile import read as profile_of

BEND = 3.0
"""of the second table, which is another motion between the same ends"""


def table(bend: float = 0.0, lift: float = 8.0) -> str:
    x = [i / 12 for i in range(13)]
    rows = (f"{120 * u},{lift * (u**3 * (10 - 15 * u + 6 * u * u) + bend * (u - u * u) ** 3):.6f}" for u in x)
    return "angle,lift\n" + "\n".join(rows) + "\n"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    text = starter("disc")
    law = 'law = "table"\nfile = "lift.csv"'
    first = text.index("law =")
    (tmp_path / "p.toml").write_text(text[:first] + law + text[text.index("\n", first) :])
    lift = next(one.to for one in profile_of(written(tmp_path, text)).motion if one.to)
    (tmp_path / "lift.csv").write_text(table(lift=lift))
    return tmp_path


def written(folder: Path, text: str) -> Path:
    path = folder / "starter.toml"
    path.write_text(text)
    return path


def test_profiles_of_two_states_of_a_file_are_two_designs(place: Path) -> None:
    def now() -> tuple[Profile, float]:
        model = read(place / "p.toml")
        return model.profile, model.setup.program.peak(2).value

    content = (place / "lift.csv").read_text()
    first, peak = now()
    digest, lift = first.digest(), float(content.split(",")[-1])
    (place / "lift.csv").write_text(table(BEND, lift))
    second, other = now()
    assert other != pytest.approx(peak, rel=1e-3)
    assert first != second
    assert first.digest() == digest != second.digest()
    (place / "lift.csv").write_text(content)
    assert now() == (first, peak)
    (place / "lift.csv").unlink()
    assert first.setup().program.peak(2).value == peak
    assert first.digest() == digest


def test_a_file_of_another_name_is_the_same_design(place: Path) -> None:
    first = profile_of(place / "p.toml").digest()
    (place / "lift.csv").rename(place / "other.csv")
    text = (place / "p.toml").read_text()
    (place / "p.toml").write_text(text.replace("lift.csv", "other.csv"))
    assert profile_of(place / "p.toml").digest() == first


def test_a_run_is_whole_though_its_table_goes_while_it_runs(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.report import delivery

    plain = delivery.compute

    def moved(*given: object) -> object:
        (place / "lift.csv").unlink()
        return plain(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(delivery, "compute", moved)
    digest = profile_of(place / "p.toml").digest()
    status = main(["run", str(place / "p.toml"), "--out", str(place / "o"), "--formats", "stl"])
    assert status in (0, 1)
    assert (place / "o" / "result.json").exists()
    assert read_manifest(place / "o")["profile_sha256"] == digest


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("angle,lift\n0,0\n1,nought\n", "row 2 is not two numbers"),
        ("angle,lift\n0,0\n1,1\n", "8 to 20000 rows"),
        (table(lift=1.0), "does not end at the segment's `to`"),
    ],
)
def test_what_is_wrong_with_the_rows_is_told_of_the_file(place: Path, content: str, told: str) -> None:
    (place / "lift.csv").write_text(content)
    with pytest.raises(ProfileError, match=told) as caught:
        profile_of(place / "p.toml")
    assert [one.key for one in caught.value.problems] == ["motion[0].file"]


def test_a_file_and_rows_are_refused(place: Path) -> None:
    text = (place / "p.toml").read_text()
    (place / "p.toml").write_text(text.replace('file = "lift.csv"', 'file = "lift.csv"\nrows = [[0, 0], [1, 1]]'))
    with pytest.raises(ProfileError, match=r"motion\[0\]\.rows: a table is either a file or rows"):
        profile_of(place / "p.toml")
