"""`import camgeom` is cheap, heavy modules load inside the function that uses them, and every public name resolves."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

import camgeom

HEAVY = {"scipy", "trimesh", "pyvista", "vtk", "vtkmodules", "meshio", "matplotlib", "ezdxf", "manifold3d"}
CHEAP = {"manifold3d"}
"""Heavy for `import camgeom`, but 9 ms: a module that always needs it may import it at its top."""
PACKAGE = Path(camgeom.__file__).parent


def loaded_after(code: str) -> set[str]:
    """The top-level modules of a fresh interpreter after the code."""
    program = f"import sys\n{code}\nprint(*sorted({{name.partition('.')[0] for name in sys.modules}}))"
    command = [sys.executable, "-c", program]
    return set(subprocess.run(command, capture_output=True, text=True, check=True, cwd=PACKAGE.parent).stdout.split())


def test_import_camgeom_loads_nothing_heavy() -> None:
    assert not loaded_after("import camgeom") & (HEAVY | {"numpy", "pydantic"})


def test_import_of_the_command_line_loads_nothing_heavy() -> None:
    assert not loaded_after("import camgeom.cli") & HEAVY


def test_import_of_the_writers_loads_nothing_heavy() -> None:
    assert not loaded_after("import camgeom.export as e; e.formats()") & HEAVY


def test_check_loads_nothing_heavy() -> None:
    """`camgeom check` answers in the time of numpy alone."""
    code = "import contextlib, io\nfrom camgeom.cli import main\nwith contextlib.redirect_stdout(io.StringIO()):\n"
    loaded = loaded_after(code + "    assert main(['check', 'profiles/pin_insertion.toml']) == 0")
    assert "numpy" in loaded
    assert not loaded & (HEAVY - CHEAP)


@pytest.mark.parametrize(
    ("profile", "others"),
    [
        (
            "pin_insertion",
            {"checks.planar", "checks.turret", "checks.dynamics", "track.turret", "track.sliding", "profile.solvers",
             "mechanics.crown", "mechanics.kept", "mechanics.slide_drive"},
        ),
        (
            "disc_offset_roller",
            {"checks.turret", "checks.dynamics", "track.turret", "solid.drum", "dynamics", "tolerance"},
        ),
        (
            "tool_changer",
            {"checks.planar", "dynamics.follower", "solid.drum", "solid.prism", "track.planar", "track.touch",
             "mechanics.roller_duty"},
        ),
    ],
)
def test_check_enters_only_what_it_asks(profile: str, others: set[str]) -> None:
    """No writers, no sections of other commands, no checks and solvers of other cams, no polynomials and no masked
    arrays of numpy, which load when first named (`numpy.unique` names the latter)."""
    code = (
        "import contextlib, io, sys\nfrom camgeom.cli import main\nwith contextlib.redirect_stdout(io.StringIO()):\n"
        f"    assert main(['check', 'profiles/{profile}.toml']) == 0\n"
        "print(*(name for name in sys.modules if name.startswith(('camgeom', 'numpy.', 'json'))))"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=PACKAGE.parent)
    loaded = set(done.stdout.split())
    assert not {name for name in loaded if name.startswith(("camgeom.export", "camgeom.report.data.load"))}
    assert not loaded & {f"camgeom.{name}" for name in others}
    assert not loaded & {"numpy.polynomial", "numpy.ma", "json"}


@pytest.mark.parametrize(
    ("profile", "most_read", "most_checked"),
    [("pin_insertion", 41, 80), ("disc_offset_roller", 43, 88), ("conical_indexer", 39, 90)],
)
def test_reading_and_checking_enter_few_modules(profile: str, most_read: int, most_checked: int) -> None:
    """How many modules of camgeom a drum, a disc and a globoid enter: who needs one more says here why.

    Three stand apart so that nothing names each other in a circle: the catalogue of laws, a program's segment, and what
    steel bears by its hardness; `model.seen` since whom a model sees is another idea than its facts; a
    groove's section, which a plate does not enter, stands on the column that all do. Reading makes no mesh, so it
    enters neither meshes nor what builds them.
    """
    path = f"profiles/{profile}.toml"
    count = "\nprint(sum(name.partition('.')[0] == 'camgeom' for name in sys.modules))"
    read, checked = (
        int(subprocess.run([sys.executable, "-c", code + count], capture_output=True, text=True, check=True,
                           cwd=PACKAGE.parent).stdout)
        for code in (
            f"import sys, camgeom\ncamgeom.read({path!r})",
            "import contextlib, io, sys\nfrom camgeom.cli import main\nwith contextlib.redirect_stdout(io.StringIO()):"
            f"\n    main(['check', {path!r}])",
        )
    )  # fmt: skip
    assert read <= most_read
    assert checked <= most_checked


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Neither when they load nor within functions; names of types alone are no import."""
    graph = grimp.build_graph("camgeom", exclude_type_checking_imports=True, cache_dir=None)
    reached = {module: graph.find_upstream_modules(module) for module in graph.modules}
    assert [module for module in graph.modules if any(module in reached[other] for other in reached[module])] == []


def test_memory_is_kept_where_the_c_library_can(monkeypatch: pytest.MonkeyPatch) -> None:
    """By glibc's own call; another library has none, and nothing happens."""
    from camgeom.__main__ import keep_memory

    told: list[tuple[int, int]] = []

    class Library:
        def __init__(self, name: str | None) -> None:
            assert name is None

        def mallopt(self, what: int, size: int) -> int:
            told.append((what, size))
            return 1

    def absent(name: str | None) -> object:
        raise OSError(name)

    monkeypatch.setattr("ctypes.CDLL", Library)
    keep_memory()
    assert told == [(-3, 1 << 25), (-1, 1 << 26)]
    for other in (absent, lambda name: object()):
        monkeypatch.setattr("ctypes.CDLL", other)
        keep_memory()


def command_loads(environment: dict[str, str]) -> set[str]:
    """All modules after a check as the `camgeom` command runs it."""
    code = (
        "import contextlib, io, sys\nfrom camgeom.__main__ import run\nsys.argv = ['camgeom', 'check', "
        "'profiles/pin_insertion.toml']\nwith contextlib.redirect_stdout(io.StringIO()):\n    assert run() == 0\n"
        "print(*sys.modules)"
    )
    told = {name: value for name, value in os.environ.items() if name != "PYDANTIC_DISABLE_PLUGINS"} | environment
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=PACKAGE.parent, env=told)
    return set(done.stdout.split())


def test_a_command_seeks_no_plugins_and_no_packers_unless_some_are_named() -> None:
    assert not command_loads({}) & {"importlib.metadata", "zipfile", "email", "shutil", "difflib"}
    assert "importlib.metadata" in command_loads({"PYDANTIC_DISABLE_PLUGINS": "none-of-these"})


def test_what_stands_for_the_loader_of_plugins_makes_way_for_it() -> None:
    code = (
        "import sys\nfrom camgeom.__main__ import LOADER, seek_no_plugins\nseek_no_plugins()\n"
        "from pydantic.plugin._loader import get_plugins\nassert get_plugins() == ()\n"
        "assert sys.modules[LOADER].__spec__ is None\n"
        "from pydantic.plugin._loader import PYDANTIC_ENTRY_POINT_GROUP\n"
        "assert sys.modules[LOADER].__spec__ is not None\n"
    )
    assert "importlib" in loaded_after(code)


def module_level_imports(tree: ast.Module) -> set[str]:
    """Top-level packages imported outside functions and outside `if TYPE_CHECKING`."""
    found: set[str] = set()
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            waiting.extend(node.orelse)
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        if isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.partition(".")[0])
        waiting.extend(ast.iter_child_nodes(node))
    return found


@pytest.mark.parametrize("file", sorted(PACKAGE.rglob("*.py")), ids=lambda file: str(file.relative_to(PACKAGE)))
def test_no_module_imports_a_heavy_package_at_its_top(file: Path) -> None:
    assert not module_level_imports(ast.parse(file.read_text(encoding="utf-8"))) & (HEAVY - CHEAP)


def test_the_search_for_imports_sees_them() -> None:
    source = "from scipy import linalg\nif TYPE_CHECKING:\n    import trimesh\n"
    source += "def f():\n    import vtk\nclass A:\n    import pyvista\n"
    assert module_level_imports(ast.parse(source)) == {"scipy", "pyvista"}


@pytest.mark.parametrize("name", camgeom._HOME)
def test_public_name_resolves_and_is_listed(name: str) -> None:
    assert getattr(camgeom, name) is not None
    assert name in dir(camgeom)


def test_the_public_names_are_those_that_are_exported() -> None:
    assert sorted(camgeom.__all__) == sorted(camgeom._HOME)


def test_unknown_name_says_what_there_is() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'raed'.*read"):
        camgeom.raed  # noqa: B018


def test_no_test_imports_a_test() -> None:
    tests = Path(__file__).parents[1]
    found = re.compile(r"^\s*(?:from|import) tests\.[\w.]*test_", re.MULTILINE)
    assert [file.name for file in tests.rglob("*.py") if found.search(file.read_text(encoding="utf-8"))] == []
