"""What may pass to the drives."""
