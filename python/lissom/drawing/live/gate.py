"""Who may talk to the server of a live view: pages that it served itself, and hosts that the user names.

A browser lets any page that is open connect to servers of its machine. Such a connection carries the page's
address in the header ``Origin``. After DNS rebinding (a name that now points to this machine) the header
``Host`` has the other name. Both are checked before anything is answered (RFC 6455, section 10.2).
"""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import io
import ipaddress
import logging
import pkgutil
import re
import threading
from collections.abc import Collection, Iterator, Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server
from websockets import Headers
from websockets.http11 import Response

from .messages import is_message

#: Names of this machine.
LOCAL = frozenset({"localhost", "127.0.0.1", "::1"})

#: Names of hosts as browsers send them (RFC 1123), and with underscores, which local networks have.
_NAME = re.compile(r"[a-z0-9_]([a-z0-9_.-]*[a-z0-9_])?")

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
    if "@" in host or (name not in LOCAL and name not in hosts):
        return f"the host {host!r} is not this machine"
    if origin is None or _name(origin) in hosts:
        return None
    # Names of hosts have no case.
    own = {f"{scheme}://{host}".lower() for scheme in ("http", "https")}
    return None if origin.lower() in own else f"a page of {origin!r} may not use this server"


def _name(url: str) -> str | None:
    """The name of the host, in lower case and without the brackets of IPv6; None if there is none."""
    try:
        parts = urlsplit(url)
        # Raises if the port is no number, as in "localhost:80.other.example".
        _ = parts.port
        return parts.hostname
    except ValueError:
        return None


def names_of(hosts: Collection[str]) -> frozenset[str]:
    """Names of hosts as they are compared.

    Raises
    ------
    ValueError
        If one is not a name or an address alone.
    """
    names = set()
    for host in hosts:
        name = host.lower().strip("[]")
        if not (_NAME.fullmatch(name) or _is_ipv6(name)):
            raise ValueError(
                f"allow_hosts: {host!r} is not the name of a host alone, without scheme and port, "
                "such as 'robot.local'"
            )
        names.add(name)
    return frozenset(names)


def _is_ipv6(name: str) -> bool:
    try:
        ipaddress.IPv6Address(name)
    except ValueError:
        return False
    return True


def serve(host: str, port: int, title: str, hosts: Collection[str]) -> Server:
    """A server that answers only what `refusal` lets through.

    Raises
    ------
    OSError
        If no port is free.
    ValueError
        If a host is not a name alone.
    """
    library = websockets.asyncio.server
    create, is_guarded = library.serve, False
    known = names_of(hosts)
    # Another page could lay the view over its own, and let the user click there.
    # Policies have no addresses of IPv6: browsers report those as errors, and such pages frame no view.
    framing = [f"{name}:*" for name in sorted(LOCAL | known) if ":" not in name]
    policy = f"frame-ancestors {' '.join(framing)}"

    def guarded(handler: Any, *place: Any, process_request: Any, **options: Any) -> Any:
        nonlocal is_guarded
        is_guarded = True

        def check(connection: Any, request: Any) -> Any:
            reason = refusal(request.headers, known)
            if reason is not None:
                text = f"lissom view: {reason}; --allow-host and `allow_hosts` name others\n"
                return Response(HTTPStatus.FORBIDDEN.value, "Forbidden", Headers(), text.encode())
            response = process_request(connection, request)
            if response is not None:
                response.headers["Content-Security-Policy"] = policy
                _style(response)
            return response

        async def serve_connection(connection: Any) -> None:
            receive = connection.recv

            async def checked(*arguments: Any, **named: Any) -> Any:
                while not is_message(message := await receive(*arguments, **named)):
                    pass
                return message

            connection.recv = checked
            await handler(connection)

        # A message for a control that is no more raises in a task of its own; the connection goes on.
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)
        options |= {"max_size": LARGEST_MESSAGE, "logger": _SILENT}
        return create(serve_connection, *place, process_request=check, **options)

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


def _style(response: Response) -> None:
    """Add the style for phones to the page."""
    if not response.headers.get("Content-Type", "").startswith("text/html"):
        return
    is_packed = response.headers.get("Content-Encoding") == "gzip"
    page = gzip.decompress(response.body) if is_packed else bytes(response.body)
    style = pkgutil.get_data(__package__, "phone.css")
    assert style is not None, "packages are read from files or archives"
    page = page.replace(b"</head>", b"<style>" + style + b"</style></head>", 1)
    # Level 1: the script of the page is packed already.
    response.body = gzip.compress(page, 1) if is_packed else page
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress the messages that viser prints."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
