"""Laws from a user's own file: known everywhere once a command names it, refused where they are not what they say."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from math import comb, pi, sin
from pathlib import Path

import pytest

import camgeom
from camgeom.cli import main
from camgeom.design.engine import Local
from camgeom.design.study import Study, axis
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.motion import LAWS, Program, Segment, make
from camgeom.motion.claims import TRUE_TO, guarded
from camgeom.motion.law import Ends, finish
from camgeom.motion.own import load_laws, loaded_files
from camgeom.motion.table import Piece
from camgeom.profile import read_data
from tests.places import PROFILES, ROOT

PIN = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")
HEAD = "from math import inf, sqrt\nfrom camgeom import Claims, Parameter, Piece, law\n"
CLAIMS = {"vm": 1.5, "am": 6.0, "jm": "inf", "vam": 2 * 3**0.5, "arms": 2 * 3**0.5, "order_start": 1, "order_end": 1}


@pytest.fixture(autouse=True)
def catalogue() -> Iterator[None]:
    """The catalogue as it was, after each test."""
    from camgeom.motion import own

    before = dict(LAWS)
    yield
    LAWS.entered.clear()
    LAWS.entered.update(before)
    own._loaded.clear()


ONE_PIECE = "[Piece(0.0, 1.0, 0.0, (0.0, 0.0, 3.0, -2.0))]"


def cubic(name: str = "our-cubic", body: str = ONE_PIECE, **claims: object) -> str:
    """A file with one law, and its claims where they differ from the cubic's."""
    said = ", ".join(f"{key}={value}" for key, value in {**CLAIMS, **claims}.items())
    decorator = f'@law("{name}", source="by hand", claims=Claims({said}))'
    return f'{HEAD}{decorator}\ndef f():\n    """A cubic."""\n    return {body}\n'


def written(folder: Path, text: str, name: str = "laws.py") -> str:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def light(model: Model) -> tuple[dict[str, float | int | bool | str | None], str, str]:
    return {"peak": model.setup.program.peak(1).value}, "pass", ""


def test_the_law_of_the_readme_is_known_once_its_file_is_read(tmp_path: Path) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```python\n# my_laws.py\n(.*?)```", readme, re.DOTALL)
    assert load_laws(written(tmp_path, text)) == ("our-power",)
    assert make("our-power", power=4).peaks().vm == pytest.approx(16.0 / 9.0, rel=1e-12)
    program = Program.from_segments([Segment(3.0, 10.0, "our-power"), Segment(6.0, 0.0, "3-4-5"), Segment(2 * pi)])
    assert program.peak(1).value == pytest.approx(-10.0 * 1.875 / 3.0)
    assert program.jet(1.5, 0)[0] == pytest.approx(5.0)


def test_every_command_that_reads_a_profile_takes_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    laws = ["--laws", written(tmp_path, cubic())]
    Path("own.toml").write_text(re.sub(r'law = "[^"]*"', 'law = "our-cubic"', PIN), encoding="utf-8")
    assert main(["check", "own.toml"]) == 2
    assert "our-cubic" in capsys.readouterr().err
    assert main(["solve", "own.toml", "--json", "--only", "motion", *laws]) == 0
    assert json.loads(capsys.readouterr().out)["motion"]["continuity"] == 1
    assert main(["laws", "--json", *laws]) == 0
    assert {"our-cubic", "cycloidal"} <= {row["name"] for row in json.loads(capsys.readouterr().out)}
    assert main(["schema", *laws]) == 0
    assert "our-cubic" in capsys.readouterr().out
    for command in (["build"], ["run"], ["report"], ["study", "--vary", "cam.diameter=1,2"], ["inspect", "points.csv"]):
        assert main([command[0], "missing.toml", *command[1:], *laws]) == 2
        assert "missing.toml" in capsys.readouterr().err


def test_worker_processes_know_the_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.design import study as study_module

    monkeypatch.setattr(study_module, "ALONE_FOR", 0.0)
    load_laws(written(tmp_path, cubic()))
    assert loaded_files() == (str(tmp_path / "laws.py"),)
    Path(tmp_path / "own.toml").write_text(re.sub(r'law = "[^"]*"', 'law = "our-cubic"', PIN), encoding="utf-8")
    study = Study(read_data(tmp_path / "own.toml"), "", (axis("operation.speed=100:200:5"),), light)
    rows = list(study.rows(Local(2)))
    assert [row.verdict for row in rows] == ["pass"] * 5
    assert len({row.figures["peak"] for row in rows}) == 1


@pytest.mark.parametrize("key", ["vm", "am", "vam", "arms"])
def test_a_claim_holds_to_its_rounding_and_no_further(tmp_path: Path, key: str) -> None:
    value = float(CLAIMS[key])
    load_laws(written(tmp_path, cubic(**{key: value * (1.0 + 0.99 * TRUE_TO)})))
    assert LAWS["our-cubic"].claims.order == 1
    with pytest.raises(ProfileError, match=rf"{key}: the claim does not hold"):
        load_laws(written(tmp_path, cubic(**{key: value * (1.0 + 1.02 * TRUE_TO)})))
    # A refused file leaves what was known before it.
    assert LAWS["our-cubic"].claims.vm == pytest.approx(1.5, rel=2 * TRUE_TO)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (cubic(order_start=2), "order_start: the claim does not hold (found 2); allowed: 1 as measured"),
        (cubic(jm="60.0"), "jm: the claim does not hold"),
        (cubic("cycloidal"), "two laws are called 'cycloidal'"),
        (cubic(body="[Piece(0.0, 1.0, 0.0, (0.0, 0.0, 3.0))]"), "not from 0 to 1"),
        (cubic(body="[Piece(0.0, 0.5, 0.0, (0.0, 1.0)), Piece(0.6, 1.0, 0.0, (0.0, 1.0))]"), "do not follow on one"),
        (cubic(body="[Piece(0.0, 0.5, 0.0, (0.0, 1.0)), Piece(0.5, 1.0, 1.0, (1.0, 2.0))]"), "lift jumps"),
        (cubic(body="None"), "does not give a motion (TypeError"),
        (cubic().replace("claims=", "joins=True, claims="), "needs the parameter `order`"),
        ("x = (", "line 1: is not Python"),
        ("import no_such_module_at_all", "line 1: ModuleNotFoundError"),
        ("raise SystemExit(0)", "line 1: SystemExit"),
        ("x = 1", "enters no law"),
        ("raise GeneratorExit", "line 1: GeneratorExit"),
        ("class Own(BaseException): pass\nraise Own(7)", "line 2: Own: 7"),
        ("class Own(Exception):\n    def __str__(self): return 1 / 0\nraise Own", "line 3: Own: its own text fails"),
        ("\0", "null bytes"),
    ],
)
def test_a_file_that_is_wrong_says_how(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str
) -> None:
    before = list(LAWS)
    path = written(tmp_path, text)
    assert main(["laws", "--laws", path]) == 2
    message = capsys.readouterr().err
    assert said in message
    assert path in message
    assert "Traceback" not in message
    assert list(LAWS) == before


def test_a_missing_file_is_one_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, why in (("missing.py", "there is no such file"), (".", "is a folder")):
        assert main(["laws", "--laws", str(tmp_path / name)]) == 2
        assert why in capsys.readouterr().err


def test_reading_a_file_again_changes_nothing_and_a_changed_one_counts(tmp_path: Path) -> None:
    path = written(tmp_path, cubic())
    load_laws(path)
    entry = LAWS["our-cubic"]
    load_laws(path)
    assert LAWS["our-cubic"] is entry
    written(tmp_path, cubic("our-other"))
    assert load_laws(path) == ("our-other",)
    assert "our-cubic" not in LAWS


def test_a_joining_law_takes_over_what_moves_beside_it(tmp_path: Path) -> None:
    honest = "LAWS['polynomial'].factory(ends, order)"
    text = HEAD + (
        "from camgeom import LAWS\n"
        "@law('our-join', source='by hand', claims=LAWS['polynomial'].claims, joins=True, "
        "order=Parameter(2, 1, 3, 'derivatives', 'integer'))\n"
        f"def join(ends, order):\n    return {honest}\n"
    )
    assert load_laws(written(tmp_path, text)) == ("our-join",)
    text = text.replace("our-join", "our-other")
    resting = text.replace(honest, "[p.scaled(ends.lift) for p in LAWS['3-4-5'].make({}).pieces]")
    with pytest.raises(ProfileError, match="does not take over derivative 1 at its start"):
        load_laws(written(tmp_path, resting, "resting.py"))


def test_what_a_law_gives_is_taken_as_plain_numbers(tmp_path: Path) -> None:
    """Rows, whole numbers, and waves of negative frequency or none, whose peaks were sought in too few places."""
    cycloidal = "[Piece(0, 1, 0, [0, 1], [(-2 * pi, 0.0, 1 / (2 * pi)), (0, 5, 7)])]"
    text = f"from math import pi\n{cubic(body=cycloidal, vm=2.0, am=2 * pi, jm='inf')}"
    text = re.sub(r"claims=Claims.*?\)\)", "claims=LAWS['cycloidal'].claims)", text)
    load_laws(written(tmp_path, f"from camgeom import LAWS\n{text}"))
    many = ONE_PIECE.replace("))", "), ((6.28 * 500, 0.0, 0.0),))")  # 499.7 periods
    load_laws(written(tmp_path, cubic("our-waves", many), "more.py"))
    at = [0.1, 0.25, 0.7]
    assert make("our-cubic").jet(at, 3) == pytest.approx(make("cycloidal").jet(at, 3), rel=1e-12)


def kept(jump: float, order: int) -> str:
    """Two halves that meet with speeds of 1.5 and 1.5 + jump; the second says how many derivatives are kept."""
    second = f"(.5, {1.5 + jump!r}, {-4.0 * jump!r}, {-2.0 + 4.0 * jump!r})"
    return f"[Piece(0., .5, 0., (0., 0., 3., -2.)), Piece(.5, 1., .5, {second}, (), {order})]"


@pytest.mark.parametrize(("jump", "order", "refused"), [(1e-5, 1, True), (1e-5, 0, False), (1e-7, 3, False)])
def test_what_a_piece_says_of_itself_hides_no_jump(tmp_path: Path, jump: float, order: int, refused: bool) -> None:
    """A piece that said it keeps nine derivatives made a motion with a jump of the velocity pass."""
    text = cubic(body=kept(jump, order))
    if refused:
        with pytest.raises(ProfileError, match=r"derivative 1 jumps at 0\.5, where a piece says that it is kept"):
            load_laws(written(tmp_path, text))
        return
    if order:
        load_laws(written(tmp_path, text))
        return
    with pytest.raises(ProfileError, match="order_inside: the claim does not hold"):
        load_laws(written(tmp_path, text))


START_JUMPS = "vm=16/9, am=12.0, jm=inf, vam=7.53876995, arms=4.38178046, order_start=1, order_end=2"


def test_what_the_first_piece_keeps_is_none_of_its_law_s(tmp_path: Path) -> None:
    """6 x2 - 8 x3 + 3 x4, whose acceleration begins at 12: it said that it keeps that of what is before it, and the
    check of continuity passed."""
    text = f"""{HEAD}
@law("starts-hard", source="by hand", claims=Claims({START_JUMPS}))
def starts():
    return [Piece(0.0, 1.0, 0.0, (0.0, 0.0, 6.0, -8.0, 3.0), (), 9)]
"""
    load_laws(written(tmp_path, text))
    data = read_data(PROFILES / "disc_offset_roller.toml")
    found = camgeom.read({**data, "motion": [{**one, "law": "starts-hard"} if "to" in one else one
                                             for one in data["motion"]]})  # fmt: skip
    assert found.setup.program.continuity.order == 1
    assert {jump.order for jump in found.setup.program.continuity.jumps} >= {2}


@pytest.mark.parametrize(("size", "refused"), [(0.0, False), (0.003, False), (20.0, False), (2e3, True), (4e5, True)])
def test_terms_that_cancel_hide_no_jump(tmp_path: Path, size: float, refused: bool) -> None:
    """Simple harmonic motion with two waves that cancel each other: its jumps were below what the sum of their sizes
    may round to, and it passed as smooth."""
    hide = f"((2513.27, {size}, 0.0), (2513.27, -{size}, 0.0))"
    order = 1 if not refused else 9
    text = f"""{HEAD}
from math import pi
@law("harmonic", source="by hand", claims=Claims(pi/2, pi**2/2, inf, pi**3/8, pi**2/2/sqrt(2), {order}, {order}))
def harmonic():
    return [Piece(0.0, 0.5, 0.0, (0.0,), ((pi, -0.5, 0.0), *{hide})),
            Piece(0.5, 1.0, 1.0, (1.0,), ((pi, 0.5, 0.0), *{hide}))]
"""
    if refused:
        with pytest.raises(ProfileError, match=r"hidden by terms that cancel each other|too few digits"):
            load_laws(written(tmp_path, text))
        return
    load_laws(written(tmp_path, text))


@pytest.mark.parametrize(("order", "refused"), [(8, False), (10, False), (25, True)])
def test_a_power_law_of_many_digits_is_known(order: int, refused: bool) -> None:
    """The smoothest power law of a degree, in one piece: its terms cancel, and leave digits up to a degree."""
    powers = [0.0] * (order + 1)
    powers += [(-1) ** k * comb(order + k, k) * comb(2 * order + 1, order - k) for k in range(order + 1)]
    piece = Piece(0.0, 1.0, 0.0, tuple(map(float, powers)))
    if refused:
        with pytest.raises(ProfileError, match="too few digits of derivative"):
            guarded("own", lambda: [piece])
        return
    assert guarded("own", lambda: [piece])


@pytest.mark.parametrize(("width", "told"), [(1e-10, True), (0.9e-6, True), (1.1e-6, False)])
@pytest.mark.parametrize("order", [0, 1])
def test_a_jump_within_less_than_is_looked_at_is_told(width: float, told: bool, order: int) -> None:
    """A velocity that came within 1e-10 of the travel passed as continuous, and pressed nothing."""

    def pieces() -> list[Piece]:
        if order == 0:  # a hundredth of the lift in a step of a half sine
            at, wave = 0.3, (pi / width, -0.005, 0.0)
            return [Piece(0.0, at, 0.0, (0.0, 0.99)), Piece(at, at + width, at, (0.297, 0.99), (wave,)),
                    Piece(at + width, 1.0, at + width, (0.307 + 0.99 * width, 0.99))]  # fmt: skip
        speed = 1.0 / (1.0 - width)
        first = Piece(0.0, width, 0.0, (0.0, 0.0, 0.5 * speed / width))
        return [first, Piece(width, 1.0 - width, width, (first.value(width), speed)), first.mirrored()]

    if told:
        with pytest.raises(ProfileError, match=rf"its (lift|velocity) changes within {width:.3g} of the travel"):
            guarded("narrow", pieces)
    else:
        assert guarded("narrow", pieces)


def test_many_small_steps_are_a_jump() -> None:
    """Velocity rises from 0.5 to 3.5 within 8e-9 of the travel, in pieces that say it is kept."""
    count, width, at = 2000, 4e-12, 0.5
    pieces, lift, speed = [Piece(0.0, at, 0.0, (0.0, 0.5))], 0.5 * at, 0.5
    for k in range(count):
        speed += 3.0 / count
        pieces.append(Piece(at + k * width, at + (k + 1) * width, at + k * width, (lift, speed), (), 2))
        lift += speed * width
    end = at + count * width
    rest = (1.0 - lift) / (1.0 - end)
    pieces.append(Piece(end, 1.0, end, (lift, speed, (rest - speed) / (1.0 - end)), (), 1))
    with pytest.raises(ProfileError, match=r"derivative 1 (changes in steps|jumps)"):
        guarded("own", lambda: pieces)


def test_a_law_s_helper_makes_another_design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of the motion before stood beside those of the new one as of the same design."""
    import sys

    from camgeom.motion import own

    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    text = f"{HEAD}import helper_of_a_law\n" + cubic(body="helper_of_a_law.pieces()").removeprefix(HEAD)
    digests = []
    for more in ("0.", "1e-14"):
        pieces = f"[Piece(0., 1., 0., (0., 0., 3. + {more}, -2. - {more}))]"
        helper = f"from camgeom import Piece\ndef pieces():\n    return {pieces}\n"
        (tmp_path / "helper_of_a_law.py").write_text(helper)
        sys.modules.pop("helper_of_a_law", None)
        LAWS.entered.pop("our-cubic", None)
        own._loaded.clear()
        load_laws(written(tmp_path, text))
        data = read_data(PROFILES / "disc_offset_roller.toml")
        motion = [{**one, "law": "our-cubic"} if "to" in one else one for one in data["motion"]]
        digests.append(camgeom.read({**data, "motion": motion}).profile.digest())
    assert digests[0] != digests[1]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"our-cubic"', "5", "a law's name is 1 to 60 letters"),
        ('"our-cubic"', '""', "a law's name is 1 to 60 letters"),
        ('"our-cubic"', f'"{"x" * 61}"', "a law's name is 1 to 60 letters"),
        ('source="by hand"', "source=None", "a law has a source, text of at most 500 characters"),
        ("source=", "k=Parameter(9, 1, 5, 'power'), source=", "parameter 'k' has no default of its kind within"),
        (HEAD, f"{HEAD}x = {'-' * 500_000}1\n", "is nested too deeply"),
    ],
)
def test_what_is_said_of_a_law_can_be_shown(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(ProfileError, match=said):
        load_laws(written(tmp_path, cubic().replace(old, new)))


@pytest.mark.parametrize("count", [3, 30, 390])
@pytest.mark.parametrize("wild", [0.0, 0.4])
def test_a_spline_keeps_what_it_says(count: int, wild: float) -> None:
    x = [(k + 1.0) / (count + 1.0) for k in range(count)]
    points = tuple((at, at + wild * sin(9.0 * at * (k % 3))) for k, at in enumerate(x))
    for order in (1, 2, 3):
        pieces = LAWS["spline"].factory(Ends(), points, order)
        found = [piece.kept for piece in guarded("own", lambda given=pieces: given)]
        assert found == [-1, *(piece.kept for piece in finish(pieces)[1:])]


def test_a_parameter_has_no_name_that_every_segment_has(tmp_path: Path) -> None:
    """It could not be given: the lift of the segment was set instead, without a word."""
    from camgeom.motion.catalogue import SEGMENT_KEYS
    from camgeom.profile.errors import keys_of
    from camgeom.profile.sections import MotionSegment

    assert set(keys_of(MotionSegment)) == SEGMENT_KEYS
    text = cubic().replace("source=", "to=Parameter(3, 1, 5, 'power'), source=").replace("f()", "f(to)")
    with pytest.raises(ProfileError, match="a parameter cannot be called 'to'"):
        load_laws(written(tmp_path, text))


def test_a_linear_cam_says_how_many_pieces_are_too_many(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It said that the motion has no series, without a result."""
    body = "[Piece(k / n, (k + 1) / n, 0, (0, 0, 3, -2)) for n in [12000 if many else 1] for k in range(n)]"
    text = cubic(body=body).replace("f()", "f(many)")
    text = text.replace("source=", "many=Parameter(0, 0, 1, 'x', 'integer'), source=")
    file, profile = written(tmp_path, text), tmp_path / "p.toml"
    plate = (PROFILES / "linear_edge.toml").read_text(encoding="utf-8")
    profile.write_text(re.sub(r'law = "[^"]*"', 'law = "our-cubic"\nmany = 1', plate, count=1), encoding="utf-8")
    assert main(["check", str(profile), "--laws", file]) == 2
    assert "pieces over the drive, more than the 20000 that are put together" in capsys.readouterr().err


def test_the_decorator_in_a_program_measures_at_once() -> None:
    with pytest.raises(ProfileError, match="am: the claim does not hold"):
        camgeom.law("our-line", source="by hand", claims=camgeom.Claims(1.5, 7.0, float("inf"), 3.4641, 3.4641, 1, 1))(
            lambda: [camgeom.Piece(0.0, 1.0, 0.0, (0.0, 0.0, 3.0, -2.0))]
        )
    assert "our-line" not in LAWS


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ('if high == 5: raise KeyError("x")', "does not give a motion at high = 5 (KeyError: 'x')"),
        ("if high == 5: raise SystemExit(0)", "SystemExit: 0"),
        ("if high == 5: return []", "it has no pieces"),
        ("if high == 5: return 7", "TypeError"),
        ("if high == 5: return [7]", "7 is no Piece"),
        ("if high == 5: return (Piece(0, 1, 0, (0, 1)) for _ in iter(int, 1))", "more than 20000 pieces"),
        ("if high == 5: return [Piece(0, 1, 0, (0, float('nan')))]", "a number that is none or beyond 1e+30"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 1e308))]", "a number that is none or beyond 1e+30"),
        ("if high == 5: return [Piece(0, 1, 0, ())]", "a piece has no number"),
        ("if high == 5: return [Piece(0, 1, 0, iter(int, 1))]", "more than 100 powers"),
        ("if high == 5: return [Piece(k / 2000, (k + 1) / 2000, 0, (0, 1, *[0] * 49)) for k in range(2000)]",
         "its pieces have 102000 powers and waves in all, more than 100000"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 1, *[0] * 99))]", "more than 100 powers"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 1), ((3147, 1e-9, 0),))]", "500.861 periods in all"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 1), ((3.0, 1e-9),))]", "not enough values to unpack"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 1), (), None)]", "TypeError"),
        ("if high == 5: return [Piece(0, .5, 0, (0, 1)), Piece(.5, 1, 1, (1, 2))]", "lift jumps between two"),
        ("if high == 5: raise NotConverged('it rings')", "at high = 5 (it rings)"),
        ("if high == 5: LAWS['cycloidal'].make({'x': 1})", "at high = 5 (x: the law cycloidal has no parameter"),
        ("if high == 5: raise Mute", "Mute: its own text fails"),
        ("if high == 5: return [Piece(0, 0.9, 0, (0, 1))]", "do not follow on one another"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 0, 3, -2)), Piece(5, 6, 5, (1,))]", "do not follow on one another"),
        ("if high == 5: raise GeneratorExit", "GeneratorExit"),
        ("if high == 5: return [Piece(0, 1, 0, (0, 2))]", "not from 0 to 1"),
        ("if high == 5: return 1 / 0", "division by zero"),
    ],
)
def test_a_law_that_goes_wrong_beyond_its_cases_is_told_as_such(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], body: str, told: str
) -> None:
    """It was called a bug of camgeom's, ended a check with 0 and no word, or never."""
    said = ", ".join(f"{key}={value}" for key, value in CLAIMS.items())
    mute = "class Mute(Exception):\n    def __str__(self): return 1 / 0\n"
    text = (
        f"{HEAD}from camgeom import LAWS\nfrom camgeom.errors import NotConverged\n{mute}"
        f'@law("our-law", source="by hand", claims=Claims({said}), high=Parameter(3, 3, 9, "power", "integer"))\n'
        f'def f(high):\n    """A cubic."""\n    {body}\n    return {ONE_PIECE}\n'
    )
    file, good, bad = written(tmp_path, text), tmp_path / "good.toml", tmp_path / "bad.toml"
    changed = re.sub(r'law = "[^"]*"', 'law = "our-law"', PIN)
    good.write_text(changed)
    bad.write_text(changed.replace('law = "our-law"', 'law = "our-law"\nhigh = 5'))
    assert main(["check", str(good), "--only", "motion", "--laws", file]) in (0, 1)
    capsys.readouterr()
    assert main(["check", str(bad), "--only", "motion", "--laws", file]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert "motion[" in error
