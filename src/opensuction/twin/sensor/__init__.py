"""What the machine's sensors make of the truth, as such parts are sold."""
