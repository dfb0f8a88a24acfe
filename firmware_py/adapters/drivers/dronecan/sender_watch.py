"""Two senders under one node id, told by the transfer ids of one type: each node counts its own."""

from __future__ import annotations

import math

_IDS = 32
_ENOUGH = 2
"""So many times in succession a stray must go on where it was, between transfers of the stream, to be a sender."""
_GAP = 2.0
"""After so long, s, or four periods, any transfer id may come."""
_SHARE = 0.1
"""Of a new interval in the mean period."""
_SHORTEST = 1e-3
"""Of a mean period, s: transfers that came while nobody listened are read at once."""


class SenderWatch:
    """Follows the transfer ids of one type from one node id; a transfer that does not continue them is a stray.

    A stream goes on by one id a transfer, or by more if as many could have been lost in the time: of one that comes in
    bursts, as a hub reports its fins, as many as there are in a burst for each period between two. A stray that is
    continued, while the stream goes on too, is a second sender. One that is continued alone is the sender itself, which
    began to count anew.

    The id of the last transfer once more is 32 further on, or a stray. One such stray proves nothing: after a stall of
    ours, or a restart of the sender, any id may come. But who of the two is the sender is then in doubt: the one before
    is taken back, and the next transfer of the stream is not believed either.

    Ids tell losses up to a round of them. Behind a longer gap the usual interval tells how many rounds were lost too.
    A stream may pause of itself, as that of fixes under water: of a long gap only the time counts in which nothing at
    all of the node came. They are counted when the stream goes on at its pace: after a stall of ours it catches up
    first, and nothing was lost.
    """

    __slots__ = (
        *("_answered", "_burst", "_come", "_due", "_last", "_met", "_period", "_silent", "_size", "_stray", "_t"),
        *("_t_stray", "_twice"),
        *("in_doubt", "missed", "strays"),
    )

    def __init__(self) -> None:
        self._last = -1
        self._t = -math.inf
        self._period = 0.0
        self._burst, self._size = 1, 1.0
        self._stray = -1
        self._t_stray = -math.inf
        self._answered = False
        self._twice = False
        self._met = 0
        self._silent = 0.0
        self._due, self._come = 0.0, 0
        self.in_doubt = False
        """Whether the last transfer leaves it open who the sender is: what was believed before is taken back."""
        self.missed = 0
        """Transfers of the stream that did not come, by their ids; whole rounds of them by the usual interval."""
        self.strays = 0
        """Transfers that were not believed; whoever asks counts them."""

    def accept(self, transfer_id: int, t: float, silent: float = 0.0) -> tuple[bool, bool]:
        """Take the next transfer.

        Args:
            transfer_id: modulo 32, as it came.
            t: when it came, s.
            silent: how long the node was silent until t in all its silences, s.

        Returns:
            Whether to believe it: it is of the stream, not a stray; whether it shows a second sender.
        """
        step, gap = (transfer_id - self._last - 1) % _IDS + 1, t - self._t
        continued = self._stray >= 0 and (transfer_id - self._stray) % _IDS == 1
        if self._last < 0 or gap > max(_GAP, 4.0 * self._period):
            self._stray, self._met = -1, 0
        elif step == 1 or step <= self._most(gap):
            if step == 1:
                self._learn(gap)
            self._answered = True
        elif continued and t == self._t_stray:  # of one burst, into which nobody could speak: no proof of anything
            self._stray, self.in_doubt = transfer_id, False
            return False, False
        elif continued and not self._answered:
            self._learn(t - self._t_stray)
            self._stray, self._met = -1, 0
        else:
            self._met = self._met + 1 if continued else 0
            self._stray, self._t_stray, self._answered = transfer_id, t, False
            self._twice = self.in_doubt = step == _IDS
            return False, self._met >= _ENOUGH
        if self._last >= 0:
            self.missed += step - 1
            self._count_rounds(step, gap, gap if gap <= _GAP else min(gap, silent - self._silent))
        self._silent = silent
        self.in_doubt, self._twice = self._twice, False
        self._last, self._t = transfer_id, t
        return not self.in_doubt, False

    def _count_rounds(self, step: int, gap: float, unheard: float) -> None:
        """Count whole rounds of ids that were lost in a gap of which the node was `unheard` for so long, s."""
        if not self._period:
            return
        due = round(self._size) * unheard / self._period
        if due > 0.5 * _IDS:
            self._due, self._come = self._due + due, self._come + step
        elif self._due and gap < 0.5 * self._period:
            self._come += step
        elif self._due:
            self.missed += _IDS * max(round((self._due - self._come) / _IDS), 0)
            self._due, self._come = 0.0, 0

    def _learn(self, gap: float) -> None:
        """Take an interval into the mean period, and none into the burst that has come.

        One of half a round of ids and more may hide a whole one.
        """
        if gap == 0.0:
            self._burst += 1
            return
        period, burst, self._burst = self._period, self._burst, 1
        if not period:
            self._period, self._size = max(gap, _SHORTEST), burst
        elif self._size * gap <= 0.5 * _IDS * period:
            self._period = max(period + _SHARE * (min(gap, 2.0 * period) - period), _SHORTEST)
            self._size += _SHARE * (burst - self._size)

    def _most(self, gap: float) -> int:
        """Return by how many ids the stream may have gone on in `gap`, s."""
        return 1 + round(self._size) * math.floor(gap / self._period + 0.5) if self._period else 1
