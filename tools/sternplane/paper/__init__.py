"""`sternplane paper`: every experiment of the source paper, through this project's own code."""
