"""What can go wrong with machine, link and patient."""
