"""What the line tells of the mucus, and how long suction goes on by it."""
