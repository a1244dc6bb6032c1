# The tool on its sensor, and the object that swings against it, by MuJoCo. The first line of stdin describes both, each further
# one is a run, all of them JSON; a line of stdout answers each run.
#
# The sensor is springs and dampers of joints. The contact is a tendon from far above the object's surface to the tcp, slack as
# long as the tcp is above the surface: MuJoCo's own contacts would only approximate a linear spring, and need its solver.
# The object is so heavy that it swings as prescribed whatever touches it.
import json
import sys
import time

import mujoco

MODEL = """
<mujoco>
  <option gravity="0 0 -{gravity_m_per_s2}"><flag contact="disable" constraint="disable"/></option>
  <worldbody>
    <body gravcomp="1">
      <joint type="slide" axis="0 0 1" stiffness="{object_n_per_m}"/>
      <geom type="sphere" size="0.01" mass="{object_kg}"/>
      <site name="surface" pos="{above_tcp_m}"/>
    </body>
    <body>
      <joint type="slide" axis="1 0 0" stiffness="{stiffness_n_per_m}" damping="{damping_ns_per_m}"/>
      <joint type="slide" axis="0 1 0" stiffness="{stiffness_n_per_m}" damping="{damping_ns_per_m}"/>
      <joint type="slide" axis="0 0 1" stiffness="{stiffness_n_per_m}" damping="{damping_ns_per_m}"/>
      <joint type="ball" stiffness="{stiffness_nm_per_rad}" damping="{damping_nms_per_rad}"/>
      <inertial pos="{centre_m}" mass="{mass_kg}" diaginertia="{inertia_kg_m2}"/>
      <site name="tcp" pos="{tcp_m}"/>
    </body>
  </worldbody>
  <tendon>
    <spatial stiffness="{contact_n_per_m}" springlength="0 {slack_m}"><site site="surface"/><site site="tcp"/></spatial>
  </tendon>
</mujoco>
"""


def attribute(value):
    return " ".join(map(repr, value)) if isinstance(value, list) else repr(value)


def build(described):
    above_tcp_m = described["tcp_m"][:2] + [described["far_m"]]
    attributes = {key: attribute(value) for key, value in {**described, "above_tcp_m": above_tcp_m}.items()}
    return mujoco.MjModel.from_xml_string(MODEL.format(**attributes))


def answer(model, described, run):
    model.opt.integrator = getattr(mujoco.mjtIntegrator, "mjINT_" + run["integrator"].upper())
    model.opt.timestep = described["tick_s"] / run["steps_per_tick"]
    data = mujoco.MjData(model)
    data.qpos[:] = [described["start_object_m"], *described["start_plate_m"], *described["start_plate_wxyz"]]
    data.qvel[0] = described["start_object_m_per_s"]
    if not run["trace"]:
        start_s = time.thread_time()
        mujoco.mj_step(model, data, nstep=run["ticks"] * run["steps_per_tick"])
        return {"core_s": time.thread_time() - start_s, "tcp_m": []}
    tcp_m = []
    for _ in range(run["ticks"]):
        mujoco.mj_step(model, data, nstep=run["steps_per_tick"])
        mujoco.mj_kinematics(model, data)
        tcp_m.append(list(data.site("tcp").xpos))
    return {"core_s": 0.0, "tcp_m": tcp_m}


described = json.loads(sys.stdin.readline())
model = build(described)
for line in sys.stdin:
    print(json.dumps(answer(model, described, json.loads(line))), flush=True)
