"""What has been: cycles, alarms, acts, and what they come to over days."""
