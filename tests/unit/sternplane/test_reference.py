from __future__ import annotations

from sternplane.codegen import configuration_reference

from sim_bridge.faults.catalogue import KINDS


def test_the_reference_of_every_key_is_up_to_date() -> None:
    assert configuration_reference.PATH.read_text() == configuration_reference.page(), (
        "run: .venv/bin/python -m sternplane.codegen.configuration_reference"
    )


def test_the_reference_names_every_fault_and_every_file() -> None:
    page = configuration_reference.page()
    for kind in KINDS:
        assert f"{kind.name}:{kind.group}" in page
    files = {
        path.name
        for path in (configuration_reference.PATH.parent / "npsauv2").glob("*.toml")
        if not path.name.startswith("io_")
    }
    for name in files | {"io_*.toml", "mission.toml", "scenarios/*.toml"}:
        assert f"## {name}\n" in page
