"""MAVLink as pure state machines: datagrams in, orders out; cycles in, datagrams out. No socket and no clock.

`Node` is the vehicle on all its links. What it says of a cycle is a table of makers (`telemetry`, `motion`, `status`,
`high_latency`), paced per link by `Streams`. What it is told goes by message id to a service of the link: `Commands`,
which hands on to `Requests`, `Setpoints` and `Upkeep`, and what joins by `Link.serve`, such as parameters. Wishes of
all links become one order a tick in `Orders`. `Codec` finds frames in datagrams and streams; `signing` checks who
speaks.
"""
