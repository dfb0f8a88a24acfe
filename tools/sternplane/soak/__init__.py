"""Every io file flown in real time, vehicle and plant in two processes, for as long as a mission lasts."""
