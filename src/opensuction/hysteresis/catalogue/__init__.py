"""What is known of every model of hysteresis, one entry each."""
