"""Missions, fences and rally points: items, checks, upload, download and storage."""
