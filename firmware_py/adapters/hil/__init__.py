"""The simulator interface of PX4 (HIL_SENSOR and HIL_ACTUATOR_CONTROLS) as hardware."""
