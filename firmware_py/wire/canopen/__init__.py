"""CANopen (CiA 301) and its drive profile (CiA 402), as far as fin drives need them."""
