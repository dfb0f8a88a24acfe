"""Many jobs on many processors: done once each, kept when done, gone on with after a kill."""
