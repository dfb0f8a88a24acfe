"""The believed vehicle's equations of motion: forces, Jacobians, transition matrix and prediction."""
