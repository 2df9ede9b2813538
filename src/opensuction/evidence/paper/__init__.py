"""The paper, number by number and figure by figure."""
