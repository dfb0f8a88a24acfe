"""The runs of a study in a folder, one file each, so that a study that was broken off goes on where it was."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from firmware_py.adapters.storage.regular_file import FolderError, make_folder
from firmware_py.run.usage_error import UsageError
from sternplane.campaign.files import file_name, write
from sternplane.study.rows import Case, RunArrays

FOLDER = "runs"
_REVISION = "revision"
"""The name under which a file says which revision of the code flew it; no array of a case has it."""


class KeptRuns:
    """What was flown already, and what is flown now.

    Args:
        folder: of the study.
        revision: of the code that flies now.

    Attributes:
        others: revisions that flew what was found, other than this one.

    Raises:
        UsageError: the folder cannot be made.
    """

    def __init__(self, folder: Path, revision: str) -> None:
        self.folder, self.revision = folder / FOLDER, revision
        self.others: set[str] = set()
        try:
            make_folder(self.folder)
        except FolderError as error:
            raise UsageError(f"{error}; choose another --out") from None

    def found(self, case: Case, seed: int, k: int) -> RunArrays | None:
        """Return a run that was kept; None if there is none, or a file that cannot be read: it is flown again."""
        try:
            with np.load(self._path(case, seed, k), allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            revision = str(arrays.pop(_REVISION))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None
        self.others |= {revision} - {self.revision}
        return arrays

    def keep(self, case: Case, seed: int, k: int, run: RunArrays) -> None:
        """Keep a run.

        Raises:
            UsageError: it cannot be written.
        """
        content, path = io.BytesIO(), self._path(case, seed, k)
        arrays: dict[str, Any] = {_REVISION: np.array(self.revision), **run}
        np.savez_compressed(content, **arrays)
        write(path, content.getvalue())

    def _path(self, case: Case, seed: int, k: int) -> Path:
        return self.folder / f"{file_name(case.files or case.name)}.{seed}.{k}.npz"
