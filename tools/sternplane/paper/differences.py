"""What differs from the paper, and why: words, with this run's own figures in them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sternplane.paper import tables
from sternplane.paper.control import IDEAL, Flown
from sternplane.paper.design import Row
from sternplane.paper.estimation import LENGTH, SHARE, STD, Estimation
from sternplane.paper.printed import TABLE_1

_BALANCED = 0.05
"""Forces whose sum is below this part of the greatest are taken to balance."""


def sections(found: Estimation, rows: list[Row], flown: Mapping[str, Mapping[str, Flown]]) -> list[tuple[str, str]]:
    """(title, HTML) of each section."""
    return [
        ("What the paper does not say, and what was taken", _taken(found)),
        ("The extended Kalman filter", _ekf(found)),
        ("The hyperplane on which a constant-gain observer rests", _hyperplane(found)),
        ("The design", _design(rows)),
        ("The flights", _flights(flown)),
        ("Errata of the print", tables.errata()),
    ]


def verdict(found: Estimation) -> tuple[str, bool]:
    """One phrase on Table 1, and whether it is as it should be."""
    errors = found.learned["ekf"].errors
    over = [name for name, limit in TABLE_1["ekf"].items() if not abs(errors[name]) <= limit]
    if over:
        return f"EKF above the paper's Table 1 in {', '.join(over)}", False
    return "every EKF row of Table 1 is at or under the paper's", True


def _taken(found: Estimation) -> str:
    pitch, at = math.degrees(found.nose[0]), found.nose[1]
    wrong = [name for name, error in found.learned["smo"].errors.items() if error < 100.0 * (SHARE - 1.0)]
    return f"""<ul>
<li><b>Where the estimates begin:</b> at {SHARE:g} of the true value, all ten. Prior and gains come from a vehicle
file that is wrong by as much, so neither estimator is told the truth. Other beginnings are below. From 0 the
constant-gain observer would come to the other sign in {", ".join(wrong)}, since its errors are in proportion to those
at the start; half was taken because laws can be flown with what comes of it.</li>
<li><b>How long:</b> {LENGTH:g} s. Speeds then hardly change any more. With rudder and elevator together the motion
ends in a steady spiral and could go on; elevator alone stands this boat on its nose ({pitch:.0f}° of pitch after
{at:.0f} s), where Euler angles fail.</li>
<li><b>The propeller:</b> 500 rpm, which trims at 1.83 m/s; the start is at 1.8 m/s, as in the paper.</li>
<li><b>Noise:</b> none, as in the paper. The filter is told of {STD[0]:.3g} m/s, {math.degrees(STD[3]):.2g}°/s and, of
roll and pitch, {math.degrees(STD[6]):.2g}°: a tenth of what the simulated sensors have. Both estimators are given all
nine outputs at 100 Hz, the fins' true angles, and water that stands still.</li>
<li><b>The plant:</b> Healey and Lienard's equations in a program that shares no line with the observers' model. In
Fig. 3 to 7 the fins are at their angles at once; in Fig. 9 and 10 the boat is flown through bus, servos, sensors and
navigation.</li>
</ul>"""


def _ekf(found: Estimation) -> str:
    errors = found.learned["ekf"].errors
    worst = max(errors, key=lambda name: abs(errors[name]))
    share = 100.0 * min(found.paper["ekf"].values())
    return f"""<p>Without noise and with a model that is right, nothing in this motion keeps a filter from the true
coefficients: at the end the worst is {tables.percent(errors[worst])} % ({worst}). The paper's filter stays 10 to 23 %
off in sway. Why cannot be told from the print: it does not say how it discretises nor what P, Q and R are, and its
Eq. 13, read as printed, forgets the coefficients at every step. Its errors are not merely what a steady motion hides,
for then they would balance in each equation; in this motion at least {share:.0f} % of the greatest force is left over
(last column of the next table).</p>"""


def _hyperplane(found: Estimation) -> str:
    smo, weighted = found.learned["smo"].errors, found.learned["smo_prbs"].errors
    low, high = min(map(abs, smo.values())), max(map(abs, smo.values()))
    left = 100.0 * max(at.share for at in found.planes["smo"].values())
    near = [name for name, share in found.paper["smo"].items() if share < _BALANCED]
    far = [name for name, share in found.paper["smo"].items() if share >= _BALANCED]
    return f"""<p>With a constant L each coefficient is moved by the switching term of its equation (Eq. 6), and that
term stands for the <i>sum</i> of what the equation gets wrong (Eq. 10). When the sum is zero nothing moves any more.
One equation for two or three coefficients is a hyperplane; the observer goes to it along a line that L fixes, and
rests where it meets it, which depends on where it began. From {SHARE:g} of the truth the errors are {low:.0f} to
{high:.0f} %, while the forces' sums are right to {left:.1f} % of their greatest part. A steady motion has but one
such plane for each equation, so there no L helps, constant or weighted.</p>
{tables.hyperplanes(found)}
<p>“At best”: the paper gives no signs; of all signs these make the errors balance best, at the end of this motion.
Balanced within {100.0 * _BALANCED:.0f} % is the paper's SMO in {", ".join(near) or "no equation"}, as a constant L
would have it; not in {", ".join(far) or "none"}: motion, length or gains must have been others.</p>
<p>Under a PRBS the planes turn with the motion, and with L weighted by the regressor the observer ends at most
{max(map(abs, weighted.values())):.2g} % off. Both observers' errors at the end are in proportion to those at the
start:</p>
{tables.starts(found)}"""


def _design(rows: list[Row]) -> str:
    missed = [row for row in rows if not row.follows]
    gaps = "; ".join(
        f"{row.number.what}, printed {row.number.printed}, is {tables.span(row.low, row.high)}" for row in missed
    )
    ours = [(row.found["ekf"], row.found["truth"]) for row in rows]
    off = max(abs(ekf / true - 1.0) for ekf, true in ours if ekf is not None and true)
    return f"""<p>The printed models follow from Table 1: Eq. 27 from the true coefficients with +0.12 and +0.26 %,
the first row of Eq. 31 with Y_v 23.29 % too small, Y_r 9.61 % and Y_dr 14.53 % too large. The paper's laws thus carry
its EKF's errors in sway. {f"What does not follow: {gaps}." if gaps else "All of it follows."} Surfaces and gains
follow from the printed models by size; by sign, Eq. 29 and 33 have all terms but the tanh turned round, which would
not put the poles where the paper wants them. What is flown here is Eq. 25.</p>
<p>The surface of Eq. 28 depends on the poles and the speed alone, whatever the coefficients. Our EKF's errors change
no number by more than {100.0 * off:.2g} %, so its laws are those of the truth; they differ from Eq. 31 to 33 by what
the paper's errors in sway did.</p>"""


def _flights(flown: Mapping[str, Mapping[str, Flown]]) -> str:
    dive, turn = flown["fig9"], flown["fig10"]
    travel = {who: tables.number(one.figures["fin_travel_deg_s"], "{:.1f}°/s") for who, one in turn.items()}
    settling = {who: tables.number(one.figures["settling_s"], "{:.0f} s") for who, one in dive.items()}
    over = tables.number(dive["pid"].figures["overshoot_pct"], "{:.1f} %")
    return f"""<p><b>Depth.</b> As in the paper it hardly matters whose coefficients the law is designed from: it
settles after {settling["ekf"]} with the EKF's and {settling["smo"]} with the SMO's. The poles, -0.25 and -0.26 1/s,
are slow by choice. The paper calls PID similar; ours takes {settling["pid"]} and goes {over} over.</p>
<p><b>Heading.</b> The paper's boundary layer (1.5 rad of rudder over 0.05 rad) makes 30 rad of rudder of a radian of
sigma. After each step the rudder swings from stop to stop: {travel["truth"]} on average with the true coefficients,
{travel["ekf"]} with the EKF's. With servos that hardly lag (0.01 s instead of 0.1 s, no play) {travel[IDEAL]} are
left: the limit cycle is the servos', of whose lag the paper says nothing. The law from the SMO's coefficients asks
for {travel["smo"]}, where the paper reports a little more rudder than with the EKF's; its SMO rested elsewhere.</p>
<p><b>The path</b> steps where its waypoint is accepted, 5 m ahead of it. The line of sight looks 15 m ahead.</p>"""
