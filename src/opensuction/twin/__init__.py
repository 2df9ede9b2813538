"""Digital twin of machine and patient: a different model from the controller's, on purpose."""
