"""Electronic cams: rows on the exact motion, the stated error measured by another evaluation, PLCopen XML read back."""

from __future__ import annotations

import csv
import re
from math import degrees, pi
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from camgeom.errors import ExportError
from camgeom.export import write
from camgeom.export.ecam import Interpolation, master_tables, quintic, straight
from camgeom.model import Model, read
from camgeom.profile import parse
from tests.places import PROFILES
from tests.reference.planar_machines import disc

SPACE = {"p": "http://www.plcopen.org/xml/tc6_0200", "h": "http://www.w3.org/1999/xhtml"}


def model(name: str, output: str = "") -> Model:
    text = (PROFILES / f"{name}.toml").read_text()
    return Model(parse(text.replace("[output]\n", f"[output]\n{output}\n")))


def csv_rows(path: Path) -> tuple[list[str], np.ndarray]:
    with path.open() as file:
        heads, *rows = csv.reader(file)
    return heads, np.array(rows, dtype=float)


@pytest.mark.parametrize("points", [3, 361, 1000])
def test_rows_are_the_motion(tmp_path: Path, points: int) -> None:
    made = model("disc_offset_roller", f"table_points = {points}")
    write(made, tmp_path / "a.ecam.csv")
    heads, rows = csv_rows(tmp_path / "a.ecam.csv")
    assert heads[:3] == ["master_deg", "position_mm", "velocity_mm_per_deg"]
    assert len(rows) == points
    assert rows[0, 0] == 0.0
    assert rows[-1, 0] == pytest.approx(360.0)
    jet = made.setup.program.jet(np.radians(rows[:, 0]), 1)
    assert rows[:, 1] == pytest.approx(jet[0], abs=1e-12)
    assert rows[1:-1, 2] == pytest.approx(jet[1, 1:-1] * pi / 180.0, abs=1e-12)
    pace = 6.0 * made.profile.operation.speed
    assert rows[:, heads.index("velocity_mm_per_s")] == pytest.approx(rows[:, 2] * pace)
    assert rows[:, heads.index("jerk_mm_per_s3")] == pytest.approx(rows[:, 4] * pace**3)


@pytest.mark.parametrize("tolerance", [0.1, 1e-3, 1e-5])
@pytest.mark.parametrize("name", ["pin_insertion", "tool_changer"])
def test_a_tolerance_chooses_the_points(tmp_path: Path, name: str, tolerance: float) -> None:
    made = model(name, f"table_tolerance = {tolerance}")
    write(made, tmp_path / "a.ecam.csv")
    _, rows = csv_rows(tmp_path / "a.ecam.csv")
    assert np.all(np.diff(rows[:, 0]) > 0.0)
    theta = np.linspace(0.0, 2.0 * pi, 100_001)
    unit = degrees(1.0) if made.profile.rotating else 1.0
    error = np.abs(np.interp(np.degrees(theta), rows[:, 0], rows[:, 1]) - unit * made.setup.program.jet(theta, 0)[0])
    assert 0.4 * tolerance < error.max() <= 1.001 * tolerance
    fewer = np.delete(rows, len(rows) // 3, axis=0)
    error = np.interp(np.degrees(theta), fewer[:, 0], fewer[:, 1]) - unit * made.setup.program.jet(theta, 0)[0]
    assert np.abs(error).max() > tolerance


@pytest.mark.parametrize("output", ["table_points = 181", "table_tolerance = 1e-3"])
def test_every_follower_has_a_table_over_the_cam_s_angle(tmp_path: Path, output: str) -> None:
    """Two grooves, the second follower a quarter of a turn later; a quintic and straight lines both keep the tolerance.
    """
    made = model("two_groove_drum", output)
    write(made, tmp_path / "a.ecam.csv")
    heads, rows = csv_rows(tmp_path / "a.ecam.csv")
    write(made, tmp_path / "a.plcopen.xml")
    root = ET.parse(tmp_path / "a.plcopen.xml").getroot()
    theta = np.linspace(0.0, 2.0 * pi, 20_001)
    second = made.bindings[1]
    assert degrees(second.angle) == 90.0
    for one, column, points in ((made, "position_mm", "Points"), (second, "follower_2.position_mm", "Points_2")):
        shown = np.interp(np.degrees(theta), rows[:, 0], rows[:, heads.index(column)])
        wanted = one.setup.program.jet((theta - one.angle) % (2.0 * pi), 0)[0]
        at_rows = one.setup.program.jet(np.radians(rows[:, 0]) - one.angle, 1)
        assert rows[:, heads.index(column)] == pytest.approx(at_rows[0], abs=1e-12)
        held = root.find(f".//p:variable[@name='{points}']/p:initialValue/p:arrayValue", SPACE)
        table = np.array([[float(v[0].get("value")) for v in row[0]] for row in held])
        assert polynomial(table, np.degrees(theta)) == pytest.approx(wanted, abs=1.01e-3)
        if "tolerance" in output:
            assert np.abs(shown - wanted).max() <= 1.001e-3
    speed = 6.0 * made.profile.operation.speed
    velocity = rows[:, heads.index("follower_2.velocity_mm_per_s")]
    assert velocity == pytest.approx(speed * rows[:, heads.index("follower_2.velocity_mm_per_deg")])
    assert np.abs(velocity).max() == pytest.approx(648.0, rel=1e-3)
    assert "Follower 2: " in root.find(".//p:documentation/h:p", SPACE).text


@pytest.mark.parametrize("interpolation", [straight, quintic])
@pytest.mark.parametrize("output", ["table_tolerance = 1e-3", "table_tolerance = 1.16e-4", "table_points = 25"])
def test_the_stated_error_is_the_largest(output: str, interpolation: Interpolation) -> None:
    """Few rows on a law of three sines: the error between two of them has its peak away from the shares of a sample.
    """
    text = (PROFILES / "disc_offset_roller.toml").read_text().replace("modified-sine", "triple-harmonic")
    made = Model(parse(text.replace("[output]\n", f"[output]\n{output}\n")))
    (table,) = master_tables(made.bindings, interpolation)
    theta = np.linspace(0.0, 2.0 * pi, 400_001)
    if interpolation is straight:
        replayed = np.interp(np.degrees(theta), table.master, table.jet[0])
    else:
        replayed = polynomial(np.stack([table.master, *table.jet[:3]], axis=1), np.degrees(theta))
    largest = np.abs(replayed - made.setup.program.jet(theta, 0)[0]).max()
    assert largest <= 1.000001 * table.error + 1e-13
    assert largest >= 0.999 * table.error
    if made.profile.output.table_tolerance is not None:
        assert largest <= 1.000001 * made.profile.output.table_tolerance


def test_a_turret_gains_its_index_every_turn() -> None:
    made = model("tool_changer")
    (table,) = master_tables(made.bindings, straight)
    assert table.unit == "deg"
    assert table.advance == pytest.approx(360.0 / made.setup.follower.stops)
    assert table.jet[0, -1] - table.jet[0, 0] == pytest.approx(table.advance)


def test_a_jump_is_halved() -> None:
    """A parabolic rise: the acceleration jumps at its ends and in its middle."""
    motion = [(90, None, ""), (180, 10, "parabolic"), (270, None, ""), (360, 0, "parabolic")]
    made = disc(motion=motion, rest="[output]\ntable_points = 9")
    (table,) = master_tables(made.bindings, quintic)
    top = 4.0 * 10.0 / 90.0**2
    assert table.master[[2, 3, 4]] == pytest.approx([90.0, 135.0, 180.0])
    assert table.jet[2, [2, 3, 4]] == pytest.approx([0.5 * top, 0.0, -0.5 * top])


def polynomial(table: np.ndarray, master: np.ndarray) -> np.ndarray:
    """Positions between rows (x, y, v, a) by scipy's own Hermite polynomials."""
    from scipy.interpolate import BPoly

    return BPoly.from_derivatives(table[:, 0], table[:, 1:])(master)


@pytest.mark.parametrize("name", ["pin_insertion", "conjugate_rocker", "two_start", "constant_width_press"])
def test_plcopen_is_read_back(tmp_path: Path, name: str) -> None:
    made = model(name, "table_tolerance = 1e-4")
    write(made, tmp_path / "a.plcopen.xml")
    root = ET.parse(tmp_path / "a.plcopen.xml").getroot()
    assert root.tag == f"{{{SPACE['p']}}}project"
    assert [child.tag.partition("}")[2] for child in root] == ["fileHeader", "contentHeader", "types", "instances"]
    pou = root.find("p:types/p:pous/p:pou", SPACE)
    variables = {v.get("name"): v for v in pou.iterfind("p:interface/p:localVars/p:variable", SPACE)}
    rows = []
    for value in variables["Points"].iterfind("p:initialValue/p:arrayValue/p:value/p:structValue", SPACE):
        fields = {v.get("member"): v.find("p:simpleValue", SPACE).get("value") for v in value}
        assert all(re.fullmatch(r"-?\d+\.\d+(e[+-]?\d+)?", text) for text in fields.values())
        rows.append([float(fields[key]) for key in ("dX", "dY", "dV", "dA")])
    rows = np.array(rows)
    head = {v.get("member"): v[0].get("value") for v in variables["Cam"].find("p:initialValue/p:structValue", SPACE)}
    assert int(head["nElements"]) == len(rows)
    assert (float(head["xStart"]), float(head["xEnd"]), head["byType"]) == (0.0, pytest.approx(360.0), "3")
    dimension = variables["Points"].find("p:type/p:array/p:dimension", SPACE)
    assert (dimension.get("lower"), dimension.get("upper")) == ("0", str(len(rows) - 1))
    kind = variables["Points"].find("p:type/p:array/p:baseType/p:derived", SPACE).get("name")
    assert kind in {d.get("name") for d in root.iterfind("p:types/p:dataTypes/p:dataType", SPACE)}
    theta = np.linspace(0.0, 2.0 * pi, 20_001)
    unit = degrees(1.0) if made.profile.rotating else 1.0
    error = np.abs(polynomial(rows, np.degrees(theta)) - unit * made.setup.program.jet(theta, 0)[0]).max()
    words = pou.find("p:documentation/h:p", SPACE).text
    stated = float(re.search(r"within (\S+) ", words)[1])
    assert error <= 1.02 * stated + 1e-9
    assert error <= 1.01e-4


def test_a_tolerance_out_of_reach_is_refused_and_the_old_file_stands(tmp_path: Path) -> None:
    path = tmp_path / "a.ecam.csv"
    path.write_text("old")
    made = read(str(PROFILES / "pin_insertion.toml"))
    output = made.profile.output.model_copy(update={"table_tolerance": 1e-15})
    profile = made.profile.model_copy(update={"output": output})
    with pytest.raises(ExportError, match=r"a\.ecam\.csv: an electronic cam within 1e-15"):
        write(Model(profile), path)
    assert path.read_text() == "old"


def test_the_quintic_is_exact_for_a_quintic() -> None:
    share = np.linspace(0.0, 1.0, 9)
    poly = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0, 0.25])

    def jet(x: float) -> np.ndarray:
        return np.array([[poly(x)], [poly.deriv()(x)], [poly.deriv(2)(x)], [0.0]])

    made = quintic(share, np.array([1.4]), jet(0.3), jet(1.7))[0]
    assert made == pytest.approx(poly(0.3 + 1.4 * share), abs=1e-13)
