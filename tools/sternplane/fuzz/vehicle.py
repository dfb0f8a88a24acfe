"""The vehicle's side of the links, as `firmware_py.run.ground_links` opens it, but for sockets, clocks and disks."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from firmware_py import app, config_files
from firmware_py.mavlink.base.codec import Codec, Message
from firmware_py.mavlink.base.identity import Identity
from firmware_py.mavlink.base.link_configuration import LinkConfiguration
from firmware_py.mavlink.base.signing import UNSIGNED_ACCEPTED, Signing
from firmware_py.mavlink.files.tree import LogFile
from firmware_py.mavlink.link import MAX_PARSED_PER_TICK
from firmware_py.mavlink.node import Node, SharedState
from firmware_py.mavlink.parameters.store import ParameterStore
from firmware_py.reconfiguration import node_settings
from firmware_py.run import kept_plans
from sternplane.fuzz.rules import Broken

LINKS = (
    LinkConfiguration(Identity.ARDUSUB),
    LinkConfiguration(Identity.GENERIC, stream=True),
    LinkConfiguration(Identity.ARDUSUB, bytes_per_s=1000.0, stream=True, high_latency=True),
)
"""UDP, TCP and a slow serial line."""
KEY = bytes(range(32))
_NOW = 10**12
"""Of signatures, 10 us since 2015; no clock is asked, so that a flight can be flown again."""
Parse = Callable[..., tuple[list[Message], int]]


class Logs:
    """A `files.tree.LogStorage` whose disk is often slow and sometimes broken."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._content = {"one.mcap": rng.randbytes(5000), "two.mcap": rng.randbytes(300), "three.mcap": b""}
        self.erased = 0

    def logs(self) -> Sequence[LogFile] | None:
        """See `files.tree.LogStorage`."""
        if self._asked():
            return None
        return [
            LogFile(name, len(content), 1_800_000_000, name == "two.mcap") for name, content in self._content.items()
        ]

    def read(self, name: str, offset: int, n: int) -> bytes | None:
        """See `files.tree.LogStorage`."""
        return None if self._asked() else self._content[name][offset : offset + n]

    def erase(self) -> bool:
        """See `files.tree.LogStorage`."""
        if self._asked():
            return False
        self.erased += 1
        return True

    def _asked(self) -> bool:
        share = self._rng.random()
        if share < 0.01:
            raise OSError(5, "Input/output error")
        return share < 0.2


@dataclass
class FuzzedVehicle:
    """A node, how many messages its links parsed, and the files that it gave to be saved."""

    node: Node
    store: ParameterStore
    signing: Signing | None
    logs: Logs
    heard: int = 0
    kept: dict[str, bytes] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, float]:
        """Return the value of every parameter."""
        return {setting.name: setting.value for setting in self.store.settings}

    def tally(self) -> dict[str, int]:
        """Return what became of everything that was received, over all links."""
        codecs = [link.codec for link in self.node.links]
        return {
            "messages heard": self.heard,
            "malformed": sum(codec.malformed for codec in codecs),
            "refused: signature": sum(codec.refused for codec in codecs),
            "of unknown id": sum(codec.unknown for codec in codecs),
            "cut: too much for a tick": sum(codec.dropped for codec in codecs),
            "dropped: too much for a tick, or to wait": sum(
                link.dropped + link.not_taken + link.not_sent for link in self.node.links
            ),
            "answers that could not be packed": sum(codec.not_encodable for codec in codecs),
        }


def open_vehicle(
    configuration: Mapping[str, Any], signed: bool, rng: random.Random, state: Path | None = None
) -> FuzzedVehicle:
    """Make a node with all services; on `signed` links it obeys only who has the KEY; `state` is the saved state.

    Raises:
        ParamError: what was kept cannot be used.
    """
    settings, store = node_settings(config_files.autopilot_params(configuration)), app.parameter_store(configuration)
    signing = Signing(KEY, _NOW) if signed else None
    shared = SharedState(signing, store, kept_plans.plans(configuration, state))
    node = Node(settings, app.vehicle_description(configuration), LINKS, shared)
    node.allow_end()
    found = FuzzedVehicle(node, store, signing, Logs(rng))
    node.offer_logs(found.logs)
    for link in node.links:
        link.codec.parse = _audited(found, link.codec, link.codec.parse)  # type: ignore[method-assign]
    return found


def _audited(found: FuzzedVehicle, codec: Codec, parse: Parse) -> Parse:
    """Return `parse` with a check: each place that it examined became a message or was counted; and not too many.

    With a key, what is heard was signed, or is of the few that may come without.
    """

    def audited(data: bytes, most: int, t_ns: int = 0) -> tuple[list[Message], int]:
        before = codec.malformed + codec.refused + codec.unknown
        messages, looked = parse(data, most, t_ns)
        counted = len(messages) + codec.malformed + codec.refused + codec.unknown - before
        if not counted <= looked <= min(counted + 1, MAX_PARSED_PER_TICK) or looked > most:
            raise Broken(f"counted: {counted} of {looked} places of at most {most}: {data.hex()}")
        for message in messages if found.signing is not None else ():
            if not message.get_signed() and message.get_msgId() not in UNSIGNED_ACCEPTED:
                raise Broken(f"signed: {message.get_type()} was heard unsigned: {data.hex()}")
        found.heard += len(messages)
        return messages, looked

    return audited
