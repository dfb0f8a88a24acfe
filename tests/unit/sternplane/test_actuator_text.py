"""What the summary says of an actuator that was at fault."""

from __future__ import annotations

import pytest
from sternplane.logs.health_record import actuator_text


@pytest.mark.parametrize(
    ("last", "faulty", "said"),
    [
        (200.0, 93.7, "reports nothing valid, from 106.3 s"),
        (150.0, 43.7, "reports nothing valid, from 106.3 s to 150.0 s"),
        (200.0, 49.2, "reports nothing valid, from 106.3 s, 49.2 s in all"),  # it was sound in between
        (150.0, 0.4, "reports nothing valid, from 106.3 s to 150.0 s, 0.4 s in all"),
    ],
)
def test_an_actuator_that_was_sound_in_between_is_not_said_to_have_been_at_fault_all_the_time(last, faulty, said):
    one = {"first_s": 106.3, "last_s": last, "faulty_s": faulty, "last": "silent", "stuck_deg": None}
    assert actuator_text(one, 200.0) == said
