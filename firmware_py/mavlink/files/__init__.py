"""MAVLink FTP and log download over one read-only file tree."""
