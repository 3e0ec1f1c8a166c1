import errno
import marshal
import os
import stat
import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_common.ros.record_log import RecordLog

PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text(max_size=20)
    | st.binary(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=10,
)


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "log")


@pytest.mark.slow(3)
@given(st.lists(PLAIN, max_size=8))
def test_records_are_read_back_unchanged(tmp_path_factory, records):
    path = str(tmp_path_factory.mktemp("log") / "log")
    log = RecordLog(path)
    assert all(log.append(record) for record in records)
    for reader in (log, RecordLog(path)):
        assert list(reader.records()) == records
        assert reader.last() == (records[-1] if records else None)


def test_tuples_and_integer_keys_stay_what_they_are(path):
    RecordLog(path).append((1, {2: (3,)}))
    assert RecordLog(path).last() == (1, {2: (3,)})


@pytest.mark.parametrize("record", [None, 0, "", [1.5, {"a": None}]])
def test_last_record_is_that_of_the_newest_call(path, record):
    log = RecordLog(path)
    assert log.append("first")
    assert log.append(record)
    assert log.last() == RecordLog(path).last() == record
    assert log.replace(record)
    assert log.last() == RecordLog(path).last() == record


def frame(body, missing=0):
    """Return a frame of the file, whose body lacks some bytes."""
    return struct.pack("<II", len(body) + missing, zlib.crc32(body)) + body


def test_file_has_the_documented_format(path):
    bodies = [marshal.dumps(record, 2) for record in ("a" * 300, ["a", "a"])]
    with open(path, "wb") as file:
        file.write(frame(bodies[0]))
    log = RecordLog(path)
    assert log.last() == "a" * 300
    log.append(["a", "a"])
    log.close()
    with open(path, "rb") as file:
        assert file.read() == frame(bodies[0]) + frame(bodies[1])


@pytest.mark.parametrize("missing", [1, 8])
def test_frame_that_is_longer_than_the_file_is_dropped(path, missing):
    whole = frame(marshal.dumps("whole", 2))
    with open(path, "wb") as file:
        file.write(whole + frame(marshal.dumps("cut", 2), missing))
    assert list(RecordLog(path).records()) == ["whole"]
    assert os.path.getsize(path) == len(whole)


def test_file_belongs_to_its_user_alone(path):
    log = RecordLog(path)
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600
    log.replace(1)
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600


@given(cut=st.integers(0, 200), flipped=st.integers(0, 199))
def test_damaged_tail_is_dropped_and_the_log_continues(tmp_path_factory, cut, flipped):
    path = tmp_path_factory.mktemp("log") / "log"
    log = RecordLog(str(path))
    ends = [0]
    for number in range(4):
        log.append([number, "padding" * 3])
        ends.append(log.size_bytes)
    damaged = bytearray(path.read_bytes()[:cut])
    if flipped < len(damaged):
        damaged[flipped] ^= 0x55
    path.write_bytes(damaged)
    whole = min(len(damaged), flipped)
    count = max(n for n, end in enumerate(ends) if end <= whole)
    again = RecordLog(str(path))
    again.append("next")
    expected = [*[[number, "padding" * 3] for number in range(count)], "next"]
    assert list(again.records()) == expected
    assert list(RecordLog(str(path)).records()) == expected


@pytest.mark.parametrize("content", [b"\xff\x00 nonsense\n", bytes(100), b'["a"]\n["b"]\n'])
def test_file_of_another_format_is_an_empty_log(path, content):
    with open(path, "wb") as file:
        file.write(content)
    log = RecordLog(path)
    assert log.failure is None
    assert log.last() is None
    assert log.append("first")
    assert list(RecordLog(path).records()) == ["first"]


def test_file_of_another_user_is_an_empty_log(path, monkeypatch):
    RecordLog(path).append("foreign")
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert RecordLog(path).last() is None


@pytest.mark.parametrize("method", ["append", "replace"])
def test_short_write_stops_the_log_and_raises_nothing(path, monkeypatch, method):
    log = RecordLog(path)
    assert log.append("first")
    write = os.write
    monkeypatch.setattr(os, "write", lambda file, data: write(file, data[:5]))
    assert not getattr(log, method)("second")
    monkeypatch.setattr(os, "write", write)
    assert not log.append("third")
    assert not log.replace("third")
    assert log.failure.errno == errno.ENOSPC
    assert "No space left" in str(log.failure)
    assert log.failure.filename == path
    assert list(log.records()) == list(RecordLog(path).records()) == ["first"]
    assert os.listdir(os.path.dirname(path)) == [os.path.basename(path)]


def test_missing_folder_is_a_failure_and_raises_nothing(tmp_path):
    log = RecordLog(str(tmp_path / "none" / "log"))
    failure = log.failure
    assert failure.errno == errno.ENOENT
    assert "No such file" in str(failure)
    assert not log.append("lost")
    assert list(log.records()) == []
    assert log.last() is None
    assert log.size_bytes == 0
    log.clear()
    log.remove()
    assert log.failure is failure


def test_device_without_space_is_a_failure_and_raises_nothing(path):
    os.symlink("/dev/full", path)
    log = RecordLog(path)
    assert not log.append("lost")
    assert log.failure.errno == errno.ENOSPC
    log.clear()
    assert log.last() is None


def test_log_survives_the_removal_of_its_folder(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    log = RecordLog(str(folder / "log"))
    log.append(1)
    os.remove(log.path)
    folder.rmdir()
    assert log.append(2)
    assert list(log.records()) == [1, 2]
    assert not log.replace(3)
    assert log.failure is not None


def test_replace_leaves_one_record(path):
    log = RecordLog(path)
    log.append(1)
    log.append(2)
    assert log.replace(3)
    assert log.append(4)
    assert list(log.records()) == list(RecordLog(path).records()) == [3, 4]


def test_clear_and_remove(path):
    log = RecordLog(path)
    log.append(1)
    log.clear()
    assert log.last() is None
    assert log.size_bytes == os.path.getsize(path) == 0
    log.append(2)
    assert list(RecordLog(path).records()) == [2]
    log.remove()
    assert not os.path.exists(path)
    assert not log.append(3)


def test_object_that_is_not_plain_data_is_refused(path):
    with pytest.raises(ValueError, match="unmarshallable"):
        RecordLog(path).append(object())


def test_file_is_closed_with_its_log(path):
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(10):
        RecordLog(path).append(1)
    assert len(os.listdir("/proc/self/fd")) == before


def test_closed_log_is_empty_and_accepts_nothing(path):
    log = RecordLog(path)
    log.append(1)
    log.close()
    assert log.failure.errno == errno.EBADF
    assert log.failure.strerror == "Bad file descriptor"
    assert log.failure.filename == path
    assert not log.append(2)
    assert (log.last(), list(log.records()), log.size_bytes) == (None, [], 0)
    assert RecordLog(path).last() == 1


def test_log_closes_only_its_own_file_and_only_once(path, tmp_path):
    before = os.listdir("/proc/self/fd")
    for log in (RecordLog(path), RecordLog(str(tmp_path / "none" / "log"))):
        log.close()
        log.close()
    assert os.listdir("/proc/self/fd") == before
