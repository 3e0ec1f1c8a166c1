"""Studies of the lab: errors of the localizer, and the figures of the document."""
