"""Safety of the machine: conditions, alarms, limits, and the governor that enforces them."""
