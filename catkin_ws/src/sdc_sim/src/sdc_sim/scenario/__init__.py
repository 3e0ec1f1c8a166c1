"""Scenarios: schema, reader, acceptance limits and runner."""
