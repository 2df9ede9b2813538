"""The ventilated patient."""
