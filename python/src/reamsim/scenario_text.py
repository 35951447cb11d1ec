# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Scenarios as YAML: what the program writes and reads."""

from __future__ import annotations

import contextlib
import os
import pathlib
import re
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy
import yaml

from .errors import InputError


class _Loader(yaml.SafeLoader):
    """YAML 1.2's scalars, as the program reads them: PyYAML takes ``1e-05`` for a text and ``no`` for a truth value."""


_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
        ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
        ("int", r"[-+]?[0-9]+", "-+0123456789"),
        ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
         "-+.0123456789"),
        ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
        ("merge", r"<<", "<")):
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first))
_Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node)))


def load_yaml(text: str) -> Any:
    """Parses YAML text. Raises yaml.YAMLError."""
    return yaml.load(text, Loader=_Loader)  # a SafeLoader


def plain(value: Any) -> Any:
    """`value` with plain types of Python: numpy's and paths become numbers, lists and texts."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, numpy.generic):
        return value.item()
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, pathlib.PurePath):
        return str(value)
    return value


def flow_text(value: Any) -> str:
    """`value` as YAML on one line, for ``--set``."""
    return yaml.safe_dump(plain(value), default_flow_style=True, width=10**9, allow_unicode=True).removesuffix(
        "...\n").strip()


def assignments(overrides: Mapping[str, Any], keywords: Mapping[str, Any]) -> list[str]:
    """``KEY=VALUE`` for each key, as of ``--set``. In `keywords`, ``__`` stands for the dot between two keys."""
    keys = {**overrides, **{name.replace("__", "."): value for name, value in keywords.items()}}
    return [f"{key}={flow_text(value)}" for key, value in keys.items()]


@contextlib.contextmanager
def scenario_file(scenario: str | os.PathLike[str] | Mapping[str, Any]) -> Iterator[str]:
    """The path of a scenario; of one that is a dict, a temporary file, whose place no `InputError` shows."""
    if not isinstance(scenario, Mapping):
        yield os.fspath(scenario)
        return
    with tempfile.TemporaryDirectory(prefix="reamsim-") as folder:
        path = pathlib.Path(folder, "scenario.yaml")
        path.write_text(scenario_text(scenario, pathlib.Path.cwd()), encoding="utf-8")
        try:
            yield str(path)
        except InputError as error:
            lines = [re.sub(rf"^{re.escape(str(path))}(:\d+:\d+)?", "scenario", line) for line in error.lines]
            raise InputError(lines, error.status) from error.__cause__


def scenario_text(scenario: Mapping[str, Any], folder: pathlib.Path) -> str:
    """The scenario as YAML, with its paths relative to `folder`."""
    values = _absolute(plain(scenario), folder)
    values.setdefault("version", 2)
    return yaml.safe_dump(values, sort_keys=False, allow_unicode=True)


def _absolute(value: Any, folder: pathlib.Path, key: str = "") -> Any:
    """Keys `path`, `mesh` and `output.dir` with a text name files; a path that begins with a variable stays."""
    if isinstance(value, dict):
        return {name: _absolute(item, folder, f"{key}.{name}") for name, item in value.items()}
    if isinstance(value, list):
        return [_absolute(item, folder, key) for item in value]
    names_file = key.endswith((".path", ".mesh")) or key == ".output.dir"
    if names_file and isinstance(value, str) and value and not re.match(r"\$\{", value):
        return str(folder / value)
    return value
