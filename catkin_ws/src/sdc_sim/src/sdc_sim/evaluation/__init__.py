"""Evaluation of a drive: progress, infractions, metrics, event log."""
