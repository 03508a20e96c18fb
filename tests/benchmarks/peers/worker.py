"""One renderer in a process of its own: requests and answers are lines of JSON on its standard streams."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

Answer = dict[str, Any]


class Peer(Protocol):
    """What a worker's file offers; `render` answers with {"wall_ms", "cpu_ms"} and more, and writes V to `out`."""

    def facts(self) -> Answer: ...

    def render(self, settings: dict[str, Any], out: str) -> Answer: ...


def timed(work: Callable[[], Any]) -> tuple[Any, Answer]:
    """What the work returns; milliseconds on the wall, and of processor time over all of the process's threads."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return result, {"wall_ms": 1e3 * wall, "cpu_ms": 1e3 * cpu}


def serve(make: Callable[[], Peer]) -> int:
    """Answer requests until there are no more. What libraries print goes to standard error."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def say(answer: Answer) -> None:
        print(json.dumps(answer), file=answers, flush=True)

    try:
        peer = make()
    except Exception as error:
        say({"error": f"{type(error).__name__}: {error}"})
        return 1
    say(peer.facts())
    for line in sys.stdin:
        request = json.loads(line)
        try:
            say(getattr(peer, request["do"])(**request.get("with", {})))
        except Exception as error:
            traceback.print_exc()
            say({"error": f"{type(error).__name__}: {error}"})
    return 0


class WorkerError(Exception):
    """A renderer could not start, or ended; its own words."""


class Worker:
    """The other end. @raises WorkerError if it does not come up."""

    def __init__(self, command: list[str], log: Path, environment: dict[str, str] | None = None) -> None:
        self._log = log
        with open(log, "ab") as stream:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stream,
                text=True,
                env=os.environ | (environment or {}),
            )
        self.facts = self._answer()

    def ask(self, do: str, **arguments: Any) -> Answer:
        assert self._process.stdin is not None
        try:
            print(json.dumps({"do": do, "with": arguments}), file=self._process.stdin, flush=True)
        except BrokenPipeError as error:
            raise WorkerError(f"it has ended; its last words are in {self._log}") from error
        return self._answer()

    def _answer(self) -> Answer:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            self._process.wait()
            raise WorkerError(f"it has ended with code {self._process.returncode}; its last words are in {self._log}")
        answer: Answer = json.loads(line)
        if "error" in answer:
            raise WorkerError(str(answer["error"]))
        return answer

    def close(self) -> None:
        """Blender as a module may hang while it ends; it has nothing left to do."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
