"""The one rule: everything points inward, and the core has no clock, file, environment, random source or thread."""

from __future__ import annotations

import ast
import configparser
import copy
import subprocess
import sys
from pathlib import Path

import grimp
import pytest
from importlinter.configuration import configure
from importlinter.contracts.acyclic_siblings import AcyclicSiblingsContract
from importlinter.contracts.forbidden import ForbiddenContract
from importlinter.contracts.layers import LayersContract

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.executable).parent
CORE = [
    path
    for path in sorted((ROOT / "firmware_py").rglob("*.py"))
    if {"adapters", "run"}.isdisjoint(path.parts) and path.name not in ("config_files.py", "__main__.py")
]


RULES = configparser.ConfigParser()
RULES.read(ROOT / ".importlinter")
KINDS = {"layers": LayersContract, "forbidden": ForbiddenContract, "acyclic_siblings": AcyclicSiblingsContract}
CONTRACTS = [section for section in RULES.sections() if section.startswith("importlinter:contract:")]


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    """Every import of the tree; a contract is checked on a copy."""
    return grimp.build_graph(
        *RULES["importlinter"]["root_packages"].split(), include_external_packages=True, cache_dir=None
    )


def keeps(section: str, graph: grimp.ImportGraph) -> bool:
    """Whether the imports keep a contract; the same code as `lint-imports` runs."""
    configure()  # the command does so when it starts
    session = {"root_packages": RULES["importlinter"]["root_packages"].split(), "include_external_packages": "True"}
    options: dict[str, str | list[str]] = {
        key: value.split("\n")[1:] if value.startswith("\n") else value for key, value in RULES[section].items()
    }
    contract = KINDS[RULES[section]["type"]](RULES[section]["name"], session, options)
    return contract.check(copy.deepcopy(graph), verbose=False).kept


@pytest.mark.parametrize("section", CONTRACTS, ids=lambda section: section.rpartition(":")[2])
def test_the_tree_keeps_the_import_contracts(section: str, graph: grimp.ImportGraph) -> None:
    assert keeps(section, graph)


@pytest.mark.parametrize(
    ("importer", "imported", "contract"),
    [
        ("firmware_py.control.depth", "firmware_py.guidance.guidance", "layers"),
        ("firmware_py.records.order", "firmware_py.safety.gate", "layers"),
        ("firmware_py.autopilot", "firmware_py.adapters.buses.can_bus", "layers"),
        ("firmware_py.app", "firmware_py.run.fly", "layers"),
        ("sim_bridge.plant.plant", "firmware_py.vehicle", "plant"),
        ("sim_bridge.devices.devices", "firmware_py.guidance", "plant"),
        ("sim_bridge.bridge", "firmware_py.run.fly", "plant"),
        ("firmware_py.app", "sim_bridge.plant.plant", "vehicle"),
        ("firmware_py.adapters.realtime_schedule", "sternplane.logs.reading", "vehicle"),
        ("firmware_py.run.fly", "sternplane.report.report", "vehicle"),
        ("firmware_py.run.flight_recorder", "rich", "vehicle"),
        ("firmware_py.safety.gate", "can", "core-io"),
        ("firmware_py.wire.dronecan.transfer", "time", "core-io"),
        ("firmware_py.mavlink.link", "socket", "mavlink-io"),
        ("firmware_py.mavlink.base.codec", "firmware_py.mavlink.link", "mavlink-rooms"),
        ("firmware_py.mavlink.commands.queue", "firmware_py.mavlink.plans.plan_store", "mavlink-rooms"),
        ("firmware_py.estimation.model.equations", "firmware_py.estimation.filter.time_update", "estimation-rooms"),
        ("firmware_py.wire.dronecan.transfer", "firmware_py.wire.log.cdr_codec", "wire-rooms"),
        ("sim_bridge.plant.plant", "sim_bridge.devices.devices", "plant-rooms"),
        ("sternplane.sitl.flight", "sternplane.paper.design", "tools-rooms"),
        ("sternplane.logs.reading", "sternplane.report.report", "circles"),
        ("firmware_py.guidance.bottom", "firmware_py.guidance.guidance", "circles"),
    ],
)
def test_an_import_that_points_outward_is_caught(
    graph: grimp.ImportGraph, importer: str, imported: str, contract: str
) -> None:
    assert {importer, *([imported] if "." in imported else [])} <= graph.modules, "the example's modules have moved"
    changed = copy.deepcopy(graph)
    changed.add_module(imported, is_squashed="." not in imported)
    changed.add_import(importer=importer, imported=imported, line_number=1, line_contents=f"import {imported}")
    assert not keeps(f"importlinter:contract:{contract}", changed)


def test_the_command_that_checks_them_runs() -> None:
    command = [BIN / "lint-imports", "--config", ROOT / ".importlinter", "--no-cache"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    assert f"Contracts: {len(CONTRACTS)} kept, 0 broken." in result.stdout


@pytest.mark.parametrize("module", ["time", "datetime", "random", "os", "pathlib", "threading", "asyncio"])
def test_a_clock_file_or_thread_in_the_core_is_caught_and_in_an_adapter_is_not(module: str) -> None:
    def check(name: str) -> str:
        command = [BIN / "ruff", "check", "--select", "TID251", "--stdin-filename", name, "-"]
        source = f"import {module}\n\n{module}\n"
        return subprocess.run(command, cwd=ROOT, input=source, capture_output=True, text=True, check=False).stdout

    assert "TID251" in check("firmware_py/control/anything.py")
    assert "TID251" not in check("firmware_py/adapters/anything.py")


@pytest.mark.parametrize("path", CORE, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_the_core_calls_nothing_that_reads_or_writes(path: Path) -> None:
    banned = {"open", "print", "input", "eval", "__import__", "breakpoint", "id", "hash"}
    calls = [
        f"{path.name}:{node.lineno}: {node.func.id}"
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in banned
    ]
    assert not calls


@pytest.mark.parametrize(
    "path",
    [p for folder in ("firmware_py", "sim_bridge", "tools") for p in sorted((ROOT / folder).rglob("*.py"))],
    ids=lambda path: path.relative_to(ROOT).as_posix(),
)
def test_a_file_is_at_most_300_lines(path: Path) -> None:
    text = path.read_text()
    assert "generated by" in text[:400].lower() or text.count("\n") <= 300


def test_the_cycle_reads_hear_obey_think_act_record_report() -> None:
    tree = ast.parse((ROOT / "firmware_py" / "loop.py").read_text())
    loop = next(node for node in ast.walk(tree) if isinstance(node, ast.For))
    calls = [
        f"{call.func.value.id}.{call.func.attr}"
        for statement in loop.body
        for call in ast.walk(statement)
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and isinstance(call.func.value, ast.Name)
    ]
    assert calls == [
        "hardware.read",
        "ground.read",
        "autopilot.step",
        "hardware.write",
        "recorder.write",
        "ground.write",
    ]
