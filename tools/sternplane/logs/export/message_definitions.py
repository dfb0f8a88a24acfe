"""The definitions of the standard messages that a log is exported as: fields in their order, without comments.

Sources: ROS 2 common_interfaces, geometry2 and rcl_interfaces (https://github.com/ros2), as of Jazzy; the schemas of
Foxglove as ROS 2 messages (https://github.com/foxglove/foxglove-sdk, schemas/ros2).
"""

from __future__ import annotations

from collections.abc import Iterator

_RULE = "=" * 80

_DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec; uint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp; string frame_id",
    "std_msgs/Float64": "float64 data",
    "std_msgs/String": "string data",
    "geometry_msgs/Point": "float64 x; float64 y; float64 z",
    "geometry_msgs/Vector3": "float64 x; float64 y; float64 z",
    "geometry_msgs/Quaternion": "float64 x; float64 y; float64 z; float64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position; geometry_msgs/Quaternion orientation",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear; geometry_msgs/Vector3 angular",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation; geometry_msgs/Quaternion rotation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header; geometry_msgs/Pose pose",
    "geometry_msgs/TwistStamped": "std_msgs/Header header; geometry_msgs/Twist twist",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose; float64[36] covariance",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist; float64[36] covariance",
    "geometry_msgs/TwistWithCovarianceStamped": "std_msgs/Header header; geometry_msgs/TwistWithCovariance twist",
    "geometry_msgs/TransformStamped": "std_msgs/Header header; string child_frame_id; "
    "geometry_msgs/Transform transform",
    "nav_msgs/Odometry": "std_msgs/Header header; string child_frame_id; geometry_msgs/PoseWithCovariance pose; "
    "geometry_msgs/TwistWithCovariance twist",
    "nav_msgs/Path": "std_msgs/Header header; geometry_msgs/PoseStamped[] poses",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "sensor_msgs/NavSatStatus": "int8 status; uint16 service",
    "sensor_msgs/NavSatFix": "std_msgs/Header header; sensor_msgs/NavSatStatus status; float64 latitude; "
    "float64 longitude; float64 altitude; float64[9] position_covariance; uint8 position_covariance_type",
    "sensor_msgs/Imu": "std_msgs/Header header; geometry_msgs/Quaternion orientation; "
    "float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity; "
    "float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration; "
    "float64[9] linear_acceleration_covariance",
    "sensor_msgs/FluidPressure": "std_msgs/Header header; float64 fluid_pressure; float64 variance",
    "sensor_msgs/Range": "std_msgs/Header header; uint8 radiation_type; float32 field_of_view; float32 min_range; "
    "float32 max_range; float32 range; float32 variance",
    "sensor_msgs/BatteryState": "std_msgs/Header header; float32 voltage; float32 temperature; float32 current; "
    "float32 charge; float32 capacity; float32 design_capacity; float32 percentage; uint8 power_supply_status; "
    "uint8 power_supply_health; uint8 power_supply_technology; bool present; float32[] cell_voltage; "
    "float32[] cell_temperature; string location; string serial_number",
    "sensor_msgs/JointState": "std_msgs/Header header; string[] name; float64[] position; float64[] velocity; "
    "float64[] effort",
    "rcl_interfaces/Log": "builtin_interfaces/Time stamp; uint8 level; string name; string msg; string file; "
    "string function; uint32 line",
    "foxglove_msgs/FrameTransform": "builtin_interfaces/Time timestamp; string parent_frame_id; "
    "string child_frame_id; geometry_msgs/Vector3 translation; geometry_msgs/Quaternion rotation",
    "foxglove_msgs/FrameTransforms": "foxglove_msgs/FrameTransform[] transforms",
    "foxglove_msgs/PoseInFrame": "builtin_interfaces/Time timestamp; string frame_id; geometry_msgs/Pose pose",
    "foxglove_msgs/PosesInFrame": "builtin_interfaces/Time timestamp; string frame_id; geometry_msgs/Pose[] poses",
    "foxglove_msgs/Color": "float64 r; float64 g; float64 b; float64 a",
    "foxglove_msgs/KeyValuePair": "string key; string value",
    "foxglove_msgs/LocationFix": "builtin_interfaces/Time timestamp; string frame_id; float64 latitude; "
    "float64 longitude; float64 altitude; float64[9] position_covariance; uint8 position_covariance_type; "
    "float64 heading; float64 heading_variance; float64 velocity_x; float64 velocity_y; float64 velocity_z; "
    "foxglove_msgs/Color color; foxglove_msgs/KeyValuePair[] metadata",
    "foxglove_msgs/Log": "builtin_interfaces/Time timestamp; uint8 level; string message; string name; string file; "
    "uint32 line",
    "foxglove_msgs/GeoJSON": "string geojson",
}


def fields(name: str) -> list[tuple[str, str]]:
    """Return type and name of each field of a message such as "nav_msgs/Odometry"."""
    pairs = (one.split() for one in _DEFINITIONS[name].split("; "))
    return [(kind, field) for kind, field in pairs]


def schema(name: str) -> str:
    """Return the definition of a message and of all messages in it, as MCAP files have it ("ros2msg")."""
    first, *others = dict.fromkeys(_with_inner(name))
    return _body(first) + "".join(f"{_RULE}\nMSG: {inner}\n{_body(inner)}" for inner in others)


def full_name(name: str) -> str:
    """Return the name as ROS 2 writes it: "nav_msgs/msg/Odometry"."""
    package, message = name.split("/")
    return f"{package}/msg/{message}"


def _with_inner(name: str) -> Iterator[str]:
    yield name
    for kind, _ in fields(name):
        if "/" in kind:
            yield from _with_inner(kind.partition("[")[0])


def _body(name: str) -> str:
    return "".join(f"{kind} {field}\n" for kind, field in fields(name))
