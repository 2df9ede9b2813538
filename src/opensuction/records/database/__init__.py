"""The database: where it is, its tables, its transactions, what can go wrong with it."""
