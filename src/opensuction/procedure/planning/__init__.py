"""Protocols, guidelines and the planner."""
