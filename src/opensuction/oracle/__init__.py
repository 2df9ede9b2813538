"""What really happened to a patient: judged from the twin's truth alone, by nobody it concerns."""
