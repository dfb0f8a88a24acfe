"""Control laws: the stern-plane angle, rudder angle and propeller speed that make the vehicle follow a reference."""
