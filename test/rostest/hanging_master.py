"""A ROS master that a test can make hang. It accepts connections and questions, and does not answer."""

import http.client
import os
import re
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlparse

from witness import PATIENCE


class HangingMaster:
    """Stands in front of the master of ROS_MASTER_URI, and passes questions and answers on while it does not hang.

    Programs with its ``environment`` ask this master.
    """

    def __init__(self, hang_at=None):
        """``hang_at`` is a regular expression. The master hangs from the first question on that contains it."""
        self._hang_at = hang_at and re.compile(hang_at.encode(), re.DOTALL)
        self._changed = threading.Condition()
        self._hangs, self._waiting = False, 0
        true_master = urlparse(os.environ["ROS_MASTER_URI"]).netloc
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler(true_master))
        self._server.handle_error = lambda request, address: None       # who asked is gone
        self.environment = dict(os.environ, ROS_MASTER_URI="http://127.0.0.1:%d" % self._server.server_port)
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def hang(self):
        """Hang from now on."""
        with self._changed:
            self._hangs = True

    def mend(self):
        """Answer again, also the questions that came meanwhile."""
        with self._changed:
            self._hangs, self._hang_at = False, None
            self._changed.notify_all()

    def wait_until_asked(self, asker=None):
        """Wait until a program waits for an answer. ``asker`` is the program that should ask (a Driver). Only the error
        message uses it.
        """
        with self._changed:
            asked = self._changed.wait_for(lambda: self._waiting, 2 * PATIENCE)      # ten nodes may start at once
            assert asked, "nobody asks:\n%s" % (asker and asker.printed)

    def close(self):
        self._server.shutdown()
        self._server.server_close()

    def _gate(self, question):
        with self._changed:
            self._hangs = self._hangs or self._hang_at is not None and self._hang_at.search(question) is not None
            self._waiting += self._hangs
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._hangs)

    def _handler(self, master):
        gate = self._gate

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self):
                question = self.rfile.read(int(self.headers["Content-Length"]))
                gate(question)
                connection = http.client.HTTPConnection(master)
                connection.request("POST", "/RPC2", question, {"Content-Type": "text/xml"})
                answer = connection.getresponse().read()
                connection.close()
                self.send_response(200)
                self.send_header("Content-Type", "text/xml")
                self.send_header("Content-Length", str(len(answer)))
                self.end_headers()
                self.wfile.write(answer)

            def log_message(self, *_):
                pass

        return Handler
