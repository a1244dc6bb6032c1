"""An experiment from a script, by nothing but the wire contract (../README.md): start, change, watch, stop.

    lcm-gen -p lcmtypes/types/*.lcm                          # package touchdown, into the working directory
    python3 lcmtypes/examples/experiment.py --url 'udpm://239.255.76.67:7667?ttl=0' --force-n 8,12

It needs a cell that is at work (`touchdown up CELL.toml`), whose controller is ready, best with
task.starts_by_itself=false. It presses with each force in turn, prints a line of CSV for each, and retracts nothing: it asks
for a stop, after which the tool rests where it is. It publishes TASK and listens to CONTROLLER_STATUS; with --key also to
ROBOT_STATE, whose session and number a signed request carries (authenticity.py).
"""

import argparse
import collections
import random
import statistics
import sys
import time

import lcm

import authenticity

# How long an answer, a start and a new force may take, s.
ANSWER_S = 2.0
PHASE_S = 30.0
# A request is repeated until it is answered: datagrams may be lost, and a repeated request is the same one.
REPEAT_MS = 50
# So many cycles have to have the force within 2 % on average before it counts as reached.
RECENT = 50


class Experiment:
    """A controller that is listened to, and asked."""

    def __init__(self, url, suffix, types, key):
        self.types, self.key = types, key
        self.link = lcm.LCM(url)
        self.suffix = suffix
        subscription = self.link.subscribe("CONTROLLER_STATUS" + suffix, self._hear)
        subscription.set_queue_capacity(64)
        self.status = None
        self.watchers = []
        # As long as this script runs it is one sender; its requests are counted from a number that no other one has.
        self.sender = random.randrange(1, 8_000_000_000_000)
        self.requests = 0
        # The robot's states under a key, and the number of the last signed request.
        self.robot, self.seq = authenticity.Signed(key, "ROBOT_STATE"), 0
        if key:
            self.link.subscribe("ROBOT_STATE" + suffix, self._hear_robot)

    def _hear_robot(self, channel, data):
        try:
            state = self.types.robot_state_t.decode(data)
        except ValueError:
            return
        before = self.robot.boot_id
        if self.robot.takes(data, state) and state.boot_id != before:
            self.seq = 0  # another robot counts anew

    def _hear(self, channel, data):
        try:
            status = self.types.controller_status_t.decode(data)
        except ValueError:
            return  # another program's message on this channel
        self.status = status
        for watcher in self.watchers:
            watcher(status)

    def listen(self, ms):
        """Take what comes within `ms`."""
        until = time.monotonic() + ms / 1000
        while (left := until - time.monotonic()) > 0:
            self.link.handle_timeout(max(1, int(left * 1000)))

    def ask(self, action=0, **parameters):
        """Ask for an action and for parameters such as desired_force_n=12; an answer that is no yes ends the script."""
        status = self.types.controller_status_t
        give_up = time.monotonic() + ANSWER_S
        while True:
            answer = self._answer(action, parameters)
            if answer == status.ANSWER_ACCEPTED:
                return
            # A robot may need a moment before it is where it was sent and takes commands.
            if answer != status.ANSWER_ROBOT_NOT_READY or time.monotonic() > give_up:
                sys.exit(f"refused: {name_of(status, 'ANSWER_', answer)}, {self.status.controller_task_limit}")

    def _answer(self, action, parameters):
        """The controller's answer to one request."""
        task = self.types.task_t()
        task.step, task.boot_id = self.sender + self.requests, self.sender
        task.tag = bytes(16)  # lcm-gen 1.3.1 begins with a text
        self.requests += 1
        task.task_action = action
        for name, value in parameters.items():
            task.task_parameter_mask |= 1 << getattr(task, "PARAMETER_" + name.upper())
            setattr(task, "task_" + name, float(value))
        give_up = time.monotonic() + ANSWER_S
        while time.monotonic() < give_up:
            self.link.publish("TASK" + self.suffix, self._encoded(task))
            self.listen(REPEAT_MS)
            if self.status and self.status.controller_task_step == task.step:
                return self.status.controller_task_answer
        sys.exit(f"no controller has answered within {ANSWER_S} s; is the cell at work on this URL?")

    def _encoded(self, task):
        """The request as it is sent; under a key a repeated one is signed anew."""
        if not self.key:
            return task.encode()
        self.seq = max(self.seq + 1, self.robot.seq)
        return self.key.sign("TASK", task, self.robot.session, self.seq)

    def until(self, holds, what):
        """Listen until `holds(status)`; a fault, or too long a time, ends the script."""
        give_up = time.monotonic() + PHASE_S
        while time.monotonic() < give_up:
            self.listen(20)
            if self.status is None:
                continue
            if self.status.controller_fault:
                fault = name_of(self.types.node_status_t, "FAULT_", self.status.controller_fault)
                sys.exit(f"the controller is in a fault: {fault}")
            if holds(self.status):
                return
        sys.exit(f"not {what} within {PHASE_S} s")


def name_of(type_, prefix, value):
    """The constant of `type_` that `value` stands for."""
    names = (name for name in dir(type_) if name.startswith(prefix) and getattr(type_, name) == value)
    return next(names, str(value)).removeprefix(prefix).lower().replace("_", " ")


def normal_force_n(status):
    """The normal force at the tcp that the control law works with, N."""
    return status.controller_desired_force_n[2] + status.controller_force_error_n


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--url", default="udpm://239.255.76.67:7667?ttl=0", help="the cell's, without its suffix")
    parser.add_argument("--suffix", default="", help="what ends the names of the cell's channels, such as _B")
    parser.add_argument("--types", default=".", help="where lcm-gen -p has put the package touchdown")
    parser.add_argument("--force-n", default="8,12", help="forces to press with, N")
    parser.add_argument("--hold-s", type=float, default=0.5, help="how long each is averaged, s")
    parser.add_argument("--key", type=authenticity.Key.named, help="key file of the cell")
    arguments = parser.parse_args()
    sys.path.insert(0, arguments.types)
    import touchdown

    status = touchdown.controller_status_t
    experiment = Experiment(arguments.url, arguments.suffix, touchdown, arguments.key)
    forces = [float(text) for text in arguments.force_n.split(",")]
    idle = (status.PHASE_INIT, status.PHASE_SYNC)
    in_contact = (status.PHASE_CONTACT, status.PHASE_SETTLED)
    experiment.until(lambda it: it.controller_phase not in idle, "ready")

    # Start, with the first force; a controller that has begun by itself is asked for the force alone.
    ready = experiment.status.controller_phase == status.PHASE_READY
    experiment.ask(touchdown.task_t.ACTION_START if ready else 0, desired_force_n=forces[0])
    print("desired_force_n,mean_force_n,deviation_force_n,object_height_m,time_s", flush=True)
    for i, force in enumerate(forces):
        if i > 0:
            experiment.ask(desired_force_n=force)

        recent = collections.deque(maxlen=RECENT)
        experiment.watchers.append(lambda it: recent.append(normal_force_n(it)))

        def pressed(it):
            # A new force is slewed to: what is desired now is published.
            arrived = it.controller_phase in in_contact and abs(it.controller_desired_force_n[2] - force) < 1e-6
            if not arrived:
                recent.clear()
            return len(recent) == RECENT and abs(statistics.fmean(recent) - force) < 0.02 * force

        experiment.until(pressed, f"pressing with {force} N")
        experiment.watchers.clear()
        # Watch.
        heard = []
        experiment.watchers.append(lambda it: heard.append(normal_force_n(it)))
        experiment.listen(1000 * arguments.hold_s)
        experiment.watchers.clear()
        newest = experiment.status
        height_m = newest.controller_r_from_o_position_m[2]
        mean_n, deviation_n = statistics.fmean(heard), statistics.pstdev(heard)
        print(f"{force},{mean_n:.4f},{deviation_n:.4f},{height_m:.6f},{newest.step * 1e-3}", flush=True)
    experiment.ask(touchdown.task_t.ACTION_STOP)


if __name__ == "__main__":
    main()
