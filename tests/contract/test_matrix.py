"""The cases of the driver contract, for drivers whose devices are no streams of bytes and no DroneCAN nodes.

These have suites in their own words. This table says which test is which case there, or why a device cannot have it.
"""

from __future__ import annotations

from types import ModuleType

import pytest

from . import test_bar30, test_canopen_drives, test_dynamixel_servos

ASKED = "it speaks only when it is asked, and each answer belongs to its question"
NO_CLOCK = "it tells no time"
WHOLE_NUMBERS = "it tells whole numbers"

BAR30 = {
    "fresh": "test_fresh",
    "stale": "test_stale",
    "order": "test_a_change_of_pressure_is_heard_in_order_and_not_before",
    "duplicates": ASKED,
    "loss": "test_transfers_that_are_lost_now_and_then_cost_a_reading_and_not_the_sensor",
    "reconnect": "test_reconnect_even_to_another_sensor",
    "absent": "test_absent_at_the_start",
    "extreme": "test_extreme",
    "not a number": "test_what_cannot_be_is_heard_and_not_ok",
    "wrong node": "it is asked by its address, which is the same for all of them",
    "length": "test_wrong_length",
    "checksum": "test_a_calibration_that_is_none_is_counted_and_read_again",
    "protocol": "test_hostile_bytes_raise_nothing",
    "clock jump": "test_what_a_late_tick_spoils_is_told_by_no_pressure",
    "flood": ASKED,
    "second speaker": "two at one address drive one line, and nothing tells whose bits are read",
    "hostile": "test_hostile_bytes_raise_nothing",
}
CANOPEN = {
    "fresh": "test_drives_are_started_up_and_follow_and_the_frame_has_their_angles_with_their_time",
    "stale": "test_a_bus_that_fails_is_silence",
    "order": "test_an_emergency_outlives_an_answer_that_is_older",
    "duplicates": "test_a_frame_that_comes_twice_is_no_second_drive_but_two_answers_to_each_sync_are",
    "loss": "test_with_a_fifth_of_all_frames_lost_drives_come_up_and_follow",
    "reconnect": "test_a_drive_that_lost_its_power_is_noticed_configured_again_and_followed",
    "absent": "test_without_drives_it_asks_on_and_waits_for_nothing",
    "extreme": "test_a_fin_where_none_can_be_is_not_believed_and_one_at_its_stop_is",
    "not a number": WHOLE_NUMBERS,
    "wrong node": "test_other_nodes_other_process_data_and_ids_of_29_bits_are_passed_over",
    "length": "test_what_is_malformed_is_counted_and_changes_nothing",
    "checksum": "the bus has one, in each frame, and drops what fails it",
    "protocol": "test_other_nodes_other_process_data_and_ids_of_29_bits_are_passed_over",
    "clock jump": NO_CLOCK,
    "flood": "test_a_flood_is_bounded_in_a_tick_and_what_lies_behind_it_is_heard",
    "second speaker": "test_another_master_is_named_and_its_fins_not_believed_until_it_is_gone",
    "hostile": "test_no_traffic_makes_it_fail_or_hear_from_the_future",
}
DYNAMIXEL = {
    "fresh": "test_fresh_servos_are_set_up_and_follow_and_positions_have_the_time_of_their_question",
    "stale": "test_stale",
    "order": "test_an_answer_that_comes_too_late_is_not_taken_for_one_to_the_next_question",
    "duplicates": "test_two_servos_under_one_id_are_noticed_and_one_answer_twice_is_not",
    "loss": "test_a_lost_answer_costs_no_more_than_itself",
    "reconnect": "test_reconnect",
    "absent": "test_absent_at_the_start",
    "extreme": "test_extreme_positions_are_angles",
    "not a number": WHOLE_NUMBERS,
    "wrong node": "test_a_wrong_id_is_not_read_and_counted",
    "length": "test_what_is_damaged_is_counted_and_changes_nothing",
    "checksum": "test_what_is_damaged_is_counted_and_changes_nothing",
    "protocol": "test_what_is_damaged_is_counted_and_changes_nothing",
    "clock jump": "test_a_clock_that_jumps_frees_the_line",
    "flood": "test_a_flood_is_bounded_in_a_tick_and_what_lies_behind_it_is_heard",
    "second speaker": "test_a_second_host_is_named_and_nothing_is_believed_until_it_is_gone",
    "hostile": "test_hostile_bytes_raise_nothing_and_nothing_is_heard_from_the_future",
}
SUITES = {test_bar30: BAR30, test_canopen_drives: CANOPEN, test_dynamixel_servos: DYNAMIXEL}


@pytest.mark.parametrize("suite", SUITES, ids=lambda suite: suite.__name__.rpartition(".")[2])
def test_each_case_is_a_test_of_the_suite_or_has_its_reason(suite: ModuleType) -> None:
    cases = SUITES[suite]
    assert cases.keys() == BAR30.keys()
    for case, told in cases.items():
        assert " " in told or callable(getattr(suite, told, None)), case
