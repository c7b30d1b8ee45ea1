"""The local server: who may ask, what is answered in which order, and that no file is ever lost."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from socket import SO_LINGER, SOL_SOCKET, create_connection
from struct import pack
from threading import Thread
from typing import Any

import pytest

from camgeom import read
from camgeom.checks import Check, Heard, Judge, checks, judge
from camgeom.checks.verdict import Finding, NotJudged
from camgeom.cli import main
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile.editing import edited
from camgeom.profile.text import load
from camgeom.report.answer import Memory, answers
from camgeom.report.server import HOST, MOST_BODY, Server
from tests.places import PROFILES

DISC = (PROFILES / "disc_offset_roller.toml").read_text(encoding="utf-8")
STAGES = ["profile", "motion", "figures", "coarse", "checks", "load", "loaded", "bodies", "verdict", "fine", "done"]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    (tmp_path / "my.toml").write_text(DISC, encoding="utf-8")
    with Server(tmp_path / "my.toml") as made:
        Thread(target=made.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
        yield made
        made.shutdown()


def ask(
    server: Server, method: str, place: str, data: Any = None, token: str | None = None, **heads: str
) -> tuple[int, str]:
    """Status and text of an answer; `token` instead of the server's."""
    link = HTTPConnection(HOST, server.port, timeout=60)
    body = None if data is None else json.dumps(data)
    path = f"/{server.token if token is None else token}/{place}"
    link.request(method, path, body, {key.replace("_", "-"): value for key, value in heads.items()})
    answer = link.getresponse()
    text = answer.read().decode()
    link.close()
    return answer.status, text


def test_the_page_is_for_this_machine_and_its_token_alone(server: Server) -> None:
    assert server.server_address[0] == "127.0.0.1"
    status, text = ask(server, "GET", "")
    assert status == 200
    assert "<!-- " not in text.replace("<!-- -->", "")
    assert ask(server, "GET", "", token="x" * 24)[0] == 404
    assert ask(server, "GET", "../../etc/passwd")[0] == 404
    assert ask(server, "GET", "file", Host="cams.example:80")[0] == 403
    assert ask(server, "POST", "save", {}, Origin="https://cams.example")[0] == 403
    assert ask(server, "GET", "file", Host=f"localhost:{server.port}")[0] == 200
    assert ask(server, "GET", "nothing")[0] == 404


def test_two_servers_have_two_tokens(server: Server, tmp_path: Path) -> None:
    with Server(tmp_path / "my.toml") as other:
        assert other.token != server.token
        assert len(other.token) >= 24


@pytest.mark.parametrize("body", ["[]", "{", '{"text": 3}', '{"text": "", "changes": []}', '{"serial": "x"}'])
def test_what_is_no_request_is_refused(server: Server, body: str) -> None:
    link = HTTPConnection(HOST, server.port, timeout=60)
    link.request("POST", f"/{server.token}/answer", body)
    assert link.getresponse().status == 400
    link.close()


def test_a_request_that_is_too_long_is_refused_unread(server: Server) -> None:
    assert ask(server, "POST", "save", None, Content_Length=str(MOST_BODY + 1))[0] == 413


def test_an_answer_comes_in_stages(server: Server) -> None:
    status, text = ask(server, "POST", "answer", {"tab": "a", "serial": 1, "text": DISC, "changes": {"cam.width": 15}})
    told = [json.loads(line) for line in text.splitlines()]
    assert status == 200
    assert [one["stage"] for one in told] == STAGES
    by = {one["stage"]: one for one in told}
    assert by["profile"]["data"]["cam"]["width"] == 15
    assert "width = 15" in by["profile"]["text"]
    assert by["checks"]["whole"] is by["loaded"]["whole"] is False
    assert "waiting" in by["checks"]
    assert "waiting" not in by["verdict"]
    assert by["verdict"]["whole"] is True
    assert by["verdict"]["level"] == "pass"
    assert "html" not in by["bodies"]  # no solver is waited for
    assert [len(by[name]["plots"]) for name in ("motion", "figures")] == [1, 1]
    assert by["motion"]["ms"] <= by["figures"]["ms"] <= by["verdict"]["ms"]
    assert len(by["coarse"]["scene"]) < len(by["fine"]["scene"])


def stages(text: str, changes: dict[str, Any] | None = None, **more: Any) -> list[dict[str, Any]]:
    return list(answers(Memory("my.toml"), text, changes or {}, lambda: True, **more))


def test_a_bad_value_is_told_by_its_key_and_keeps_the_text() -> None:
    (told,) = stages(DISC, {"cam.base_radius": -3})
    assert told["stage"] == "problems"
    assert [one["key"] for one in told["problems"]] == ["cam.base_radius"]
    assert told["data"]["cam"]["base_radius"] == -3
    assert "base_radius = -3" in told["text"]
    (told,) = stages("no toml")
    assert told["stage"] == "problems"


def test_a_folded_cam_has_figures_and_a_reason_instead_of_a_body() -> None:
    by = {one["stage"]: one for one in stages(DISC, {"motion[0].until": 20})}
    assert "figures" in by["figures"]
    assert by["coarse"]["reason"]
    assert by["verdict"]["level"] == "fail"


def test_plots_are_as_wide_as_the_page_has_room_for() -> None:
    for asked, width in ((100.0, 370), (510.0, 510), (5000.0, 820)):
        svg = next(one for one in stages(DISC, width=asked) if one["stage"] == "motion")["plots"][0]["svg"]
        assert f'viewBox="0 0 {width} ' in svg


def test_a_kept_variant_is_drawn_and_told_beside() -> None:
    by = {one["stage"]: one for one in stages(DISC, {"cam.base_radius": 40}, kept_text=DISC)}
    labels = [one["label"] for one in by["figures"]["figures"]]
    assert [one["label"] for one in by["figures"]["kept"]] == labels
    assert by["figures"]["kept"] != by["figures"]["figures"]
    assert by["motion"]["kept"] == by["motion"]["figures"]  # the same motion
    assert by["figures"]["plots"][0]["svg"].count("kept") >= 1


def test_checks_of_the_body_do_not_wait_for_a_solver() -> None:
    text = (PROFILES / "milled_drum.toml").read_text(encoding="utf-8")
    by = {one["stage"]: one for one in answers(Memory(str(PROFILES / "milled_drum.toml")), text, {}, lambda: True)}
    assert by["bodies"]["whole"] is False
    assert "Gouge" not in by["bodies"]["html"] + by["bodies"]["sentence"]
    told = [by[name] for name in ("checks", "loaded", "bodies", "verdict")]
    counts = [int(one["sentence"].split(" findings")[0].split()[-1]) for one in told]
    assert sorted(set(counts)) == counts
    assert [one.get("waiting") for one in told] == ["load, body and solvers", "body and solvers", "solvers", None]


def test_what_a_check_has_said_is_not_asked_again() -> None:
    model, asked = read(DISC), Counter[str]()
    entries = {name: replace(entry, judge=counted(entry, asked)) for name, entry in checks(model).items()}
    heard: Heard = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("camgeom.checks._REGISTRY", entries)
        assert judge(model, ["pressure-angle", "wall"], heard).findings != ()
        whole = judge(model, None, heard)
        assert set(asked.values()) == {1}
        assert judge(model) == whole
        assert set(asked.values()) == {2}


def counted(entry: Check, asked: Counter[str]) -> Judge:
    def said(model: Model) -> Iterable[Finding | NotJudged]:
        asked[entry.name] += 1
        return entry.judge(model)

    return said


def test_nothing_more_is_computed_for_a_request_that_nobody_waits_for() -> None:
    memory = Memory("my.toml")
    first = memory.arrived("tab", 1)
    seen = []
    for stage in answers(memory, DISC, {}, first):
        seen.append(stage["stage"])
        if stage["stage"] == "figures":
            memory.arrived("tab", 2)
    assert seen == ["profile", "motion", "figures"]
    assert memory.arrived("other", 1)()
    # What was left half computed is whole when it is asked for again.
    assert [one["stage"] for one in answers(memory, DISC, {}, lambda: True)] == STAGES


def test_saving_loses_no_file(server: Server, tmp_path: Path) -> None:
    state = json.loads(ask(server, "GET", "file")[1])
    changed = DISC.replace("base_radius", "base_radius ", 1)
    status, text = ask(server, "POST", "save", {"text": changed, "name": "my.toml", "known": state["digest"]})
    saved = json.loads(text)
    assert (status, saved["kept"]) == (200, "my.1.toml")
    assert (tmp_path / "my.toml").read_text() == changed
    assert (tmp_path / "my.1.toml").read_text() == DISC
    again = {"text": DISC, "name": "my.toml", "known": state["digest"]}
    assert ask(server, "POST", "save", again)[0] == 409  # another page saved since
    again["known"] = saved["digest"]
    assert json.loads(ask(server, "POST", "save", again)[1])["kept"] == "my.2.toml"
    status, text = ask(server, "POST", "save", {"text": DISC, "name": "my.1.toml", "known": ""})
    assert (status, "my.1.1.toml" in text) == (409, True)
    assert ask(server, "POST", "save", {"text": DISC, "name": "new.toml", "known": ""})[0] == 200


@pytest.mark.parametrize("name", ["../my.toml", "/tmp/x.toml", "a/b.toml", "x.txt", ".toml", "", "a\nb.toml", "..toml"])
def test_only_names_beside_the_profile_are_saved(server: Server, name: str) -> None:
    assert ask(server, "POST", "save", {"text": DISC, "name": name, "known": ""})[0] == 400


@pytest.mark.parametrize("place", ["save", "answer"])
@pytest.mark.parametrize("key", ["text", "name", "kept", "tab"])
def test_what_is_no_text_is_refused(server: Server, place: str, key: str) -> None:
    data = {"text": "a = 1", "name": "new.toml", "known": "", key: "\ud800"}
    status, text = ask(server, "POST", place, data)
    assert (status, "UTF-16" in text) == (400, True)
    assert not server.seat.path.with_name("new.toml").exists()


def test_a_length_without_end_is_refused_and_who_is_gone_is_not_answered(
    server: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    head = f"POST /{server.token}/answer HTTP/1.1\r\nHost: {HOST}:{server.port}\r\n"
    for length, said in (("9" * 5000, b"413"), ("-5", b"413"), ("\xb2", b"413"), (str(MOST_BODY + 1), b"413")):
        with create_connection((HOST, server.port), timeout=30) as link:
            link.sendall(f"{head}Content-Length: {length}\r\n\r\n".encode("latin-1"))
            assert said in link.recv(100)
    for _ in range(5):
        with create_connection((HOST, server.port), timeout=30) as link:
            link.setsockopt(SOL_SOCKET, SO_LINGER, pack("ii", 1, 0))  # closed by a reset
            link.sendall(f"{head}Content-Length: 100\r\n\r\nabc".encode())
    assert ask(server, "GET", "file")[0] == 200
    assert "Traceback" not in capsys.readouterr().err


def test_a_file_that_went_is_told(server: Server, tmp_path: Path) -> None:
    (tmp_path / "my.toml").unlink()
    assert "no such file" in json.loads(ask(server, "GET", "file")[1])["reason"]
    saved = ask(server, "POST", "save", {"text": DISC, "name": "my.toml", "known": ""})
    assert saved[0] == 200


def test_an_edit_keeps_comments_and_order() -> None:
    text = '# head\nname = "a # b"  # why\n\n[cam]  # the cam\nwidth = 3 # mm\n\n'
    text += "[[motion]]\nuntil = 9\n[[motion]]\nuntil = 20\n"
    found = edited(text, {"cam.width": 4.5, "motion[1].until": 25, "name": 'c "d"', "cam.bore": 7, "limits.life_h": 5})
    head = ["# head", 'name = "c \\"d\\""  # why', "", "[cam]  # the cam", "width = 4.5 # mm", "bore = 7"]
    assert found.splitlines()[:6] == head
    assert load(found, "")[0] == {"name": 'c "d"', "cam": {"width": 4.5, "bore": 7}, "limits": {"life_h": 5},
                                  "motion": ({"until": 9}, {"until": 25})}  # fmt: skip
    assert "bore" not in edited(found, {"cam.bore": None})


def test_an_edit_that_is_no_line_is_written_anew_and_means_the_same() -> None:
    text = 'formats = [\n  "stl",\n]\n[a]\nb = { c = 1 }\n'
    assert load(edited(text, {"a.b.c": 2}), "")[0] == {"formats": ("stl",), "a": {"b": {"c": 2}}}
    assert load(edited(text, {"formats": ["3mf"]}), "")[0]["formats"] == ("3mf",)
    with pytest.raises(ProfileError, match="no dotted key"):
        edited(text, {"a b": 1})
    with pytest.raises(ProfileError, match="finite"):
        edited(text, {"a.b": float("nan")})


@pytest.mark.parametrize("words", [["nowhere.toml"], ["my.toml", "--port", "x"], ["my.toml", "--port", "0"]])
def test_what_cannot_be_served_is_bad_input(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my.toml").write_text(DISC, encoding="utf-8")
    assert main(["serve", *words, "--no-browser"]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_port_that_is_taken_is_told(server: Server, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", str(tmp_path / "my.toml"), "--no-browser", "--port", str(server.port)]) == 2
    assert f"127.0.0.1:{server.port} cannot be used" in capsys.readouterr().err
