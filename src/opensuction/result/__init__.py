"""Results of a run as frozen records: made once, read by every report, JSON only at the edge."""
