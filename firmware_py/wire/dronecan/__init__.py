"""DroneCAN: message layouts (DSDL), their codec, transfers over CAN frames."""
