"""`sternplane export`: a log as other tools read it."""
