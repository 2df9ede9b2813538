"""What scripts and notebooks call: fits, comparisons, cycles; `import opensuction` has them."""
