"""The workshop in a browser: JupyterLab, and a small desktop for programs with windows."""
