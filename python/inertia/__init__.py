"""Runs scenes and sweeps of the sandbox, and reads the files that it writes as NumPy arrays.

Every flag of the program is a keyword: `run("orbit", method="yoshida_4", refuse_unstable=True)` is
`sandbox run orbit --method yoshida_4 --refuse-unstable`.
"""

import csv
import json
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

# Columns of names and other texts, some of which may look like numbers.
_TEXTS = {"body", "case", "class", "method", "outcome", "processor", "state_hash", "subject", "why"}

__all__ = ["Run", "SandboxError", "frame", "program", "run", "sweep", "table"]


class SandboxError(RuntimeError):
    """The program ended with an exit code that is not 0: `code`, and what it said."""

    def __init__(self, code, said):
        super().__init__(said.strip() or f"exit code {code}")
        self.code = code


@dataclass
class Run:
    """A run: `summary` as in summary.json, `states` by column, a row per body and tick."""

    summary: dict
    states: dict


def program():
    """The path of the program: the one of this package, or else the first in the path of the shell."""
    name = "sandbox.exe" if sys.platform == "win32" else "sandbox"
    installed = Path(sysconfig.get_path("scripts")) / name
    if installed.is_file():
        return str(installed)
    # As for a package of a user alone.
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError("the program `sandbox` is not installed; install this package from its wheel")
    return found


def run(scene, *, every=1, **flags):
    """Runs a scene without a window. `every`: ticks between two states.

    Raises `SandboxError` where the exit code is not 0, as for a body that was quarantined.
    """
    with tempfile.TemporaryDirectory() as folder:
        state, summary = Path(folder) / "state.csv", Path(folder) / "summary.json"
        _call(["run", str(scene), "--state", state, "--summary", summary, "--every", every], flags)
        return Run(json.loads(summary.read_text("utf-8")), table(state))


def sweep(scene, vary, *, out=None, **flags):
    """Runs a scene for every combination of values, and gives the table of runs by column.

    `vary` has a place of the scene and its values: one or a list, or a text such as "1e2..1e6 log 20". With `out` the files of
    the sweep stay in that folder.
    """
    def values(given):
        given = _plain(given)
        if isinstance(given, str):
            return given
        return ",".join(_word(value) for value in (given if hasattr(given, "__iter__") else [given]))

    axes = [part for place, given in vary.items() for part in ("--vary", f"{place}={values(given)}")]
    measures = _plain(flags.get("measure"))
    if isinstance(measures, (list, tuple)):
        flags["measure"] = ",".join(measures)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(out) if out is not None else Path(folder) / "sweep"
        _call(["sweep", str(scene), *axes, "--out", out], flags)
        return table(out / "runs.csv")


def table(path):
    """The columns of a CSV file of the program as arrays: numbers (NaN where a field is empty), truth values (1, 0 and NaN
    where a field is empty), or texts."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = list(zip(*rows)) or [()] * len(names)
    return {name: _array(name, column) for name, column in zip(names, columns)}


def frame(columns):
    """A pandas DataFrame of the columns of a table."""
    import pandas

    return pandas.DataFrame(columns)


def _array(name, column):
    if name in _TEXTS or name.endswith(".name"):
        return np.array(column, dtype=str)
    if any(column) and all(field in ("true", "false", "") for field in column):
        values = [{"true": True, "false": False}.get(field, np.nan) for field in column]
        return np.array(values, dtype=bool if all(column) else float)
    try:
        return np.array([float(field) if field else np.nan for field in column])
    except ValueError:
        return np.array(column)


def _plain(value):
    """A value of NumPy or pandas as one of Python."""
    return value.tolist() if hasattr(value, "tolist") else value


def _word(value):
    """A value as a person writes it in a scene."""
    value = _plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (tuple, list)):
        return "(" + ",".join(_word(part) for part in value) + ")"
    return str(value)


def _call(arguments, flags):
    command = [program(), *map(str, arguments)]
    for name, value in flags.items():
        flag, value = "--" + name.replace("_", "-"), _plain(value)
        if value is True:
            command.append(flag)
        elif isinstance(value, (list, tuple)):
            command += [part for item in value for part in (flag, str(item))]
        elif value is not None and value is not False:
            command += [flag, str(value)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    if done.returncode != 0:
        raise SandboxError(done.returncode, done.stderr)
