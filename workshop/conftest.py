"""Count what the checks judge rightly."""


def pytest_terminal_summary(terminalreporter):
    """Print how many rows of mistakes.yaml were judged rightly, in all parts together."""
    reports = [*terminalreporter.getreports("passed"), *terminalreporter.getreports("failed")]
    found = [value for one in reports for name, value in one.user_properties if "judged" in name]
    counts = [text.split(" of ") for lines in found for text in lines if " of " in text]
    if counts:
        right, rows = (sum(map(int, column)) for column in zip(*counts))
        terminalreporter.write_line(f"mistakes: {right} of {rows} were judged rightly")
