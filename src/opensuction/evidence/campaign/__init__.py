"""Cycles played for a claim: machines drawn, faults placed, runs played; judged by the truth."""
