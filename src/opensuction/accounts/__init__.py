"""Who may do what: people's accounts, sign-in, sessions, and tokens for other programs.

Kept in the database of the records, each act with its entry in the trail. Nothing here speaks to a
network, and nothing here is asked before the machine is stopped: everybody may do that.
"""
