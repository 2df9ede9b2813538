"""What is set before a cycle: protocol, travel length, the transmission of the machine."""
