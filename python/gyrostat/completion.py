# SPDX-License-Identifier: MIT
"""Completion for shells: scenarios, components, papers, options, and keys and values of ``--set``.

``gyrostat completion SHELL`` prints a script that a shell reads once; at each TAB it asks ``gyrostat completion SHELL
--line TEXT`` what could come next.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import PurePath
from typing import Any

from gyrostat import _core
from gyrostat.errors import InputError
from gyrostat.scenario import Scenario, shipped

SCRIPTS = {
    "bash": """_gyrostat() {
  local line="${COMP_LINE:0:COMP_POINT}" current="${COMP_WORDS[COMP_CWORD]}"
  mapfile -t COMPREPLY < <(gyrostat completion bash --line "$line" 2>/dev/null)
  [[ "${COMPREPLY[*]}" == *= ]] && compopt -o nospace
  if [[ ${#COMPREPLY[@]} -eq 0 ]]; then mapfile -t COMPREPLY < <(compgen -f -- "$current"); fi
}
complete -o filenames -F _gyrostat gyrostat
""",
    "zsh": """#compdef gyrostat
_gyrostat() {
  local -a found
  found=("${(@f)$(gyrostat completion zsh --line "$LBUFFER" 2>/dev/null)}")
  found=(${found:#})
  compadd -S '' -- ${(M)found:#*=}
  compadd -- ${found:#*=}
  (( ${#found} )) || _files
}
compdef _gyrostat gyrostat
""",
    "fish": """complete -c gyrostat -a '(gyrostat completion fish --line (commandline -cp) 2>/dev/null)'
""",
}
"""What a shell reads, by its name."""

_where = {
    "bash": 'eval "$(gyrostat completion bash)"   # in ~/.bashrc',
    "zsh": 'eval "$(gyrostat completion zsh)"   # in ~/.zshrc, after compinit',
    "fish": "gyrostat completion fish | source   # in ~/.config/fish/config.fish",
}


def script(shell: str) -> str:
    """What a shell reads, with a line that says where.

    Raises
    ------
    InputError
        No such shell.
    """
    if shell not in SCRIPTS:
        raise InputError(f"no completion for '{shell}'; there is one for: {', '.join(SCRIPTS)}")
    head, comment = SCRIPTS[shell], f"# {_where[shell]}\n"
    return head.replace("\n", f"\n{comment}", 1) if head.startswith("#compdef") else comment + head


def answer(command: Any, shell: str, line: str) -> list[str]:
    """What could come next of a line; bash, which takes ``=`` for the end of a word, gets what follows it."""
    words, current = _split(line)
    found = sorted({c for c in candidates(command, words, current) if c.startswith(current)})
    value = current.rpartition("=")[0]
    return [c[len(value) + 1 :] for c in found] if shell == "bash" and value else found


def _split(line: str) -> tuple[list[str], str]:
    """Words after the command, and the one that is being written."""
    for closing in ("", '"', "'"):
        try:
            words = shlex.split(line + closing)
            break
        except ValueError:
            continue
    else:
        return [], ""
    current = words.pop() if words and not line[-1:].isspace() else ""
    at = max((i for i, word in enumerate(words) if PurePath(word).name == "gyrostat"), default=-1)
    return words[at + 1 :], current


def candidates(command: Any, words: list[str], current: str) -> Iterator[str]:
    """Everything that could come next.

    Parameters
    ----------
    command
        Of the command line, as typer makes it.
    words
        After the command.
    current
        What has been written of the next one.
    """
    rest = list(words)
    while rest and rest[0] in getattr(command, "commands", {}):
        command = command.commands[rest.pop(0)]
    if hasattr(command, "commands"):
        yield from (name for name, one in command.commands.items() if not one.hidden)
    given, asked = _given(command, rest)
    if asked is None and current.startswith("-"):
        yield from (name for option in _options(command) for name in option.opts if name.startswith("--"))
        yield "--help"
    elif asked is not None:
        look = _values.get(f"{command.name} {asked.name}") or _values.get(asked.name)
        yield from _choices.get(asked.name, ()) if look is None else look(given, current)


def _options(command: Any) -> Iterator[Any]:
    return (p for p in command.params if p.param_type_name == "option" and not getattr(p, "hidden", False))


def _given(command: Any, words: list[str]) -> tuple[dict[str, list[str]], Any]:
    """Words by the parameter that they belong to, and the parameter that comes next."""
    options = {name: option for option in _options(command) for name in option.opts}
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    given: dict[str, list[str]] = {}
    asked: list[Any] = []
    for word in words:
        if asked:
            given.setdefault(asked.pop(0).name, []).append(word)
        elif word in options:
            option = options[word]
            asked = [] if getattr(option, "is_flag", False) else [option] * max(option.nargs, 1)
        elif arguments and not word.startswith("-"):
            given.setdefault(arguments[0].name, []).append(word)
            arguments = arguments[1:] if arguments[0].nargs > 0 else arguments
    return given, (asked or arguments or [None])[0]


Given = Mapping[str, list[str]]


def _scenarios(given: Given, current: str) -> Iterable[str]:
    del given, current
    return shipped()


def _campaigns(given: Given, current: str) -> Iterable[str]:
    del given, current
    from gyrostat.campaign.catalogue import shipped as campaigns

    return campaigns()


def _papers(given: Given, current: str) -> Iterable[str]:
    del given, current
    from gyrostat.papers import available

    return [*available(), "all"]


def _claims(given: Given, current: str) -> Iterable[str]:
    del current
    from gyrostat.papers import available, load

    chosen = given.get("paper", ["all"])[0]
    return [c.id for name in (available() if chosen == "all" else [chosen]) for c in load(name).claims]


def _families(given: Given, current: str) -> Iterable[str]:
    del current
    catalogue = _core.catalogue()
    if "family" in given:
        return list(catalogue.get(given["family"][0], ()))
    return [*catalogue, *(name for names in catalogue.values() for name in names), "scenario", "campaign", "paper"]


def _designs(given: Given, current: str) -> Iterable[str]:
    del given, current
    from gyrostat.design import DESIGNS

    return DESIGNS


def _design_options(given: Given, current: str) -> Iterable[str]:
    del current
    from gyrostat.design import DESIGNS

    chosen = [DESIGNS[name] for name in given.get("name", ()) if name in DESIGNS]
    return [f"{key}=" for one in chosen for key in one.options.model_fields]


def _vehicles(given: Given, current: str) -> Iterable[str]:
    del given, current
    from gyrostat.first_scenario import vehicles

    return vehicles()


def _settings(given: Given, current: str) -> Iterator[str]:
    """Keys of the scenario that was named; after a key its values, where they are names."""
    named = [*given.get("scenario", ()), *given.get("names", ())]
    tables = Scenario.load(named[0]).resolve() if named else {}
    keys = dict(_keys(tables))
    key, equals, _ = current.partition("=")
    if equals:
        head, comma, _ = current.rpartition(",")
        yield from (f"{head + comma if comma else key + '='}{value}" for value in keys.get(key, ()))
    else:
        yield from (f"{name}=" for name in keys)


def _keys(tables: Mapping[str, Any]) -> Iterator[tuple[str, list[str]]]:
    """Dotted keys of a scenario, each with the names that it can be."""
    catalogue = _core.catalogue()
    for p in _core.describe("run", "run")["params"]:
        yield p["name"], _names(p)
    for role, table in tables.items():
        rows = table if isinstance(table, list) else [table]
        for i, row in enumerate(rows):
            if not isinstance(row, dict):
                continue
            family = role.removesuffix("s") if isinstance(table, list) else role
            key = f"{role}.{i}" if isinstance(table, list) else role
            if family not in catalogue:
                continue
            kind = row.get("type", family)
            if kind != family:
                yield key, list(catalogue[family])
            if kind in catalogue[family]:
                yield from ((f"{key}.{p['name']}", _names(p)) for p in _core.describe(family, kind)["params"])


def _names(parameter: Mapping[str, Any]) -> list[str]:
    return list(parameter["options"]) or (["true", "false"] if parameter["kind"] == "switch" else [])


_values: dict[str, Callable[[Given, str], Iterable[str]]] = {
    "scenario": _scenarios,
    "names": _scenarios,
    "like": _scenarios,
    "source": lambda given, current: [*_scenarios(given, current), *_campaigns(given, current)],
    "campaign": _campaigns,
    "paper": _papers,
    "claim": _claims,
    "family": _families,
    "describe name": _families,
    "design name": _designs,
    "design settings": _design_options,
    "design more": _design_options,
    "fly file": _campaigns,
    "vehicle": _vehicles,
    "settings": _settings,
    "vary": _settings,
}
"""By the name of a parameter, with that of its command where it has another meaning elsewhere."""

_choices = {"target": ("cpp", "c", "fmu"), "scalar": ("double", "float"), "shell": tuple(SCRIPTS)}
"""Of parameters that are one of a few words."""


__all__ = ["SCRIPTS", "answer", "candidates", "script"]
