"""Generated files: Jacobians, C kernels, the configuration reference; and kernel compilation."""
