"""What a person does with MAVSDK, in a process of its own: `python with_mavsdk.py PORT FOLDER`.

Each line that is printed is JSON: a name, and what MAVSDK said to it.
"""

from __future__ import annotations

import asyncio
import json
import math
import sys
from collections.abc import AsyncGenerator, Awaitable, Callable
from pathlib import Path
from typing import Any

from mavsdk.asyncio import ComponentType, Configuration, Mavsdk, System
from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.component_metadata import ComponentMetadataAsync
from mavsdk.asyncio.plugins.ftp import FtpAsync
from mavsdk.asyncio.plugins.info import InfoAsync, InfoError
from mavsdk.asyncio.plugins.log_files import LogFilesAsync
from mavsdk.asyncio.plugins.mavlink_direct import MavlinkDirectAsync, MavlinkMessage
from mavsdk.asyncio.plugins.mission_raw import MissionItem, MissionRawAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import FlightMode, TelemetryAsync

PATIENCE = 30.0
"""Nothing that is waited for takes longer, s."""
PLACE = 36.801, -121.8, 294.0
"""To go to: degrees, m above mean sea level."""

GLOBAL, RELATIVE, NO_FRAME = 0, 6, 2
WAYPOINT, LOITER_TURNS, RETURN, CHANGE_SPEED, FENCE_CIRCLE, RALLY_POINT = 16, 18, 20, 178, 5003, 5100
"""MAV_FRAME and MAV_CMD."""
ASK_FOR_PROTOCOL_VERSION = {
    "target_system": 1,
    "target_component": 1,
    "command": 512,
    "confirmation": 0,
    "param1": 300.0,
    **{f"param{i}": 0.0 for i in range(2, 8)},
}


def say(name: str, value: Any) -> None:
    print(json.dumps([name, value]), flush=True)


def plain(record: Any) -> dict[str, Any]:
    """The fields of one of MAVSDK's records."""
    return {name: value for name, value in vars(record).items() if isinstance(value, bool | int | float | str)}


async def refused(call: Awaitable[Any]) -> str:
    """How MAVSDK names the error of what must not succeed."""
    try:
        return f"taken: {await call}"
    except Exception as error:
        return str(error).partition(";")[0]


async def first(updates: AsyncGenerator[Any, None], wanted: Callable[[Any], bool] = lambda _: True) -> Any:
    async with asyncio.timeout(PATIENCE):
        async for update in updates:
            if wanted(update):
                return update
    raise AssertionError("no more updates")


async def whole(progress: AsyncGenerator[Any, None]) -> None:
    async with asyncio.timeout(PATIENCE):
        async for _ in progress:
            pass


async def watch(system: System) -> None:
    telemetry, info = TelemetryAsync(system), InfoAsync(system)
    say("version", plain(await info.get_version()))
    health = await first(telemetry.subscribe_health(), lambda it: it.is_local_position_ok and it.is_armable)
    say("health", plain(health))
    for name in ("altitude", "attitude_euler", "position", "home", "battery", "distance_sensor", "velocity_ned"):
        say(name, plain(await first(getattr(telemetry, f"subscribe_{name}")())))
    for name in ("armed", "in_air", "flight_mode"):
        say(name, await first(getattr(telemetry, f"subscribe_{name}")()))
    await telemetry.set_rate_attitude_quaternion(20.0)  # not sent unless asked for
    say("attitude_quaternion", plain(await first(telemetry.subscribe_attitude_quaternion())))
    origin = await telemetry.get_gps_global_origin()
    say("origin", plain(origin))


async def tune(system: System) -> None:
    param = ParamAsync(system)
    told = await param.get_all_params()
    say("floats", {it.name: it.value for it in told.float_params})
    say("ints", {it.name: it.value for it in told.int_params})
    await param.set_param_float("CTL_Z_DELTA_SW", 0.3)
    await param.set_param_int("SAF_LATE_MAX", 900)
    say("set", [await param.get_param_float("CTL_Z_DELTA_SW"), await param.get_param_int("SAF_LATE_MAX")])
    say("too much", await refused(param.set_param_float("SAF_DEPTH_MAX", 1e9)))
    say("of the other kind", await refused(param.set_param_int("SAF_DEPTH_MAX", 20)))
    say("unknown", await refused(param.get_param_float("NONESUCH")))


async def fetch(system: System, folder: Path) -> None:
    ftp, logs, metadata = FtpAsync(system), LogFilesAsync(system), ComponentMetadataAsync(system)
    say("folders", [it.name for it in (await ftp.list_directory("/")).entries])
    say("logs", [it.name for it in (await ftp.list_directory("/logs")).entries])
    for path, burst in (("/logs/earlier.mcap", True), ("/@PARAM/param.pck", False)):
        await whole(ftp.download(path, str(folder), burst))
        say(f"identical {path}", await ftp.are_files_identical(str(folder / Path(path).name), path))
    say("missing", await refused(whole(ftp.download("/logs/none.mcap", str(folder), True))))
    say("forbidden", await refused(ftp.remove_file("/@PARAM/param.pck")))
    entries = await logs.get_entries()
    say("entries", [plain(it) for it in entries])
    await whole(logs.download_log_file(entries[0], str(folder / "log_1.mcap")))
    waiting = asyncio.create_task(first(metadata.subscribe_metadata_available()))
    await asyncio.sleep(0)  # so that it is subscribed to
    await metadata.request_autopilot_component()
    say("metadata", json.loads((await waiting).json_metadata))


async def _speed_factor(info: InfoAsync) -> float:
    try:
        return float(await info.get_speed_factor())
    except InfoError:
        return math.nan  # not measured yet


async def tell_time(system: System) -> None:
    """The clock runs as fast as ours; a TIMESYNC comes back with the vehicle's, and so does what it speaks."""
    direct, info = MavlinkDirectAsync(system), InfoAsync(system)
    waiting = asyncio.create_task(
        first(direct.subscribe_message("TIMESYNC"), lambda it: json.loads(it.fields_json)["ts1"] == 4711)
    )
    await asyncio.sleep(0)
    asked = json.dumps({"tc1": 0, "ts1": 4711, "target_system": 1, "target_component": 1})
    await direct.send_message(MavlinkMessage("TIMESYNC", 255, 190, 1, 1, asked))
    say("timesync", json.loads((await waiting).fields_json))
    waiting = asyncio.create_task(first(direct.subscribe_message("PROTOCOL_VERSION")))
    await asyncio.sleep(0)
    await direct.send_message(MavlinkMessage("COMMAND_LONG", 255, 190, 1, 1, json.dumps(ASK_FOR_PROTOCOL_VERSION)))
    say("protocol version", json.loads((await waiting).fields_json))
    async with asyncio.timeout(PATIENCE):
        while not math.isfinite(pace := await _speed_factor(info)):
            await asyncio.sleep(0.1)
    say("pace", pace)


def route(depth: float) -> list[MissionItem]:
    """Two places, the second more slowly, a circle, and up."""
    speed, nan = [1.0, 1.5, -1.0, 0.0], math.nan
    return [
        MissionItem(0, RELATIVE, WAYPOINT, 1, 1, 0.0, 0.0, 0.0, nan, 368003500, -1218000000, -8.0, 0),
        MissionItem(1, NO_FRAME, CHANGE_SPEED, 0, 1, *speed, 0, 0, 0.0, 0),
        MissionItem(2, RELATIVE, WAYPOINT, 0, 1, 0.0, 0.0, 0.0, nan, 368020000, -1217998000, -depth, 0),
        MissionItem(3, RELATIVE, LOITER_TURNS, 0, 1, 1.0, 0.0, 40.0, nan, 368024000, -1217998000, -depth, 0),
        MissionItem(4, NO_FRAME, RETURN, 0, 1, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, 0),
    ]


async def plan(system: System, missions: MissionRawAsync) -> None:
    telemetry = TelemetryAsync(system)
    fence = MissionItem(0, GLOBAL, FENCE_CIRCLE, 0, 1, 900.0, 0.0, 0.0, 0.0, 368000000, -1218000000, 0.0, 1)
    await missions.upload_geofence([fence])
    rally = MissionItem(0, RELATIVE, RALLY_POINT, 0, 1, 0.0, 0.0, 0.0, 0.0, 368002000, -1218002000, 0.0, 2)
    await missions.upload_rally_points([rally])
    say("sent", [plain(fence), plain(rally)])
    kept = *await missions.download_geofence(), *await missions.download_rallypoints()
    say("kept", [plain(it) for it in kept])
    # MAVSDK takes the number of items that it sent last for the mission's.
    say("route", [plain(it) for it in route(9.0)])
    await missions.upload_mission(route(9.0))
    sentence = asyncio.create_task(first(telemetry.subscribe_status_text(), lambda it: it.text.startswith("mission")))
    await asyncio.sleep(0)
    say("above the water", await refused(missions.upload_mission(route(-5.0))))
    say("why", (await sentence).text)
    say("mission", [plain(it) for it in await missions.download_mission()])


async def fly(system: System, missions: MissionRawAsync) -> None:
    action, telemetry, logs = ActionAsync(system), TelemetryAsync(system), LogFilesAsync(system)

    async def in_mode(mode: FlightMode) -> None:
        await first(telemetry.subscribe_flight_mode(), lambda it: it == mode)

    await action.hold()  # it is held at arming
    await in_mode(FlightMode.HOLD)
    say("take off", await refused(action.takeoff()))
    await action.arm()
    await first(telemetry.subscribe_armed(), bool)
    refusal = asyncio.create_task(first(telemetry.subscribe_status_text(), lambda it: "erased" in it.text))
    await asyncio.sleep(0)
    await logs.erase_all_log_files()
    say("erase, armed", (await refusal).text)
    say("reboot, armed", await refused(action.reboot()))
    await action.hold()
    await in_mode(FlightMode.HOLD)
    progress = missions.subscribe_mission_progress()
    begun = asyncio.create_task(first(progress))
    await asyncio.sleep(0)  # it listens before the first item can be passed
    await missions.start_mission()
    await in_mode(FlightMode.MISSION)
    say("begun", plain(await begun))
    say("passed", plain(await first(progress, lambda it: it.current > 0)))
    await missions.pause_mission()
    await in_mode(FlightMode.HOLD)
    await missions.set_current_mission_item(3)
    await missions.start_mission()
    await in_mode(FlightMode.MISSION)
    say("jumped", plain(await first(progress, lambda it: it.current == 3)))
    await action.set_current_speed(1.6)
    await action.goto_location(*PLACE, math.nan)
    await in_mode(FlightMode.OFFBOARD)
    above = await first(telemetry.subscribe_position(), lambda it: it.relative_altitude_m > -7.8)
    say("on the way", plain(above))
    await action.land()
    await in_mode(FlightMode.LAND)
    say("disarm, under water", await refused(action.disarm()))
    await action.kill()  # the same, by force
    await first(telemetry.subscribe_armed(), lambda it: not it)
    await logs.erase_all_log_files()


async def main(port: str, folder: Path) -> None:
    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    async with Mavsdk(configuration) as sdk:
        await sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = await sdk.first_autopilot(timeout_s=2 * PATIENCE)
        assert system is not None, "no autopilot"
        await watch(system)
        await tune(system)
        await fetch(system, folder)
        await tell_time(system)
        missions = MissionRawAsync(system)  # knows of the progress of what it has sent itself
        await plan(system, missions)
        await fly(system, missions)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], Path(sys.argv[2])))
