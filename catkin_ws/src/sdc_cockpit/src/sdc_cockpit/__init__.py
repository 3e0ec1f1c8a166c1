"""The cockpit: a drive in the browser."""
