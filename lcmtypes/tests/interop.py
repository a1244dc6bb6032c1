"""Python's LCM against the wire of the Rust crate. Run by tests/wire/interop.rs.

The files golden/<CHANNEL>.values say what the golden encodings mean, member by member; they are what both languages
have to agree on.

    interop.py describe TYPES GOLDEN LOG          write golden/*.values from the encodings in LOG
    interop.py log      TYPES GOLDEN LOG ANSWER   check the encodings in LOG, write Python's own to ANSWER
    interop.py link     TYPES GOLDEN URL ANSWER   the same through two LCM URLs
"""

import ast
import importlib
import pathlib
import sys

import lcm

TYPES = {
    "ROBOT_STATE": "robot_state_t",
    "SENSOR_DEFLECTION": "sensor_deflection_t",
    "ROBOT_COMMAND": "robot_command_t",
    "CONTROLLER_STATUS": "controller_status_t",
    "NODE_STATUS": "node_status_t",
    "TASK": "task_t",
    "OBJECT_POSE": "object_pose_t",
    "SIM_LINK_MOTION": "sim_link_motion_t",
    "SIM_TOOL_MOTION": "sim_tool_motion_t",
    "SIM_TRUTH": "sim_truth_t",
}
PATIENCE_MS = 10_000


def type_of(channel):
    name = TYPES[channel]
    return getattr(importlib.import_module("touchdown." + name), name)


def plain(value):
    """Tuples as lists, at any depth."""
    return [plain(element) for element in value] if isinstance(value, (list, tuple)) else value


def values_of(message):
    return {name: plain(getattr(message, name)) for name in message.__slots__}


def golden_values(golden, channel):
    lines = (golden / (channel + ".values")).read_text().splitlines()
    return {name: ast.literal_eval(value) for name, value in (line.split(" = ", 1) for line in lines)}


def check(golden, channel, data):
    """What `data` says is what the golden file says."""
    found, expected = values_of(type_of(channel).decode(data)), golden_values(golden, channel)
    for name in found.keys() | expected.keys():
        if repr(found.get(name)) != repr(expected.get(name)):
            sys.exit(f"{channel}: {name} is {found.get(name)}, not {expected.get(name)}")


def encode(golden, channel):
    """The golden values as Python encodes them."""
    message = type_of(channel)()
    for name, value in golden_values(golden, channel).items():
        setattr(message, name, value)
    return message.encode()


def describe(golden, log):
    for event in lcm.EventLog(log, "r"):
        values = values_of(type_of(event.channel).decode(event.data))
        lines = [f"{name} = {value!r}\n" for name, value in values.items()]
        (golden / (event.channel + ".values")).write_text("".join(lines))


def through_log(golden, log, answer):
    events = list(lcm.EventLog(log, "r"))
    answers = lcm.EventLog(answer, "w", overwrite=True)
    for event in events:
        check(golden, event.channel, event.data)
        answers.write_event(event.timestamp, event.channel, encode(golden, event.channel))
    answers.close()


def through_link(golden, url, answer):
    inbound, outbound = lcm.LCM(url), lcm.LCM(answer)
    waiting = set(TYPES)

    def on_message(channel, data):
        check(golden, channel, data)
        outbound.publish(channel, encode(golden, channel))
        waiting.discard(channel)

    for channel in TYPES:
        inbound.subscribe(channel, on_message)
    print("ready", flush=True)
    while waiting:
        if not inbound.handle_timeout(PATIENCE_MS):
            sys.exit(f"nothing arrived within {PATIENCE_MS} ms; still waiting for {sorted(waiting)}")


if __name__ == "__main__":
    command, types, golden_directory, *arguments = sys.argv[1:]
    sys.path.insert(0, types)
    actions = {"describe": describe, "log": through_log, "link": through_link}
    actions[command](pathlib.Path(golden_directory), *arguments)
