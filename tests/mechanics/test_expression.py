"""Expressions compute what they say and refuse everything else at once."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camgeom.errors import ProfileError
from camgeom.mechanics.applied import FUNCTIONS, MAX_CHARACTERS, MAX_DEPTH, compile_expression

PHI = np.linspace(0.1, 6.2, 37)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12.5", lambda p: 12.5 + 0 * p),
        ("2*phi + 1", lambda p: 2 * p + 1),
        ("-phi**2", lambda p: -(p**2)),
        ("2**-1 * theta", lambda p: 0.5 * p),
        ("sin(phi)**2 + cos(phi)**2", lambda p: 1 + 0 * p),
        ("deg/180*pi - phi", lambda p: 0 * p),
        ("exp(log(phi)) / e", lambda p: p / math.e),
        ("max(phi, 1, 2) - min(phi, 3)", lambda p: np.maximum(p, 2) - np.minimum(p, 3)),
        ("atan2(sin(phi), cos(phi))", lambda p: np.arctan2(np.sin(p), np.cos(p))),
        ("  ( sqrt( abs( phi - 3 ) ) )\n", lambda p: np.sqrt(np.abs(p - 3))),
        ("+phi - -phi", lambda p: 2 * p),
        ("2**3**2 + 0*phi", lambda p: 512 + 0 * p),
        ("1e-3*hypot(3, 4)*floor(phi)*sign(phi-2)", lambda p: 5e-3 * np.floor(p) * np.sign(p - 2)),
    ],
)
def test_values(text, value):
    np.testing.assert_allclose(compile_expression(text)(PHI), value(PHI), rtol=1e-13, atol=1e-13)


def test_motion_variables_and_shapes():
    expression = compile_expression("s + 10*v + 100*a")
    assert expression.variables == {"s", "v", "a"}
    lift, speed = np.ones((2, 3)), np.arange(4.0).reshape(4, 1, 1)
    found = expression(np.zeros((2, 3)), lift, speed, 0.5)
    assert found.shape == (4, 2, 3)
    assert found[3, 1, 2] == 1 + 30 + 50
    assert compile_expression("7")(np.zeros((2, 3))).shape == (2, 3)


def test_the_insertion_force_of_the_pin_machine():
    text = "79.55*((56*pi - 36*phi)/(13*pi) + sin((72*phi - 86*pi)/13)/(2*pi))"
    phi = np.array([4.456, 14 * np.pi / 9])
    pi = math.pi
    expected = [79.55 * ((56 * pi - 36 * p) / (13 * pi) + math.sin((72 * p - 86 * pi) / 13) / (2 * pi)) for p in phi]
    np.testing.assert_allclose(compile_expression(text)(phi), expected, rtol=1e-12, atol=1e-12)
    assert abs(expected[1]) < 1e-12


HOSTILE = [
    "",
    "   ",
    "phi +",
    "1 2",
    "phi = 3",
    "lambda: 1",
    "[1, 2]",
    "{1: 2}",
    "'text'",
    "True",
    "None",
    "1j",
    "...",
    "phi if phi else 1",
    "phi < 3",
    "not phi",
    "~1",
    "1 // 2",
    "5 % 2",
    "1 << 99",
    "1 @ 2",
    "1or 2",
    "'\\d'",
    "phi.real",
    "().__class__",
    "().__class__.__bases__[0]",
    "__import__('os').system('true')",
    "eval('1')",
    "exec('1')",
    "open('x')",
    "sin.__call__(1)",
    "(sin)(1)(2)",
    "sin",
    "sin(phi)(phi)",
    "sin()",
    "sin(1, 2)",
    "sin(*phi)",
    "sin(x=1)",
    "max(1)",
    "max(1,2,3,4,5,6,7,8,9)",
    "9**9**9",
    "9**9**9**9",
    "2**phi",
    "2**1000",
    "phi**33",
    "phi**-33",
    "2**(1/0)",
    "1e999",
    "9" * 400,
    "1e31",
    "f'{phi}'",
    "phi; phi",
    "phi\nphi",
    "(yield)",
    "await phi",
    "(x := 3)",
    "\x00",
    "(" * 90 + "1" + ")" * 90 + "(",
    "-" * 300 + "1",
    "sin(" * 60 + "1" + ")" * 60,
    "phi" + "+1" * 200 + "+(" * 3,
    "1+" * 1000 + "1",
    "phy",
    "Phi",
    "sine(phi)",
    "print(1)",
    "e(1)",
    "__builtins__",
    "phi[0]",
    "π",
    "9**" * 100 + "9",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_text_is_refused(text):
    with pytest.raises(ProfileError) as refused:
        compile_expression(text, "operation.force.0.expression")
    problem = refused.value.problems[0]
    assert problem.key == "operation.force.0.expression"
    assert problem.message
    assert len(str(refused.value)) < 500


def test_limits_have_two_sides():
    assert compile_expression("phi**32").steps
    assert compile_expression("1e30*phi").steps
    chain = "1" + "+1" * ((MAX_CHARACTERS - 1) // 2)
    assert float(compile_expression(chain)(0.0)) == (MAX_CHARACTERS + 1) // 2
    assert compile_expression("sin(" * MAX_DEPTH + "1" + ")" * MAX_DEPTH).steps
    with pytest.raises(ProfileError, match="nested"):
        compile_expression("sin(" * (MAX_DEPTH + 1) + "1" + ")" * (MAX_DEPTH + 1))
    assert compile_expression("1" + " " * (MAX_CHARACTERS - 1)).steps
    with pytest.raises(ProfileError, match="characters"):
        compile_expression("1" + " " * MAX_CHARACTERS)


def test_hints():
    with pytest.raises(ProfileError, match="did you mean 'phi'"):
        compile_expression("phy")
    with pytest.raises(ProfileError, match="did you mean 'sqrt'"):
        compile_expression("sqr(phi)")
    with pytest.raises(ProfileError, match="exp"):
        compile_expression("2**phi")


@pytest.mark.parametrize(
    "text",
    [
        "1/(phi-phi)",
        "log(phi-4)",
        "sqrt(phi-4)",
        "exp(exp(exp(phi)))",
        "asin(phi)",
        "0*(1/(phi-phi))",
        "phi**-1 * 1/0",
        "(phi-phi)**-2",
    ],
)
def test_values_that_are_not_finite_name_the_angle(text):
    with pytest.raises(ProfileError, match="no finite value at cam angle"):
        compile_expression(text)(PHI)


def test_an_expression_survives_pickling():
    expression = compile_expression("sin(phi) + s")
    assert pickle.loads(pickle.dumps(expression))(1.0, 2.0) == expression(1.0, 2.0)
    assert hash(expression) == hash(compile_expression("sin(phi) + s"))


@given(st.text(alphabet="0123456789.+-*/()phisnvaeox, _[]'\"", max_size=60))
def test_any_text_gives_an_expression_or_a_problem(text):
    found: ProfileError | None = None
    try:
        value = compile_expression(text)(np.array([0.5, 1.5]), 1.0, 2.0, 3.0)
    except ProfileError as refused:
        found = refused
    assert found.problems if found else np.isfinite(value).all()


def test_every_listed_function_runs():
    for name, (_, least, _) in FUNCTIONS.items():
        arguments = ", ".join(["0.5"] * least)
        assert np.isfinite(compile_expression(f"{name}({arguments})")(0.0))
