"""Accounts and access rights: people's accounts, sign-in, sessions, and tokens for other programs.

All are kept in the database of the records, each action with its entry in the trail. Nothing here
uses a network, and nothing here is consulted before the machine is stopped: everybody may stop it.
"""
