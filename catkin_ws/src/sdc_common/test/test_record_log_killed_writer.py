import os
import signal
import subprocess
import sys
import time

import pytest

from sdc_common.ros.record_log import RecordLog

WRITER = """
import sys
from sdc_common.ros.record_log import RecordLog
log = RecordLog(sys.argv[1])
number = 0
while log.append({"number": number, "padding": "x" * 3000}):
    number += 1
    if sys.argv[2] == "replace" and log.size_bytes > 50_000:
        log.replace({"number": number, "padding": "x" * 3000})
        number += 1
    print(number - 1, flush=True)
"""


@pytest.mark.parametrize("mode", ["append", "replace"])
def test_killed_writer_loses_at_most_the_record_it_writes(tmp_path, mode):
    path = str(tmp_path / "log")
    for pause_s in (0.0, 0.01, 0.03):
        if os.path.exists(path):
            os.remove(path)
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, path, mode], stdout=subprocess.PIPE, text=True
        )
        writer.stdout.readline()
        time.sleep(pause_s)
        writer.send_signal(signal.SIGKILL)
        # A line that the writer could not finish is no promise.
        printed = [line for line in writer.stdout.read().splitlines(True) if line.endswith("\n")]
        writer.wait()
        writer.stdout.close()
        reached = int(printed[-1]) if printed else 0
        assert RecordLog(path).last()["number"] in (reached, reached + 1, reached + 2)
