"""The lab's server: on this machine only, one page per browser; when it ends, no process is left."""

import contextlib
import io
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import viser

from tumble.lab.draft import Draft
from tumble.lab.guard import drop_what_cannot_be_used, guarded
from tumble.lab.page import Page
from tumble.lab.pool import Contestant, Pool

HOST = "127.0.0.1"


class LocalServer(viser.ViserServer):
    """A server that a browser cannot ask to share what it shows with another machine."""

    def request_share_url(self, verbose: bool = True) -> None:
        """Share nothing."""


@contextmanager
def serving(draft: Draft, contestants: list[Contestant], pool: Pool, folder: Path, port: int) -> Iterator[str]:
    """Serve the lab while the context lasts.

    Parameters
    ----------
    draft
        The scene that a new page shows.
    contestants
        Those that are selected on a new page.
    pool
        The engines' processes.
    folder
        Where throws are saved.
    port
        The port, or the next free one where it is in use.

    Yields
    ------
    str
        The address.
    """
    # viser greets on standard output, which is for results.
    with guarded(), contextlib.redirect_stdout(io.StringIO()):
        server = LocalServer(host=HOST, port=port, label="Tumble lab", verbose=False)
    server.get_event_loop().set_exception_handler(drop_what_cannot_be_used)
    # A message cut off by a closing browser is not reported, nor is an upload of the wrong length.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    warnings.filterwarnings("ignore", r"\[viser\] ", UserWarning)
    pages: dict[int, Page] = {}
    lock = threading.Lock()

    @server.on_client_connect
    def _(client: viser.ClientHandle) -> None:
        page = Page(client, draft, contestants, pool, folder)
        with lock:
            pages[client.client_id] = page
        if client.client_id not in server.get_clients():  # it was closed meanwhile
            forget(client)

    @server.on_client_disconnect
    def forget(client: viser.ClientHandle) -> None:
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
