"""MAVLink as pure state machines: datagrams in, orders out; cycles in, datagrams out. No socket and no clock.

`Node` is the vehicle on all its links. What it says of a cycle is a table of makers (`telemetry`, `status`), paced per
link by `Streams`. What it is told goes by message id to a service: `Commands` and `Helm` so far. Parameters, missions,
fences, files and logs are more services, and join them in `Link`; signing belongs into `Codec`. Until then their
requests are left unanswered, and AUTOPILOT_VERSION does not claim them.
"""
