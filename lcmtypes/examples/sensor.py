"""A sensor in real time, by nothing but the wire contract (../README.md): a skeleton for a driver in Python.

    lcm-gen -p lcmtypes/types/*.lcm                          # package touchdown, into the working directory
    python3 lcmtypes/examples/sensor.py --url 'udpm://239.255.76.67:7667?ttl=0'

It speaks the device channels alone: publishes NODE_STATUS every 100 ms and SENSOR_DEFLECTION every --every ticks of 1 ms, and
listens to NODE_STATUS and ROBOT_COMMAND. `read` is what there is to be filled in. Python can't be relied upon to be on
time every ms: by default it publishes every 4 ms, which no reading is lost by, since each message carries the last eight.
With --key it signs, and takes no command that is not signed (authenticity.py).
"""

import argparse
import collections
import random
import select
import socket
import struct
import sys
import time

import lcm

import authenticity

READINGS = 8
TICK_US = 1000
STATUS_US = 100_000
SILENT_US = 500_000
# What nodes must agree on; a driver without a scenario file takes it from the robot.
HELLO = ("node_run_id", "node_protocol", "node_ticks_per_cycle", "node_seed", "node_configuration_hash")

Reading = collections.namedtuple("Reading", "utime translation_m rotation_rad")


def clock_us():
    """A clock that never steps. Its epoch is of no concern."""
    return time.monotonic_ns() // 1000


def read(utime):
    """The sensor's reading at `utime`, position (m) and rotation vector (rad) of s' in s: here a tool that hangs at rest.

    A real sensor's driver takes the instant at which the device has sampled, as well as it can be told.
    """
    noise = random.gauss
    return Reading(utime, [noise(0, 1e-6), noise(0, 1e-6), noise(-1e-4, 1e-6)], [noise(0, 1e-5) for _ in range(3)])


class Peer:
    """Whom the sensor works with as robot or controller: until that process has been silent for 0.5 s."""

    def __init__(self):
        self.boot_id, self.heard_us = 0, -SILENT_US

    def hear(self, boot_id):
        """Whether it is the one."""
        now = clock_us()
        if boot_id != self.boot_id and now - self.heard_us < SILENT_US:
            return False
        self.boot_id, self.heard_us = boot_id, now
        return True


class Sensor:
    def __init__(self, url, types, every, key):
        self.types, self.every, self.key = types, every, key
        self.link = lcm.LCM(url)
        self.link.subscribe("NODE_STATUS", self.on_status)
        self.link.subscribe("ROBOT_COMMAND", self.on_command)
        self.boot_id = random.SystemRandom().randrange(1, 2**63)
        self.host = socket.gethostname().encode()[:32].ljust(32, b"\0")
        self.hello = None
        self.robot, self.controller = Peer(), Peer()
        self.echo_command_send_us, self.echo_receive_us = 0, 0
        self.tick, self.began_us = 0, clock_us()
        self.next_status_us = self.began_us
        self.published = self.received = self.undecodable = self.refused = 0
        # The controller's commands under a key, and how many messages have been signed.
        self.commands, self.seq = authenticity.Signed(key, "ROBOT_COMMAND"), 0
        # Newest first. Those never taken have flags 0.
        self.readings = collections.deque(maxlen=READINGS)

    def decode(self, type_of_message, data):
        """The message, or None if it is none of that type."""
        try:
            message = type_of_message.decode(data)
        except (ValueError, struct.error):
            self.undecodable += 1
            return None
        self.received += 1
        return message

    def on_status(self, _, data):
        status = self.decode(self.types.node_status_t, data)
        if not status:
            return
        if bool(status.node_authenticated) != bool(self.key):
            return  # with and without a key nodes do not work with each other
        hello = {name: getattr(status, name) for name in HELLO}
        role = status.node_role.rstrip(b"\0")
        if role == b"robot" and status.node_protocol == status.PROTOCOL and self.robot.hear(status.boot_id):
            self.hello = hello
        if role == b"controller" and hello == self.hello:
            self.controller.hear(status.boot_id)

    def on_command(self, _, data):
        received_us = clock_us()
        command = self.decode(self.types.robot_command_t, data)
        if not command or command.boot_id != self.controller.boot_id:
            return
        if self.key and not self.commands.takes(data, command):
            self.refused += 1
        else:
            self.echo_command_send_us, self.echo_receive_us = command.command_send_us, received_us

    def publish_status(self):
        status = self.types.node_status_t()
        status.step, status.utime, status.boot_id = self.tick, clock_us(), self.boot_id
        status.node_role, status.node_host = b"sensor".ljust(32, b"\0"), self.host
        status.node_state = status.STATE_RUNNING
        status.node_fault_step, status.node_fault_peer = -1, status.ROLE_SENSOR
        for name, value in self.hello.items():
            setattr(status, name, value)
        status.node_published, status.node_received = self.published, self.received
        status.node_undecodable, status.node_refused = self.undecodable, self.refused
        status.node_authenticated = bool(self.key)
        self.link.publish("NODE_STATUS", status.encode())

    def publish_deflection(self):
        message = self.types.sensor_deflection_t()
        message.step, message.utime, message.boot_id = self.tick, self.readings[0].utime, self.boot_id
        for i, reading in enumerate(self.readings):
            message.deflection_sample_us[i] = reading.utime
            message.deflection_translation_m[i] = reading.translation_m
            message.deflection_rotation_rad[i] = reading.rotation_rad
            message.deflection_flags[i] = message.FLAG_VALID
        message.tag = bytes(16)
        if self.echo_command_send_us:
            message.deflection_echo_command_send_us = self.echo_command_send_us
            message.deflection_echo_receive_us = self.echo_receive_us
            message.deflection_echo_send_us = clock_us()
        self.seq += 1
        channel = "SENSOR_DEFLECTION"
        signed = self.key and self.key.sign(channel, message, self.commands.session, self.seq)
        self.link.publish(channel, signed or message.encode())
        self.published += 1

    def hear_until(self, due_us):
        """Hear what comes until `due_us`; a flood of messages does not hold up the tick."""
        while True:
            left_us = max(0, due_us - clock_us())
            if select.select([self.link.fileno()], [], [], 1e-6 * left_us)[0]:
                self.link.handle()
            if clock_us() >= due_us:
                return

    def run(self):
        while True:
            due_us = self.began_us + (self.tick + self.every) * TICK_US
            self.hear_until(min(due_us, self.next_status_us))
            now = clock_us()
            if now >= self.next_status_us:
                self.next_status_us = now + STATUS_US
                if self.hello:
                    self.publish_status()
            if now < due_us:
                continue
            # Each reading at its own tick, also after a delay: what is too old is not sent any more.
            for _ in range(self.every):
                self.tick += 1
                self.readings.appendleft(read(self.began_us + self.tick * TICK_US))
            if self.hello and now - due_us < READINGS * TICK_US:
                self.publish_deflection()


def main():
    arguments = argparse.ArgumentParser(description="Plays a sensor in real time.")
    arguments.add_argument("--url", default="udpm://239.255.76.67:7667?ttl=0", help="LCM URL of the device channels")
    arguments.add_argument("--types", default=".", help="directory of the package touchdown that lcm-gen has made")
    arguments.add_argument("--every", type=int, default=4, choices=range(1, READINGS + 1), help="publish every so many ticks")
    arguments.add_argument("--key", type=authenticity.Key.named, help="key file of the cell")
    given = arguments.parse_args()
    sys.path.insert(0, given.types)
    import touchdown

    Sensor(given.url, touchdown, given.every, given.key).run()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
