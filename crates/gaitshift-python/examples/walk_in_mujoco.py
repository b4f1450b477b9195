"""Walks in MuJoCo: the exported body under the exported policy.

    gaitshift export mjcf --out biped.xml && gaitshift export onnx --out policy.onnx
    python crates/gaitshift-python/examples/walk_in_mujoco.py

needs mujoco, numpy and onnxruntime, and nothing of ours but the two files, which are the shipped controller's body and policy.
For another controller give both exports the same --controller.
"""

import mujoco
import numpy as np
import onnxruntime

model, omega_v = mujoco.MjModel.from_xml_path("biped.xml"), 0.0
data, policy = mujoco.MjData(model), onnxruntime.InferenceSession("policy.onnx")
mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
steps = round(model.numeric("control_period_s").data[0] / model.opt.timestep)
while data.time < 10.0:
    mujoco.mj_forward(model, data)  # brings the sensors up to date
    observation = np.append(data.sensordata, omega_v)[np.newaxis].astype(np.float32)
    [data.ctrl[:]] = policy.run(["action"], {"observation": observation})[0]
    mujoco.mj_step(model, data, steps)
print(f"{data.qpos[0]:.2f} m in {data.time:.2f} s, hip at {data.qpos[1]:.2f} m")
