"""What is read, shown and solved has bounds: files without end, hostile text, closed streams, budgets."""

from __future__ import annotations

import json
import math
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import camgeom
from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.cli import main
from camgeom.dynamics.linear.budget import Purse, refuse_costly
from camgeom.dynamics.linear.method import find
from camgeom.dynamics.linear.solve import _hopeless
from camgeom.errors import NotConverged, Problem, ProfileError, visible
from camgeom.inspection.points import read_points
from camgeom.maths import Floats, within_range
from camgeom.maths.panels import panels, resolved
from camgeom.model import Model
from camgeom.motion.own import load_laws
from camgeom.profile import from_data, parse, read, read_data
from camgeom.reading import MAX_LINE, lines_of, read_bytes
from camgeom.report.files import write
from camgeom.report.result import compute
from tests.places import PROFILES

HOSTILE = "a\x1b[31mred\x1b[0m\u202egnp.\u202c\u200fb\rc\x07"


@pytest.mark.parametrize("reader", [read, read_points, load_laws])
def test_devices_pipes_and_folders_are_no_input(tmp_path: Path, reader) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (Path("/dev/zero"), pipe, tmp_path):
        with pytest.raises(ProfileError, match=r"is not a regular file|is a folder"):
            reader(path)


def test_a_file_is_read_up_to_its_limit_and_no_further(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(b"x" * 1000)
    assert read_bytes(path, 1000, "points.csv") == b"x" * 1000
    with pytest.raises(ProfileError, match=r"too large \(found 1000\); allowed: at most 999 bytes"):
        read_bytes(path, 999, "points.csv")
    # A file of the kernel says it is empty and has content all the same.
    assert read_bytes(Path("/proc/self/status"), 1_000_000, "status").startswith(b"Name:")


def test_a_line_is_as_long_as_allowed_and_no_longer() -> None:
    assert list(lines_of(b"\xef\xbb\xbfa\r\nb\rc\n" + b"d" * MAX_LINE, "t")) == ["a", "b", "c", "d" * MAX_LINE]
    with pytest.raises(ProfileError, match=f"line 2 is too long; allowed: text of at most {MAX_LINE} characters"):
        list(lines_of(b"a\n" + b"d" * (MAX_LINE + 1), "t"))


def test_a_lift_table_of_one_endless_cell_is_refused_by_line(tmp_path: Path) -> None:
    text = (PROFILES / "disc_offset_roller.toml").read_text()
    laws = 'law = "table"\nfile = "lift.csv"'
    first = text.index('law = "')
    text = text[:first] + laws + text[text.index("\n", first):]
    (tmp_path / "lift.csv").write_text("angle,lift\n" + "1" * 200_000)
    path = tmp_path / "cam.toml"
    path.write_text(text)
    with pytest.raises(ProfileError, match="line 2 is too long"):
        read(path).setup()


def test_what_is_not_seen_is_shown() -> None:
    shown = visible(HOSTILE)
    assert shown == "a\\x1b[31mred\\x1b[0m\\u202egnp.\\u202c\\u200fb\\rc\\x07"
    names = "Nockenwelle \u4e2d\u6587 \u05d0\u05d1 line\n\tnext"
    assert visible(names) == names
    error = ProfileError([Problem("key", "is wrong", HOSTILE)], HOSTILE)
    assert visible(str(error)).isprintable()


def test_hostile_names_reach_no_terminal_and_no_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (PROFILES / "disc_flat_face.toml").read_text()
    path = tmp_path / f"{HOSTILE}.toml"
    path.write_text(text)
    assert main(["report", str(path), "--out", str(tmp_path / "out"), "--only", "motion"]) == 0
    said = capsys.readouterr()
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for shown in (said.out, said.err, page):
        assert not set(HOSTILE) & set("\x1b\u202e\u200f\x07") & set(shown)
    path.write_text(text + '\n["\\u001b[2J"]\nx = 1\n')
    assert main(["check", str(path)]) == 2
    assert "\x1b" not in capsys.readouterr().err
    with pytest.raises(ProfileError, match="control characters"):
        parse('name = "a\\u200fb"\n' + text.replace("name =", "# name =", 1))


def _camgeom(line: str, **more: object) -> int:
    command = f'exec "{sys.executable}" -m camgeom {line}'
    return subprocess.run(["bash", "-c", command], timeout=120, stdout=subprocess.DEVNULL, **more).returncode


@pytest.mark.parametrize("elsewhere", ["2>&-", "2>/dev/full"])
def test_a_closed_stderr_changes_no_exit_status(elsewhere: str) -> None:
    assert _camgeom(f"check '{PROFILES / 'pin_insertion.toml'}' {elsewhere}") == 0
    assert _camgeom(f"check nowhere.toml {elsewhere}") == 2


def test_a_design_on_stdout_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["design", "disc", "--pressure-angle", "30"]
    assert main(words) == 0
    said = capsys.readouterr()
    assert parse(said.out).kind == "disc"
    assert "findings pass" in said.err
    assert main([*words[:2], str(tmp_path / "cam.toml"), *words[2:]]) == 0
    assert "findings pass" in capsys.readouterr().out
    assert (tmp_path / "cam.toml").read_text() == said.out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["profile"] == said.out


def _drive(speed: float, *keys: str) -> Model:
    text = (PROFILES / "tool_changer.toml").read_text().replace("speed = 120", f"speed = {speed}")
    return Model(parse(text.replace('kind = "indexing"', "\n".join(('kind = "indexing"', *keys)))))


@pytest.mark.parametrize(
    ("sound", "slow", "keys"),
    [(5.0, 0.3, ()), (40.0, 0.3, ("exact_contact = true",)), (120.0, 120.0, ("steps = 4_000_000",)),
     (120.0, 30.0, ("sweep = [20, 30]", "sweep_points = 5000"))],
)  # fmt: skip
def test_a_drive_too_slow_for_its_modes_is_refused_before_it_is_solved(sound, slow, keys) -> None:
    assert _drive(sound, *(key for key in keys if key.startswith("exact"))).indexing.steady.solution.grid.steps > 1000
    before = resource.getrusage(resource.RUSAGE_SELF)
    study = _drive(slow, *keys).indexing
    with pytest.raises(NotConverged, match=r"steps of gauss8 would take about [\d.e+]+ s.*, more than the"):
        getattr(study, "sweep" if study.sweep_speeds is not None else "steady")
    after = resource.getrusage(resource.RUSAGE_SELF)
    assert after.ru_utime - before.ru_utime < 6.0
    assert after.ru_maxrss < 1_500_000


@pytest.mark.parametrize(("seconds", "answered"), [(10.0, True), (1e-4, False)])
def test_a_sweep_spends_no_more_than_it_has(seconds: float, answered: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camgeom.dynamics.linear.response.Purse", lambda _: Purse(seconds))
    found = _drive(120.0, "sweep = [110, 130]", "sweep_points = 3").indexing.sweep
    assert found.answered.tolist() == 3 * [answered]
    assert all("of the sweep are spent" in why for _, why in found.refused)
    assert len(found.refused) == (0 if answered else 3)


@pytest.mark.parametrize(("rate", "lost"), [(0.5, False), (0.89, False), (0.95, True), (1.0, True), (1.3, True)])
def test_passes_that_will_not_settle_are_told_after_a_dozen(rate: float, lost: bool) -> None:
    changes = [rate**k for k in range(12)]
    assert not _hopeless(changes[:11])
    assert _hopeless(changes) == lost


@pytest.mark.parametrize("key", ["exact_contact = false", "exact_contact = true"])
def test_parts_of_a_solution_are_its_whole(key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def figures() -> list[float]:
        drive = _drive(120.0, key).indexing
        peak = drive.steady.peak("load_acceleration")
        return [peak.maximum[0], peak.minimum[0], drive.energy.input[0], *drive.steady.at([1, 2], "load_deviation")[0]]

    whole = figures()
    for module in ("solve", "peaks"):
        monkeypatch.setattr(f"camgeom.dynamics.linear.{module}.AT_ONCE", 100)
    assert figures() == pytest.approx(whole, rel=1e-12)


def test_numbers_beyond_their_range_are_no_bug() -> None:
    for wrong in (lambda: np.float64(1e300) * 1e300, lambda: np.linalg.inv(np.zeros((2, 2))), lambda: math.sqrt(-1.0),
                  lambda: math.exp(1e4), lambda: np.sqrt(np.array([-1.0])), lambda: 1.0 / 0.0):  # fmt: skip
        with pytest.raises(NotConverged, match=r"^gap: the numbers leave .*out of proportion"), within_range("gap"):
            wrong()
    with pytest.raises(ValueError, match="another"), within_range("gap"):
        raise ValueError("another")
    with within_range("gap"):
        assert math.sqrt(4.0) == 2.0


FLAT = """
[cam]
kind = "disc"
base_radius = 68.87
width = 25.15
[follower]
kind = "translating"
face = "flat"
mass = 3.47
face_width = 125.414
[operation]
speed = 101.0
[dynamics]
kind = "follower"
linkage_stiffness = 3490.0
shaft_inertia = 0.00071
shaft_stiffness = {shaft}
[[motion]]
until = 60
to = 30.3
law = "3-4-5"
[[motion]]
until = 170
[[motion]]
until = 360
to = 0
law = "modified-sine"
"""


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("shaft", "status"), [(272.0, "failed"), (272000.0, "made")])
def test_a_cam_shaft_too_soft_for_its_cam_is_said_to_be(shaft: float, status: str) -> None:
    """Its passes grow beyond all numbers: no warning, and what would help."""
    product = compute(Model(parse(FLAT.format(shaft=shaft))), ("dynamics",)).products["dynamics"]
    assert product.status == status
    assert ("does not settle" in product.reason) == (status == "failed")


@pytest.mark.parametrize(("most", "told"), [(40, True), (4000, False)])
def test_a_force_is_sampled_on_so_many_panels_and_no_more(most: int, told: bool) -> None:
    asked = []

    def ringing(theta: Floats) -> Floats:
        asked.append(len(theta))
        return np.sin(400.0 * theta)

    if told:
        with pytest.raises(NotConverged, match=f"and {most} are spent"):
            resolved(ringing, panels([0.0, 2.0 * np.pi]), 1e-6, most=most)
    else:
        found = resolved(ringing, panels([0.0, 2.0 * np.pi]), 1e-6, most=most)
        assert found.tail(ringing(found.theta)[None]).max() <= 1e-6
    assert max(asked) <= most


RINGING = """
[cam]
kind = "parallel-index"
center_distance = 55.692
diameter = 75.86
width = 7.2
gap = 6.723
[follower]
kind = "turret"
stops = 4
pitch_radius = 27.8
inertia = 0.36344
rollers = 8
[roller]
diameter = 9.823
length = 7.313
[operation]
speed = {speed}
[[operation.force]]
from = 130
until = 180
expression = "5000"
[dynamics]
kind = "indexing"
input_stiffness = {shaft}
output_stiffness = {shaft}
cam_inertia = 0.506
turret_inertia = 0.358
load_inertia = 0.00544
[output]
tolerance = 0.1
[[motion]]
until = 70
[[motion]]
until = 260
to = 90
law = "cycloidal"
[[motion]]
until = 360
"""


@pytest.mark.parametrize(("speed", "shaft", "told"), [(36.7, 11200.0, False), (5.0, 112000.0, True)])
def test_a_solved_force_that_rings_all_round_costs_its_duty_alone(speed: float, shaft: float, told: bool) -> None:
    """Its check is not judged, its figures say why, and the response stands."""
    model = Model(parse(RINGING.format(speed=speed, shaft=shaft)))
    result = compute(model, ("dynamics",))
    found = result.data["dynamics"]
    assert found["peak_load_acceleration_rad_s2"] > 0.0
    assert (result.products["dynamics"].status, result.products["dynamics"].exit_status) == ("made", 0)
    verdict = judge(model, ["dynamic-pressure"])
    if told:
        assert "panels do not resolve it" in found["duty"]["failed"]
        assert "panels do not resolve it" in verdict.not_judged[0].reason
    else:
        assert found["duty"]["peak_force_n"] > 0.0
        assert not verdict.not_judged


def test_what_was_not_found_is_not_sought_again(monkeypatch: pytest.MonkeyPatch) -> None:
    study = _drive(0.3).indexing
    with pytest.raises(NotConverged, match="would take about") as first:
        study.steady  # noqa: B018
    monkeypatch.setattr("camgeom.dynamics.indexing.study.periodic_response", None)
    with pytest.raises(NotConverged) as second:
        study.steady  # noqa: B018
    assert str(second.value) == str(first.value)
    assert type(second.value) is type(first.value)


def test_a_lift_table_without_knots_is_fitted() -> None:
    rows = ", ".join(f"[{i}, {30 * (i / 10) ** 2 * (3 - 2 * i / 10)}]" for i in range(11))
    text = starter("cylindrical").replace('law = "modified-sine"', f'law = "table"\nrows = [{rows}]\nknots = COUNT\n#')
    lifts = [parse(text.replace("COUNT", str(n))).setup().program.jet(np.radians([30.0, 60.0]), 0)[0] for n in (0, 1)]
    assert lifts[0] == pytest.approx(lifts[1], abs=2.0)
    assert lifts[0][1] == pytest.approx(15.0, abs=0.1)


@pytest.mark.parametrize(("diameter", "level"), [(19, "pass"), (110, "fail")])
def test_a_rib_whose_rollers_pass_beside_its_foot_fails(diameter: int, level: str) -> None:
    text = starter("cylindrical").replace('form = "groove"', 'form = "rib"\nrib_thickness = 10')
    text = text.replace("diameter = 19", f"diameter = {diameter}").replace("bore = 35", "")
    model = Model(parse(text.replace("groove_depth = 12", "groove_depth = 30")))
    found = judge(model, ["watertight", "interference"])
    assert {finding.level for finding in found.findings} == {level}
    assert not found.not_judged
    if level == "fail":
        assert all("a smaller roller, less groove_depth" in finding.advice for finding in found.findings)


def of_states(name: str, count: int, speed: float, step: float, *stations: float) -> str:
    """A profile with so many operating states of ever higher speed, and further followers at these angles."""
    text = (PROFILES / f"{name}.toml").read_text()
    written = re.search(r"(?m)^speed = ([\d.]+)", text)
    assert written is not None
    text = text.replace(written[0], f"speed = {speed}", 1)
    states = (f'\n[[duty]]\nname = "{i}"\nshare = {1 / count!r}\nspeed = {speed + step * i}\n' for i in range(count))
    return text + "".join(states) + "".join(f"\n[[station]]\nangle = {angle}\n" for angle in stations)


def test_states_of_all_followers_have_a_bound_in_common() -> None:
    angles = 90.0, 180.0, 270.0, 300.0
    assert len(parse(of_states("disc_offset_roller", 51, 100.0, 1.0, *angles)).duty) == 51
    with pytest.raises(ProfileError, match=r"duty: too many states of 5 followers \(found 52\); allowed: at most 51"):
        parse(of_states("disc_offset_roller", 52, 100.0, 1.0, *angles))
    assert len(parse(of_states("disc_offset_roller", 64, 100.0, 1.0, *angles[:3])).duty) == 64


def test_elastic_followers_and_states_are_no_more_than_can_be_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camgeom.model.price.SPENT", 1.7)
    three, four = (Model(parse(of_states("globoidal_drive", count, 300.0, 100.0))) for count in (3, 4))
    assert all(state.dynamic_duties for state in three.states)
    told = r"^\[dynamics\] of 4 followers .* about 1.8 s of one core beside 0.2 s of loads, .* most 3 of"
    with pytest.raises(NotConverged, match=told):
        _ = four.states[0].dynamic_duties
    assert four.turret_duty is not None  # what needs no [dynamics] stands


@pytest.mark.parametrize(("count", "shared"), [(5, True), (6, False)])
def test_the_time_of_a_solver_is_that_of_all_its_states(count: int, shared: bool) -> None:
    """One takes 2.98 s, of 4 s alone and of 16 s in common; none is begun that would make all take longer."""
    model = Model(parse(of_states("globoidal_drive", count, 3.0, 0.01)))
    study = model.states[0].indexing
    assert study is not None
    assert study.accuracy.runs == count
    steps = 2 * 55_114
    if shared:
        refuse_costly(study.system, find("auto"), steps, runs=count)
        return
    with pytest.raises(NotConverged, match=r"2\.98 s .* more than the 2\.67 s .* each of 6 followers and operating"):
        _ = study.steady


@pytest.mark.parametrize(("states", "angles"), [(8, 0), (4, 1), (16, 1)])
def test_what_followers_follow_in_all_states_has_a_bound_in_common(states: int, angles: int) -> None:
    """Pieces of motions and rows of forces, 40 000 at most: a row more of the table is too many. With 4 901 rows and
    256 of them a check did not end in 150 s."""
    text = of_states("disc_offset_roller", states, 100.0, 1.0, *(90.0 for _ in range(angles)))
    head, _, rest = text.partition("[[operation.force]]")
    assert rest
    rest = rest[rest.index("[material") :]
    pieces = len(parse(text).setup().program.knots) - 1
    most = (40_000 // (states * (1 + angles))) - pieces
    for count, refused in ((most, False), (most + 1, True)):
        table = [[360.0 * k / count, 100.0] for k in range(count)]
        force = f"[[operation.force]]\ntable = {table}\n"
        if not refused:
            assert len(parse(head + force + rest).duty) == states
            continue
        with pytest.raises(ProfileError, match=r"duty: too many pieces .* \(found 40\d{3}\); allowed: at most 40000"):
            parse(head + force + rest)


@pytest.mark.parametrize(("states", "refused"), [(2, False), (3, True)])
def test_what_a_turret_follows_counts_seven_times(states: int, refused: bool) -> None:
    """Seven states of 4 900 rows with [dynamics] held 5 GB, two took 86 s."""
    data = read_data(PROFILES / "tool_changer.toml")
    table = tuple((360.0 * k / 2400, 1.0) for k in range(2400))
    data["operation"] = {**data["operation"], "force": ({"table": table},)}
    speed = data["operation"]["speed"]
    data["duty"] = tuple({"share": 1.0 / states, "speed": speed - number} for number in range(states))
    if not refused:
        assert len(from_data(data).duty) == states
        return
    with pytest.raises(ProfileError, match=r"duty: too many pieces .* allowed: at most 5714"):
        from_data(data)


def test_what_several_tracks_follow_is_told_of_the_tracks() -> None:
    """Without [[duty]] there is none to blame: five tracks with a table of 8 500 rows each."""
    data = read_data(PROFILES / "two_groove_drum.toml")
    table = tuple((360.0 * k / 8500, 100.0) for k in range(8500))
    data["operation"] = {**data["operation"], "force": ({"table": table},)}
    (track,) = data["track"]
    assert len(from_data(data).tracks) == 1
    many = tuple({**track, "angle": 60.0 * k} for k in range(1, 5))
    with pytest.raises(ProfileError, match=r"track: too many pieces .* allowed: at most 40000"):
        from_data({**data, "track": many})


@pytest.mark.parametrize(
    ("name", "most"),
    [("fine_indexer", 1_200), ("parallel_index", 1_500), ("linear_groove", 6_500), ("pin_insertion", 3_000),
     ("conical_guide", 2_000), ("end_face_lifter", 5_000), ("disc_flat_face", 5_000)],
)
@pytest.mark.parametrize("more", [0, 1])
def test_a_motion_has_no_more_pieces_than_its_cam_is_made_of(
    name: str, most: int, more: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A globoid of 2 000 segments took 3.6 GB, a cone of 9 800 pieces 14 GB, parallel plates of 1 500 did not end."""
    data = read_data(PROFILES / f"{name}.toml")
    profile = from_data(data)
    assert most == profile.cam.MOST_PIECES
    monkeypatch.setattr(type(profile.cam), "MOST_PIECES", profile._pieces - more)
    if not more:
        assert from_data(data) == profile
        return
    with pytest.raises(ProfileError, match=rf"motion: too many pieces .* \(found {profile._pieces}\); allowed"):
        from_data(data)


@pytest.mark.parametrize("more", [0, 1])
def test_a_step_file_has_a_bound_of_pieces(more: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """That of a drum with 4 000 took 73 s, of a barrel with 750 three minutes."""
    model = camgeom.read(PROFILES / "disc_flat_face.toml")
    monkeypatch.setattr(type(model.profile.cam), "MOST_STEPPED", model.profile.pieces - more)
    if more:
        told = f"of {model.profile.pieces} pieces .*: at most {model.profile.pieces - 1} "
        with pytest.raises(NotConverged, match=told):
            camgeom.write(model, tmp_path / "cam.step")
        assert not list(tmp_path.iterdir())
        return
    assert camgeom.write(model, tmp_path / "cam.step")


def test_pieces_of_all_tracks_count_together() -> None:
    data = read_data(PROFILES / "two_groove_drum.toml")
    (track,) = data["track"]
    law = {"law": "cycloidal"}
    motion = tuple({"until": 360.0 * (k + 1) / 900, "to": 0.001 * (k % 2 == 0), **law} for k in range(900))
    shared = {**data, "motion": motion, "track": ({"angle": 180.0},) if "motion" not in track else (track,)}
    assert from_data({**shared, "track": ({"angle": 180.0},)})._pieces == 900
    many = tuple({"angle": 60.0 * k} for k in range(1, 5))
    with pytest.raises(ProfileError, match=r"motion: too many pieces .*, of all tracks \(found 4500\).*at most 3000"):
        from_data({**shared, "track": many})


@pytest.mark.parametrize(("most", "told"), [(1.0, False), (0.99, True)])
def test_results_are_found_at_so_many_vertices_at_most(
    most: float, told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both discs of a pair at 1e-6 mm had 4 000 000, which took 40 s of a processor (seed 1391402)."""
    model, path = Model(read(PROFILES / "conjugate_rocker.toml")), tmp_path / "cam.vtu"
    write(model, path)
    count = int(path.read_bytes().split(b'NumberOfPoints="')[1].split(b'"')[0])
    monkeypatch.setattr("camgeom.report.files.MOST_COLOURED", int(most * count))
    if not told:
        write(model, path)
        return
    with pytest.raises(NotConverged, match=f"found at {count} vertices, more than .* a coarser tolerance"):
        write(model, path)
