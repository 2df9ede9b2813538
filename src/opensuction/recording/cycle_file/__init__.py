"""The recording of a run: rows of numbers and events in an MCAP file, written and read back."""
