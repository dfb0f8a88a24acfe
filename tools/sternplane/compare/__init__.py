"""`sternplane compare`: runs side by side."""
