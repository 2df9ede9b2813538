"""How far each threshold of the controller is from what a sound machine shows."""
