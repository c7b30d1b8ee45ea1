"""`camgeom serve`: prints the page's address, opens it, and answers it until interrupted."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from threading import Thread

from camgeom.cli import Console, UsageError, whole
from camgeom.interrupts import heard
from camgeom.profile import STDIN


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Serve the page until Ctrl-C; returns 0. Raises ProfileError where the file cannot be read."""
    from camgeom.report.server import HOST, Server

    port = whole(arguments.port, "--port", 1, 65535) or 0
    path = Path(arguments.profile)
    if arguments.profile == STDIN:
        raise UsageError("serve needs a file, which it watches and saves; standard input is none")
    try:
        server = Server(path, port)
    except OSError as error:
        raise UsageError(f"--port: {HOST}:{port} cannot be used: {error.strerror or error}") from None
    with server:
        server.seat.text()
        Thread(target=server.warm, daemon=True).start()
        console.out(server.url)
        sys.stdout.flush()
        console.err(f"camgeom: {path} is open at this address, on this machine alone; Ctrl-C ends")
        if not arguments.no_browser:
            import webbrowser

            webbrowser.open(server.url)
        try:
            server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt as stop:
            if stop.args:  # SIGTERM
                raise
            heard()
            console.err("camgeom: ended; the page keeps what was not saved while it is open")
    return 0
