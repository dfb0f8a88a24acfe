"""report.html: the figures and tables of the paper, made by this project's plant, estimators, laws and simulator."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from firmware_py.run import provenance, version
from sternplane.paper import differences, tables
from sternplane.paper.control import StepFlight
from sternplane.paper.design import Comparison
from sternplane.paper.estimation import Estimation
from sternplane.paper.figures import Figure
from sternplane.paper.plots import plot
from sternplane.report.page import Heading, Page, Section, Table, plot_section, render, rows_of
from sternplane.sitl.taken_settings import told


def page(
    found: Estimation,
    rows: list[Comparison],
    flown: Mapping[str, Mapping[str, StepFlight]],
    figures: Iterable[Figure],
    settings: Sequence[str] = (),
) -> str:
    """Return the page as HTML; `settings` are those of the flights."""
    drawn = {figure.name: [*_figure(figure)] for figure in figures}
    sections = [
        Heading("Estimation (section 2)", anchor="estimation"),
        *drawn["fig3"],
        _wide("Table 1: steady-state error", tables.table_1(found)),
        *(section for name in ("fig4", "fig5", "fig6", "fig7", "excited") for section in drawn[name]),
        Heading("Design (section 3)", anchor="design"),
        _wide("Eq. 27 to 33", tables.equations(rows)),
        Heading("Flights (section 4)", anchor="flights"),
        *drawn["fig9"],
        _wide("Fig. 9 in figures", tables.flights(flown["fig9"])),
        *drawn["fig10"],
        _wide("Fig. 10 in figures", tables.flights(flown["fig10"])),
        Heading("What differs, and why", anchor="differences"),
        *differences.sections(found, rows, flown),
        _wide("Made by", Table(_made_by(), style="log")),
    ]
    status, good = differences.outcome(found)
    return render(
        Page(
            title="The paper, flown again",
            status=status,
            mood="good" if good else "bad",
            description="J.-Y. Kim, “Controller Design for an Autonomous Underwater Vehicle Using Estimated "
            "Hydrodynamic Coefficients”, with this project's plant, estimators, laws and simulator.",
            identity=told(settings),
            key_figures={"": _key_figures(found, flown)},
            sections=sections,
            footnote="The figures are beside this page as PNG files, the numbers in results.json, the flights in "
            "vehicles and flights: `sternplane sitl --config DIR/vehicles/smo --scenario paper-depth` flies it again"
            f"{', with the same --set' if settings else ''}.",
        )
    )


def _figure(figure: Figure) -> Iterator[Section | Heading]:
    """Yield a heading, and a section for each pair (or three) of axes."""
    yield Heading(figure.title, figure.note)
    for panel in figure.panels:
        yield plot_section(plot(panel), wide=panel.lines[0].z is not None)


def _key_figures(found: Estimation, flown: Mapping[str, Mapping[str, StepFlight]]) -> list[tuple[str, str]]:
    errors = {who: [abs(error) for error in one.errors.values()] for who, one in found.learned.items()}
    settling = {who: tables.number(one.figures["settling_s"], "{:.1f} s") for who, one in flown["fig9"].items()}
    return [
        ("EKF, greatest error of the ten", f"{max(errors['ekf']):.2g} %"),
        ("SMO, constant L, errors", f"{min(errors['smo']):.0f} to {max(errors['smo']):.0f} %"),
        ("SMO, weighted L, under PRBS, errors", f"at most {max(errors['smo_prbs']):.2g} %"),
        ("1 m of depth, law from the EKF, settled after", settling["ekf"]),
        ("1 m of depth, law from the SMO, settled after", settling["smo"]),
        ("1 m of depth, PID, settled after", settling["pid"]),
    ]


def _wide(title: str, table: Table) -> Section:
    return Section(title, tables=(table,), wide=True)


def _made_by() -> list[list[str]]:
    made = {"revision": version.git_revision(), **provenance.fingerprint(), **provenance.versions()}
    return rows_of(made.items())
