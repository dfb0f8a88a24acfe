"""Particulars of a hull in a published table: what they are called there, and what is assumed where they lack."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from firmware_py.error_text import quoted
from firmware_py.params import ParamError
from sternplane.vehicles.derivative_table import Entry
from sternplane.vehicles.particular_units import factor
from sternplane.vehicles.units import G

_LENGTHS = {"weight_n": 2, "buoyancy_n": 2, "mass_kg": 3, "I_x": 5, "I_y": 5, "I_z": 5, "I_xy": 5, "I_yz": 5, "I_xz": 5}
"""Powers of L in rho/2 L^k of what may be given without dimension, as m' and Iy'; W' and B' are over U^2 too."""


_LEAST_MASS = 5e-4
"""Of m', over rho/2 L^3: a hull 50 times as long as thick. A mass that is less in SI, and was given without unit in a
table in prime form, is m'."""
_SAME = 0.02
"""By so much buoyancy and the weight of the water of a volume may differ, by rounding."""


class MissingError(ParamError):
    """A table lacks what no hull can be made without."""


class Known(NamedTuple):
    """A particular: what else it is called, and whether it must be above zero."""

    aliases: str = ""
    positive: bool = True


KNOWN: dict[str, Known] = {
    "length_m": Known("L length Lpp LOA l"),
    "diameter_m": Known("d diam diameter"),
    "height_m": Known("height"),
    "width_m": Known("width"),
    "density_kg_m3": Known("rho density ρ"),
    "mass_kg": Known("m mass"),
    "weight_n": Known("W weight"),
    "buoyancy_n": Known("B buoyancy"),
    "volume_m3": Known("volume nabla ∇ displaced_volume"),
    **{f"I_{a}_kg_m2": Known(f"I{a} I{a}{a} I_{a} I_{a}{a}") for a in "xyz"},
    **{f"I_{a}_kg_m2": Known(f"I{a} I_{a}", positive=False) for a in ("xy", "yz", "xz")},
    **{f"{a}_{c}_m": Known(f"{a}{c} {a}{c.lower()} {a}_{c} {a}_{c.lower()}", False) for c in "GB" for a in "xyz"},
    "speed_m_s": Known("U0 U U_0 u0 u_0 speed"),
    "u_trim_m_s": Known("u_trim"),
    "n_trim_rpm": Known("n_trim rpm"),
    "n_max_rpm": Known("n_max"),
    "thrust_n": Known("Xprop X_prop", positive=False),
    "propeller_diameter_m": Known("D_prop D_propeller D"),
    "wake_fraction": Known("w_prop wake", positive=False),
    "thrust_deduction": Known("t t_prop", positive=False),
    "delta_max_deg": Known("delta_max"),
    "C_dy": Known("Cdy cdy C_DY", positive=False),
    "C_dz": Known("Cdz cdz C_DZ", positive=False),
    **{f"amplitude_{a}_m_s": Known(f"amplitude_{a}") for a in "vw"},
    **{f"amplitude_{a}_deg_s": Known(f"amplitude_{a}") for a in "pqr"},
}
_CALLED = {alias: key for key, known in KNOWN.items() for alias in (key, *known.aliases.split())}
_TEXTS = ("name", "source", "form", "tail", "coriolis")
_CHOICES = {"form": ("dimensional", "prime"), "tail": ("plus", "x"), "coriolis": ("false", "true", "full")}
_SWITCHES = ("symmetric", "left_handed")


@dataclass
class Particulars:
    """What a table says of a hull beside its derivatives, and what had to be assumed.

    Attributes:
        values: by our key, SI; angles and rates in the unit of the key.
        texts: name, source, form ("dimensional" or "prime"), tail ("plus" or "x"), coriolis ("false", "true", "full").
        switches: symmetric, left_handed.
        assumed: a sentence for each number that the table does not have.
        where: the file.
    """

    where: str
    values: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    switches: dict[str, bool] = field(default_factory=dict)
    assumed: list[str] = field(default_factory=list)
    _prime: dict[str, float] = field(default_factory=dict)
    _named: dict[str, str] = field(default_factory=dict)
    _bare: set[str] = field(default_factory=set)

    def take(self, entry: Entry) -> bool:
        """Take an entry if it is a particular; return whether it is.

        Raises:
            ParamError: it is one, with a value that it cannot have, or under a second name.
        """
        name, value = entry.name, entry.value
        self._refuse_twice(name)
        if name.lower() in _TEXTS:
            self.texts[name.lower()] = str(value).lower() if name.lower() == "coriolis" else str(value)
            return True
        if name.lower() in _SWITCHES:
            if isinstance(value, str) and value.lower() not in ("true", "false"):
                raise ParamError(f"{self.where}: {name} = {quoted(value)}: must be true or false")
            self.switches[name.lower()] = value.lower() == "true" if isinstance(value, str) else bool(value)
            return True
        key = _CALLED.get(name)
        if key is None and re.sub("['’′]$", "", name) in _CALLED and name[-1:] in "'’′":
            self._prime[_CALLED[name[:-1]]] = self._number(name, value)
            return True
        if key is None:
            return False
        number = self._number(name, value)
        if not entry.unit.strip():
            self._bare.add(key)
        if KNOWN[key].positive and not number > 0.0:
            raise ParamError(f"{self.where}: {name} = {number:g}: must be above 0")
        try:
            self.values[key] = number * factor(key, entry.unit)
        except ParamError as error:
            raise ParamError(f"{self.where}: {name}: {error}") from None
        return True

    def _refuse_twice(self, name: str) -> None:
        """Refuse a particular under two names, such as m and mass_kg."""
        key = _CALLED.get(name) or _CALLED.get(re.sub("['’′]$", "", name)) or name.lower()
        if key in (*KNOWN, *_TEXTS, *_SWITCHES) and (first := self._named.setdefault(key, name)) != name:
            both = f"{quoted(first)} and {quoted(name)}"
            raise ParamError(f"{self.where}: {both} are the same, which has one value; leave one of them out")

    def _number(self, name: str, value: float | str | bool) -> float:
        if isinstance(value, bool | str) or not math.isfinite(value):
            raise ParamError(f"{self.where}: {name} = {quoted(value)}: must be a number")
        return float(value)

    def get(self, key: str, otherwise: float | None = None) -> float:
        """Return a particular.

        Raises:
            MissingError: the table has none, and nothing is assumed for it.
        """
        if key in self.values:
            return self.values[key]
        if otherwise is None:
            also = f" (or {KNOWN[key].aliases.split()[0]})" if KNOWN[key].aliases else ""
            raise MissingError(f"{self.where}: {key}{also} is missing")
        return otherwise

    def assume(self, key: str, value: float, why: str) -> None:
        """Fill in what the table does not have."""
        if key not in self.values:
            self.values[key] = value
            self.assumed.append(f"{key} = {value:.4g}: {why}")

    def _refuse_prime_mass(self, L: float) -> None:
        """Refuse a mass that is given as in SI, and is one over rho/2 L^3."""
        mass = self.values.get("mass_kg", math.inf)
        scale = 0.5 * self.values["density_kg_m3"] * L**3
        if self.texts.get("form") == "prime" and "mass_kg" in self._bare and mass < _LEAST_MASS * scale:
            name = self._named["mass_kg"]
            raise ParamError(
                f"{self.where}: {name} = {mass:g}: no mass in kg of a hull of {L:g} m; a mass over rho/2 L^3 is m': "
                f"write m' = {mass:g} for {mass * scale:.4g} kg, or the mass in kg"
            )

    def complete(self) -> None:
        """Fill in everything that a hull needs.

        Raises:
            MissingError: length, mass or speed are missing.
            ParamError: a mass is no mass in SI, or buoyancy and volume contradict each other.
        """
        v = self.values
        L = self.get("length_m")
        self.assume("density_kg_m3", 1025.0, "sea water")
        U = self.get("speed_m_s")
        for key, value in self._prime.items():
            if key == "volume_m3":
                v[key] = value * L**3
                continue
            power = _LENGTHS.get(key.removesuffix("_kg_m2"), _LENGTHS.get(key))
            pressure = 0.5 * v["density_kg_m3"] * (U * U if key in ("weight_n", "buoyancy_n") else 1.0)
            v[key] = value * pressure * L**power if power else value * L
        if "diameter_m" in v:
            v.setdefault("height_m", v["diameter_m"])
            v.setdefault("width_m", v["diameter_m"])
        self._refuse_prime_mass(L)
        displaced = v["density_kg_m3"] * v.get("volume_m3", 0.0)
        if displaced and abs(v.get("buoyancy_n", displaced * G) / (displaced * G) - 1.0) > _SAME:
            both = f"volume_m3 = {v['volume_m3']:.4g} displaces {displaced * G:.4g} N of water, and buoyancy_n"
            raise ParamError(
                f"{self.where}: {both} = {v['buoyancy_n']:.4g}; leave one of them out, or correct the density"
            )
        if displaced:
            self.assume("buoyancy_n", displaced * G, "of the water displaced, density times volume")
        if "mass_kg" not in v and "weight_n" in v:
            self.assume("mass_kg", v["weight_n"] / G, "weight over 9.81")
        if displaced:
            self.assume("mass_kg", displaced, "that of the water displaced")
        if "mass_kg" not in v and {"height_m", "width_m"} <= v.keys():
            volume = 0.7 * L * 0.25 * math.pi * v["height_m"] * v["width_m"]
            self.assume("mass_kg", v["density_kg_m3"] * volume, "the water displaced, 0.7 of a cylinder of its size")
        self.get("mass_kg")
        d = math.sqrt(v["mass_kg"] / (v["density_kg_m3"] * 0.7 * L * 0.25 * math.pi))
        self.assume("height_m", v.get("width_m", d), "a round hull of that mass, 0.7 of the cylinder around it")
        self.assume("width_m", v["height_m"], "as its height")
        self.assume("weight_n", v["mass_kg"] * G, "mass times 9.81")
        self.assume("buoyancy_n", v["weight_n"], "as the weight")
        for key, axis in (("I_y_kg_m2", "I_z_kg_m2"), ("I_z_kg_m2", "I_y_kg_m2")):
            if axis in v:
                self.assume(key, v[axis], f"as {axis}")
        self.assume("I_y_kg_m2", v["mass_kg"] * L * L / 16.0, "radius of gyration L / 4")
        self.assume("I_z_kg_m2", v["I_y_kg_m2"], "as I_y_kg_m2")
        I_x = 0.1 * v["mass_kg"] * v["height_m"] * v["width_m"]
        self.assume("I_x_kg_m2", I_x, "radius of gyration 0.32 of the height")
        if "z_G_m" not in v and "z_B_m" not in v:
            self.assume("z_G_m", 0.1 * v["height_m"], "a tenth of the height below the centre of buoyancy")
        self.assume("delta_max_deg", 20.0, "usual")


def unknown_text(name: str) -> str:
    """Return what to do with a name that nobody knows: what was probably meant, or where all names are told."""
    if any(angle in name.lower() for angle in ("theta", "phi")):
        return "weight and z_G make what rights the hull: write z_G, or z_G = -Mtheta / W"
    near = difflib.get_close_matches(name, sorted(_CALLED), n=1)
    return f"did you mean {near[0]}?" if near else "configs/hull.md tells the names"


def read_particulars(entries: Iterable[Entry], where: str) -> tuple[Particulars, tuple[Entry, ...]]:
    """Return the particulars of a table, and the entries that are none.

    Raises:
        ParamError: a particular with an impossible value.
    """
    found = Particulars(where)
    rest = tuple([entry for entry in entries if not found.take(entry)])
    for text, choices in _CHOICES.items():
        if found.texts.get(text, choices[0]) not in choices:
            raise ParamError(f"{where}: {text} = {quoted(found.texts[text])}: must be {' or '.join(choices)}")
    return found, rest
