"""Who may connect to the lab: pages of this machine, and nobody else's."""

from pathlib import Path

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from tumble.lab import server


class SeenPage:
    """In place of a page of the lab: who connects is all that counts here."""

    def __init__(self, client, *_) -> None:
        self.client = client

    def close(self) -> None:
        """Nothing to close."""


@pytest.fixture(scope="module")
def address():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server, "Page", SeenPage)
        with server.serving(None, [], None, Path(), 18080) as found:  # type: ignore[arg-type]
            yield found


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "https://127.0.0.1.evil.example", "null", "http://127.0.0.1:1.evil.example"]
)
def test_a_page_of_another_site_is_refused(address, origin):
    with pytest.raises(InvalidStatus) as refused, connect(address.replace("http", "ws"), origin=origin):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("origin", ["own", "http://localhost:5173", None])
def test_pages_of_this_machine_connect(address, origin):
    with connect(address.replace("http", "ws"), origin=address if origin == "own" else origin) as line:
        assert line.response is not None
        assert line.response.status_code == 101
