"""A Swellcast server for a test: started on a free port, stopped by its own process alone."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

BINARY = os.environ.get("SWELLCAST_BIN")


def skip_loudly() -> str:
    """Says that tests with a server are not run, and why."""
    why = "SWELLCAST_BIN is not set: no test with a server is run"
    print(f"SKIPPED: {why}", file=sys.stderr)
    return why


class Served:
    """A server that runs until `stop`; with a folder it keeps its log, and its epoch, through restarts."""

    def __init__(self, scene: Path | str, data: Path | None = None, listen: str = "127.0.0.1:0") -> None:
        assert BINARY is not None
        kept = [] if data is None else ["--data", str(data)]
        command = [BINARY, "serve", "--scene", str(scene), "--listen", listen, "--backend", "cpu", *kept]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self._url()

    def _url(self) -> str:
        late = threading.Timer(30, self.process.kill)
        late.start()
        assert self.process.stdout is not None
        try:
            for line in self.process.stdout:
                if " at http://" in line:
                    return line.split(" at ")[1].strip().rstrip("/")
        finally:
            late.cancel()
        raise AssertionError(f"the server did not start: status {self.process.wait()}")

    def stop(self) -> None:
        """Kills it, as a power cut would."""
        self.process.kill()
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()
