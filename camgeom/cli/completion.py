"""`camgeom completion`: a script for the shell, made from the parser, so that it needs nothing when it runs."""

from __future__ import annotations

import argparse

from camgeom.cli import COMMANDS, Console, UsageError, parser
from camgeom.errors import did_you_mean

SHELLS = ("bash", "zsh", "fish")


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Print the script; returns 0."""
    shell = arguments.shell
    if shell not in SHELLS:
        hint = did_you_mean(shell, SHELLS)
        raise UsageError(f"unknown shell {shell[:60]!r}; known: {', '.join(SHELLS)}{hint and '; ' + hint}")
    console.out(_fish() if shell == "fish" else _bash(shell))
    return 0


def options() -> dict[str, list[tuple[str, str]]]:
    """The options of every command with their help."""
    top = parser()
    below = next(action for action in top._actions if isinstance(action, argparse._SubParsersAction))
    return {
        name: [(flag, action.help or "") for action in sub._actions for flag in action.option_strings if flag[1] == "-"]
        for name, sub in below.choices.items()
    }


def kinds_of() -> dict[str, str]:
    """What the first word of a command is, where it is no file."""
    from camgeom.cams import kinds

    designs = "globoidal disc conjugate constant-width end-face"
    return {"new": " ".join(kinds()), "design": designs, "completion": " ".join(SHELLS)}


def _bash(shell: str) -> str:
    flags = {name: " ".join(flag for flag, _ in found) for name, found in options().items()}
    cases = "\n".join(f"    {name}) options='{known}' ;;" for name, known in flags.items())
    words = "\n".join(f"    {name}) words='{known}' ;;" for name, known in kinds_of().items())
    head = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return f"""# {shell} completion of camgeom: eval "$(camgeom completion {shell})"
{head}_camgeom() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" options='' words=''
  if [ "$COMP_CWORD" = 1 ]; then
    COMPREPLY=($(compgen -W '{" ".join(command.name for command in COMMANDS)} --help --version' -- "$word"))
    return
  fi
  case "${{COMP_WORDS[1]}}" in
{cases}
  esac
  case "${{COMP_WORDS[1]}}" in
{words}
  esac
  case "$word" in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) COMPREPLY=($(compgen -W "$words" -- "$word") $(compgen -f -- "$word")) ;;
  esac
}}
complete -o filenames -F _camgeom camgeom"""


def _fish() -> str:
    lines = ["# fish completion of camgeom: camgeom completion fish | source"]
    lines += [
        f"complete -c camgeom -f -n __fish_use_subcommand -a {command.name} -d {_quoted(command.help)}"
        for command in COMMANDS
    ]
    for name, found in options().items():
        seen = f"-n '__fish_seen_subcommand_from {name}'"
        lines += [f"complete -c camgeom {seen} -l {flag[2:]} -d {_quoted(about)}" for flag, about in found]
    lines += [
        f"complete -c camgeom -f -n '__fish_seen_subcommand_from {name}' -a '{known}'"
        for name, known in kinds_of().items()
    ]
    return "\n".join(lines)


def _quoted(text: str) -> str:
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
