"""A run of surfit_slam --serve, and its viewers."""

import json
import os
import pathlib
import re
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "report"))

TOOL = os.path.join(os.environ["SURFIT_TOOLS_DIR"], "surfit_slam")


class ServedRun:
    """surfit_slam --serve. `url` is the address of its page."""

    def __init__(self, room, output, *flags):
        self.output = pathlib.Path(output)
        self.process = subprocess.Popen(
            [TOOL, f"--sequence={room}", f"--output={output}", "--nopictures", "--serve", *flags],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        line = ""
        while "watch the run at " not in line:
            line = self.process.stderr.readline()
            assert line, "the run ended before it was served"
        self.url = line.split()[-1]
        self.errors = []
        self.reader = threading.Thread(target=self.read_errors)
        self.reader.start()

    def read_errors(self):
        self.errors = self.process.stderr.readlines()

    def get(self, page):
        with urllib.request.urlopen(self.url + page, timeout=30) as answer:
            return answer.read()

    def state(self, after=0):
        return json.loads(self.get(f"state?after={after}&want=62"))

    def post(self, name):
        urllib.request.urlopen(urllib.request.Request(self.url + name, method="POST"), timeout=30)

    def wait_until(self, condition):
        """Waits until the state satisfies a condition. Returns the state."""
        for _ in range(600):
            state = self.state()
            if condition(state):
                return state
            time.sleep(0.05)
        raise AssertionError(f"never: {state}")

    def finish(self):
        """Waits for the end of the run. Returns the exit code and the CPU time in seconds."""
        _, status, usage = os.wait4(self.process.pid, 0)
        self.process.returncode = os.waitstatus_to_exitcode(status)
        self.reader.join()
        self.process.stderr.close()
        return self.process.returncode, usage.ru_utime + usage.ru_stime

    def end(self):
        """Kills the run if it is still active."""
        if self.process.returncode is None:
            self.process.kill()
            self.process.wait()
            self.reader.join()
            self.process.stderr.close()

    def summary(self):
        return json.loads((self.output / "summary.json").read_text())


def run_unserved(room, output):
    """CPU time in seconds and summary of a run without --serve."""
    process = subprocess.Popen([TOOL, f"--sequence={room}", f"--output={output}", "--nopictures"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_utime + usage.ru_stime, json.loads((pathlib.Path(output) / "summary.json").read_text())


class Viewer:
    """Sends the requests of a page at the same rate until the run ends. Counts the answers."""

    def __init__(self, url):
        host, path = re.match(r"http://([^/]*)(/.*)", url).groups()
        self.host, self.path = host, path
        self.answers = self.bytes = 0
        self.is_done = False
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()

    def connect(self):
        name, port = self.host.split(":")
        return socket.create_connection((name, int(port)), timeout=30)

    def get(self, connection, page):
        connection.sendall(f"GET {self.path}{page} HTTP/1.1\r\nHost: {self.host}\r\n\r\n".encode())
        data = b""
        while b"\r\n\r\n" not in data:
            more = connection.recv(65536)
            if not more:
                raise ConnectionError
            data += more
        head, body = data.split(b"\r\n\r\n", 1)
        length = re.search(rb"Content-Length: (\d+)", head)
        parts, left = [body], int(length.group(1)) - len(body) if length else 0
        while left > 0:
            parts.append(connection.recv(min(left, 1 << 20)))
            if not parts[-1]:
                raise ConnectionError
            left -= len(parts[-1])
        body = b"".join(parts)
        self.answers += 1
        self.bytes += len(body)
        return body

    def watch(self):
        try:
            with self.connect() as connection:
                self.ask_on(connection)
        except (ConnectionError, OSError):
            pass  # the run is over

    def ask_on(self, connection):
        number, place, begun = 0, [0, 0, 0, 0], 0
        while True:
            state = json.loads(self.get(connection, f"state?after={number}&want=62") or b"{}")
            number = state.get("number", number)
            self.is_done = state.get("done", False)
            while True:
                body = self.get(connection, "map?epoch={}&level={}&since={}&slot={}".format(*place))
                epoch, level, _, version, following, _ = struct.unpack("<6I", body[:24])
                if epoch != place[0]:
                    place = [epoch, level, 0, 0]
                if place[3] == 0:
                    begun = version
                place = [epoch, level, place[2] if following else begun, following]
                if following == 0:
                    break
            for page in ["path", "frame.jpg", "model.jpg"]:
                self.get(connection, page)
            time.sleep(0.1)


class StalledViewer(Viewer):
    """Requests the page repeatedly without reading the answers."""

    def watch(self):
        self.connection = self.connect()
        self.connection.settimeout(1)
        request = f"GET {self.path} HTTP/1.1\r\nHost: {self.host}\r\n\r\n".encode()
        try:
            while True:
                self.connection.sendall(request)
        except OSError:
            pass
