"""Functions for scripts and notebooks: fits, comparisons, cycles; `import opensuction` has them."""
