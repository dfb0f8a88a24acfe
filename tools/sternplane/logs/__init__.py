"""Logs: reading, replay, summary, tracking errors and export."""
