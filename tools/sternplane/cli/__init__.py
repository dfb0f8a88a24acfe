"""The `sternplane` command line: arguments, progress, run folders, errors."""
