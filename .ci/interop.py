"""All clients against one server: the same digests of the same ticks, also after it was killed and started again.

    .ci/interop.py SECONDS CLIENT..     (.ci/interop calls it; seconds from all clients' being there to the kill)

What must have come is told by a twin: another server, which goes on with a copy of the log and is never killed. Both
are the same function of the same log, so the digests of any client at any tick are the twin's, or something is wrong.
"""

import contextlib
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

# A small sea, so that a busy machine needn't send anybody coarser frames.
SCENE = 'name = "interop"\n[wind]\nspeed_mps = 8\n[cascades]\nn = 64\npatches_m = [120]\n'
HZ = 15
#: From the kill to the start: clients find nobody there, more than once.
DOWN_S = 2
#: From the server's being ready again to the first new frame of each client.
WITHIN_S = 5
#: After that, digests are compared for so long.
AFTER_S = 3
#: What starting clients, and the server again, may take on a busy machine; after that, clients end by themselves.
START_S = 10


def command(client, url, seconds):
    """How a client is told to print digests of the first cascade's displacement for so many seconds."""
    return {
        "rust": ["target/release/examples/follow", url.replace("http", "ws") + "v1/stream", seconds],
        "web": ["node", "--experimental-websocket", "clients/web/test/digest.mjs", url, seconds],
        "python": ["target/python/bin/python", "-m", "swellcast.digest", "--url", url, "--seconds", seconds],
        "unity": ["mono", "target/unity/Digest.exe", "--url", url, "--seconds", seconds],
    }[client]


class Client:
    """A process that prints digests."""

    def __init__(self, name, arguments, folder):
        self.name = name
        self.log = folder / f"{name}.log"
        self.digests = {}  # by tick
        self.came = {}  # when, by our clock
        self.process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=self.log.open("w"), text=True)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            now = time.monotonic()
            if line.startswith("{"):
                said = json.loads(line)
                self.came.setdefault(said["tick"], now)
                self.digests[said["tick"]] = said["digest"]

    def first(self, tick):
        """When the first digest of this tick or a later one came."""
        return min((at for of, at in list(self.came.items()) if of >= tick), default=None)


class Server:
    """A server on a folder."""

    def __init__(self, folder, port, *more):
        self.url = f"http://127.0.0.1:{port}/"
        self.log = folder.with_suffix(".log")
        arguments = ["--listen", f"127.0.0.1:{port}", "--data", folder, "--backend", "cpu", "--threads", "1", *more]
        with self.log.open("a") as log:
            arguments = ["target/release/swellcast", "serve", *arguments]
            environment = os.environ | {"NO_COLOR": "1"}
            self.process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=log, env=environment)

    def get(self, path):
        with urllib.request.urlopen(self.url + path, timeout=5) as answer:
            return answer.read()

    def ready(self):
        """Waits for it, and gives the time."""
        patience = time.monotonic() + 30
        while self.process.poll() is None and time.monotonic() < patience:
            with contextlib.suppress(OSError):  # also what is answered with another status than 200
                self.get("readyz")
                return time.monotonic()
            time.sleep(0.01)
        ended = self.process.returncode
        raise RuntimeError(f"the server is not ready; its exit status: {ended}\n{self.log.read_text()}")


def main(seconds, names):
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as processes:
        check(seconds, names, pathlib.Path(folder), processes)


def check(seconds, names, folder, processes):
    def started(thing):
        processes.callback(thing.process.wait)
        processes.callback(thing.process.kill)  # first; it may have ended already
        return thing

    (folder / "scene.toml").write_text(SCENE)
    data, copy = folder / "data", folder / "twin"
    port, port_of_twin = free_ports(2)

    # The log must have begun before it is copied.
    server = started(Server(data, port, "--scene", folder / "scene.toml"))
    server.ready()
    server.process.terminate()
    server.process.wait()
    shutil.copytree(data, copy)
    server, twin = started(Server(data, port)), started(Server(copy, port_of_twin))
    server.ready()
    twin.ready()

    last = str(START_S + seconds + DOWN_S + WITHIN_S + AFTER_S)
    truth = started(Client("twin", command("rust", twin.url, last), folder))
    clients = [started(Client(name, command(name, server.url, last), folder)) for name in names]
    try:
        wait_for([truth, *clients], 0, time.monotonic() + START_S)
        time.sleep(seconds)
        compare(truth, clients, 0, 0.8 * HZ * seconds)

        print(f"killing the server; it is started again after {DOWN_S} s")
        server.process.kill()
        server.process.wait()
        time.sleep(DOWN_S)
        # Past all that the killed one can have sent: frames leave a quarter of a second before their tick.
        tick = json.loads(twin.get("v1/time"))["tick"]
        server = started(Server(data, port))
        resume(clients, tick, server.ready())
        time.sleep(AFTER_S)
        compare(truth, clients, tick, 0.8 * HZ * AFTER_S)

        for client in [truth, *clients]:
            assert client.process.wait(60) == 0, f"{client.name} ended with {client.process.returncode}"
    except BaseException:
        for log in [server.log, *(client.log for client in clients)]:
            print(f"---- {log.name}", log.read_text()[-2000:], sep="\n", file=sys.stderr)
        raise


def compare(truth, clients, tick, least):
    """So much was told by all clients of this tick and later ones, and all of it is the same, and the twin's."""
    told = {each: {of: digest for of, digest in dict(each.digests).items() if of >= tick} for each in [truth, *clients]}
    common = sorted(set.intersection(*(set(told[client]) for client in clients)))
    # A tick that the twin's server or client had no time for is held to the first client's.
    right = told[clients[0]] | told[truth]
    by_twin = sum(of in told[truth] for of in common)
    print(f"{len(common)} ticks told by all clients, {by_twin} of them by the twin, too")
    for client in clients:
        wrong = [of for of in common if told[client][of] != right[of]]
        print(f"{client.name}: {len(told[client])} ticks, {len(wrong)} of those in common are wrong")
        assert not wrong, (client.name, wrong[:5])
    assert len(common) >= least, f"{len(common)} ticks in common, must be {least:.0f}"
    assert by_twin >= least / 4, f"{by_twin} ticks in common with the twin, must be {least / 4:.0f}"


def resume(clients, tick, ready):
    """Each client tells of new frames in time."""
    wait_for(clients, tick, ready + WITHIN_S)
    late = []
    for client in clients:
        first = client.first(tick)
        took = "no frame of this sea" if first is None else f"{first - ready:.2f} s from ready to a new frame"
        print(f"{client.name}: {took}")
        if first is None or first > ready + WITHIN_S:
            late.append(client.name)
    assert not late, f"not there again within {WITHIN_S} s: {', '.join(late)}"


def wait_for(clients, tick, until):
    """Waits until all have told of this tick or a later one, or that time has come."""
    while any(client.first(tick) is None for client in clients) and time.monotonic() < until:
        time.sleep(0.01)


def free_ports(count):
    """Ports that nobody listens at, all different."""
    with contextlib.ExitStack() as held:
        sockets = [held.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(count)]
        return [each.getsockname()[1] for each in sockets]


if __name__ == "__main__":
    main(float(sys.argv[1]), sys.argv[2:])
