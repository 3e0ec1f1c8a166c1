"""Evaluation of a drive: progress, infractions, metrics, file of events."""
