"""Rules of the accounts as plain functions and tables: no clock, no database, no random numbers."""
