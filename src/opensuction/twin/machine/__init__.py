"""The machine: axes, transmission, valve, suction line, sensors."""
