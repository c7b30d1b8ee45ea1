"""Completion scripts for shells: made from the parser, and read by the shells that are here."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from camgeom.cli import COMMANDS, main
from camgeom.cli.completion import SHELLS, options


@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_names_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for name, found in options().items():
        assert name in script
        for flag, _ in found:
            assert (flag if shell != "fish" else f"-l {flag[2:]}") in script
    assert set(options()) == {command.name for command in COMMANDS}


def test_another_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bsh"]) == 2
    assert "did you mean 'bash'" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@pytest.mark.parametrize(
    ("words", "place", "found"),
    [("camgeom opt", 1, "optimise"), ("camgeom study --va", 2, "--vary"), ("camgeom new glo", 2, "globoidal")],
)
def test_bash_completes(words: str, place: int, found: str, capsys: pytest.CaptureFixture[str]) -> None:
    main(["completion", "bash"])
    script = capsys.readouterr().out
    ask = f'{script}\nCOMP_WORDS=({words}); COMP_CWORD={place}; _camgeom; echo "${{COMPREPLY[@]}}"'
    done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [found]
