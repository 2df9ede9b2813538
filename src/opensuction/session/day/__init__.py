"""A day of cycles."""
