"""A file for each device that the contract of drivers is tried with: `DEVICE`. One more file is one more device."""
