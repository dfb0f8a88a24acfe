"""Prints the folders, how many files and lines they have, and the layers that their imports make: `make rooms`."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import grimp

from firmware_py.adapters.installation import ROOT

PACKAGES = ("firmware_py", "sim_bridge", "sternplane")
_FOLDERS = {name: ROOT / ("tools" if name == "sternplane" else "") / name for name in PACKAGES}


def main() -> None:
    """Print the table of rooms, then for each package with rooms its layers, the highest first."""
    print(f"{'room':<44}{'files':>6}{'lines':>7}{'median':>8}{'greatest':>10}")
    for folder, name in _rooms():
        code = [_lines(path) for path in folder.glob("*.py") if path.name != "__init__.py"] or [0]
        print(f"{name:<44}{len(code):>6}{sum(code):>7}{statistics.median(code):>8.0f}{max(code):>10}")
    everything = [_lines(path) for folder in _FOLDERS.values() for path in folder.rglob("*.py")]
    print(
        f"{'all':<44}{len(everything):>6}{sum(everything):>7}{statistics.median(everything):>8.0f}{max(everything):>10}"
    )
    graph = grimp.build_graph(*PACKAGES)
    for _, name in _rooms():
        if len(children := graph.find_children(name)) > 1:
            print(f"\n{name}, from the highest layer to the lowest")
            for layer in layers(graph, children):
                print("  " + " · ".join(layer))


def layers(graph: grimp.ImportGraph, modules: set[str]) -> list[list[str]]:
    """Return the modules' own names in layers, each module with all below it: every import points to a later layer.

    Modules that import each other in a circle are one layer, in which "↔" joins them.
    """
    imports = {one: {two for two in modules - {one} if _imports(graph, one, two)} for one in modules}
    circles = _circles(imports)
    of = {
        module: " ↔ ".join(sorted(name.rpartition(".")[2] for name in circle))
        for circle in circles
        for module in circle
    }
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for one, found in imports.items():
        sorter.add(of[one], *(of[two] for two in found if of[two] != of[one]))
    sorter.prepare()
    found_layers = []
    while sorter.is_active():
        ready = sorter.get_ready()
        found_layers.append(sorted(ready))
        sorter.done(*ready)
    return found_layers[::-1]


def _imports(graph: grimp.ImportGraph, importer: str, imported: str) -> bool:
    return graph.direct_import_exists(importer=importer, imported=imported, as_packages=True)


def _circles(imports: dict[str, set[str]]) -> list[frozenset[str]]:
    """Return the modules in sets of those that reach each other."""
    reach = {one: set(found) for one, found in imports.items()}
    for middle in imports:
        for found in reach.values():
            if middle in found:
                found |= reach[middle]
    return list({frozenset({one, *(two for two in reach[one] if one in reach[two])}) for one in imports})


def _lines(path: Path) -> int:
    return path.read_text(encoding="utf-8").count("\n")


def _rooms() -> Iterator[tuple[Path, str]]:
    for package, root in _FOLDERS.items():
        for folder in [root, *sorted(path for path in root.rglob("*") if path.is_dir())]:
            if (folder / "__init__.py").exists():
                yield folder, ".".join((package, *folder.relative_to(root).parts))


if __name__ == "__main__":
    main()
