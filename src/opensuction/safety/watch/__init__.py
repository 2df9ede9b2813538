"""What readings say against the limits."""
