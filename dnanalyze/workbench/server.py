"""The workbench's server: one session a folder, pages that show it, on the loopback address."""

from __future__ import annotations

import html
import logging
import secrets
import socket
import warnings
import webbrowser
from asyncio import AbstractEventLoop
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field
from importlib.util import find_spec
from threading import Lock
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.source import CaptureSource

LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANY = ("0.0.0.0", "::")


@dataclass
class Sessions:
    """One session for each capture folder; every page of a folder is a view of it.

    Parameters
    ----------
    sources : sequence of CaptureSource
        The folders that pages may show, that of a page's plain address first.
    model : NoiseModel, optional
        Starting model of each.
    captures : CaptureSet
        Of the first folder; the others are read when a page asks for them.
    """

    sources: Sequence[CaptureSource]
    model: NoiseModel | None
    captures: CaptureSet
    _held: dict[int, WorkbenchSession] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    def get(self, asked: str) -> tuple[int, WorkbenchSession]:
        """The session of a folder by its number; that of the first for any other text.

        Raises
        ------
        InputError
            The folder cannot be read.
        """
        number = int(asked) if asked in map(str, range(len(self.sources))) else 0
        with self._lock:
            if number not in self._held:
                loaded = None if number else self.captures
                self._held[number] = WorkbenchSession(self.sources[number], self.model, loaded)
            return number, self._held[number]

    def close(self) -> None:
        """End every session's worker."""
        for session in self._held.values():
            session.close()


def serve(
    sources: Sequence[CaptureSource],
    model: NoiseModel | None = None,
    *,
    port: int = 0,
    host: str = "127.0.0.1",
    browser: bool = True,
    say: Any = print,
) -> None:
    """Serve the page until interrupted.

    Parameters
    ----------
    sources : sequence of CaptureSource
        One at least; pages offer the choice between them, and read no other folder.
    model : NoiseModel, optional
        Starting model; the Wang 2025 model by default.
    port : int
        0: any free port.
    host : str
        Address to listen on. Others than the loopback address demand a token in the page's
        address.
    browser : bool
        Whether to open the page in the default browser.
    say : callable
        Called with the page's address.

    Raises
    ------
    InputError
        The extra ``workbench`` is not installed, the port is in use, or the captures cannot be
        read.
    """
    captures = sources[0].captures()  # what cannot be read is told before a page is opened
    if find_spec("panel") is None or find_spec("bokeh") is None:
        raise InputError(
            "workbench: Panel is not installed; pip install 'panel>=1.9,<2' 'bokeh>=3.9,<4'"
        )
    port = _free(host, port)
    with closing(Sessions(sources, model, captures)) as sessions:
        sessions.get("")[1].begin()  # while Panel is imported and the browser starts
        _serve(sessions, port, host, browser, say)


def _serve(sessions: Sessions, port: int, host: str, browser: bool, say: Any) -> None:
    import panel as pn

    from dnanalyze.workbench.page.app import page, style_sheet

    sources = sessions.sources
    token = "" if host in LOOPBACK else secrets.token_urlsafe(24)
    pn.extension(notifications=False)
    # News for a page that is closed, and a browser's first words of a button: nothing for the user
    logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)
    warnings.filterwarnings("ignore", "reference already known")

    def app() -> Any:
        arguments = {k: v[0].decode() for k, v in pn.state.session_args.items()}
        given = arguments.get("token", "")
        if token and not secrets.compare_digest(given.encode(), token.encode()):
            return pn.pane.HTML("<p>This address needs its token: see the terminal.</p>")
        theme = "dark" if arguments.get("theme") == "dark" else "light"
        pn.config.raw_css = [style_sheet(theme)]
        try:
            number, session = sessions.get(arguments.get("folder", ""))
        except InputError as error:
            return pn.pane.HTML(f"<p>{html.escape(str(error))}</p>")

        def query(of: int) -> str:
            return f"?folder={of}&theme={theme}" + (f"&token={token}" if token else "")

        others = {named(s, sources): query(i) for i, s in enumerate(sources) if i != number}
        return page(session, query(number), theme, session.begin, others)

    names = _names(host)
    address = f"http://{names[0]}:{port}/" + (f"?token={token}" if token else "")
    origins = [f"{name}:{port}" for name in {*names, "localhost", "127.0.0.1"}]
    server = pn.io.server.get_server(
        app, port=port, address=host, websocket_origin=origins, title="dnanalyze workbench",
        show=False, start=False, check_unused_sessions_milliseconds=5000,
        unused_session_lifetime_milliseconds=15000,
    )  # fmt: skip
    server.io_loop.asyncio_loop.set_exception_handler(unless_closed)
    say(address)
    if browser:
        webbrowser.open(address)
    try:
        server.start()
        server.io_loop.start()
    except KeyboardInterrupt:
        pass
    finally:
        server.stop()


def unless_closed(loop: AbstractEventLoop, context: dict[str, Any]) -> None:
    """Report what went wrong in a loop, but for news on its way to a page that was closed."""
    from tornado.websocket import WebSocketClosedError

    if not isinstance(context.get("exception"), WebSocketClosedError):
        loop.default_exception_handler(context)


def named(source: CaptureSource, among: Sequence[CaptureSource]) -> str:
    """Name of a folder; its path where several have that name."""
    same = [s for s in among if s.folder.name == source.folder.name]
    return source.folder.name if len(same) == 1 else str(source.folder)


def _names(host: str) -> list[str]:
    """By what a browser may call the host, in an address; the best first."""
    if host in LOOPBACK:
        return ["127.0.0.1" if host == "localhost" else _literal(host)]
    if host not in ANY:
        return [_literal(host)]
    name = socket.gethostname()
    try:
        found = {str(entry[4][0]) for entry in socket.getaddrinfo(name, None)}
    except OSError:
        found = set()
    return [name, *sorted(_literal(x) for x in found)]


def _literal(host: str) -> str:
    """An address of version 6 in brackets."""
    return f"[{host}]" if ":" in host else host


def _free(host: str, port: int) -> int:
    """The port, if it can be listened on; any free one for 0."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((host, port))
        except OSError as error:
            raise InputError(
                f"--port {port}: cannot listen on {host}: {error.strerror}; name another port, "
                "or 0 for a free one"
            ) from None
        return int(trial.getsockname()[1])
