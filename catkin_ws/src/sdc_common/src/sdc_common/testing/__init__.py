"""Helpers of tests and checks: messages, processes, virtual displays."""
