"""Who may talk to the server of a live view: pages that it served itself, and hosts that the user names.

A browser lets any page that is open connect to servers of its machine. Such a connection carries the page's
address in the header ``Origin``. After DNS rebinding (a name that now points to this machine) the header
``Host`` has the other name. Both are checked before anything is answered (RFC 6455, section 10.2).
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import logging
import threading
from collections.abc import Collection, Iterator, Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server
from websockets import Headers
from websockets.http11 import Response

#: Names of this machine.
LOCAL = frozenset({"localhost", "127.0.0.1", "::1"})

#: Largest message from a page, bytes: pages send positions of the camera and values of sliders.
LARGEST_MESSAGE = 2**16

#: Messages of the library about single connections are of no use to the user of a view.
_SILENT = logging.getLogger("lissom.live.connections")
_SILENT.addHandler(logging.NullHandler())
_SILENT.propagate = False

#: One server at a time is created while the library's function is replaced.
_CREATING = threading.Lock()


class Server(viser.ViserServer):
    """viser's server without its public tunnel: any page may ask for that, and nothing here does."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Make no tunnel."""
        return None

    def disconnect_share_url(self) -> None:
        """There is no tunnel."""


def refusal(headers: Mapping[str, str], hosts: Collection[str]) -> str | None:
    """Why a request with these headers is refused; None for one that is answered."""
    host = headers.get("Host", "")
    name, origin = _name(f"//{host}"), headers.get("Origin")
    if name not in LOCAL and name not in hosts:
        return f"the host {host!r} is not this machine"
    if origin is None or _name(origin) in hosts:
        return None
    return None if urlsplit(origin).netloc == host else f"a page of {origin!r} may not use this server"


def _name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None


def serve(host: str, port: int, title: str, hosts: Collection[str]) -> Server:
    """A server that answers only what `refusal` lets through.

    Raises
    ------
    OSError
        If no port is free.
    """
    library = websockets.asyncio.server
    create, is_guarded = library.serve, False
    known = frozenset(name.lower() for name in hosts)

    def guarded(handler: Any, *place: Any, process_request: Any, **options: Any) -> Any:
        nonlocal is_guarded
        is_guarded = True

        def check(connection: Any, request: Any) -> Any:
            reason = refusal(request.headers, known)
            if reason is not None:
                text = f"lissom view: {reason}; --allow-host and `allow_hosts` name others\n"
                return Response(HTTPStatus.FORBIDDEN.value, "Forbidden", Headers(), text.encode())
            return process_request(connection, request)

        # Messages that are none raise in tasks of their own; the connection goes on without them.
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)
        options |= {"max_size": LARGEST_MESSAGE, "logger": _SILENT}
        return create(handler, *place, process_request=check, **options)

    with _CREATING, quiet():
        library.serve = guarded  # type: ignore[assignment, misc]
        try:
            server = Server(host=host, port=port, label=title, verbose=False)
        finally:
            library.serve = create  # type: ignore[misc]
    if not is_guarded:
        server.stop()
        raise RuntimeError(
            f"viser {viser.__version__} does not let lissom check who connects; install viser 1.1"
        )
    return server


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress the messages that viser prints."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
