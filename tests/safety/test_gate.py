"""The gate at every limit and for any input; and a mutation test: every mutant of its source must fail a property."""

from __future__ import annotations

import ast
import copy
import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_py.records.command import Applied, FinCommand, ModeState
from firmware_py.records.order import Mode
from firmware_py.records.sensing import Ahrs, Heard, SensorFrame, silence
from firmware_py.safety import gate
from firmware_py.tick import Tick

DT_NS = 10_000_000
TRAVEL = (0.4, 0.3, 0.2, 0.1)  # rad
RATE = (1.0, 2.0, 0.5, 4.0)  # rad/s: 10, 20, 5, 40 mrad per tick
N_MAX = 20.0  # rev/s
N_RATE = 50.0  # rev/s^2: 0.5 rev/s per tick
HOLD = 3
LEVEL = Ahrs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NON_FINITE = (math.nan, math.inf, -math.inf)
REST = Applied((0.0,) * 4, 0.0, True, False)


def make(module: Any = gate, travel: Any = TRAVEL, rate: Any = RATE, n_max: float = N_MAX) -> Any:
    return module.Gate(module.GateParams(n_rate=N_RATE, ahrs_timeout=0.5, hold_ticks=HOLD), travel, rate, n_max)


def heard(t: float, *, fresh: bool = True, ok: bool = True, value: Ahrs = LEVEL) -> SensorFrame:
    return replace(silence(4), ahrs=Heard(value, t, fresh, ok))


def limit(
    part: Any, fins: tuple[float, ...], n: float, previous: Applied = REST, k: int = 0, mode: Mode = Mode.HOLD
) -> Applied:
    """Run one tick with an attitude of that tick."""
    tick = Tick(k, DT_NS)
    return part.limit(tick, ModeState(mode, False, 0), heard(tick.t), FinCommand(fins, n), previous)


def close(a: Applied, fins: tuple[float, ...], n: float) -> bool:
    return a.fins == pytest.approx(fins, abs=1e-12) and a.n == pytest.approx(n, abs=1e-12)


def angles_stay_within_their_limits(module: Any) -> None:
    for sign in (1.0, -1.0):
        near = Applied(tuple(sign * (x - 0.004) for x in TRAVEL), sign * (N_MAX - 0.4), True, False)
        for step, changed in ((-0.001, False), (0.0, False), (0.0005, True), (1e9, True)):
            asked = tuple(sign * (x + step) for x in TRAVEL)
            answer = limit(make(module), asked, sign * N_MAX, near)
            assert answer.limited is changed
            assert answer.fins == tuple(sign * min(x, x + step) for x in TRAVEL)
        for step, changed in ((-0.1, False), (0.0, False), (0.01, True), (1e9, True)):
            answer = limit(make(module), near.fins, sign * (N_MAX + step), near)
            assert answer.limited is changed
            assert answer.n == sign * min(N_MAX, N_MAX + step)


def rates_stay_within_their_limits(module: Any) -> None:
    reach = (0.01, 0.02, 0.005, 0.04)
    for start in (0.0, 0.05, -0.05):
        was = Applied((start,) * 4, 10.0 * start, True, False)
        for sign in (1.0, -1.0):
            for part, changed in ((0.0, False), (0.99, False), (1.01, True), (3.0, True)):
                asked = tuple(start + sign * part * x for x in reach)
                n = was.n + sign * part * 0.5
                answer = limit(make(module), asked, n, was)
                got = min(part, 1.0)
                assert close(answer, tuple(start + sign * got * x for x in reach), was.n + sign * got * 0.5)
                assert answer.limited is changed
    slow = make(module).limit(
        Tick(0, 2 * DT_NS), ModeState(Mode.MANUAL, False, 0), heard(0.0), FinCommand((1.0,) * 4, 9.0), REST
    )
    assert close(slow, (0.02, 0.04, 0.01, 0.08), 1.0)


def one_limited_value_sets_the_flag(module: Any) -> None:
    assert limit(make(module), (0.5, 0.0, 0.0, 0.0), 0.0).limited
    assert limit(make(module), (0.0, 0.0, 0.0, 0.0), 5.0).limited
    assert not limit(make(module), (0.001, 0.0, 0.0, 0.0), 0.1).limited


def output_is_armed_in_every_mode_but_disarmed(module: Any) -> None:
    for mode in Mode:
        answer = limit(make(module), (0.005,) * 4, 0.5, mode=mode)
        assert answer.armed is (mode is not Mode.DISARMED)
        assert answer.limited is (mode is Mode.DISARMED)
        assert answer.fins == (0.005 if answer.armed else 0.0,) * 4


def disarmed_is_centred_and_stopped_at_once(module: Any) -> None:
    was = Applied(TRAVEL, N_MAX, True, False)
    for fins, n in ((TRAVEL, N_MAX), ((0.0,) * 4, 1.0), ((0.1, 0.0, 0.0, 0.0), 0.0), ((math.nan,) * 4, math.inf)):
        assert limit(make(module), fins, n, was, mode=Mode.DISARMED) == Applied((0.0,) * 4, 0.0, False, True)
    assert limit(make(module), (0.0,) * 4, 0.0, was, mode=Mode.DISARMED) == Applied((0.0,) * 4, 0.0, False, False)


def ahrs_timeout_centres_and_stops(module: Any) -> None:
    part, asked = make(module), FinCommand((0.1,) * 4, 4.0)
    was = Applied(asked.fins, asked.n, True, False)
    for k in range(120):  # valid at t = 0 only: 0.5 s is k = 50
        was = part.limit(Tick(k, DT_NS), ModeState(Mode.HOLD, False, 0), heard(0.0, fresh=k == 0), asked, was)
        steps = max(0, k - 50)
        expected = tuple(max(0.0, 0.1 - steps * x * 0.01) for x in RATE)
        assert close(was, expected, max(0.0, 4.0 - 0.5 * steps)), k
        assert was.armed
        assert was.limited is (k > 50)
    assert was.fins == (0.0,) * 4
    back = limit(part, asked.fins, asked.n, was, k=120)
    assert close(back, (0.01, 0.02, 0.005, 0.04), 0.5)


def surface_needs_no_attitude(module: Any) -> None:
    part, asked = make(module), FinCommand((0.1,) * 4, -4.0)
    was = Applied(asked.fins, asked.n, True, False)
    for k in range(120):
        was = part.limit(Tick(k, DT_NS), ModeState(Mode.SURFACE, False, 0), heard(0.0, fresh=k == 0), asked, was)
        assert was == Applied(asked.fins, asked.n, True, False)
    for k in range(8):  # what is not finite does not pass for that
        was = limit(part, (math.nan,) * 4, -4.0, was, 120 + k, Mode.SURFACE)
    assert was.fins != asked.fins
    assert was.n == -4.0 + (8 - HOLD) * 0.5


def release_of_the_weight_passes(module: Any) -> None:
    for mode in Mode:
        for drop in (False, True):
            state = ModeState(mode, False, 0, drop=drop)
            answer = make(module).limit(Tick(0, DT_NS), state, silence(4), FinCommand((math.nan,) * 4, 0.0), REST)
            assert answer.drop is drop


def only_good_attitude_counts(module: Any) -> None:
    asked, was = FinCommand((0.1,) * 4, 4.0), Applied((0.1,) * 4, 4.0, True, False)
    # valid as far in the future as rounding may put it, and no further
    cases = [(heard(0.0), True), (heard(1e-6), True), (heard(1.5e-6), False), (heard(1.0), False)]
    cases += [(heard(0.0, ok=False), False), (heard(0.0, fresh=False), False), (silence(4), False)]
    cases += [(heard(0.0, value=LEVEL._replace(**{f: b})), False) for f in Ahrs._fields for b in NON_FINITE]
    cases += [(heard(t), False) for t in NON_FINITE]
    for frame, good in cases:
        answer = make(module).limit(Tick(0, DT_NS), ModeState(Mode.HOLD, False, 0), frame, asked, was)
        assert (answer.fins == asked.fins) is good
        assert (answer.n == asked.n) is good
    part = make(module)
    for k, frame in (
        (40, heard(0.4)),
        (41, heard(-9.0)),
        (89, heard(math.nan)),
    ):  # an old or non-finite attitude does not shorten the time
        answer = part.limit(Tick(k, DT_NS), ModeState(Mode.HOLD, False, 0), frame, asked, was)
        assert answer.fins == asked.fins


def non_finite_commands_hold_then_centre(module: Any) -> None:
    commands = [FinCommand((0.1,) * i + (b,) + (0.1,) * (3 - i), 4.0) for i in range(4) for b in NON_FINITE]
    commands += [FinCommand((0.1,) * 4, b) for b in NON_FINITE]
    commands += [FinCommand((0.1,) * 3, 4.0), FinCommand((0.1,) * 5, 4.0), FinCommand((), 4.0)]
    for command in commands:
        part, was = make(module), Applied((0.05,) * 4, 2.0, True, False)
        for k in range(8):
            was = limit(part, command.fins, command.n, was, k)
            steps = max(0, k + 1 - HOLD)
            assert close(was, tuple(max(0.0, 0.05 - steps * x * 0.01) for x in RATE), max(0.0, 2.0 - 0.5 * steps))
            assert was.limited
        good = limit(part, was.fins, was.n, was, 8)
        assert good == Applied(was.fins, was.n, True, False)
        for k in range(9, 9 + HOLD):  # the count restarts
            assert limit(part, command.fins, command.n, good, k).fins == good.fins


def a_non_finite_previous_output_is_replaced_by_zero(module: Any) -> None:
    for bad in NON_FINITE:
        answer = limit(make(module), TRAVEL, N_MAX, Applied((bad,) * 4, bad, True, False))
        assert close(answer, (0.01, 0.02, 0.005, 0.04), 0.5)
        answer = limit(make(module), (bad,) * 4, bad, Applied((bad,) * 4, bad, True, False))
        assert close(answer, (0.0,) * 4, 0.0)
    for fins in ((), (0.1,) * 3, (0.1,) * 5):
        assert close(limit(make(module), TRAVEL, 0.0, Applied(fins, 0.0, True, False)), (0.01, 0.02, 0.005, 0.04), 0.0)
    for sign in (1.0, -1.0):  # beyond the travel: back inside at once, whatever the rate
        out = Applied((sign,) * 4, sign * 99.0, True, False)
        answer = limit(make(module), (sign * 0.05,) * 4, sign * 3.0, out)
        assert close(answer, (sign * 0.39, sign * 0.28, sign * 0.195, sign * 0.06), sign * 19.5)


def limits_that_are_not_positive_and_finite_are_refused(module: Any) -> None:
    for bad in (0.0, -0.1, math.nan, math.inf):
        for i in range(4):
            with pytest.raises(ValueError, match="> 0 and finite"):
                make(module, travel=(*TRAVEL[:i], bad, *TRAVEL[i + 1 :]))
            with pytest.raises(ValueError, match="> 0 and finite"):
                make(module, rate=(*RATE[:i], bad, *RATE[i + 1 :]))
        with pytest.raises(ValueError, match="> 0 and finite"):
            make(module, n_max=bad)
    for rates in (RATE[:3], (*RATE, 1.0)):
        with pytest.raises(ValueError, match="as many"):
            make(module, rate=rates)


def thawed_gate_continues_as_the_frozen_one(module: Any) -> None:
    part, twin = make(module), make(module)
    for k in range(2):
        limit(part, (math.nan,) * 4, 0.0, k=k)
    twin.thaw(part.freeze())
    was = Applied((0.05,) * 4, 2.0, True, False)
    for k in range(2, 6):
        tick, mode, command = Tick(k, DT_NS), ModeState(Mode.HOLD, False, 0), FinCommand((math.nan,) * 4, 0.0)
        frame = heard(0.0, fresh=False)
        assert twin.limit(tick, mode, frame, command, was) == part.limit(tick, mode, frame, command, was)
        assert twin.freeze() == part.freeze() == (k + 1, 0.01)


PROPERTIES: list[Callable[[Any], None]] = [
    angles_stay_within_their_limits,
    rates_stay_within_their_limits,
    one_limited_value_sets_the_flag,
    output_is_armed_in_every_mode_but_disarmed,
    disarmed_is_centred_and_stopped_at_once,
    ahrs_timeout_centres_and_stops,
    surface_needs_no_attitude,
    release_of_the_weight_passes,
    only_good_attitude_counts,
    non_finite_commands_hold_then_centre,
    a_non_finite_previous_output_is_replaced_by_zero,
    limits_that_are_not_positive_and_finite_are_refused,
    thawed_gate_continues_as_the_frozen_one,
]


@pytest.mark.parametrize("holds", PROPERTIES, ids=lambda f: f.__name__)
def test_gate(holds: Callable[[Any], None]) -> None:
    holds(gate)


ANY = st.floats(allow_nan=True, allow_infinity=True)
MODES = st.sampled_from(Mode)
COMMANDS = st.builds(FinCommand, st.one_of(st.tuples(*[ANY] * 4), st.lists(ANY, max_size=6).map(tuple)), ANY)
PASTS = st.builds(Applied, st.lists(ANY, max_size=6).map(tuple), ANY, st.booleans(), st.booleans())
AHRS = st.builds(Heard, st.builds(Ahrs, *[ANY] * 6), ANY, st.booleans(), st.booleans())
CYCLES = st.tuples(MODES, COMMANDS, st.one_of(st.just(Heard(LEVEL, 0.0, True, True)), AHRS))


@given(PASTS, st.lists(CYCLES, min_size=1, max_size=12), st.integers(0, 10**9))
def test_output_is_finite_and_within_all_limits_for_any_input(
    past: Applied, cycles: list[tuple[Mode, FinCommand, Heard[Ahrs]]], k: int
) -> None:
    part, was = make(), past
    for i, (mode, command, ahrs) in enumerate(cycles):
        tick = Tick(k + i, DT_NS)
        frame = replace(silence(4), ahrs=ahrs)
        now = part.limit(tick, ModeState(mode, False, 0), frame, command, was)
        assert len(now.fins) == 4
        assert all(abs(x) <= top for x, top in zip((*now.fins, now.n), (*TRAVEL, N_MAX), strict=True))
        if mode is Mode.DISARMED:
            assert (now.fins, now.n, now.armed) == ((0.0,) * 4, 0.0, False)
        else:
            assert now.armed
            if i > 0:
                moved = [abs(a - b) for a, b in zip((*now.fins, now.n), (*was.fins, was.n), strict=True)]
                assert all(m <= r * 0.01 + 1e-12 for m, r in zip(moved, (*RATE, N_RATE), strict=True))
        assert now.limited is not ((now.fins, now.n) == (command.fins, command.n))
        was = now


# Mutants that no test can tell from the gate, each with its reason.
EQUIVALENT = {
    # the same time of validity again changes nothing
    "since < ahrs.t_valid <= tick.t + _TIME_ROUNDING -> since <= ahrs.t_valid <= tick.t + _TIME_ROUNDING",
}

COMPARISONS = {ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.Gt), ast.Gt: (ast.GtE, ast.Lt), ast.GtE: (ast.Gt,)}
COMPARISONS |= {ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,)}
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div}


def mutations(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the mutations of one node."""
    match node:
        case ast.Compare():
            for i, op in enumerate(node.ops):
                for other in COMPARISONS.get(type(op), ()):
                    yield ast.Compare(node.left, [*node.ops[:i], other(), *node.ops[i + 1 :]], node.comparators)
        case ast.BinOp() if type(node.op) in OPERATORS:
            yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
        case ast.BoolOp():
            yield ast.BoolOp(ast.And() if isinstance(node.op, ast.Or) else ast.Or(), node.values)
            for i in range(len(node.values)):
                yield (
                    ast.BoolOp(node.op, node.values[:i] + node.values[i + 1 :])
                    if len(node.values) > 2
                    else node.values[i]
                )
        case ast.Call(func=ast.Name(id="min" | "max" as name)):
            yield ast.Call(ast.Name("max" if name == "min" else "min", ast.Load()), node.args, [])
            yield from node.args  # a clip that is missing
        case ast.UnaryOp():
            yield node.operand
        case ast.IfExp():
            yield node.body
            yield node.orelse
        case ast.If():
            yield ast.If(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
            yield ast.Pass()
        case ast.Constant(value=bool(b)):
            yield ast.Constant(not b)
        case ast.Constant(value=float(x)):
            yield ast.Constant(x + 1.0)
        case ast.Constant(value=int(i)):
            yield ast.Constant(i + 1)


def mutants() -> Iterator[tuple[str, ast.Module]]:
    """Yield (description, module) for every mutation of every node in the gate's functions."""
    tree = ast.parse(inspect.getsource(gate))
    bodies = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    inside = {id(m) for body in bodies for statement in body.body for m in ast.walk(statement)}
    inside -= {id(n.value) for n in ast.walk(tree) if isinstance(n, ast.keyword) and n.arg == "strict"}  # an assertion
    wanted = [i for i, n in enumerate(ast.walk(tree)) if id(n) in inside]
    for i in wanted:
        for j, _ in enumerate(mutations(list(ast.walk(tree))[i])):
            mutant = copy.deepcopy(tree)
            node = list(ast.walk(mutant))[i]
            new = list(mutations(node))[j]
            text = f"{ast.unparse(node)} -> {ast.unparse(new)}"
            yield text, ast.fix_missing_locations(_Replace(node, new).visit(mutant))


class _Replace(ast.NodeTransformer):
    def __init__(self, old: ast.AST, new: ast.AST) -> None:
        self.old, self.new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        return self.new if node is self.old else super().visit(node)


def survives(tree: ast.Module) -> bool:
    module = ModuleType(gate.__name__)
    exec(compile(tree, "mutant", "exec"), module.__dict__)
    for holds in PROPERTIES:
        try:
            holds(module)
        except Exception:
            return False
        except BaseException as error:
            if type(error).__name__ != "Failed":  # pytest.raises that saw nothing
                raise
            return False
    return True


def test_every_mutant_of_the_gate_is_caught() -> None:
    every = list(mutants())
    assert len(every) >= 90
    assert {text for text, tree in every if survives(tree)} == EQUIVALENT


def test_the_gate_itself_survives() -> None:
    assert survives(ast.parse(inspect.getsource(gate)))
