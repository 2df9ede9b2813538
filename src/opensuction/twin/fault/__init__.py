"""Faults of machine, link and patient.

`fault` names and numbers the faults; `fault_table` has a row for each, with what it means and what
it changes, collected from a file for each part of the machine. `reading_fault` and `link` are the
twin's side of faults of sensors and messages: what a run steps.
"""
