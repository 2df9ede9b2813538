"""What is decided of accounts, as plain functions and tables: no clock, no database, no chance."""
