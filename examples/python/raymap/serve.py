# SPDX-License-Identifier: MIT
"""A scene or ray map that stays in memory, in the program's server (docs/server.md).

    import raymap.serve
    with raymap.serve.start("scene.yaml") as lens:
        lens.trace(rays=100000)                        # waits; lens.ask("trace", rays=...) does not
        lens.query("registered(sensor)")["flux"]
        lens.move("mount", 0, 0, 1)
        lens.undo()
        lens.save("other.yaml")

A request is a method: its keywords are the request's keys, what it returns is the answer's result. A
request that is wrong raises ServerError. One object is one client; threads may share it.
"""
from __future__ import annotations

import json
import operator
import os
import socket
import subprocess
import threading
from typing import Any, Callable, Iterable, Optional

from .program import Path, Program, RaymapError


LINE_MAX = 1 << 24


class ServerError(RaymapError):
    """A request was refused: `status` and words as those of the program, `details` all of it."""

    def __init__(self, error: "dict[str, Any]", command: str):
        found = ["{}{}: {severity}: {text}".format(mistake.get("file", error.get("file", "scene")),
                                                  ":{line}:{column}".format(**mistake) if mistake["line"] else "", **mistake)
                 for mistake in error.get("diagnostics", [])]
        super().__init__(error.get("status", 1), "\n".join([error.get("message", ""), *found]), [command])
        self.details = error


class _Waiting:
    """An answer that is to come."""

    def __init__(self, told: "Optional[Callable[[dict[str, Any]], None]]"):
        self.told = told
        self.come = threading.Event()
        self.answer: "Optional[dict[str, Any]]" = None


def _plain(value: Any) -> Any:
    """Of a number or an array of numpy, or of what is a whole number otherwise."""
    return value.tolist() if hasattr(value, "tolist") else operator.index(value)


class Server:
    """A client of a server that speaks in lines: of one that it started, or at a Unix socket."""

    def __init__(self, lines_in, lines_out, process: "Optional[subprocess.Popen[str]]" = None):
        self._in, self._out, self._process = lines_in, lines_out, process
        self._lock = threading.Lock()
        self._waiting: "dict[int, _Waiting]" = {}
        self._last = 0
        self._gone = False
        self.on_event: "Optional[Callable[[dict[str, Any]], None]]" = None  # after ask("watch")
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in self._in:
            answer = json.loads(line)
            waiting = self._waiting.get(answer.get("id"))
            if waiting is None:
                if self.on_event and "id" not in answer:  # no late word about a request given up
                    self.on_event(answer)
            elif "ok" not in answer:
                if waiting.told:
                    waiting.told(answer)
            else:
                waiting.answer = answer
                waiting.come.set()
        with self._lock:
            self._gone = True
            for waiting in self._waiting.values():
                waiting.come.set()

    def ask(self, command: str, told: "Optional[Callable[[dict[str, Any]], None]]" = None,
            timeout: Optional[float] = None, **keys: Any) -> Any:
        """Sends a request and waits for its result. told: gets progress, and pictures on the way.
        After `timeout` seconds the request is cancelled and TimeoutError raised."""
        waiting = _Waiting(told)
        with self._lock:
            if self._gone:
                raise ConnectionError("the server has gone")
            self._last += 1
            number = self._last
            self._waiting[number] = waiting
            try:
                self._send({"id": number, "command": command, **keys})
            except BaseException:
                del self._waiting[number]
                raise
        came = waiting.come.wait(timeout)
        with self._lock:
            del self._waiting[number]
            if not came:
                self._last += 1
                self._send({"id": self._last, "command": "cancel", "of": number})
        if not came:
            raise TimeoutError(f"{command}: no answer within {timeout} s")
        if waiting.answer is None:
            raise ConnectionError("the server has gone")
        if not waiting.answer["ok"]:
            raise ServerError(waiting.answer["error"], command)
        return waiting.answer["result"]

    def _send(self, request: "dict[str, Any]") -> None:
        line = json.dumps(request, allow_nan=False, default=_plain, ensure_ascii=False)
        has_nul = "\\u0000" in line.replace("\\\\", "")
        if has_nul or len(line.encode()) > LINE_MAX:  # the answer could not say whose it is
            raise ValueError("a request has no NUL in its texts, and at most 16 MiB")
        self._out.write(line + "\n")
        self._out.flush()

    def __getattr__(self, command: str) -> "Callable[..., Any]":
        if command.startswith("_"):
            raise AttributeError(command)
        return lambda **keys: self.ask(command, **keys)

    def query(self, criterion: str, **keys: Any) -> Any:
        """How many rays match, and their flux."""
        return self.ask("query", criterion=criterion, **keys)

    def sample(self, criterion: str, rays: int, **keys: Any) -> Any:
        """So many of the rays that match, with their paths."""
        return self.ask("sample", criterion=criterion, rays=rays, **keys)

    def detector(self, name: str, **keys: Any) -> Any:
        """What a detector caught."""
        return self.ask("detector", name=name, **keys)

    def trace(self, rays: int, seed: int = 1, **keys: Any) -> Any:
        """Traces rays [0, rays) of the scene and waits for them; others are answered meanwhile."""
        return self.ask("trace", rays=rays, seed=seed, wait=True, **keys)

    def edit(self, text: Optional[str] = None, **values: Any) -> Any:
        """Another text of the scene, or keys: remove=["objects.stop"], set={"objects.lens.at": [0, 0, 1]}."""
        return self.ask("edit", **({"text": text} if text is not None else {}), **values)

    def move(self, name: str, x: float, y: float, z: float, **keys: Any) -> Any:
        """An object or group, source or detector by so much; axes="world": not in the frame of its
        group. amend=moved["revision"]: in the place of the move that had this answer, from where it
        was before."""
        return self.ask("edit", move=name, by=[x, y, z], **keys)

    def save(self, file: Optional[Path] = None, force: bool = False) -> Any:
        """The scene's text as a file below the folder that the server was started in."""
        return self.ask("save", force=force, **({"file": os.fspath(file)} if file is not None else {}))

    def close(self) -> None:
        """Leaves; a server that this object started ends."""
        try:
            self._out.close()
        except OSError:
            pass
        if self._process:
            self._process.wait()

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *failure: Any) -> None:
        self.close()


def start(path: Path, folder: Optional[Path] = None, program: Optional[Path] = None,
          before: Iterable[str] = ()) -> Server:
    """Starts a server for a scene or map, for this process alone. folder: where it runs, which path
    is relative to. program, before: as those of Program; before=["mpirun", "-np", "4"]: ranks share
    the work."""
    command = [*Program(program, before).command, "serve", os.fspath(path), "--stdin"]
    process = subprocess.Popen(command, cwd=folder, encoding="utf-8", stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE)
    server = Server(process.stdout, process.stdin, process)
    try:
        server.status()
    except ConnectionError:
        raise RaymapError(process.wait(), "the server did not start; see its words above",
                          command) from None
    return server


def connect(path: Path) -> Server:
    """A client more of the server at a Unix socket (raymap serve SCENE --socket PATH)."""
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(os.fspath(path))
    stream = connection.makefile("rw", encoding="utf-8")

    class _Closing:
        """Closing a file of a socket leaves the socket open as long as the reader has it."""
        write, flush = stream.write, stream.flush

        @staticmethod
        def close() -> None:
            connection.shutdown(socket.SHUT_RDWR)
            connection.close()

    return Server(stream, _Closing)
