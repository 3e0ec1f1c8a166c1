"""What tests of the project's files need to know about its folders."""

# Folders that tools, builds and drives write, and the guide's pages for JupyterLab; none of the
# project's own texts is in them.
GENERATED = {
    *(".git", ".venv", ".axe", ".browser", ".site", ".wheel"),
    *("build", "devel", "world_ws", "report", "grades"),
    *("Workshop.md", "Phase 1.md", "Phase 2.md", "Phase 3.md", "Phase 4.md"),
}
