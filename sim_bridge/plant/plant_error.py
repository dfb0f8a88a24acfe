"""What a plant refuses, apart from it: whoever names the error needs no compiled kernels."""


class PlantError(ValueError):
    """Impossible commands or parameters, a state that became non-finite, or a vehicle that ran aground."""
