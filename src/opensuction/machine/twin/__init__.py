"""The twin as a machine in real time: its process, faults put into it, its hand, its judge."""
