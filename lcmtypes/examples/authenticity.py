"""Messages signed with the key of a cell, by nothing but the wire contract (../README.md#authenticity) and Python's own hmac.

    key = Key.read("cell.key")                                   # what `touchdown keygen cell.key` has written
    link.publish("TASK", key.sign("TASK", task, session, seq))   # instead of task.encode()
    robot = Signed(key, "ROBOT_STATE")                           # in a handler: if robot.takes(data, message): ...

Channels are those of the contract, without the suffix of a cell.
"""

import argparse
import hashlib
import hmac
import os
import stat

KEY_BYTES = 32
TAG_BYTES = 16
LABELS = {
    "ROBOT_STATE": b"touchdown robot",
    "SENSOR_DEFLECTION": b"touchdown sensor",
    "ROBOT_COMMAND": b"touchdown controller",
    "TASK": b"touchdown operator",
}


def _mac(key, data):
    return hmac.new(key, data, hashlib.sha256).digest()


class Key:
    """The key of a cell."""

    def __init__(self, secret):
        if len(secret) != KEY_BYTES:
            raise ValueError(f"a key has {KEY_BYTES} bytes, not {len(secret)}; `touchdown keygen FILE` writes one")
        self.id = max(1, int.from_bytes(_mac(secret, b"touchdown key id")[:4], "big") & 0x7FFFFFFF)
        self.authors = {channel: _mac(secret, label) for channel, label in LABELS.items()}

    @classmethod
    def read(cls, path):
        """The key in a file that nobody but its owner may read."""
        mode = stat.S_IMODE(os.stat(path).st_mode)
        if mode & 0o177:
            raise ValueError(f"{path} has mode {mode:04o}, but nobody else may read a key; chmod 600 {path}")
        with open(path, "rb") as file:
            return cls(file.read(KEY_BYTES + 1))

    @classmethod
    def named(cls, path):
        """The same for argparse, which tells what is wrong."""
        try:
            return cls.read(path)
        except (OSError, ValueError) as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    def tag(self, channel, encoding):
        """The tag of an encoding on `channel`: what its last 16 bytes have to be."""
        return _mac(self.authors[channel], channel.encode() + b"\0" + encoding[:-TAG_BYTES])[:TAG_BYTES]

    def sign(self, channel, message, session, seq):
        """The encoding of `message`, signed as number `seq` of `session`."""
        message.session, message.seq, message.key_id, message.tag = session, seq, self.id, bytes(TAG_BYTES)
        encoding = message.encode()
        return encoding[:-TAG_BYTES] + self.tag(channel, encoding)


class Signed:
    """What is taken of the robot's states, or of the controller's commands, and the session that they tell."""

    def __init__(self, key, channel):
        self.key, self.channel = key, channel
        self.boot_id, self.seq, self.session = 0, 0, 0

    def takes(self, encoding, message):
        """Whether `message`, which came as `encoding`, is signed and new; else it is as good as none."""
        signed = hmac.compare_digest(encoding[-TAG_BYTES:], self.key.tag(self.channel, encoding))
        if message.key_id != self.key.id or not signed:
            return False
        if message.boot_id != self.boot_id:
            self.boot_id, self.seq, self.session = message.boot_id, 0, 0
        if message.seq <= self.seq:
            return False
        self.seq, self.session = message.seq, message.session or self.session
        return True
