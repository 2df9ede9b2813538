"""The interface of the console, one file a subject; the page uses nothing else."""
