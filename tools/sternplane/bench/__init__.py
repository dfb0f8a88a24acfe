"""Benchmarks: cycle, kernels, messages, flights and lateness."""
