"""Tables of the reviewer's pages, `docs/safety`."""
