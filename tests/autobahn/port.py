# Carries the installed Autobahn test suite, which is Python 2, over to Python 3: `port.py FOLDER`.
#
# Its strings are bytes. Here they stay strings of the code points 0 to 255, one for each byte: all that the cases do
# with them (repeat, join, cut, take an element, compare) then means what it meant. fuzz.py encodes and decodes them
# where they meet the protocol. What must change by hand is named below, and must be there as often as said.
import importlib.util
import pathlib
import shutil
import sys

from fissix.refactor import RefactoringTool, get_fixers_from_package

FILES = ["_version.py", "caseset.py", "fuzzing.py", "case"]

# Autobahn|Python asks for its framework as it is read.
INIT = "import txaio\ntxaio.use_twisted()\nfrom ._version import __version__ as version\n"

# Of the reports only the JSON is asked for; the module of the HTML's styles wants a template engine.
REPORT = 'CSS_COMMON = CSS_DETAIL_REPORT = CSS_MASTER_REPORT = JS_MASTER_REPORT = ""\n'

# Functions that want bytes, for strings.
STRINGS = '''
import binascii

from autobahn.websocket.utf8validator import Utf8Validator as Validator


def b2a_hex(data):
    return binascii.b2a_hex(data.encode("latin-1") if isinstance(data, str) else data).decode()


class Utf8Validator(Validator):
    def validate(self, data):
        return super().validate(data.encode("latin-1"))
'''

HEX = ("import binascii\n", "from autobahntestsuite import strings as binascii\n")
VALIDATOR = ("from autobahn.websocket.utf8validator import", "from autobahntestsuite.strings import")
# Text that is put in another's place, per file.
CHANGES = {
    "fuzzing.py": [
        ("import os, json, binascii, time, textwrap, pkg_resources\n",
         "import os, json, time, textwrap\nfrom autobahntestsuite import strings as binascii\n"),
        # No server, no TLS.
        ("from twisted.internet import reactor, ssl\n", "from twisted.internet import reactor\n"),
        ("from twisted.web.server import Site\n", ""),
        ("from twisted.web.static import File\n", ""),
        # An option of autobahn before 0.11.
        ("WebSocketClientFactory.__init__(self, debug = debug, debugCodePaths = debug)",
         "WebSocketClientFactory.__init__(self)"),
        ("self.failConnection()", "self._fail_connection()"),
        ("return dd.decode('utf8',", "return dd.encode('latin-1').decode('utf8',"),
    ],
    "case/case10_1_1.py": [
        ("len(self.payload) / self.p.autoFragmentSize", "len(self.payload) // self.p.autoFragmentSize"),
    ],
    "case/__init__.py": [
        # The suite itself does not run this one.
        ("from case9_9_1 import *\n", ""),
        # Compression, which the server does not negotiate.
        ("from case12_x_x import *\n", ""),
        ("Cases.extend(Case12_X_X)\n", ""),
        ("CaseSubCategories.update(Case12_X_X_CaseSubCategories)\n", ""),
        ("Cases.extend(Case13_X_X)\n", ""),
        ("CaseSubCategories.update(Case13_X_X_CaseSubCategories)\n", ""),
    ],
    # The pickle of equal things can differ: an object that occurs twice is written once.
    "case/case.py": [("pickle.dumps(obj1) == pickle.dumps(obj2)", "repr(obj1) == repr(obj2)")],
    "case/case6_x_x.py": [(HEX[0] + "from case", HEX[1] + "from case"), VALIDATOR],
}
for name in ["6_2_1", "6_2_2", "6_2_3", "6_2_4", "6_3_1", "6_3_2", "6_4_1", "6_4_2", "6_4_3", "6_4_4", "7_5_1"]:
    CHANGES[f"case/case{name}.py"] = [HEX]


def port(source, target):
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for name in FILES:
        if (source / name).is_dir():
            shutil.copytree(source / name, target / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source / name, target / name)
    for name, text in [("__init__.py", INIT), ("report.py", REPORT), ("strings.py", STRINGS)]:
        (target / name).write_text(text)
    for name, changes in CHANGES.items():
        text = (target / name).read_text("latin-1")
        for old, new in changes:
            if text.count(old) != 1:
                raise SystemExit(f"{name}: {text.count(old)} times, not once: {old!r}")
            text = text.replace(old, new)
        (target / name).write_text(text, "latin-1")
    tool = RefactoringTool(get_fixers_from_package("fissix.fixes"))
    for path in sorted(target.rglob("*.py")):
        # Read as what a byte is here, whatever it means in UTF-8.
        # What `object` as the first base was needed for is so by itself now.
        text = path.read_text("latin-1").replace("(object, Case, )", "(Case, )")
        path.write_text(str(tool.refactor_string(text if text.endswith("\n") else text + "\n", str(path))), "utf-8")


if __name__ == "__main__":
    # Found, not imported: as it is, it can't be.
    source = pathlib.Path(importlib.util.find_spec("autobahntestsuite").submodule_search_locations[0])
    port(source, pathlib.Path(sys.argv[1]) / "autobahntestsuite")
