from __future__ import annotations

from sim_bridge.faults import KINDS
from tools import reference


def test_the_reference_of_every_key_is_up_to_date() -> None:
    assert reference.PATH.read_text() == reference.page(), "run: .venv/bin/python -m tools.reference"


def test_the_reference_names_every_fault_and_every_file() -> None:
    page = reference.page()
    for kind, (argued, _) in KINDS.items():
        assert f"{kind}:FIN" in page if argued else kind in page
    files = {
        path.name for path in (reference.PATH.parent / "npsauv2").glob("*.toml") if not path.name.startswith("io_")
    }
    for name in files | {"io_*.toml", "mission.toml", "scenarios/*.toml"}:
        assert f"## {name}\n" in page
