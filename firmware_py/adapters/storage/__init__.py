"""Files: configuration (TOML), log (MCAP), state folder, and the logs that ground stations download."""
