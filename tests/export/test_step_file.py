"""Part 21 text: escapes, numbers, determinism, structure; and the writers of a model."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from camgeom.errors import ExportError
from camgeom.export import format_of
from camgeom.export.step import Assembly, Brep, FacetBody, step_text, write_step
from camgeom.export.step.brep import Placed
from camgeom.export.step.geometry import Frame
from camgeom.export.step.groove import grooved_solid
from camgeom.export.step.solids import bore_curve, circle_curve, prism_solid
from camgeom.export.step.text import real, string
from tests.export.step_bodies import drum


def disc(name: str = "disc") -> Brep:
    return prism_solid(circle_curve(30.0, name="rim"), 0.0, 10.0, [bore_curve(20.0)], name=name)


def unescaped(literal: str) -> str:
    """Read a Part 21 string back, the way the standard defines it."""
    body = literal[1:-1].replace("''", "'")
    body = re.sub(r"\\X2\\((?:[0-9A-F]{4})+)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-16-be"), body)
    body = re.sub(r"\\X4\\((?:[0-9A-F]{8})+)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-32-be"), body)
    return body.replace("\\\\", "\\")


@given(st.text(st.characters(codec="utf-8", exclude_characters="\\")))
def test_any_name_survives_the_escapes(text: str) -> None:
    literal = string(text)
    assert literal.isascii()
    assert literal.isprintable()
    assert unescaped(literal) == text


def test_known_escapes() -> None:
    assert string("") == "''"
    assert string("it's a \\") == "'it''s a \\\\'"
    assert string("Nut Ø22 \U0001f600") == r"'Nut \X2\00D8\X0\22 \X4\0001F600\X0\'"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_reals_are_step_literals_and_read_back_as_the_same_double(value: float) -> None:
    text = real(value)
    assert re.fullmatch(r"-?\d+\.\d*(E[+-]?\d+)?", text)
    assert float(text) == value


def test_every_reference_points_backwards_to_an_instance() -> None:
    lines = step_text(grooved_solid(drum(), 1e-3)).split("DATA;\n")[1].split("ENDSEC;")[0].splitlines()
    for number, line in enumerate(lines, 1):
        head, body = line.split("=", 1)
        assert head == f"#{number}"
        assert all(int(found) < number for found in re.findall(r"#(\d+)", re.sub(r"'(?:''|[^'])*'", "", body)))


def test_same_shape_gives_the_same_bytes() -> None:
    assert step_text(grooved_solid(drum(), 1e-4)) == step_text(grooved_solid(drum(), 1e-4))


@pytest.mark.parametrize(("schema", "says"), [("AP242", "442"), ("AP214", "AUTOMOTIVE_DESIGN")])
def test_header_names_the_schema(schema: str, says: str) -> None:
    text = step_text(disc(), schema)  # type: ignore[arg-type]
    assert says in text.split("ENDSEC;")[0]
    assert text.startswith("ISO-10303-21;\n")
    assert text.endswith("END-ISO-10303-21;\n")
    assert "LENGTH_MEASURE(1.E-07)" in text


def test_triangles_need_ap242() -> None:
    mesh = drum().solid(0.5).mesh
    assert "TRIANGULATED_FACE('flank'" in step_text(FacetBody("cam", mesh))
    with pytest.raises(ExportError, match="AP242"):
        step_text(FacetBody("cam", mesh), "AP214")


def test_a_body_placed_twice_is_written_once() -> None:
    body = disc()
    far = Frame((0.0, 0.0, 50.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    text = step_text(Assembly("pair", (Placed(body, name="low"), Placed(body, far, "high"))))
    assert text.count("MANIFOLD_SOLID_BREP") == 1
    assert text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE") == 2


def test_groove_cam_file_is_small() -> None:
    assert len(step_text(grooved_solid(drum()))) < 1_000_000


def test_a_failed_write_leaves_the_earlier_file(tmp_path: Path) -> None:
    target = tmp_path / "cam.step"
    size = write_step(target, disc())
    assert target.stat().st_size == size
    with pytest.raises(ExportError):
        write_step(target, FacetBody("cam", drum().solid(0.5).mesh), "AP214")
    assert target.stat().st_size == size
    assert list(tmp_path.iterdir()) == [target]


def test_both_extensions_are_registered() -> None:
    assert format_of("cam.step").takes == format_of("cam.stp").takes == "model"


def test_points_are_rounded_below_any_uncertainty() -> None:
    text = step_text(disc())
    assert not re.search(r"CARTESIAN_POINT\('',\([^)]*E", text)
