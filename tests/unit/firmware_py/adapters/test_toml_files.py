"""Files that people write, and what becomes of those that are none."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from firmware_py.adapters.storage.toml_files import read_toml
from firmware_py.params import ParamError


def test_a_file_is_its_table(tmp_path):
    path = tmp_path / "io.toml"
    path.write_bytes('[dvl]\nport = "µ"\r\nbaud = 9600\n'.encode())
    assert read_toml(path) == {"dvl": {"port": "µ", "baud": 9600}}


@pytest.mark.parametrize(
    "content",
    [
        b"a = ",
        b"[a]\n[a]\n",
        b"port = \xff",
        b"\x00",
        b"a = " + b"[" * 50_000,
        b"a = " + b"9" * 5_000,
        b"a = " + b"\x01" * 1_000_000,
        b'a = {"' + b"k" * 1_000_000 + b'" = 1, "' + b"k" * 1_000_000 + b'" = 2}',
    ],
    ids=["cut", "twice", "not UTF-8", "zero", "bottomless", "too many digits", "long garbage", "long key twice"],
)
def test_what_is_no_toml_is_one_line_that_names_the_file(tmp_path, content):
    path = tmp_path / "io.toml"
    path.write_bytes(content)
    with pytest.raises(ParamError) as failure:
        read_toml(path)
    assert str(failure.value).startswith(f"{path}: is not TOML (")
    assert "\n" not in str(failure.value)
    assert len(str(failure.value)) < len(str(path)) + 300


def test_a_number_that_is_too_long_is_told_by_its_line_and_not_by_what_python_advises(tmp_path):
    path = tmp_path / "io.toml"
    path.write_bytes(b"a = 1\nb = " + b"9" * 1_000_000)
    with pytest.raises(ParamError) as failure:
        read_toml(path)
    assert str(failure.value) == f"{path}: is not TOML (a number at line 2 has more than 4300 digits)"


@pytest.mark.timeout(20)
def test_a_fifo_and_a_device_are_refused_at_once(tmp_path):
    path = tmp_path / "io.toml"
    os.mkfifo(path)
    for name in (path, Path("/dev/zero")):
        with pytest.raises(ParamError, match=f"^{name}: cannot be read \\(it is not a regular file\\)$"):
            read_toml(name)


def test_a_missing_file_and_a_folder_are_named_with_the_reason(tmp_path):
    with pytest.raises(ParamError, match=r"none\.toml: cannot be read \(No such file"):
        read_toml(tmp_path / "none.toml")
    with pytest.raises(ParamError, match=r"cannot be read \(Is a directory\)"):
        read_toml(tmp_path)
    (tmp_path / "io.toml").write_text("")
    with pytest.raises(ParamError, match=r"cannot be read \(Not a directory\)"):
        read_toml(tmp_path / "io.toml" / "io.toml")
