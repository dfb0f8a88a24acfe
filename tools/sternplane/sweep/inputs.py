"""The files that a sweep flies: copied when it begins, so that all of its flights have the same, here and elsewhere."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

from firmware_py.adapters.storage.regular_file import FolderError, make_folder, read_regular
from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.run.options import io_file
from firmware_py.run.usage_error import UsageError
from sim_bridge.scenarios import scenario_path
from sim_bridge.truth_file import DERIVES
from sternplane.campaign.files import write
from sternplane.sitl.request import SCENARIOS, FlightRequest
from sternplane.sweep.flight import SCENARIO_FILE

FOLDER = "inputs"
_IO, _TRUTH, _BASE = "io_sitl.toml", "truth.toml", "truth_derives.toml"
_DERIVES = re.compile(rb"^\s*[\"']?" + DERIVES.encode() + rb"[\"']?\s*=.*$", re.MULTILINE)


def files_of(request: FlightRequest) -> dict[str, bytes]:
    """Return the files of a request by the names that they have in a sweep.

    A vehicle file elsewhere, from which the truth derives, is among them, under a name of its own.

    Raises:
        UsageError: one cannot be read.
    """
    io = io_file(request.config, request.io)
    paths = {path.name: path for path in sorted(request.config.glob("*.toml")) if not path.name.startswith("io_")}
    paths |= {_IO: io, SCENARIO_FILE: scenario_path(request.scenario, SCENARIOS)}
    files = {name: _read(path) for name, path in paths.items()}
    base = read_toml(request.config / _TRUTH).get(DERIVES)
    if isinstance(base, str) and base not in files:
        files[_BASE] = _read(request.config / base)
        files[_TRUTH] = _DERIVES.sub(f'{DERIVES} = "{_BASE}"'.encode(), files[_TRUTH], count=1)
    return files


def freeze(files: dict[str, bytes], folder: Path) -> None:
    """Leave the files in the sweep's folder.

    Raises:
        UsageError: they cannot be written.
    """
    place = folder / FOLDER
    try:
        make_folder(place)
    except FolderError as error:
        raise UsageError(f"{error}; choose another --out") from None
    for name, content in files.items():
        write(place / name, content)


def digest(files: dict[str, bytes]) -> str:
    """Return what tells these files from all others."""
    each = {name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)}
    return hashlib.sha256(json.dumps(each).encode()).hexdigest()[:16]


def read_inputs(folder: Path) -> dict[str, bytes]:
    """Return the files that a sweep flies.

    Raises:
        UsageError: they are not there.
    """
    files = {path.name: _read(path) for path in sorted((folder / FOLDER).glob("*.toml"))}
    if SCENARIO_FILE not in files:
        raise UsageError(f"{folder / FOLDER}: has no {SCENARIO_FILE}; the sweep cannot go on; choose another --out")
    return files


def frozen_request(folder: Path) -> FlightRequest:
    """Return the request that flies what was frozen."""
    return FlightRequest(str(folder / FOLDER / SCENARIO_FILE), folder / FOLDER)


def _read(path: Path) -> bytes:
    try:
        return read_regular(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None
