"""The derived kernels in C, for `make bench` to compare with: `bench/ekf_step.c` includes them as jacobians.h.

What returns a tuple in Python fills `out` in C. The expressions are the same, letter for letter.
"""

from __future__ import annotations

from firmware_py.estimation.model.equations import CONSTANTS
from firmware_py.estimation.model.state import WIDTH
from firmware_py.estimation.model.transition import BUOYANCY, DRAG
from sternplane.codegen.derive_jacobians import kernels
from sternplane.codegen.kernel_text import Kernel, body

COLUMNS = {"M": 6, "A": WIDTH, "B": WIDTH, "D": WIDTH}
"""How wide each matrix is; all others are vectors."""
NAMED = {"scale": "SCALE", "L": "LENGTH", "advance": "ADVANCE", "k_race": "K_RACE", "knee": "KNEE"}
"""Constants that code by hand needs too."""


def generate() -> str:
    """The whole text of jacobians.h."""
    places = [f"{NAMED[name]} = {CONSTANTS.index(name)}" for name in NAMED]
    head = f"enum {{ {', '.join([*places, f'WIDTH = {WIDTH}', f'DRAG = {DRAG}', f'BUOYANCY = {BUOYANCY}'])} }};"
    return "\n\n".join([head, *map(_function, kernels()), ""])


def _function(kernel: Kernel) -> str:
    loads, shared, values = body(kernel)
    inputs = ["const double *restrict c" if name == "c" else f"double {name}" for name in kernel.arguments]
    outs = [_out(name) for name in kernel.outs or ("out",)]
    lines = [f"const double {name} = c[{i}];" for name, i in loads]
    lines += [f"const double {name} = {right};" for name, right in shared]
    for (array, *place), value in zip(kernel.cells, values, strict=True):
        lines.append(f"{array}{''.join(f'[{i}]' for i in place)} = {value};")
    text = "\n".join(f"    {line}" for line in lines)
    return f"static inline void {kernel.name}({', '.join([*inputs, *outs])})\n{{\n{text}\n}}"


def _out(name: str) -> str:
    return f"double (*restrict {name})[{COLUMNS[name]}]" if name in COLUMNS else f"double *restrict {name}"
