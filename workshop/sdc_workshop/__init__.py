"""The workshop: which parts of the solution a student writes, and how a student's workspace is made."""
