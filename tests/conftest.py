"""What every test needs before it imports anything: the compiled kernels' folder, and a reproducible hypothesis."""

from __future__ import annotations

import hypothesis

from firmware_py.adapters import kernel_cache

kernel_cache.use()
hypothesis.settings.register_profile("sternplane", derandomize=True, deadline=None, max_examples=100)
hypothesis.settings.load_profile("sternplane")
