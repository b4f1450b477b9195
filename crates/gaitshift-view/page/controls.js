// What the hand does: slider, buttons, keys, pushes, body, files.
const control = {
  socket: null, omega: 0, dragging: false, paused: false, saving: false,
  // Where another program moves the body, the hand does nothing.
  idle: document.documentElement.dataset.mode === "watch",
  send(message) { if (!this.idle && this.socket && this.socket.readyState === 1) this.socket.send(JSON.stringify(message)); },
};
const slider = $("omega");

// What was asked of the program and not yet seen to be done: until then its older reports do not take it back.
const asked = {};
function ask(name, value) { asked[name] = { value, until: performance.now() + 5000 }; }
function overdue(name, reported) {
  const wish = asked[name];
  if (wish && Math.abs(wish.value - reported) > 1e-9 && performance.now() < wish.until) return true;
  delete asked[name];
  return false;
}

function setOmega(value, tell) {
  const low = +slider.min, high = +slider.max;
  value = Math.round(Math.min(Math.max(value, low), high) * 1000) / 1000;
  control.omega = value;
  slider.value = value;
  $("omegaOut").textContent = value.toFixed(2);
  if (tell) { ask("omega_v", value); control.send({ type: "omega_v", value }); }
}
slider.addEventListener("input", () => setOmega(+slider.value, true));
slider.addEventListener("pointerdown", () => { control.dragging = true; });
for (const end of ["pointerup", "pointercancel", "blur"]) slider.addEventListener(end, () => { control.dragging = false; });

// The trained range as a band, whole numbers as ticks; the thumb's middle moves within half its width of the ends.
function markRange([low, high]) {
  const min = +slider.min, max = +slider.max;
  const at = (value) => `calc(8px + (100% - 16px) * ${(value - min) / (max - min)})`;
  const band = $("band");
  band.style.left = at(Math.max(low, min));
  band.style.width = `calc((100% - 16px) * ${(Math.min(high, max) - Math.max(low, min)) / (max - min)})`;
  band.title = `${word("trained")}: ${low} – ${high}`;
  $("ticks").replaceChildren(...[...Array(Math.floor(max) - Math.ceil(min) + 1).keys()].map((k) => {
    const tick = document.createElement("span"), value = Math.ceil(min) + k;
    tick.textContent = value;
    tick.style.left = at(value);
    return tick;
  }));
}

function setPaused(on) {
  control.paused = on;
  $("pause").textContent = word(on ? "goOn" : "pause");
  $("pause").classList.toggle("on", on);
}
spoken.push(() => setPaused(control.paused));
function pause(on, message) { setPaused(on); ask("paused", on); control.send(message); }
$("pause").addEventListener("click", () => pause(!control.paused, { type: "pause", on: !control.paused }));
$("step").addEventListener("click", () => pause(true, { type: "step", periods: 1 }));
$("reset").addEventListener("click", () => control.send({ type: "reset" }));
for (const [button, name] of [["toRun", "run"], ["toWalk", "walk"], ["round", "round"]]) {
  $(button).addEventListener("click", () => { delete asked.omega_v; control.send({ type: "change", name }); });
}
$("pace").addEventListener("change", () => control.send({ type: "pace", value: +$("pace").value }));
$("compare").addEventListener("change", () => control.send({ type: "compare", on: $("compare").checked }));

function push(forceN) {
  const duration = Math.min(Math.max(+$("pushTime").value || 0.1, 0.01), 2);
  const size = Math.hypot(...forceN), scale = size > 2000 ? 2000 / size : 1;
  control.send({ type: "push", force_n: forceN.map((f) => f * scale), duration_s: duration });
}
$("pushBack").addEventListener("click", () => push([-Math.abs(+$("force").value || 200), 0]));
$("pushForward").addEventListener("click", () => push([Math.abs(+$("force").value || 200), 0]));

// A drag on the stage is a push: body weight for a third of the leg's length, as long as the ground's arrows.
let drag = null;
stageCanvas.addEventListener("pointerdown", (event) => {
  if (control.idle) return;
  const y = event.offsetY, hit = views.find((v) => y >= v.top && y < v.top + v.lane);
  if (!hit) return;
  drag = { view: hit.view, pose: hit.pose, from: [event.offsetX, event.offsetY], to: [event.offsetX, event.offsetY] };
  stageCanvas.setPointerCapture(event.pointerId);
});
stageCanvas.addEventListener("pointermove", (event) => { if (drag) drag.to = [event.offsetX, event.offsetY]; });
stageCanvas.addEventListener("pointercancel", () => { drag = null; });
stageCanvas.addEventListener("pointerup", () => {
  if (drag) { const force = dragForce(); if (Math.hypot(...force) >= 10) push(force); }
  drag = null;
});
function dragForce() {
  const biped = bipeds[0], perNewton = biped.body.leg_length_m * drag.view.scale / 3 / Math.max(biped.weight, 1e-9);
  const by = [drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]];
  const force = [by[0] / perNewton, -by[1] / perNewton], size = Math.hypot(...force);
  return size > 2000 ? force.map((f) => f * 2000 / size) : force;
}
function drawDrag(context) {
  if (!drag || !views.length) return;
  const { view, pose } = views[0], hip = view.place([pose.x, pose.z]);
  const by = [drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]];
  context.globalAlpha = 0.8;
  arrow(context, hip, by, ink.command, 4);
  context.globalAlpha = 1;
  context.font = "bold 13px system-ui, sans-serif";
  context.textAlign = "center";
  context.fillStyle = ink.command;
  context.fillText(Math.round(Math.hypot(...dragForce())) + " N", hip[0] + by[0], hip[1] + by[1] - 12);
}

addEventListener("keydown", (event) => {
  const field = event.target.closest && event.target.closest("input[type=number], select, textarea, summary");
  if (control.idle || field || event.ctrlKey || event.metaKey || event.altKey) return;
  const button = event.target.closest && event.target.closest("button");
  const own = event.target.type === "range" && event.target !== slider;
  const small = event.shiftKey ? 0.01 : 0.1;
  const act = {
    ArrowRight: () => setOmega(control.omega + small, true), ArrowUp: () => setOmega(control.omega + small, true),
    ArrowLeft: () => setOmega(control.omega - small, true), ArrowDown: () => setOmega(control.omega - small, true),
    " ": () => $("pause").click(), ".": () => $("step").click(), r: () => $("reset").click(), R: () => $("reset").click(),
    "1": () => $("toRun").click(), "2": () => $("toWalk").click(), "3": () => $("round").click(),
    ",": () => $("pushBack").click(), ";": () => $("pushForward").click(),
  }[event.key];
  if (!act || (own && event.key.startsWith("Arrow")) || (button && event.key === " ")) return;
  if (event.target.type === "radio" || event.target.type === "checkbox") return;
  event.preventDefault();
  act();
});

// Sliders of the body: from a quarter of the given value to four times it, in even ratios; gravity from the Moon's up.
const BODY_KEYS = ["hip_mass_kg", "thigh_mass_kg", "tibia_mass_kg", "foot_mass_kg", "hip_stiffness_nm_per_rad", "hip_damping_nms_per_rad",
  "k1_n_per_m", "k2_n_per_m", "k3_n_per_m", "c1_ns_per_m", "c2_ns_per_m", "actuator_force_n", "friction", "gravity_m_per_s2"];
const bodyInputs = {};
function buildBody(given) {
  $("bodySliders").replaceChildren(...BODY_KEYS.map((key) => {
    const label = document.createElement("label"), name = document.createElement("span"), out = document.createElement("output"), input = document.createElement("input");
    name.dataset.word = ""; // replaced below with the language
    name.removeAttribute("data-word");
    name.textContent = word("bodyNames")[key];
    input.type = "range";
    const base = given[key];
    // Nothing to take ratios of: from 0 to 1.
    Object.assign(input, base > 0 ? { min: -1, max: 1, step: 0.01 } : { min: 0, max: 1, step: 0.01 });
    input.value = 0;
    input.id = "body_" + key;
    const value = () => (base > 0 ? base * 4 ** +input.value : +input.value);
    input.addEventListener("input", () => {
      out.textContent = +value().toPrecision(3);
      control.send({ type: "body", values: [[key, value()]] });
    });
    bodyInputs[key] = { input, out, name, base };
    label.append(name, out, input);
    return label;
  }));
}
function showBody(body) {
  for (const key of BODY_KEYS) {
    const { input, out, base } = bodyInputs[key] || {};
    if (!input) continue;
    if (document.activeElement !== input) input.value = base > 0 ? Math.log(Math.max(body[key], 1e-9) / base) / Math.log(4) : body[key];
    out.textContent = +body[key].toPrecision(3);
  }
}
spoken.push(() => { for (const key in bodyInputs) bodyInputs[key].name.textContent = word("bodyNames")[key]; });
$("bodyReset").addEventListener("click", () => { for (const key in bodyInputs) bodyInputs[key].input.blur(); control.send({ type: "body", values: [] }); });

const chosen = () => +(document.querySelector("input[name=which]:checked") || { value: 0 }).value;
for (const button of document.querySelectorAll(".save")) {
  button.addEventListener("click", () => control.send({
    type: "save", what: button.dataset.what, biped: Math.min(chosen(), bipeds.length - 1),
    seconds: Math.min(Math.max(+$("saveTime").value || 10, 1), 60),
  }));
}
function download(name, bytes) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
