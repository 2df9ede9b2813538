"""The report of a day of cycles."""
