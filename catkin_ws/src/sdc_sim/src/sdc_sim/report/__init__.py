"""Report of a drive: files, pages, comparison, status on the console."""
