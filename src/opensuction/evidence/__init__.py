"""Runs that show something: cycles on the twin, with everything a report needs."""
