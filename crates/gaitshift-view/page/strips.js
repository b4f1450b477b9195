// The strips beside the stage: what happened lately, scrolling with time.
const SHOWN_S = 8;
const STRIPS = {
  energies: new Scale(), speed: new Scale(), cost: new Scale(), reward: new Scale(),
};
const PHASE_INK = ["shade-double", "shade-right", "shade-left", null];

function shadeSupport(context, panel, track) {
  for (const [kind, begin, end] of track.phases) {
    const name = PHASE_INK[kind];
    if (!name || end < panel.x.low || begin > panel.x.high) continue;
    const left = panel.across(Math.max(begin, panel.x.low)), right = panel.across(Math.min(end, panel.x.high));
    context.fillStyle = ink[name];
    context.fillRect(left, panel.area.top, right - left, panel.area.height);
  }
}

// Draws everything up to `now`; `cursor` marks another time, for a replay.
function drawStrips(canvas, track, now, from, cursor) {
  const context = fit(canvas), width = canvas.clientWidth, height = canvas.clientHeight;
  const left = 46, inner = width - left - 10;
  const x = { low: from, high: Math.max(now, from + 1e-6) };
  const first = Math.max(track.before(from) - 1, 0), end = Math.min(track.before(now + 1e-9), track.time.length);
  const area = (top, size) => ({ left, top, width: inner, height: size });
  const free = height - 40 - 5 * 24, unit = free / 10;
  let top = 20;

  // Support: right above left, the shades behind the other strips say the same.
  const support = new Panel(context, area(top, unit), x, { low: 0, high: 1, ticks: () => ({ ticks: [], digits: 0 }) });
  support.frame(word("support"));
  context.textAlign = "right";
  context.textBaseline = "middle";
  [[0, ink.right, word("right")], [1, ink.left, word("left")]].forEach(([side, colour, name]) => {
    const size = unit * 0.42, y = top + side * (unit - size);
    context.fillStyle = ink.panel;
    context.fillRect(left, y, inner, size);
    context.fillStyle = colour;
    context.font = "10px system-ui, sans-serif";
    context.fillText(name, left - 5, y + size / 2);
    for (const [kind, begin, stop] of track.phases) {
      if (!(kind === 0 || kind === side + 1) || stop < x.low || begin > x.high) continue;
      const l = support.across(Math.max(begin, x.low)), r = support.across(Math.min(stop, x.high));
      context.fillRect(l, y, r - l, size);
    }
  });
  context.textBaseline = "alphabetic";
  top += unit + 24;

  const values = (name) => {
    const points = [];
    for (let k = first; k < end; k++) points.push([track.time[k], track.column[name][k]]);
    return points;
  };
  const range = (series, scale, least, ...more) => {
    let low = Math.min(...more), high = Math.max(...more);
    for (const points of series) for (const [, y] of points) if (y !== null && isFinite(y)) { low = Math.min(low, y); high = Math.max(high, y); }
    scale.hold(low, high, least);
  };
  const lines = (size, title, scale, series) => {
    const panel = new Panel(context, area(top, size), x, scale);
    shadeSupport(context, panel, track);
    panel.frame(title);
    panel.legend(series.filter((s) => s[0]).map(([name, , colour, dash]) => [name, colour, dash]));
    for (const [, points, colour, dash] of series) panel.curve(points, colour, 1.7, dash);
    top += size + 24;
  };

  const energies = [["kinetic", ink.right], ["gravitational", ink.left], ["elastic", ink.command]].map(([name, colour]) => {
    const points = values(name), mean = points.reduce((sum, p) => sum + p[1], 0) / Math.max(points.length, 1);
    return [word(name), points.map(([t, y]) => [t, y - mean]), colour];
  });
  range(energies.map((e) => e[1]), STRIPS.energies, 10, 0);
  lines(unit * 3, word("energies") + " (J)", STRIPS.energies, energies);

  const lately = track.figures.filter((f) => f.time >= x.low - 0.2 && f.time <= now + 1e-6);
  const figure = (name) => lately.map((f) => [f.time, f[name]]);
  const speed = [["", values("speed"), mix(ink.quiet, ink.paper, 0.4)], [word("speed") + " (m/s)", figure("speed"), ink.text],
    [word("froude"), figure("froude"), ink.paper2, [5, 3]], ["", values("omega"), ink.command, [2, 2]]];
  speed[3][0] = "ω_v".replace("_v", "ᵥ");
  range(speed.map((e) => e[1]), STRIPS.speed, 1, 0);
  lines(unit * 2.2, word("speed"), STRIPS.speed, speed);

  const cost = [["", figure("cost"), ink.text]];
  range(cost.map((e) => e[1]), STRIPS.cost, 0.2, 0);
  lines(unit * 1.4, word("costShort"), STRIPS.cost, cost);

  const palette = [ink.right, ink.left, ink.command, ink.quiet, ink.paper2, "#b59b00", "#56b4e9"];
  // The terms of the program, then those of one's own, dashed and with the names that they were given.
  const terms = ["rEnergy", "rVelocity", "rForward", "rAlive", "rLeg", "rFriction", "rWork"].map((name, k) => [word(name), values(name), palette[k]]);
  const own = track.own.map((name, k) => [name.replace("reward_", ""), values(name), palette[k % palette.length], [5, 3]]);
  const reward = [...terms, ...own].filter(([, points]) => points.some((p) => Math.abs(p[1]) > 1e-9));
  range(reward.map((e) => e[1]), STRIPS.reward, 0.1, 0);
  const panel = new Panel(context, area(top, height - top - 34), x, STRIPS.reward);
  shadeSupport(context, panel, track);
  panel.frame(inner > 420 ? word("reward") : word("reward").split(" ")[0]);
  panel.legend(reward.map(([name, , colour, dash]) => [name, colour, dash]));
  for (const [, points, colour, dash] of reward) panel.curve(points, colour, 1.4, dash);
  panel.bottom(word("timeAxis"));
  if (cursor !== undefined) strokeLine(context, [[panel.across(cursor), 20], [panel.across(cursor), height - 34]], ink.command, 1.5);
}
