"""What every test needs before it imports anything: the compiled kernels' folder, and a reproducible hypothesis.

`--hypothesis-profile=thorough` looks at many more examples, other ones in every run.

What is imported and collected stays until the end, a million objects: whoever collects garbage leaves them out.
"""

from __future__ import annotations

import gc

import hypothesis

from firmware_py.adapters import kernel_cache

kernel_cache.use()
hypothesis.settings.register_profile("sternplane", derandomize=True, deadline=None, max_examples=50)
hypothesis.settings.register_profile("thorough", deadline=None, max_examples=1000, print_blob=True)
hypothesis.settings.load_profile("sternplane")
gc.disable()


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.enable()
