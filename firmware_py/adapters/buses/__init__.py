"""CAN buses: virtual, UDP multicast and SocketCAN."""
