"""What reaches the lab's server: pages of this machine and well-formed messages, nothing else.

viser checks neither who connects nor what is sent: a page of another site could reach the lab through the browser of
whoever has it open, under another name of this machine (DNS rebinding) or in a frame, and a message of a wrong shape
ends in a traceback.  Here such requests are refused and such messages dropped.
"""

import asyncio
import http
import logging
import math
import re
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import MISSING, fields
from functools import cache
from typing import Any, get_type_hints

import msgspec
import viser
import websockets.asyncio.server as sockets
from viser import _messages
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

OWN_HOST = r"(127\.0\.0\.1|localhost|\[::1\])(:\d+)?"
# Pages that may connect: those of this machine; and what is no page and does not say where it comes from.
OWN_PAGES = (re.compile(rf"http://{OWN_HOST}"), None)
OWN_HOSTS = re.compile(OWN_HOST)
# No page may show the lab in a frame, and have its visitor click there without knowing.
HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
}
# What a browser has to say to the lab; anything else that viser knows is for what the lab does not have.
HEARD = (
    _messages.ViewerCameraMessage,
    _messages.ScenePointerMessage,
    _messages.GuiUpdateMessage,
    _messages.FileTransferStartUpload,
    _messages.FileTransferPart,
    _messages.GetRenderResponseMessage,
)
UPLOAD = _messages.FileTransferStartUpload.__name__
Value = bool | int | float | str | list | None

Handler = Callable[[ServerConnection], Awaitable[None]]
HttpServer = Callable[[ServerConnection, Request], Response | None]


@contextmanager
def guarded() -> Iterator[None]:
    """Let a server of viser's that is started meanwhile hear only this machine's own pages and well-formed messages."""
    serve = sockets.serve

    def guarded_serve(handler: Handler, *where: Any, process_request: HttpServer, **options: Any) -> Any:
        return serve(
            only_well_formed(handler),
            *where,
            process_request=only_own_hosts(process_request),
            origins=OWN_PAGES,
            logger=silent(),
            **options,
        )

    sockets.serve = guarded_serve  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        sockets.serve = serve  # type: ignore[misc]


def silent() -> logging.Logger:
    """Return a logger that drops all messages: errors of a peer on a connection do not concern the user."""
    logger = logging.Logger("tumble.lab")
    logger.addHandler(logging.NullHandler())
    return logger


def only_own_hosts(answer: HttpServer) -> HttpServer:
    """Return an HTTP server that answers only requests to this machine's own names, and sends HEADERS."""

    def checked(connection: ServerConnection, request: Request) -> Response | None:
        hosts = request.headers.get_all("Host")
        if len(hosts) != 1 or not OWN_HOSTS.fullmatch(hosts[0]):
            text = "the lab answers to 127.0.0.1 and localhost alone\n"
            return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", Headers(HEADERS), text.encode())
        try:
            response = answer(connection, request)
        except (OSError, ValueError):  # a path that is none
            response = Response(http.HTTPStatus.NOT_FOUND, "Not Found", Headers(), b"")
        if response is not None:
            for name, value in HEADERS.items():
                response.headers[name] = value
        return response

    return checked


def only_well_formed(handle: Handler) -> Handler:
    """Return a handler of connections that hears only pages of the viser served here, and what `is_heard`."""

    async def checked(connection: ServerConnection) -> None:
        # viser would print that on standard output, which is for results.
        if connection.subprotocol != f"viser-v{viser.__version__}":
            await connection.close(1002, "another version of the page: load it again")
            return
        await handle(WellFormed(connection))  # type: ignore[arg-type]

    return checked


class WellFormed:
    """A connection of which only well-formed messages are received."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)

    async def recv(self) -> bytes:
        """Return the next message that is heard.  Raises ConnectionClosed."""
        while True:
            raw = await self._connection.recv()
            if isinstance(raw, bytes) and is_heard(raw):
                return raw


UPLOADS: set[str] = set()


def take_uploads_of(button: viser.GuiUploadButtonHandle) -> None:
    """Let files come for this control.  viser would make one the value of any control that a browser names."""
    UPLOADS.add(button._impl.uuid)


def is_heard(raw: bytes) -> bool:
    """Whether a message is one of HEARD: every field there, of its type, and every number finite."""
    try:
        message = msgspec.msgpack.decode(raw)
        if not isinstance(message, dict) or not is_finite(message):
            return False
        name = message.pop("type", None)
        kind = shapes().get(name)
        if kind is None or (name == UPLOAD and message.get("source_component_uuid") not in UPLOADS):
            return False
        msgspec.convert(message, kind, builtin_types=(bytes,))
    except (msgspec.MsgspecError, UnicodeDecodeError, TypeError, RecursionError):
        return False
    return True


def is_finite(value: object) -> bool:
    """Whether every number in a message is finite."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, dict):
        return all(map(is_finite, value.values()))
    return all(map(is_finite, value)) if isinstance(value, list) else True


@cache
def shapes() -> dict[str, type]:
    """Return the type of each message that is heard, by name, as msgspec checks it."""
    return {kind.__name__: shape(kind) for kind in HEARD}


def shape(kind: type) -> type:
    """Return a type with a message's fields, those that have no default required, and no others."""
    hints = get_type_hints(kind)
    if kind is _messages.GuiUpdateMessage:  # of a control a person changes the value alone
        hints["updates"] = msgspec.defstruct("Updates", [("value", Value)], forbid_unknown_fields=True)
    stated = []
    for one in fields(kind):
        has_default = one.default is not MISSING or one.default_factory is not MISSING
        stated.append((one.name, hints[one.name], msgspec.UNSET) if has_default else (one.name, hints[one.name]))
    return msgspec.defstruct(kind.__name__, stated, forbid_unknown_fields=True)


def drop_what_cannot_be_used(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Handle an exception of the server's loop: a well-formed message with a value that its control cannot have is
    dropped, as a malformed one is."""
    task = context.get("future")
    if isinstance(task, asyncio.Task) and "_handle_incoming_message" in str(task.get_coro()):
        return
    loop.default_exception_handler(context)
