"""The local server of the page: one file on the loopback interface, behind a random token, with the standard library.

Nobody else may ask: the address is 127.0.0.1, every path begins with the token, the host must be this address (a name
that an attacker points here is refused), and what changes anything must come from the page itself.
"""

from __future__ import annotations

import json
import re
import secrets
from collections.abc import Iterator
from hashlib import sha256
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, final

from camgeom.drawing.plots import WIDE
from camgeom.errors import CamgeomError, ExportError
from camgeom.export.files import write_whole
from camgeom.profile.text import MAX_BYTES
from camgeom.reading import decode, read_bytes
from camgeom.report.answer import Memory, answers, line
from camgeom.report.page import asset

HOST = "127.0.0.1"
MOST_BODY = 4 * MAX_BYTES
"""B of a request; it holds two profiles"""
PATIENCE = 30.0
"""s that a connection may stay silent"""
NAME = re.compile(r"[\w][\w .+-]{0,119}\.toml", re.ASCII)
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'; img-src data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Refused(Exception):
    """A request that is not carried out: status and reason."""

    def __init__(self, status: HTTPStatus, reason: str, **more: str) -> None:
        super().__init__(reason)
        self.status, self.reason, self.more = status, reason, more


@final
class Seat:
    """The file that is edited, and what was computed of it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.memory = Memory(str(path))

    def text(self) -> str:
        """The file's text. Raises ProfileError where it cannot be read."""
        return decode(read_bytes(self.path, MAX_BYTES, str(self.path)), str(self.path))

    def state(self) -> dict[str, Any]:
        """The file as it is now: text and digest; the reason where it cannot be read."""
        try:
            text = self.text()
        except CamgeomError as error:
            return {"name": self.path.name, "digest": "", "reason": str(error)}
        return {"name": self.path.name, "digest": digest(text), "text": text}

    def save(self, text: str, name: str, known: str) -> dict[str, str]:
        """Write the text, to the profile's own file or to a new one beside it; no file is ever lost.

        known  digest of the file that the page was made from: where another has been saved since, nothing is written.
        The text that the own file had is kept beside it under the first free name. Raises Refused.
        """
        if len(text.encode()) > MAX_BYTES:
            raise Refused(HTTPStatus.BAD_REQUEST, "the profile is too long")
        if not NAME.fullmatch(name):
            reason = "needs the name of a .toml file of letters, digits, blanks and .+-_, without a folder"
            raise Refused(HTTPStatus.BAD_REQUEST, reason)
        target, kept = self.path.with_name(name), ""
        if target.name == self.path.name:
            state = self.state()
            if state["digest"] not in ("", known):
                raise Refused(HTTPStatus.CONFLICT, "the file was changed outside since this page read it")
            if state["digest"] and state["text"] != text:
                before = self._free(target)
                _write(before, state["text"])
                kept = before.name
        elif target.exists():
            reason = f"{name} exists and is left as it is; a free name is {self._free(target).name}"
            raise Refused(HTTPStatus.CONFLICT, reason)
        _write(target, text)
        return {"saved": target.name, "digest": digest(text) if target.name == self.path.name else known, "kept": kept}

    def _free(self, path: Path) -> Path:
        """The first name of the form `cam.1.toml` that is free."""
        number = 1
        while (found := path.with_name(f"{path.stem}.{number}{path.suffix}")).exists():
            number += 1
        return found


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text)
    except ExportError as error:
        raise Refused(HTTPStatus.INTERNAL_SERVER_ERROR, str(error)) from None


def digest(text: str) -> str:
    """What tells two texts apart."""
    return sha256(text.encode()).hexdigest()


@final
class Server(ThreadingHTTPServer):
    """Serves one profile; `url` is the address with its token."""

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, path: Path, port: int = 0) -> None:
        self.seat = Seat(path)
        self.token = secrets.token_urlsafe(18)
        super().__init__((HOST, port), _Handler)

    @property
    def port(self) -> int:
        """The port it listens at."""
        return int(self.server_address[1])

    @property
    def url(self) -> str:
        """The page's address."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    def warm(self) -> None:
        """Make one whole answer, so that the first page waits for no import."""
        state = self.seat.state()
        for _ in answers(self.seat.memory, state.get("text", ""), {}, lambda: True):
            pass


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "camgeom", ""
    timeout = PATIENCE

    def do_GET(self) -> None:
        """The page, the schema, the file as it is."""
        self._carried_out({"": self._page, "schema": self._schema, "file": self._file})

    def do_POST(self) -> None:
        """An answer to a profile, line by line; saving."""
        self._carried_out({"answer": self._answer, "save": self._save})

    def _carried_out(self, known: dict[str, Any]) -> None:
        try:
            try:
                job = known.get(self._asked())
                if job is None:
                    raise Refused(HTTPStatus.NOT_FOUND, "there is nothing here")
                job()
            except Refused as refused:
                self.close_connection = True
                self._send({"reason": refused.reason, **refused.more}, refused.status)
        except (ConnectionError, TimeoutError):
            self.close_connection = True  # nobody is there any more, to be answered or to be refused

    def _asked(self) -> str:
        """What is asked for behind the token. Raises Refused for every other place, host and origin."""
        own = f"{HOST}:{self.server.port}"
        if self.headers.get("Host") not in (own, f"localhost:{self.server.port}"):
            raise Refused(HTTPStatus.FORBIDDEN, "this page is for this machine alone")
        if self.headers.get("Origin") not in (None, f"http://{own}", f"http://localhost:{self.server.port}"):
            raise Refused(HTTPStatus.FORBIDDEN, "asked from another page")
        parts = self.path.partition("?")[0].split("/")
        if len(parts) != 3 or not secrets.compare_digest(parts[1].encode(), self.server.token.encode()):
            raise Refused(HTTPStatus.NOT_FOUND, "open the address that camgeom serve prints, with its token")
        return parts[2]

    def _body(self) -> dict[str, Any]:
        """The request's JSON, its values by name; a name that is missing is an empty text."""
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or len(length) > len(str(MOST_BODY)) or int(length) > MOST_BODY:
            raise Refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"needs a body of at most {MOST_BODY} bytes")
        try:
            data = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            raise Refused(HTTPStatus.BAD_REQUEST, "needs JSON") from None
        texts = ("text", "kept", "tab", "name", "known")
        if not isinstance(data, dict) or not all(isinstance(data.get(key, ""), str) for key in texts):
            raise Refused(HTTPStatus.BAD_REQUEST, f"needs an object of texts ({', '.join(texts)})")
        try:
            "".join(data.get(key, "") for key in texts).encode()
        except UnicodeEncodeError:
            reason = "needs text: half a pair of UTF-16 is none, and no file can hold it"
            raise Refused(HTTPStatus.BAD_REQUEST, reason) from None
        return {**dict.fromkeys(texts, ""), **data}

    def _answer(self) -> None:
        body = self._body()
        serial, changes, width = body.get("serial", 0), body.get("changes", {}), body.get("width", WIDE)
        if not isinstance(serial, int) or not isinstance(changes, dict) or not isinstance(width, int | float):
            raise Refused(HTTPStatus.BAD_REQUEST, "needs a serial number, changes by key and a width")
        memory = self.server.seat.memory
        fresh = memory.arrived(body["tab"], serial)
        stages = answers(memory, body["text"], changes, fresh, body["kept"], width)
        self._stream(map(line, stages))

    def _stream(self, lines: Iterator[bytes]) -> None:
        self.send_response(HTTPStatus.OK)
        self._heads("application/x-ndjson")
        self.send_header("Transfer-Encoding", "chunked")
        self.end_headers()
        for text in lines:
            self.wfile.write(f"{len(text):x}\r\n".encode() + text + b"\r\n")
            self.wfile.flush()
        self.wfile.write(b"0\r\n\r\n")

    def _save(self) -> None:
        body = self._body()
        self._send(self.server.seat.save(body["text"], body["name"], body["known"]))

    def _file(self) -> None:
        self._send(self.server.seat.state())

    def _schema(self) -> None:
        from camgeom.profile.schema import schema

        self._send(schema())

    def _page(self) -> None:
        nonce = secrets.token_urlsafe(12)
        content = page(self.server.seat.state(), nonce).encode()
        self.send_response(HTTPStatus.OK)
        self._heads("text/html; charset=utf-8")
        self.send_header("Content-Security-Policy", POLICY.format(nonce=nonce))
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _send(self, data: dict[str, Any], status: HTTPStatus = HTTPStatus.OK) -> None:
        content = json.dumps(data, allow_nan=False).encode()
        self.send_response(status)
        self._heads("application/json")
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _heads(self, kind: str) -> None:
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")

    def log_message(self, format: str, *arguments: Any) -> None:
        """Nothing is printed for a request."""


def page(state: dict[str, Any], nonce: str) -> str:
    """The page with the file's state in it."""
    told = json.dumps(state).replace("<", "\\u003c")
    parts = {
        "STYLE": asset("report.css") + asset("serve.css"),
        "STATE": f'<script nonce="{nonce}" type="application/json" id="state">{told}</script>',
        "VIEWER": f'<script nonce="{nonce}">{asset("viewer.js")}</script>',
        "SCRIPT": f'<script nonce="{nonce}">{asset("serve.js")}</script>',
    }
    text = asset("serve.html")
    for name, part in parts.items():
        text = text.replace(f"<!-- {name} -->", part)
    return text
