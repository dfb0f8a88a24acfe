"""Bench tools: the devices of a vehicle on a desk, before it flies."""
