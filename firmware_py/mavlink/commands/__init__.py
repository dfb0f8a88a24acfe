"""Commands from ground stations: queue, dispatch, setpoints, manual control and pre-flight actions."""
