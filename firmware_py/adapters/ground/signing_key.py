"""The signing key, from a file that only its owner may read, and the time of signatures."""

from __future__ import annotations

import hashlib
import os
import stat
import time
from pathlib import Path

from firmware_py.adapters.ground.station_link import GroundError
from firmware_py.adapters.storage.regular_file import read_regular
from firmware_py.mavlink.base.signing import STATE_FILE, TICKS_PER_S, Signing

_EPOCH_S = 1_420_070_400
"""2015-01-01, the epoch of signature timestamps."""
_HEX_DIGITS, _SHORTEST = 64, 8


def read_signing(path: Path, state: Path | None = None) -> Signing:
    """Read the key from a file, and the timestamps that the last run saved in the folder `state`.

    The file has one line: a passphrase of 8 characters or more, whose SHA-256 is the key, as MAVProxy's and
    QGroundControl's passphrases are; or the key itself as 64 hex digits.

    Raises:
        GroundError: there is no such file, others may read it, or it has no key; the error never shows the key.
    """
    try:
        if path.is_fifo():  # opening one would wait for a writer
            raise GroundError(f"key {path}: it is not a file")
        with path.open("rb") as file:
            found = os.fstat(file.fileno())
            if not stat.S_ISREG(found.st_mode):
                raise GroundError(f"key {path}: it is not a file")
            if found.st_uid != os.getuid() or found.st_mode & 0o077:
                raise GroundError(f"key {path}: others may read it; `chmod 600 {path}`, as its owner")
            text = file.read(4096).decode("utf-8").strip()
    except OSError as error:
        raise GroundError(f"key {path}: {error.strerror}; make it with `umask 077` and one line of text") from None
    except UnicodeDecodeError:
        raise GroundError(f"key {path}: it is not text; write a passphrase, or 64 hex digits") from None
    if len(text) < _SHORTEST or "\n" in text:
        raise GroundError(f"key {path}: write one line of {_SHORTEST} characters or more, or of 64 hex digits")
    return Signing(_key(text), now(), _saved(state))


def _saved(state: Path | None) -> bytes:
    try:
        return read_regular(state / STATE_FILE) if state is not None else b""
    except OSError:
        return b""


def now() -> int:
    """Return the time in the unit of signatures: 10 us since 2015."""
    return max(0, int((time.time() - _EPOCH_S) * TICKS_PER_S))


def _key(text: str) -> bytes:
    if len(text) == _HEX_DIGITS:
        try:
            return bytes.fromhex(text)
        except ValueError:
            pass
    return hashlib.sha256(text.encode()).digest()
