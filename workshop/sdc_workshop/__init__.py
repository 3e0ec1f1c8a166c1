"""The workshop: students' workspaces, the checks of what students write, and the guide."""
