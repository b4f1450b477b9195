// The body in one pose, from its real geometry. Widths across the leg, which the model does not have, are free.
// Each leg shows, from the hip down: the actuator's sleeve, the thigh that slides in it by h, then k1 between thigh and
// foot on one side and the tibia between k3 and k2 on the other, and the foot with the spheres of its sole.

let ink = {};
function readInk() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["paper", "panel", "text", "quiet", "faint", "right", "left", "command", "paper2", "soil", "soil-edge", "mark", "post",
    "arrow", "shade-double", "shade-right", "shade-left", "fallen"]) ink[name] = style.getPropertyValue("--" + name).trim();
}
readInk();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", readInk);

function mix(a, b, share) {
  const part = (hex, k) => parseInt(hex.slice(1 + 2 * k, 3 + 2 * k), 16);
  return "#" + [0, 1, 2].map((k) => Math.round(part(a, k) + (part(b, k) - part(a, k)) * share).toString(16).padStart(2, "0")).join("");
}

// Fits the canvas to its place on the page; gives its size in CSS pixels.
function fit(canvas) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  return context;
}

function path(context, points, close) {
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (close) context.closePath();
}
function fillShape(context, points, fill, edge, width) {
  path(context, points, true);
  context.fillStyle = fill;
  context.fill();
  if (edge) { context.strokeStyle = edge; context.lineWidth = width; context.stroke(); }
}
function strokeLine(context, points, colour, width) {
  path(context, points, false);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
}

// From metres to pixels: xM is shown at `left`, the mean height of the ground around it at `ground`. `points` of the ground, if it is not flat.
class View {
  constructor(points, xM, left, ground, scale) {
    Object.assign(this, { points, xM, left, ground, scale, zM: groundLevel(points, xM) });
  }
  onGround(x) { return this.place([x, groundHeight(this.points, x)]); }
  place([x, z]) { return [this.left + (x - this.xM) * this.scale, this.ground - (z - this.zM) * this.scale]; }
}

// Height of the ground at x, in m: straight lines between and beyond its points, 0 without any.
function groundHeight(points, x) {
  if (!points) return 0;
  let low = 1, high = points.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (points[middle][0] > x) high = middle; else low = middle + 1;
  }
  const [x0, z0] = points[low - 1], [x1, z1] = points[low];
  return x1 > x0 ? z0 + (z1 - z0) * (x - x0) / (x1 - x0) : z1;
}

// Its mean height around x: what the eye follows without jumping over steps.
const AROUND_M = 0.75, AROUND_POINTS = 30;
function groundLevel(points, x) {
  if (!points) return 0;
  let sum = 0;
  for (let k = -AROUND_POINTS; k <= AROUND_POINTS; k++) sum += groundHeight(points, x + AROUND_M * k / AROUND_POINTS);
  return sum / (2 * AROUND_POINTS + 1);
}

function sphereCenter(body, psi, foot, index) {
  const half = Math.max(body.foot_arc_half_angle_rad, 0);
  const count = body.foot_sphere_count;
  const first = count > 1 ? -half : 0, spacing = count > 1 ? 2 * half / (count - 1) : 0;
  const angle = psi + first + spacing * index;
  const along = body.leg_length_m - body.foot_arc_radius_m + foot;
  const arc = body.foot_arc_radius_m - body.foot_sphere_radius_m;
  return [along * Math.sin(psi) + arc * Math.sin(angle), -along * Math.cos(psi) - arc * Math.cos(angle)];
}

function drawLeg(context, view, body, pose, side) {
  // As in the pictures, the left leg, which is behind, is paler: both colours are equally dark in grey.
  const full = side === 0 ? ink.right : ink.left, far = side === 1;
  const colour = far ? mix(full, "#ffffff", 0.55) : full;
  const h = pose["h" + side], d = pose["d" + side], w = pose["w" + side];
  const psi = pose.theta + pose["phi" + side];
  const sin = Math.sin(psi), cos = Math.cos(psi), l = body.leg_length_m;
  const at = ([down, across]) => view.place([pose.x + down * sin + across * cos, pose.z - down * cos + across * sin]);
  const block = (down, across, fill, edge, width) =>
    fillShape(context, [[down[0], across[0]], [down[0], across[1]], [down[1], across[1]], [down[1], across[0]]].map(at), fill, edge, width);
  const px = (metres) => Math.max(metres * view.scale, 0.4);
  const dark = mix(full, "#000000", 0.45), light = mix(full, "#ffffff", far ? 0.85 : 0.6), edge = px(0.008 * l);
  const thighTop = 0.24 * l + h, thighBottom = 0.43 * l + h, footShift = h - d;
  const soleHeight = body.foot_arc_radius_m * (1 - Math.cos(body.foot_arc_half_angle_rad));
  const plate = l - Math.min(soleHeight + 0.07 * l, 0.35 * l) + footShift;
  const spring = (from, to, across, half) => {
    const turns = 4, points = [[from, across], [from + (to - from) / 6, across]];
    for (let i = 0; i < 2 * turns; i++) {
      const share = (1 + 4 * (i + 0.5) / (2 * turns)) / 6;
      points.push([from + (to - from) * share, across + (i % 2 === 0 ? half : -half)]);
    }
    points.push([from + (to - from) * 5 / 6, across], [to, across]);
    strokeLine(context, points.map(at), dark, px(0.011 * l));
  };
  const tibia = body.tibia_distance_m + h - w;
  spring(thighBottom, plate, -0.045 * l, 0.022 * l);
  spring(thighBottom, tibia, 0.045 * l, 0.017 * l);
  spring(tibia, plate, 0.045 * l, 0.017 * l);
  block([0.06 * l, thighTop], [-0.016 * l, 0.016 * l], "#c4c4c4", "#5a5a5a", edge);
  block([0, 0.15 * l], [-0.034 * l, 0.034 * l], mix("#5a5a5a", colour, 0.25), "#3a3a3a", edge);
  block([thighTop, thighBottom], [-0.06 * l, 0.06 * l], colour, dark, edge);
  block([tibia - 0.04 * l, tibia + 0.04 * l], [0.015 * l, 0.075 * l], light, dark, edge);
  const spheres = Array.from({ length: body.foot_sphere_count }, (_, i) => {
    const [x, z] = sphereCenter(body, psi, footShift, i);
    return view.place([pose.x + x, pose.z + z]);
  });
  const top = [[plate, -0.075 * l], [plate, 0.085 * l]].map(at);
  fillShape(context, [top[1], top[0], ...spheres], colour, dark, edge);
  strokeLine(context, top, dark, px(0.02 * l));
  strokeLine(context, spheres, dark, px(2 * body.foot_sphere_radius_m));
}

function drawHip(context, view, body, pose) {
  const unit = body.leg_length_m / 0.8, sin = Math.sin(pose.theta), cos = Math.cos(pose.theta);
  const outline = [[-0.15, -0.06], [-0.15, 0.06], [-0.11, 0.10], [0.09, 0.10], [0.15, 0.05], [0.15, -0.05], [0.09, -0.10], [-0.11, -0.10]];
  const place = ([f, u]) => {
    const forward = f * unit, up = u * unit + body.hip_com_height_m;
    return view.place([pose.x + forward * cos - up * sin, pose.z + forward * sin + up * cos]);
  };
  fillShape(context, outline.map(place), "#8d8d8d", "#4a4a4a", Math.max(0.012 * unit * view.scale, 0.5));
}

function arrow(context, from, by, colour, width) {
  const length = Math.hypot(by[0], by[1]);
  if (length < 2 * width) return;
  const [u, v] = [by[0] / length, by[1] / length], head = Math.min(5 * width, 0.6 * length);
  const tip = [from[0] + by[0], from[1] + by[1]], neck = [tip[0] - head * u, tip[1] - head * v], wing = 0.45 * head;
  strokeLine(context, [from, neck], colour, width);
  fillShape(context, [tip, [neck[0] - wing * v, neck[1] + wing * u], [neck[0] + wing * v, neck[1] - wing * u]], colour);
}

function drawBiped(context, view, body, weightN, pose) {
  context.lineJoin = context.lineCap = "round";
  drawLeg(context, view, body, pose, 1);
  drawHip(context, view, body, pose);
  drawLeg(context, view, body, pose, 0);
  const [x, y] = view.place([pose.x, pose.z]);
  context.beginPath();
  context.arc(x, y, 0.028 * body.leg_length_m * view.scale, 0, 2 * Math.PI);
  context.fillStyle = "#ffffff";
  context.fill();
  context.strokeStyle = "#222222";
  context.lineWidth = Math.max(0.012 * body.leg_length_m * view.scale, 0.5);
  context.stroke();
  // Ground reaction forces, body weight a third of the leg long, two weights at most.
  const perNewton = body.leg_length_m * view.scale / 3 / Math.max(weightN, 1e-9);
  for (const side of [1, 0]) {
    const forward = pose["fx" + side], up = pose["fz" + side];
    if (up < 0.05 * weightN) continue;
    const psi = pose.theta + pose["phi" + side], shift = pose["h" + side] - pose["d" + side];
    let lowest = null;
    for (let i = 0; i < body.foot_sphere_count; i++) {
      const centre = sphereCenter(body, psi, shift, i);
      if (!lowest || centre[1] < lowest[1]) lowest = centre;
    }
    const foot = view.onGround(pose.x + lowest[0]);
    const scale = perNewton * Math.min(4 * weightN / Math.hypot(up, forward), 1);
    arrow(context, foot, [forward * scale, -up * scale], ink.arrow, 2.6);
    context.beginPath();
    context.arc(foot[0], foot[1], 3.2, 0, 2 * Math.PI);
    context.fillStyle = side === 0 ? ink.right : ink.left;
    context.fill();
  }
  const push = Math.hypot(pose.pushX, pose.pushZ);
  if (push > 1) arrow(context, [x, y], [pose.pushX * perNewton, -pose.pushZ * perNewton], ink.command, 4);
}

// The ground with a post every metre, so that motion over it is seen.
function drawGround(context, view, top, width, bottom) {
  const from = view.xM - view.left / view.scale, to = from + width / view.scale;
  const corners = (view.points || []).filter(([x]) => from < x && x < to).map((point) => view.place(point));
  const surface = [view.onGround(from), ...corners, view.onGround(to)];
  const depth = Math.min(24, bottom - view.ground), down = ([x, y]) => [x, view.points ? bottom : y + depth];
  path(context, [...surface, down(surface.at(-1)), down(surface[0])], true);
  context.fillStyle = ink.soil;
  context.fill();
  const first = Math.floor(from * 4), count = Math.min(Math.ceil(4 * width / view.scale) + 2, 2000);
  context.font = "10px system-ui, sans-serif";
  context.textAlign = "center";
  for (let quarter = first; quarter <= first + count; quarter++) {
    const [x, y] = view.onGround(quarter / 4);
    if (quarter % 4 === 0) {
      strokeLine(context, [[x, top], [x, y]], ink.post, 1.5);
      strokeLine(context, [[x, y], [x, y + 8]], ink.mark, 1.6);
      context.fillStyle = ink.quiet;
      context.fillText(quarter / 4 + " m", x, y + 19);
    } else {
      strokeLine(context, [[x, y], [x, y + 4.5]], ink.mark, 1);
    }
  }
  strokeLine(context, surface, ink["soil-edge"], 1.6);
}
