"""Campaigns of many cycles."""
