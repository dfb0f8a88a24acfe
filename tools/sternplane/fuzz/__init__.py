"""What a station may send, and what is none of a station's, into the ground links of a vehicle that flies."""
