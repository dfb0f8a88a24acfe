"""The laws: what stern planes, rudder and propeller shall do to follow a reference."""
