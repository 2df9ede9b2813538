"""History of the machine: cycles, alarms, actions, and trends over days."""
