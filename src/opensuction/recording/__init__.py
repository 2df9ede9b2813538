"""Recordings: tables from elsewhere (CSV, Parquet), and the file that a run leaves."""
