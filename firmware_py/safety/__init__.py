"""Who may only make the vehicle safer: the supervisor first, the gate last."""
