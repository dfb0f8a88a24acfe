"""The simulated instruments on lines of their own: what each sends of a reading, and what it answers."""
