"""The trail of what was stored: its entries chained by hashes, and whether they are whole."""
