"""`sternplane sweep`: one scenario flown many times with other values, and what came of it as a table."""
