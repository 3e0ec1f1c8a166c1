"""What tests of the project's files need to know about its folders."""

# Folders that tools, builds and drives write; none of the project's own texts is in them.
GENERATED = {
    *(".git", ".venv", ".axe", ".browser", ".site", ".wheel"),
    *("build", "devel", "world_ws", "report", "grades"),
}
