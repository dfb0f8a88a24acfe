"""MAVLink as pure state machines: datagrams in, orders out; cycles in, datagrams out. No socket and no clock.

`Node` is the vehicle on all its links. `telemetry` has an encoder for each message, and `Streams` says per link when
it is sent. A received message goes by its id to a service of the link: `CommandDispatch`, which passes commands on to
`MessageRequests`, `SetpointCommands`, `PreflightCommands` and `PlanUpload`, or a service added by `Link.add_service`,
such as parameters. `CommandQueue` makes the commands of all links one order a tick. `Codec` finds frames in datagrams
and streams; `signing` checks signatures.
"""
