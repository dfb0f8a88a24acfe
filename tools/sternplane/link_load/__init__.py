"""How late a vehicle's cycles begin while ground stations keep it busy, beside the same flight without any."""
