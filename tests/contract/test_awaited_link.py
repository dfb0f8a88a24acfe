"""A link to a station whose adapter is plugged in later, or whose network comes up later."""

from __future__ import annotations

import errno
import os
import pty
import select
import termios
import tty
from pathlib import Path
from types import SimpleNamespace

import pytest
import serial

from firmware_py.adapters.ground import awaited_link, stream_links
from firmware_py.adapters.ground.awaited_link import AwaitedLink
from firmware_py.adapters.ground.mavlink_ground import GroundError, open_link


@pytest.fixture
def passing(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, which a test lets pass."""
    now = [0.0]
    monkeypatch.setattr(awaited_link, "time", SimpleNamespace(monotonic=lambda: now[0]))
    return now


def test_a_radio_that_is_plugged_in_later_is_opened_then(tmp_path: Path, passing: list[float]) -> None:
    place = tmp_path / "radio"
    link = open_link(f"serial:{place}:57600", absent=True)
    assert isinstance(link, AwaitedLink)
    assert link.missing == "No such file or directory"
    link.send(b"nobody")
    assert (link.receive(), link.fileno(), link.lost, link.overrun) == ([], -1, 0, 0)
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    place.symlink_to(os.ttyname(theirs))
    assert link.receive() == []
    assert link.missing
    passing[0] += awaited_link.RETRY_S
    link.receive()
    assert link.missing == ""
    link.send(b"out")
    assert os.read(ours, 9) == b"out"
    os.write(ours, b"in")
    assert select.select([link.fileno()], [], [], 30.0)[0]
    assert link.receive() == [b"in"]
    link.close()
    link.close()
    os.close(ours)
    os.close(theirs)


def test_an_address_that_is_not_ours_yet_is_waited_for(passing: list[float]) -> None:
    link = open_link("udpin:192.0.2.1:14550", absent=True)
    assert isinstance(link, AwaitedLink)
    assert link.missing == "Cannot assign requested address"
    passing[0] += 1.0
    assert link.receive() == []


def test_a_name_that_is_not_known_is_not_looked_up_in_flight(
    passing: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    link = open_link("tcp:no-such-host.invalid:5760", absent=True)
    assert isinstance(link, AwaitedLink)
    assert link.missing.endswith("given up: write the host's address in numbers")
    monkeypatch.setattr("socket.gethostbyname", None)
    passing[0] += 10.0
    assert link.receive() == []


@pytest.mark.parametrize("number", [errno.EBUSY, errno.EACCES])
def test_a_radio_that_may_not_be_opened_yet_is_waited_for(monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """At boot a modem manager tries its port, and udev gives it to its group when it is there already."""

    def refused(*_words: object, **_options: object) -> None:
        raise serial.SerialException(number, os.strerror(number))

    monkeypatch.setattr(serial, "Serial", refused)
    link = open_link("serial:/dev/radio:57600", absent=True)
    assert isinstance(link, AwaitedLink)
    assert link.missing == os.strerror(number)
    with pytest.raises(GroundError, match=os.strerror(number)):
        open_link("serial:/dev/radio:57600")


def test_a_radio_that_goes_while_it_is_opened_is_waited_for(
    monkeypatch: pytest.MonkeyPatch, passing: list[float]
) -> None:
    def refused(*_words: object, **_options: object) -> None:
        raise termios.error(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(serial, "Serial", refused)
    link = open_link("serial:/dev/radio:57600", absent=True)
    assert isinstance(link, AwaitedLink)
    assert link.missing == os.strerror(errno.EIO)

    def gone(*_words: object, **_options: object) -> None:
        raise serial.SerialException(errno.ENOENT, os.strerror(errno.ENOENT))

    monkeypatch.setattr(serial, "Serial", gone)
    passing[0] += 10.0
    assert link.receive() == []
    assert link.missing == os.strerror(errno.ENOENT), "why it is not there now"


def test_a_radio_that_goes_while_it_is_opened_again_is_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    master, line = pty.openpty()
    tty.setraw(line)
    link = open_link(f"serial:{os.ttyname(line)}:57600")

    def refused(*_words: object, **_options: object) -> None:
        raise termios.error(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(serial, "Serial", refused)
    monkeypatch.setattr(stream_links, "RETRY_S", 0.0)
    os.close(line)
    os.close(master)  # the other end hangs up
    assert [link.receive() for _ in range(4)] == [[]] * 4
    link.close()


@pytest.mark.parametrize("text", ["serial:/dev/null:57600", "udpout:127.0.0.1:0", "radio"])
def test_what_will_never_be_a_link_is_an_error(text: str) -> None:
    with pytest.raises(GroundError):
        open_link(text, absent=True)


def test_without_patience_it_is_an_error() -> None:
    with pytest.raises(GroundError, match="cannot be opened"):
        open_link("serial:/dev/no-such-radio:57600")
