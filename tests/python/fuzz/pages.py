"""Messages to the live view: bytes, requests with the headers of other pages, WebSocket messages.

A case is a line of JSON for each message. After all of them the view must answer its own page, and have said
nothing on stderr.
"""

import contextlib
import json
import os
import re
import socket
import struct
import time
from functools import cache
from pathlib import Path

import numpy as np

import lissom
from fuzz import damage, judge
from fuzz import values as v

NAME = "pages"
SUFFIX = ".case"

#: Hosts and origins; `{own}` stands for those of the view.
HOSTS = (
    "{own}",
    "localhost",
    "127.0.0.1",
    "[::1]",
    "evil.example",
    "localhost.evil.example",
    "{own}.evil.example",
    "",
    "a" * 5000,
)
ORIGINS = (
    "http://{own}",
    "https://{own}",
    "http://evil.example",
    "null",
    "",
    "file://",
    "http://localhost@evil.example",
)
TYPES = (
    *(
        "GuiUpdateMessage",
        "TransformControlsUpdateMessage",
        "TransformControlsDragStartMessage",
        "ViewerCameraMessage",
    ),
    *("TransformControlsDragEndMessage", "ShareUrlRequest", "ShareUrlDisconnect", "FileTransferStartUpload"),
    *(
        "FileTransferPart",
        "ScenePointerMessage",
        "SceneNodeClickMessage",
        "GuiButtonHoldMessage",
        "BackgroundImageMessage",
    ),
    *("RunJavascriptMessage", "FileTransferPartAck", "GetRenderResponseMessage", "", "x" * 3000),
)
KEYS = (
    "uuid",
    "updates",
    "name",
    "owner",
    "position",
    "wxyz",
    "fov",
    "near",
    "far",
    "look_at",
    "part_count",
    "value",
    "content",
)
#: Seconds in which a view answers, on a busy machine.
PATIENCE = 20.0


def prepare() -> None:
    pass


@cache
def view():
    """A view that is open while this process lives."""
    page = lissom.Simulation(v.planar(), dt=1e-3).view(port=0, block=False)
    return page, page.url.removeprefix("http://")


def make(rng: np.random.Generator) -> bytes:
    lines = []
    for _ in range(int(rng.integers(1, 6))):
        kind = str(rng.choice(["bytes", "request", "socket"], p=[0.2, 0.2, 0.6]))
        line = {"kind": kind, "seed": int(rng.integers(2**31))}
        if kind == "request":
            line |= {"host": str(rng.choice(HOSTS)), "origin": str(rng.choice(ORIGINS))}
        lines.append(json.dumps(line))
    return "\n".join(lines).encode()


def where(path: Path) -> str:
    return "view"


def said() -> str:
    """What this process has said on stderr, which the worker keeps in a file."""
    with contextlib.suppress(OSError):
        return Path(os.readlink("/proc/self/fd/2")).read_text(errors="replace")
    return ""


def run(path: Path, clock) -> judge.Outcome:
    page, own = view()
    for line in path.read_text(encoding="utf-8").splitlines():
        message = json.loads(line)
        outcome = {"bytes": _bytes, "request": _request, "socket": _socket}[message["kind"]](own, message)
        if outcome is not None:
            return outcome
    time.sleep(0.05)
    status = _status(own, _head(own, own, f"http://{own}"))
    if status != 200 or not page.is_open:
        return judge.found("crash", "view", f"answers its own page with {status}")
    if "Traceback" in said():
        return judge.found("exception", "view", said()[-2000:], "a traceback on stderr")
    return judge.Outcome("done", "it answers")


def _connection(own: str) -> socket.socket:
    return socket.create_connection(("127.0.0.1", int(own.rpartition(":")[2])), timeout=PATIENCE)


def _head(own: str, host: str, origin: str, upgrade: bool = False) -> bytes:
    lines = ["GET / HTTP/1.1", f"Host: {host}"]
    if origin:
        lines.append(f"Origin: {origin}")
    if upgrade:
        import viser

        lines += ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13"]
        lines += [
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            f"Sec-WebSocket-Protocol: viser-v{viser.__version__}",
        ]
    return "\r\n".join([*lines, "", ""]).encode()


def _status(own: str, request: bytes) -> int | None:
    """Status of the answer to a request; None without one."""
    with contextlib.suppress(OSError), _connection(own) as connection:
        connection.sendall(request)
        answer = connection.recv(1 << 12)
        if answer.startswith(b"HTTP/1.1 "):
            return int(answer.split()[1])
    return None


def _bytes(own: str, message) -> None:
    """A request that is damaged, or none."""
    rng = np.random.default_rng(message["seed"])
    content = _head(own, own, f"http://{own}", bool(rng.integers(2)))
    content = (
        damage.damaged(content, damage.changes(rng))
        if rng.random() < 0.7
        else rng.bytes(int(rng.integers(5000)))
    )
    with contextlib.suppress(OSError), _connection(own) as connection:
        connection.sendall(content)
        connection.settimeout(0.05)
        connection.recv(1 << 12)


def _request(own: str, message) -> judge.Outcome | None:
    """Only the view's own page, on this machine, may use it."""
    host, origin = (message[key].replace("{own}", own) for key in ("host", "origin"))
    for upgrade in (False, True):
        status = _status(own, _head(own, host, origin, upgrade))
        name = re.sub(r":\d+$", "", host) if host.count(":") == 1 or host.startswith("[") else host
        is_own = name in ("localhost", "127.0.0.1", "[::1]") and origin in (
            "",
            f"http://{host}",
            f"https://{host}",
        )
        if not is_own and status in (101, 200):
            where_from = f"host {message['host'][:40]!r}, origin {message['origin']!r}"
            return judge.found("silent", "view", f"answers another page, {where_from}: {status}")
    return None


def _socket(own: str, message) -> None:
    """Messages through an open WebSocket."""
    rng = np.random.default_rng(message["seed"])
    with contextlib.suppress(OSError), _connection(own) as connection:
        connection.sendall(_head(own, own, f"http://{own}", True))
        connection.recv(1 << 12)
        for _ in range(int(rng.integers(1, 20))):
            connection.sendall(_frame(_message(rng), rng))
        connection.settimeout(0.05)
        connection.recv(1 << 12)


def _frame(content: bytes, rng) -> bytes:
    """A frame as clients send them (RFC 6455, section 5.2); one in ten is wrong."""
    first, mask = 0x82, rng.bytes(4)
    length = len(content)
    if rng.random() < 0.1:
        first, length = int(rng.integers(256)), int(rng.choice([length, 0, 125, 2**16, 2**31, 2**63 - 1]))
    if length < 126:
        head = struct.pack("!BB", first, 0x80 | length)
    elif length < 2**16:
        head = struct.pack("!BBH", first, 0x80 | 126, length)
    else:
        head = struct.pack("!BBQ", first, 0x80 | 127, length)
    masked = bytes(byte ^ mask[k % 4] for k, byte in enumerate(content))
    return head + mask + masked


def _message(rng) -> bytes:
    import msgspec

    if rng.random() < 0.15:
        return rng.bytes(int(rng.integers(200)))
    message = {"type": str(rng.choice(TYPES))}
    for key in rng.choice(KEYS, int(rng.integers(6)), replace=False):
        message[str(key)] = _value(rng)
    content = msgspec.msgpack.encode(message)
    return damage.damaged(content, damage.changes(rng)[:1]) if rng.random() < 0.2 else content


def _value(rng):
    values = [
        0,
        -1,
        2**63,
        1e308,
        float("nan"),
        float("inf"),
        "",
        "x",
        "/handle",
        "x" * 3000,
        None,
        True,
        b"x" * 100,
        [],
    ]
    kind = int(rng.integers(len(values) + 3))
    if kind < len(values):
        return values[kind]
    if kind == len(values):
        return [_value(rng) for _ in range(int(rng.integers(5)))]
    if kind == len(values) + 1:
        return {"value": _value(rng)}
    return rng.normal(size=int(rng.choice([3, 4]))).tolist()
