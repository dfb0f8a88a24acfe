"""The error of an argument; it stands alone, so that a help text imports nothing else."""


class UsageError(Exception):
    """An argument that cannot be used."""
