"""The table of node ids in the state folder: read as it was saved, and refused in a line if it is something else."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.adapters.drivers.dronecan.own_node import KeptNodeIds
from firmware_py.adapters.installation import configs
from firmware_py.run.kept_node_ids import FILE, load_node_ids
from firmware_py.run.resumed_state import set_aside_unusable
from firmware_py.run.usage_error import UsageError

ONE = "000102030405060708090a0b0c0d0e0f"
tables = st.dictionaries(st.binary(min_size=16, max_size=16), st.integers(1, 125), max_size=20)


@given(tables)
def test_a_table_is_read_as_it_was_saved(tmp_path_factory: pytest.TempPathFactory, table: dict[bytes, int]) -> None:
    distinct = {unique_id: node_id for node_id, unique_id in {n: u for u, n in table.items()}.items()}
    folder = tmp_path_factory.mktemp("state")
    KeptNodeIds(distinct, (folder / FILE).write_bytes).changed()
    assert load_node_ids(folder) == distinct


def test_nothing_is_kept_without_a_folder_or_in_a_new_one(tmp_path: Path) -> None:
    assert load_node_ids(None) == load_node_ids(tmp_path) == load_node_ids(tmp_path / "new") == {}


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ("{", "cannot be read"),
        ("[1]", "must hold a unique id for each node id"),
        (f'{{"126": "{ONE}"}}', 'node_ids.json: "126": "0001'),
        (f'{{"0": "{ONE}"}}', "from 1 to 125"),
        (f'{{"\\u0663": "{ONE}"}}', "from 1 to 125"),
        ('{"20": "00"}', "32 hexadecimal digits"),
        ('{"20": 7}', "32 hexadecimal digits"),
        (f'{{"20": "{ONE[:-1]}x"}}', "32 hexadecimal digits"),
        (f'{{"20": "{ONE}", "21": "{ONE.upper()}"}}', "nodes 20 and 21 have the same unique id"),
    ],
)
def test_another_file_is_refused_in_a_line_and_set_aside_at_the_start(tmp_path: Path, content: str, why: str) -> None:
    (tmp_path / FILE).write_text(content)
    with pytest.raises(UsageError) as refused:
        load_node_ids(tmp_path)
    assert why in str(refused.value).replace("'", '"')
    assert "\n" not in str(refused.value)
    [sentence] = set_aside_unusable(configs() / "npsauv2", None, tmp_path)
    assert f"set aside as {FILE}.corrupt-1" in sentence
    assert load_node_ids(tmp_path) == {}
