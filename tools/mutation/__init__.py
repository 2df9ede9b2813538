"""Mutation testing of the safety code: does some test notice when it is wrong?"""
