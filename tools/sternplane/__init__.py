"""The `sternplane` command and everything for people."""
