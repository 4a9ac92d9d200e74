# Runs the ported Autobahn fuzzing client against one server: `fuzz.py URL OUTPUT CASE...`. Writes its reports.
import sys

from autobahntestsuite import fuzzing
from twisted.internet import reactor


def octets(text):
    """Strings of the suite's cases are bytes, one for each character."""
    return text.encode("latin-1") if isinstance(text, str) else text


def string(data):
    return data.decode("latin-1") if isinstance(data, bytes) else data


class Protocol(fuzzing.FuzzingClientProtocol):
    """The suite's own, its strings turned to bytes on the way out, and back on the way in."""

    def sendFrame(self, opcode, payload=b"", payload_len=None, **more):
        # Repeats the payload up to a length; the library's own way of it does not work under Python 3.
        if payload_len is not None:
            payload = (payload * (payload_len // len(payload) + 1))[:payload_len]
        super().sendFrame(opcode=opcode, payload=octets(payload), **more)

    def sendMessage(self, payload, *args, **more):
        super().sendMessage(octets(payload), *args, **more)

    def sendMessageFrameData(self, payload, *args, **more):
        return super().sendMessageFrameData(octets(payload), *args, **more)

    def sendCloseFrame(self, code=None, reasonUtf8=None, isReply=False):
        super().sendCloseFrame(code, octets(reasonUtf8), isReply)

    def onMessage(self, payload, isBinary):
        super().onMessage(string(payload), isBinary)

    def onPong(self, payload):
        super().onPong(string(payload))

    def logRxOctets(self, data):
        super().logRxOctets(string(data))

    def logTxOctets(self, data, sync):
        super().logTxOctets(string(data), sync)

    def logRxFrame(self, frameHeader, payload):
        super().logRxFrame(frameHeader, [string(part) for part in payload])

    def logTxFrame(self, frameHeader, payload, *args):
        super().logTxFrame(frameHeader, string(payload), *args)


def main(url, output, cases):
    fuzzing.FuzzingClientProtocol = Protocol
    # Bytes are left only in what was said over HTTP, and in reasons.
    fuzzing.json.JSONEncoder.default = lambda self, value: string(value)
    plain = fuzzing.FuzzingFactory.createReports
    fuzzing.FuzzingFactory.createReports = lambda self: plain(self, produceHtml=False)
    server = {"agent": "swellcast", "url": url, "protocols": ["swellcast.v1"]}
    spec = {"outdir": output, "servers": [server], "cases": cases}
    fuzzing.startClient(spec)
    reactor.run()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
