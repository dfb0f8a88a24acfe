"""The estimation study: what the coefficient filter learns, beside the bound of what anybody can learn."""
