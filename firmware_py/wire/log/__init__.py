"""The flight log's records: a ROS 2 schema and CDR bytes."""
