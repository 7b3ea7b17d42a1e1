"""Puts one question to one contestant: registry, participants, worker, flight, timer, provenance."""
