"""Studies of the lab: drives, single pictures with their truth, and figures of the document."""
