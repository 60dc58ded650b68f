"""A WebSocket client whose messages need not all be read: by default, 16 unread ones delay its end by ten seconds."""

from functools import partial

from websockets.sync.client import connect as bounded_connect

connect = partial(bounded_connect, max_queue=None)
