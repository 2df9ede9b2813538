"""Recordings from elsewhere: tables of columns (CSV, Parquet), read within a bound of memory."""
