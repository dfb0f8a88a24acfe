"""Files: configuration, log, kept state, and the store of logs."""
