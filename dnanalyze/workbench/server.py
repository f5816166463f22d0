"""The workbench's server: sessions by name, one page each, on the loopback address."""

from __future__ import annotations

import secrets
import socket
import webbrowser
from collections import OrderedDict
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.fitting.design import design
from dnanalyze.fitting.predictor import Bench, bench
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.source import CaptureSource

MOST_SESSIONS = 8
LOOPBACK = ("localhost", "127.0.0.1", "::1")
ANY = ("0.0.0.0", "::")


@dataclass
class Sessions:
    """Sessions by name; the one unused for longest gives way to a new one beyond the limit."""

    source: CaptureSource
    model: NoiseModel | None
    captures: CaptureSet
    _held: OrderedDict[str, WorkbenchSession] = field(default_factory=OrderedDict)
    _lock: Lock = field(default_factory=Lock)
    _taking: Lock = field(default_factory=Lock)
    _bench: Bench | None = None

    def get(self, name: str) -> tuple[str, WorkbenchSession]:
        """A session by its name, or a new one where there is none of that name."""
        with self._lock:
            if name in self._held:
                self._held.move_to_end(name)
                return name, self._held[name]
            session = WorkbenchSession(self.source, self.model, self.captures, self.statistics)
            name = secrets.token_urlsafe(9)
            self._held[name] = session
            if len(self._held) > MOST_SESSIONS:
                self._held.popitem(last=False)[1].close()
        return name, session

    def statistics(self) -> Bench:
        """The statistics of the captures, taken once for all sessions."""
        with self._taking:
            if self._bench is None:
                self._bench = bench(design(self.captures))
            return self._bench

    def close(self) -> None:
        """End every session's worker."""
        for session in self._held.values():
            session.close()


def serve(
    source: CaptureSource,
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
    source : CaptureSource
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
    captures = source.captures()  # what cannot be read is told before a page is opened
    try:
        import panel as pn
    except ImportError:
        raise InputError(
            "workbench: Panel is not installed; pip install 'panel>=1.9,<2' 'bokeh>=3.9,<4'"
        ) from None
    from dnanalyze.workbench.page.app import page, style_sheet

    sessions = Sessions(source, model, captures)
    token = "" if host in LOOPBACK else secrets.token_urlsafe(24)
    port = _free(host, port)
    pn.extension(notifications=False)

    def app() -> Any:
        arguments = {k: v[0].decode() for k, v in pn.state.session_args.items()}
        given = arguments.get("token", "")
        if token and not secrets.compare_digest(given.encode(), token.encode()):
            return pn.pane.HTML("<p>This address needs its token: see the terminal.</p>")
        theme = "dark" if arguments.get("theme") == "dark" else "light"
        name, session = sessions.get(arguments.get("session", ""))
        pn.config.raw_css = [style_sheet(theme)]
        asked = f"?session={name}&theme={theme}" + (f"&token={token}" if token else "")
        return page(session, asked, theme, session.begin)

    names = _names(host)
    address = f"http://{names[0]}:{port}/" + (f"?token={token}" if token else "")
    origins = [f"{name}:{port}" for name in {*names, "localhost", "127.0.0.1"}]
    server = pn.io.server.get_server(
        app, port=port, address=host, websocket_origin=origins, title="dnanalyze workbench",
        show=False, start=False, check_unused_sessions_milliseconds=5000,
        unused_session_lifetime_milliseconds=15000,
    )  # fmt: skip
    say(address)
    if browser:
        webbrowser.open(address)
    try:
        server.start()
        server.io_loop.start()
    except KeyboardInterrupt:
        pass
    finally:
        sessions.close()
        server.stop()


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
