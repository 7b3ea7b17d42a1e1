"""The lab's server: on this machine alone, one page a browser, nothing left when it ends."""

import contextlib
import io
import re
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import viser
import websockets.asyncio.server as sockets

from tumble.lab.crew import Contestant, Crew
from tumble.lab.draft import Draft
from tumble.lab.page import Page

HOST = "127.0.0.1"
# Pages that may connect: those of this machine; and what is no page and says nothing of where it comes from.
OWN_PAGES = (re.compile(r"http://(127\.0\.0\.1|localhost|\[::1\]):\d+"), None)


class LocalServer(viser.ViserServer):
    """A server that a browser cannot ask to share what it shows with another machine."""

    def request_share_url(self, verbose: bool = True) -> None:
        """Share nothing."""


@contextmanager
def own_pages_only() -> Iterator[None]:
    """Let a server that is started meanwhile refuse pages of other sites, which viser itself does not."""
    serve = sockets.serve
    sockets.serve = partial(serve, origins=OWN_PAGES)  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        sockets.serve = serve  # type: ignore[misc]


@contextmanager
def serving(draft: Draft, contestants: list[Contestant], crew: Crew, folder: Path, port: int) -> Iterator[str]:
    """Serve the lab and give its address; another port is taken where that one is.  folder: where throws are kept."""
    # viser greets on standard output, which is for results.
    with own_pages_only(), contextlib.redirect_stdout(io.StringIO()):
        server = LocalServer(host=HOST, port=port, label="Tumble lab", verbose=False)
    # What was on its way when a browser was closed is no news.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    pages: dict[int, Page] = {}
    lock = threading.Lock()

    @server.on_client_connect
    def _(client: viser.ClientHandle) -> None:
        page = Page(client, draft, contestants, crew, folder)
        with lock:
            pages[client.client_id] = page

    @server.on_client_disconnect
    def _(client: viser.ClientHandle) -> None:
        with lock:
            page = pages.pop(client.client_id, None)
        if page:
            page.close()

    try:
        yield f"http://{HOST}:{server.get_port()}"
    finally:
        for page in list(pages.values()):
            page.close()
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()
