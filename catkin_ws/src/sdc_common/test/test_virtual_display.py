import pytest

from sdc_testing.virtual_display import VirtualDisplay


def test_missing_xvfb_is_an_error_that_names_it(monkeypatch):
    monkeypatch.setenv("PATH", "/none")
    with pytest.raises(FileNotFoundError, match="Xvfb"), VirtualDisplay():
        pass
