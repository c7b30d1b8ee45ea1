"""Profiles read from TOML: what comes out of a good one, and one plain message for everything wrong with a bad one."""

from __future__ import annotations

import os
from math import isclose, pi, radians
from pathlib import Path

import numpy as np
import pytest

from camgeom.errors import ProfileError
from camgeom.mechanics.applied import check_table
from camgeom.profile import Profile, from_data, parse, read
from camgeom.profile.motion import motion_problems, program_of
from camgeom.profile.sections import Force, MotionSegment
from camgeom.profile.text import MAX_BYTES, load
from camgeom.track.follower import FrameFollower, TurretFollower
from tests.places import PROFILES

GOOD = """
name = "pin-insertion groove cam"

[cam]
kind = "cylindrical"
diameter = 134
length = 110
start = 18
groove_depth = 13
bore = 40

[follower]
kind = "translating"
mass = 2.25

[roller]
shape = "cylinder"
diameter = 22
length = 12

[[motion]]
until = 155
[[motion]]
until = 215
to = 37
law = "cycloidal"
[[motion]]
until = 280
to = 74
law = "modified-constant-velocity"
share = 0.4
[[motion]]
until = 290
[[motion]]
until = 360
to = 0
law = "cycloidal"

[operation]
speed = 600
[[operation.force]]
from = 255
until = 280
expression = "79.55 * sin(phi)**2"

[output]
tolerance = 0.005
"""


def refused(text: str, file: str = "bad.toml") -> str:
    with pytest.raises(ProfileError) as caught:
        parse(text, file)
    return str(caught.value)


def changed(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new, 1)


def test_good_profile() -> None:
    profile = parse(GOOD)
    assert profile.kind == "cylindrical"
    assert profile.roller is not None
    assert profile.roller.diameter == 22.0
    assert isinstance(profile.roller.diameter, float)
    assert profile.limits.pressure_angle_deg == 30.0
    assert profile.motion[2].parameters == (("share", 0.4),)
    assert hash(profile) == hash(parse(GOOD))
    assert profile == parse(GOOD)


def test_angles_become_radians_at_the_door() -> None:
    program = parse(GOOD).setup().program
    assert np.allclose(program.jet(np.radians([0.0, 100.0, 215.0, 280.0, 285.0]), 0)[0], [0, 0, 37, 74, 74], atol=1e-12)
    assert program.knots[-1] == 2.0 * pi


def test_positions_of_a_swinging_follower_are_degrees() -> None:
    text = changed('kind = "translating"\nmass = 2.25', 'kind = "swinging"\narm = 400').replace("to = 74", "to = 7.4")
    profile = parse(text.replace("to = 37", "to = 3.7"))
    lift = profile.setup().program.jet(np.array([radians(285.0)]), 0)[0, 0]
    assert isclose(lift, radians(7.4), rel_tol=1e-14)
    assert profile.rotating


def test_velocity_per_degree_becomes_per_radian() -> None:
    text = changed('law = "modified-constant-velocity"\nshare = 0.4', 'law = "polynomial"')
    text = text.replace('to = 37\nlaw = "cycloidal"', 'to = 37\nlaw = "polynomial"\nvelocity = 0.6')
    program = parse(text).setup().program
    assert isclose(program.jet(np.array([radians(215.0)]), 1)[1, 0], 0.6 * 180.0 / pi, rel_tol=1e-12)


def test_half_a_turn_is_mirrored() -> None:
    motion = (
        MotionSegment(until=140.0, to=30.0, law="modified-trapezoid"),
        MotionSegment(until=180.0),
    )
    follower = FrameFollower(kind="frame")
    program = program_of(motion, follower, 180.0, "")
    theta = np.linspace(0.01, 3.13, 50)
    first, second = program.jet(theta, 2), program.jet(theta + pi, 2)
    assert np.allclose(second[0], 30.0 - first[0], atol=1e-12)
    assert np.allclose(second[1:], -first[1:], atol=1e-9)
    assert motion_problems(motion, follower, 180.0) == []
    wrong = (*motion[:1], MotionSegment(until=170.0))
    assert [p.key for p in motion_problems(wrong, follower, 180.0)] == ["motion[1].until"]


def test_turret_steps_by_whole_indexes() -> None:
    follower = TurretFollower(kind="turret", stops=7, pitch_radius=100.0)
    step = MotionSegment(until=200.0, to=51.4285714, law="modified-sine")
    assert motion_problems((step, MotionSegment(until=360.0)), follower, 360.0) == []
    program = program_of((step, MotionSegment(until=360.0)), follower, 360.0, "")
    assert program.advance == 2.0 * pi / 7.0, "the written decimals do not add up turn by turn"
    for bad in (0.0, 51.4, 60.0):
        wrong = (MotionSegment(until=360.0, to=bad, law="modified-sine"),)
        assert [p.key for p in motion_problems(wrong, follower, 360.0)] == ["motion[0].to"]


def test_name_defaults_to_the_file(tmp_path: Path) -> None:
    file = tmp_path / "winder.toml"
    file.write_text(changed('name = "pin-insertion groove cam"\n', ""))
    assert read(file).name == "winder"


def test_typed_construction() -> None:
    read_one = parse(GOOD)
    again = Profile(
        name=read_one.name,
        cam=read_one.cam,
        follower=read_one.follower,
        roller=read_one.roller,
        motion=read_one.motion,
        operation=read_one.operation,
        output=read_one.output,
    )
    assert again == read_one


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("diameter = 134", "diameter = -134", ["bad.toml: cam.diameter:", "-134", "at most 100000 mm"]),
        ("diameter = 134", "diameter = 1e30", ["cam.diameter", "at most 100000 mm"]),
        ("diameter = 134", "diamter = 134", ["cam.diamter: unknown key", "did you mean 'diameter'?"]),
        ("diameter = 134\n", "", ["cam.diameter: is missing", "outside diameter"]),
        ("diameter = 134", 'diameter = "134"', ["cam.diameter: needs a number", "'134'"]),
        ("diameter = 134", "diameter = true", ["cam.diameter: needs a number", "found true"]),
        ("diameter = 134", "diameter = nan", ["cam.diameter: must be a finite number"]),
        ("diameter = 134", "diameter = -inf", ["cam.diameter: must be a finite number"]),
        ("diameter = 134", "diameter = 1e999", ["cam.diameter: must be a finite number"]),
        ("diameter = 134", "diameter = 1979-05-27", ["cam.diameter: a date"]),
        ("diameter = 134", "diameter = 12:30:00", ["cam.diameter: a date or time"]),
        ("diameter = 134", "diameter = " + "9" * 5000, ["too many digits"]),
        ("diameter = 134", "diameter = 0x" + "F" * 5000, ["cam.diameter: the whole number is too large"]),
        ("diameter = 134", "diameter = [134]", ["cam.diameter: needs a number", "an array of 1"]),
        ("diameter = 134", "diameter = {a = 1}", ["cam.diameter: needs a number", "a table"]),
        ("diameter = 134", "diameter = 134\ndiameter = 135", ["TOML syntax", "line 7"]),
        ("diameter = 134", "diameter = ", ["TOML syntax: invalid value", "line 6"]),
        ("[cam]", "[camm]", ["camm: unknown key", "did you mean 'cam'?"]),
        ("[roller]", "[rollar]", ["rollar: unknown key", "did you mean 'roller'?"]),
        ('kind = "cylindrical"', 'kind = "cylindrcal"', ["cam.kind: unknown cam kind", "did you mean 'cylindrical'?"]),
        ('kind = "cylindrical"', "kind = 5", ["cam.kind: needs the name of a cam kind"]),
        ('kind = "cylindrical"\n', "", ["cam.kind: is missing", "cylindrical"]),
        ('kind = "translating"', 'kind = "swining"', ["follower.kind", "did you mean 'swinging'?"]),
        ('kind = "translating"\nmass = 2.25', 'kind = "frame"', ["follower.kind: a cylindrical cam has"]),
        ('shape = "cylinder"', 'shape = "cilinder"', ["roller.shape", "did you mean 'cylinder'?"]),
        ("speed = 600", "speed = 600\nstroke = 3", ["operation.stroke: unknown key"]),
        ("speed = 600", "speed = 600\nmass = 3", ["operation.mass: unknown key", "[follower] mass"]),
        ("speed = 600", "speed = 600\ngroove_depth = 3", ["did you mean [cam] groove_depth?"]),
        ("speed = 600", "speed = 600\nload_inertia = 1", ["operation.load_inertia: means nothing here", "translating"]),
        ("speed = 600", "speed = 0", ["operation.speed: out of range", "more than 0", "r/min"]),
        ("tolerance = 0.005", "tolerance = 1e-9", ["output.tolerance", "at least 1e-07 and at most 1 mm"]),
        ("tolerance = 0.005", 'formats = "stl"', ["output.formats: needs an array"]),
        ("tolerance = 0.005", "formats = [3]", ["output.formats[0]: needs text in quotes"]),
        ("to = 0\n", "to = 1\n", ["motion[4].to", "end where it began"]),
        ("until = 360", "until = 350", ["motion[4].until", "360"]),
        ("until = 290", "until = 270", ["motion[3].until", "280"]),
        ("until = 290", "until = 400", ["motion[3].until: out of range", "at most 360 deg"]),
        ("until = 290", "until = 290\nto = 74", ["motion[3].law"]),
        ("until = 290", 'until = 290\nlaw = "cycloidal"', ["motion[3].to"]),
        ("until = 290", "until = 290\nvelocity = 1", ["motion[3].velocity: a dwell has none"]),
        ("until = 290", "until = 290\nshare = 1", ["motion[3].share: unknown key", "a dwell has no parameters"]),
        ('law = "cycloidal"', 'law = "cycloid"', ["motion[1].law: unknown motion law", "did you mean 'cycloidal'?"]),
        ("share = 0.4", "share = 4", ["motion[2].share", "found 4"]),
        ("share = 0.4", "shaer = 0.4", ["motion[2].shaer: unknown key", "did you mean 'share'?"]),
        ("[[motion]]\nuntil = 155\n", "[[motion]]\n", ["motion[0].until: is missing"]),
        ('"79.55 * sin(phi)**2"', '"__import__(1)"', ["operation.force[0]", "unknown function '__import__'"]),
        ('"79.55 * sin(phi)**2"', '"' + "(" * 4000 + '"', ["operation.force[0]"]),
        ("from = 255\n", "from = 280\n", ["operation.force[0]: `from` and `until` are equal"]),
        ("from = 255\n", "from = 640\n", ["operation.force[0]: `from` and `until` are equal"]),
        ("from = 255\n", "from = -80.1\n", ["operation.force[0]: `from` and `until` are more than a turn apart"]),
        ("from = 255\n", "from = 640.1\n", ["operation.force[0]: `from` and `until` are more than a turn apart"]),
        ("groove_depth = 13", "groove_depth = 8", ["roller.length", "8 mm"]),
        ("name = ", 'name = "' + "x" * 200 + '" #', ["name: needs a text of 1 to 120 characters"]),
        ("name = ", 'name = "\\u001b[2J" #', ["name: the text holds control characters"]),
    ],
)
def test_one_plain_message(old: str, new: str, words: list[str]) -> None:
    text = refused(changed(old, new))
    assert text.startswith("bad.toml: ")
    assert "\n" not in text, "one mistake gives one message"
    for word in words:
        assert word in text
    assert "pydantic" not in text
    assert len(text) < 900


@pytest.mark.parametrize("begin", [-80, 639.9])
def test_a_force_may_act_over_a_whole_turn(begin: float) -> None:
    profile = parse(changed("from = 255\n", f"from = {begin}\n"))
    assert profile.operation is not None
    assert isclose(profile.operation.force[0].applied().length, radians((280 - begin) % 360) or 2 * pi)


def test_a_whole_turn_from_anywhere_is_a_whole_turn() -> None:
    for begin in range(-3600, 3600):
        ends = {"from": begin / 10, "until": (begin + 3600) / 10}
        assert isclose(Force(**ends, expression="1").applied().length, 2 * pi)
        with pytest.raises(ValueError, match="equal"):
            Force(**{"from": ends["until"], "until": ends["from"]}, expression="1")
    for begin in range(3600):
        check_table([begin / 10, (begin + 3600) / 10])
    with pytest.raises(ValueError, match="more than one turn"):
        check_table([0.1, 360.2])


def test_everything_wrong_at_once() -> None:
    text = changed("diameter = 134", "diameter = -1").replace("speed = 600", "sped = 600")
    text = refused(text.replace("share = 0.4", "share = 7").replace("bore = 40", "bore = nan"))
    for key in ("cam.diameter", "cam.bore", "operation.sped", "motion[2].share"):
        assert key in text
    assert text.startswith("bad.toml: 4 problems\n")


def test_motion_is_judged_although_another_section_is_wrong() -> None:
    text = refused(changed("diameter = 134", "diameter = -1").replace("to = 0\n", "to = 1\n"))
    assert "cam.diameter" in text
    assert "motion[4].to" in text


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "cam: is missing"),
        ("[", "TOML syntax"),
        ("a = " + "[" * 100_000, "nested too deeply"),
        ("a = " + "[" * 40 + "]" * 40, "nested too deeply"),
        ("a = " + "{a = " * 50_000, "nested too deeply"),
        (".".join(["a"] * 400_000) + " = 1", "too many parts"),
        ("[" + " . ".join(["a"] * 200_000) + "]", "too many parts"),
        (".".join(['"a,"'] * 100_000) + " = 1", "quoted dotted keys"),
        ("a = [" + "1," * 250_000 + "]", "too many entries"),
        ("[[motion]]\nuntil = 1\n" * 3_001, "at most 3000"),
        ("".join(f"a{i} = 1\n" for i in range(3000)), "unknown key"),
        ('x = "' + "a" * 30_000 + '"', "the text is too long"),
        ("x" * (MAX_BYTES + 1), "at most 1000000 characters"),
        ("motion = 5\ncam = 3\nroller = [1]\nfollower = 'x'\noperation = 1", "5 problems"),
        ("[motion]\nuntil = 3", "[[motion]] in double brackets"),
        ("motion = []\n[cam]\nkind = 'cylindrical'", "motion: is missing"),
        ("motion = [1]\n[cam]\nkind = 'cylindrical'", "motion[0]: needs a table"),
    ],
)
def test_hostile_text(text: str, word: str) -> None:
    found = refused(text)
    assert word in found
    assert len(found) < 60_000


def test_number_of_messages_is_bounded() -> None:
    segments = "".join(f'[[motion]]\nuntil = {i * 0.03 + 0.1}\nto = 1\nlaw = "x{i}"\n' for i in range(5000))
    head = GOOD.split("[[motion]]")[0]
    assert refused(head + segments).count("\n") < 60


def test_bad_files(tmp_path: Path) -> None:
    def message(name: str, content: bytes | None = None) -> str:
        file = tmp_path / name
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(ProfileError) as caught:
            read(file)
        text = str(caught.value)
        assert text.startswith(f"{file}: ")
        assert "\n" not in text
        return text

    assert "there is no such file" in message("none.toml")
    assert "not UTF-8 text (byte 5, line 2)" in message("latin.toml", b"a=1\n\xff")
    assert "NUL byte (line 2)" in message("nul.toml", b"a=1\nb=\x00")
    assert "too large" in message("large.toml", b"#" * (MAX_BYTES + 1))
    (tmp_path / "folder").mkdir()
    assert "is a folder" in message("folder")
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    assert "cannot be opened" in message("loop.toml")
    os.mkfifo(tmp_path / "pipe.toml")
    assert "not a regular file" in message("pipe.toml")
    with pytest.raises(ProfileError, match="not a regular file"):
        read("/dev/zero")
    for name in ("a\0b", "x" * 5000):
        with pytest.raises(ProfileError):
            read(name)


def test_size_is_looked_at_before_reading(tmp_path: Path) -> None:
    file = tmp_path / "sparse.toml"
    with file.open("wb") as stream:
        stream.truncate(10**11)
    with pytest.raises(ProfileError, match="too large"):
        read(file)


def test_line_ends_and_byte_order_mark(tmp_path: Path) -> None:
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert read(file).cam == parse(GOOD).cam


FORCE = 'expression = "79.55 * sin(phi)**2"'


def with_force_file(tmp_path: Path, name: str, content: str | None = None) -> Path:
    if content is not None:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    file = tmp_path / "p.toml"
    file.write_text(changed(f"from = 255\nuntil = 280\n{FORCE}", f"file = {name!r}"))
    return file


def test_force_table_from_a_file(tmp_path: Path) -> None:
    profile = read(with_force_file(tmp_path, "a/force.csv", "# by hand\nangle, force\n250, 0\n260; 10.5\n\n270\t0\n"))
    assert profile.operation is not None
    assert profile.operation.force[0].table == ((250.0, 0.0), (260.0, 10.5), (270.0, 0.0))


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.csv", None, "there is no such file"),
        ("../p.csv", None, "may not leave"),
        ("/etc/hostname", None, "may not leave"),
        ("~/x.csv", None, "may not leave"),
        ("a/../../b.csv", None, "may not leave"),
        ("C:\\x.csv", None, "may not leave"),
        (".", None, "not a regular file"),
        ("text.csv", "1,2\nx,y\n", "line 2: needs 2 finite numbers"),
        ("three.csv", "1,2,3\n", "line 1: needs 2 finite numbers"),
        ("nan.csv", "1,2\n2,nan\n", "line 2: needs 2 finite numbers"),
        ("down.csv", "5,2\n2,1\n", "must increase"),
        ("empty.csv", "", "two rows"),
    ],
)
def test_bad_force_files(tmp_path: Path, name: str, content: str | None, words: str) -> None:
    file = with_force_file(tmp_path, name, content)
    with pytest.raises(ProfileError, match=words) as caught:
        read(file)
    assert "operation.force[0]" in str(caught.value)


def test_link_out_of_the_folder(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "secret.csv").write_text("1,2\n3,4\n")
    (inside / "force.csv").symlink_to(tmp_path / "secret.csv")
    with pytest.raises(ProfileError, match="a link leads out of it"):
        read(with_force_file(inside, "force.csv"))


def test_data_can_be_varied() -> None:
    data, problems, dropped = load(GOOD, "")
    assert not problems
    assert not dropped
    data["cam"]["diameter"] = 140.0
    assert from_data(data).cam.diameter == 140.0  # type: ignore[attr-defined]


PIN = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("given", "hint"),
    [
        ("170mm", "a number stands without its unit: 170"),
        ("170,5", "a number has a decimal point and no quotes: 170.5"),
        ('"170"', "a number has a decimal point and no quotes: 170"),
        ('"6.7 in"', "lengths are mm: 6.7 in is 170.18"),
        ('6.7"', "lengths are mm: 6.7 in is 170.18"),
        ("1.7e2mm", "a number stands without its unit: 1.7e2"),
        (".5", "a number begins with a digit: 0.5"),
        ("5.", "a number ends with a digit: 5.0"),
        ("012", "a number has no zero in front: 12"),
        ("1 000", "digits stand together, with a decimal point: 1000"),
        ("1.000,5", "digits stand together, with a decimal point: 1000.5"),
        ("360/7", "a value is a number, no formula: 51.4285714285714"),
        ("1 1/4", "a value is a number, no formula: 1.25"),
        ("1-1/4 in", "a value is a number, no formula: 1.25"),
        ("12 ; thick", "a comment begins with #: 12  # ..."),
        ("True", "write true"),
        ("disc", 'a text stands in straight quotes: "disc"'),
        ("“disc”", 'a text stands in straight quotes: "disc"'),
        ("", "a value is missing behind ="),
        ("12 deg", "a number stands without its unit: 12"),
    ],
)
def test_a_number_with_unit_comma_or_quotes_is_told_how_to_be_written(given: str, hint: str) -> None:
    text = PIN.replace("diameter = 134", f"diameter = {given}")
    with pytest.raises(ProfileError) as refused:
        parse(text)
    assert hint in str(refused.value)


@pytest.mark.parametrize("given", ["big", '"large"', "1.2.3"])
def test_what_is_no_number_gets_no_such_hint(given: str) -> None:
    text = PIN.replace("diameter = 134", f"diameter = {given}")
    with pytest.raises(ProfileError) as refused:
        parse(text)
    assert "a number" not in str(refused.value).replace("needs a number", "")


@pytest.mark.parametrize("table", ["operation", "cam", "follower"])
def test_a_table_in_double_brackets_is_told(table: str) -> None:
    text = PIN.replace(f"[{table}]", f"[[{table}]]")
    with pytest.raises(ProfileError, match=rf"write \[{table}\] in single brackets"):
        parse(text)


@pytest.mark.parametrize(("old", "new", "hint"), [
    ("[[motion]]", "[motion]", "write [[motion]] in double brackets each time"),
    ("[cam]", "[cam", "write [cam]"),
    ("diameter = 134", "diameter: 134", "write diameter = 134"),
    ("diameter = 134", "diameter = 134\ndiameter = 140", "already: take one of the two away"),
    ("[roller]", "[cam]\nbore = 3\n[roller]", "already: put its keys there"),
    ("[operation]", "[operation.force]\nexpression = '5'\n[operation]", "write [[operation.force]] in double brackets"),
    ("[material.cam]", "[[material.cam]]", "write [material.cam] in single brackets"),
])  # fmt: skip
def test_mistakes_of_brackets_signs_and_repeats_are_told(old: str, new: str, hint: str) -> None:
    with pytest.raises(ProfileError) as refused:
        parse(PIN.replace(old, new, 1))
    assert hint in str(refused.value)
