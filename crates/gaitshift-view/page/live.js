// The live page: what the program sends, shown smoothly.
const live = { epoch: -1, period: 0.01, pace: 1, shown: 0, lastFrame: 0, delay: 0.04, stripsAt: 0, built: false };

function connect() {
  const socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  // The program begins anew with every connection; what the page shows as chosen is asked for again.
  socket.onopen = () => {
    $("state").textContent = "";
    control.socket = socket;
    if (+$("pace").value !== 1) control.send({ type: "pace", value: +$("pace").value });
    if (run.chosen !== null) control.send({ type: "evaluation", step: run.chosen });
  };
  socket.onmessage = ({ data }) => (typeof data === "string" ? hear(JSON.parse(data)) : take(data));
  socket.onclose = () => { $("state").textContent = word("lost"); setTimeout(connect, 1500); };
}

function hear(message) {
  if (message.type === "bipeds") {
    live.period = message.control_period_s;
    const tracks = bipeds.map((a) => a.track);
    bipeds = message.bipeds.map((a, k) => ({ name: a.name, body: a.body, ground: a.ground, weight: a.weight_n, trained: a.trained, track: tracks[k] && `${tracks[k].own}` === `${a.own_columns}` ? tracks[k] : new Track(a.own_columns) }));
    begin(message.epoch);
    $("who").textContent = message.bipeds.map((a) => a.name).join(" · ");
    $("which").hidden = bipeds.length < 2;
    $("compare").checked = bipeds.length > 1;
    for (const film of document.querySelectorAll(".film")) film.hidden = !message.films;
    if (!live.built || live.given !== JSON.stringify(message.bipeds[0].given)) {
      live.given = JSON.stringify(message.bipeds[0].given);
      buildBody(message.bipeds[0].given);
      live.built = true;
    }
    showBody(message.bipeds[0].body);
    markRange(message.bipeds[0].trained);
  } else if (message.type === "now") {
    if (message.epoch !== live.epoch) begin(message.epoch);
    live.pace = message.paused ? 0 : message.pace;
    if (!overdue("paused", message.paused) && message.paused !== control.paused) setPaused(message.paused);
    if (!overdue("omega_v", message.omega_v) && !control.dragging) setOmega(message.omega_v, false);
    message.bipeds.forEach((now, k) => {
      const biped = bipeds[k];
      if (!biped) return;
      biped.track.phases = now.phases;
      const figures = biped.track.figures, entry = { time: now.time_s, gait: now.gait, speed: now.speed_m_per_s, froude: now.froude, cost: now.cost_of_transport };
      if (figures.length && figures[figures.length - 1].time >= entry.time) figures.pop();
      figures.push(entry);
    });
    const fell = message.bipeds.some((now) => now.gait === "fallen");
    if (fell) $("state").textContent = word("again");
    else if ($("state").textContent === word("again")) $("state").textContent = "";
    window.gaitshift.now = message;
  } else if (message.type === "error") {
    $("state").textContent = message.message;
  } else if (message.type === "saving") {
    $("state").textContent = word("saving");
  }
}

function begin(epoch) {
  live.epoch = epoch;
  live.shown = 0;
  for (const biped of bipeds) biped.track.clear();
}

function take(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) === 2) {
    const length = view.getUint8(1), name = new TextDecoder().decode(new Uint8Array(buffer, 2, length));
    download(name, new Uint8Array(buffer, 2 + length));
    $("state").textContent = `${word("saved")}: ${name}`;
    return;
  }
  const biped = bipeds[view.getUint8(1)], epoch = view.getUint32(4, true), count = view.getUint32(8, true);
  if (!biped) return;
  if (epoch !== live.epoch) begin(epoch);
  let at = 12;
  for (let k = 0; k < count; k++) {
    const time = view.getFloat64(at, true);
    at += 8;
    if (biped.track.time.length && time <= biped.track.last) { at += 4 * biped.track.names.length; continue; }
    biped.track.time.push(time);
    for (const name of biped.track.names) { biped.track.column[name].push(view.getFloat32(at, true)); at += 4; }
  }
  biped.track.trim(SHOWN_S + 4);
}

// Time on the page runs evenly, a little behind the newest sample, and is led back to it gently.
function frame(at) {
  notePace(at);
  const seconds = Math.min((at - live.lastFrame) / 1000, 0.25);
  live.lastFrame = at;
  const newest = bipeds.length ? bipeds[0].track.last : 0;
  if (live.pace === 0) live.shown = newest;
  else {
    live.shown += seconds * live.pace;
    const wanted = newest - live.delay * live.pace, error = wanted - live.shown;
    live.shown += Math.abs(error) > 0.3 * Math.max(live.pace, 0.05) ? error : error * 0.08;
    live.shown = Math.min(live.shown, newest);
  }
  drawDrag(drawStage(live.shown));
  showFigures(live.shown);
  // The strips move slowly enough for half the frames.
  if (at - live.stripsAt > 30 && bipeds.length) {
    live.stripsAt = at;
    const track = bipeds[Math.min(chosen(), bipeds.length - 1)].track;
    drawStrips($("strips"), track, live.shown, live.shown - SHOWN_S);
  }
  requestAnimationFrame(frame);
}

slider.min = -1;
slider.max = 4;
speak();
setOmega(0, false);
connect();
requestAnimationFrame(frame);
