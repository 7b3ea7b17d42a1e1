"""What reaches the lab: only this machine's own pages, in no frame, and messages of the right shape; no tracebacks."""

import contextlib
import http.client
import random
import socket
import subprocess
from collections.abc import Iterator
from urllib.parse import urlsplit

import msgspec
import pytest
import viser
from lab_pages import Lab, serving
from viser import _messages
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from tumble.lab.guard import HEARD, is_heard
from tumble.lab.page import TICKS_S

CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, 0.0, 5.0], "fov": 0.8, "near": 0.02,
    "far": 2000.0, "image_height": 720, "image_width": 612, "look_at": [0.0, 0.0, 0.0], "up_direction": [0.0, 1.0, 0.0],
}  # fmt: skip
CLICK = {
    "type": "ScenePointerMessage", "event_type": "click", "ray_origin": [0, 0.5, 5], "ray_direction": [0.0, 0.0, -1.0],
    "screen_pos": [[0.5, 0.5]], "modifier": None,
}  # fmt: skip
UPDATE = {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1.0}}
PART = {"type": "FileTransferPart", "source_component_uuid": "x", "transfer_uuid": "y", "part_index": 0, "content": b""}
WELL_FORMED = (CAMERA, CLICK, UPDATE, PART)
STRANGE = (None, True, -1, 1e308, float("nan"), float("inf"), "", "\x00", b"\xff", [], [None], {}, "x" * 9999, 2**63)
BROKEN_HTTP = (b"\r\n\r\n", b"GET\r\n\r\n", b"\xff\xfe" * 99 + b"\r\n\r\n", b"GET / HTTP/1.1\r\nHost\r\n\r\n", b"")


def packed(message: object) -> bytes:
    return msgspec.msgpack.encode(message)


@pytest.mark.parametrize("message", WELL_FORMED, ids=lambda message: message["type"])
def test_what_a_browser_sends_is_heard(message):
    assert is_heard(packed(message))


@pytest.mark.parametrize("message", WELL_FORMED, ids=lambda message: message["type"])
def test_a_message_with_a_field_missing_or_more_is_dropped(message):
    assert not is_heard(packed(message | {"more": 1}))
    for name in message:
        assert not is_heard(packed({key: value for key, value in message.items() if key != name}))


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"\xc1", b"\x80", b"\x93\x01", packed([]), packed(1), packed({"type": "ResetGuiMessage"}),
        packed({"type": 3}), b"\x91" * 9999,
        packed(CAMERA | {"fov": "wide"}), packed(CAMERA | {"fov": float("nan")}), packed(CAMERA | {"wxyz": [1.0]}),
        packed(CAMERA | {"position": [0.0, 0.0, float("inf")]}), packed(CLICK | {"event_type": "throw"}),
        packed(UPDATE | {"updates": {"update_cb": []}}), packed(UPDATE | {"updates": {"value": {"a": 1}}}),
        packed(UPDATE | {"updates": {"value": 1.0, "removed": True}}), packed(PART | {"content": "text"}),
    ],
)  # fmt: skip
def test_everything_else_is_dropped(raw):
    assert not is_heard(raw)


def test_viser_listens_to_nothing_else_that_the_lab_has():
    heard = {kind.__name__ for kind in HEARD}
    assert heard <= set(_messages.Message._subclass_from_type_string())


@pytest.fixture(scope="module")
def lab(tmp_path_factory) -> Iterator[Lab]:
    with serving(tmp_path_factory.mktemp("guard"), "table-4-1-ray", "-e", "tumble:rk4", errors=subprocess.PIPE) as lab:
        yield lab


def ask(lab: Lab, host: str | None) -> tuple[int, http.client.HTTPMessage]:
    """Return the status and the headers of the answer to a request with that Host, with none for None."""
    port = urlsplit(lab.address).port
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", port, timeout=60)) as asked:
        asked.putrequest("GET", "/", skip_host=True)
        if host is not None:
            asked.putheader("Host", host.format(port=port))
        asked.endheaders()
        answer = asked.getresponse()
        answer.read()
        return answer.status, answer.headers


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "localhost", "[::1]:{port}"])
def test_this_machine_is_answered_and_no_page_may_frame_the_lab(lab, host):
    status, headers = ask(lab, host)
    assert status == 200
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert headers["X-Frame-Options"] == "DENY"


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{port}", "127.0.0.1.evil.example", "", None])
def test_another_name_of_this_machine_is_not_answered(lab, host):
    assert ask(lab, host)[0] == 403


def test_another_name_is_not_answered_on_a_web_socket_either(lab):
    port = urlsplit(lab.address).port
    line = socket.create_connection(("127.0.0.1", port), timeout=60)
    with pytest.raises(InvalidStatus) as refused, talking(lab, uri=f"ws://evil.example:{port}", sock=line):
        pass
    assert refused.value.response.status_code == 403


def talking(lab: Lab, uri: str = "", version: str = viser.__version__, **options) -> ClientConnection:
    """Return a connection as a browser makes it."""
    return connect(
        uri or lab.address.replace("http", "ws"), subprotocols=[f"viser-v{version}"], max_size=None, **options
    )  # type: ignore[arg-type]


def strange_messages(rng: random.Random, uuids: list[str]) -> Iterator[bytes | str]:
    """Yield messages of every wrong kind, and well-formed ones that say what no control can be set to."""
    yield "text"
    for _ in range(60):
        yield rng.randbytes(rng.randrange(200))
    for message in WELL_FORMED:
        for name in message:
            for value in STRANGE:
                yield packed(message | {name: value})
    for uuid in uuids:
        for value in STRANGE:
            yield packed(UPDATE | {"uuid": uuid, "updates": {"value": value}})
        upload = {"source_component_uuid": uuid, "transfer_uuid": uuid, "filename": "\x00/../x.csv", "mime_type": ""}
        yield packed({"type": "FileTransferStartUpload", **upload, "part_count": 0, "size_bytes": 0})
        yield packed({"type": "FileTransferStartUpload", **upload, "part_count": 0, "size_bytes": 9})
    yield packed(CLICK | {"ray_direction": [0.0, 0.0, 0.0]})
    yield packed(CAMERA | {"fov": 0.0, "image_height": 0, "image_width": 0})


def controls(connection: ClientConnection) -> list[str]:
    """Return the names of the page's controls, from what the lab sends at first."""
    import zstandard

    found = []
    while True:
        try:
            raw = connection.recv(timeout=TICKS_S + 2.0 if found else 60.0)  # its tick boxes come later
        except TimeoutError:
            return found
        assert isinstance(raw, bytes)
        size, length = (int.from_bytes(raw[at : at + 8], "little") for at in (0, 8))
        inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + length], max_output_size=size)
        for message in msgspec.msgpack.decode(inner)["messages"]:
            if message["type"].startswith("Gui") and "container_uuid" in message:
                found.append(message["uuid"])


def test_what_is_malformed_leaves_no_traceback_and_the_lab_alive(lab):
    host, port = "127.0.0.1", urlsplit(lab.address).port
    for raw in BROKEN_HTTP:
        with socket.create_connection((host, port), timeout=60) as line:
            line.sendall(raw)
    with talking(lab, version="0.0.1") as other, pytest.raises(ConnectionClosed):
        other.recv(timeout=60)
    sent = 0
    with talking(lab) as connection:
        connection.send(packed(CAMERA))
        uuids = controls(connection)
        assert len(uuids) > 40
        for message in strange_messages(random.Random(24), uuids):
            connection.send(message)
            sent += 1
    assert sent > 1200  # the tick boxes among them
    with talking(lab) as connection:  # who comes after is served
        connection.send(packed(CAMERA))
        assert controls(connection)
    lab.process.terminate()
    out, errors = lab.process.communicate(timeout=60)
    assert "Traceback" not in errors, errors
    assert "Task" not in errors, errors
    assert out == ""
    assert len(errors.splitlines()) <= 3, errors
    assert lab.process.returncode == 0
