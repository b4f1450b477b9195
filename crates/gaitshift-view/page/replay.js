// A recording: play, scrub, the same stage and strips.
const replay = { playing: false, time: 0, pace: 1, lastFrame: 0, dirty: true };

function decode(series) {
  const text = atob(series.data), bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  const view = new DataView(bytes.buffer), count = bytes.length / series.width, values = new Array(count);
  for (let k = 0; k < count; k++) {
    const whole = series.width === 2 ? view.getInt16(2 * k, true) : view.getInt32(4 * k, true);
    values[k] = series.offset + whole * series.resolution;
  }
  return values;
}

{
  const data = JSON.parse($("data").textContent), track = new Track(data.own_columns);
  track.time = decode(data.time_s);
  data.columns.forEach((series, k) => { track.column[track.names[k]] = decode(series); });
  track.phases = data.phases;
  track.figures = data.figures.map(([time, gait, speed, froude, cost]) => ({ time, gait, speed, froude, cost }));
  bipeds = [{ name: data.controller, body: data.body, weight: data.weight_n, ground: data.ground, track }];
  $("who").textContent = data.controller;
  replay.first = track.time[0];
  replay.last = track.last;
  replay.time = replay.first;
}

const scrub = $("scrub");
scrub.min = replay.first;
scrub.max = replay.last;
scrub.step = 0.01;
function seek(time) {
  replay.time = Math.min(Math.max(time, replay.first), replay.last);
  scrub.value = replay.time;
  replay.dirty = true;
}
function setPlaying(on) {
  if (on && replay.time >= replay.last - 1e-6) seek(replay.first);
  replay.playing = on;
  $("play").textContent = word(on ? "stop" : "play");
  $("play").classList.toggle("on", on);
}
spoken.push(() => { setPlaying(replay.playing); replay.dirty = true; });
$("play").addEventListener("click", () => setPlaying(!replay.playing));
scrub.addEventListener("input", () => { setPlaying(false); seek(+scrub.value); });
$("playPace").addEventListener("change", () => { replay.pace = +$("playPace").value; });
// A click on the strips goes to that time.
$("strips").addEventListener("click", (event) => {
  const share = (event.offsetX - 46) / ($("strips").clientWidth - 56), from = stripFrom();
  seek(from + share * (Math.min(from + SHOWN_S, replay.last) - from));
});
addEventListener("keydown", (event) => {
  if (event.target.closest && event.target.closest("select")) return;
  if (event.key === " " && !(event.target.closest && event.target.closest("button"))) { event.preventDefault(); setPlaying(!replay.playing); }
  const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (by) { event.preventDefault(); setPlaying(false); seek(replay.time + by * (event.shiftKey ? 1 : 0.02)); }
});
addEventListener("resize", () => { replay.dirty = true; });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { replay.dirty = true; });

// The strips show a stretch of the recording in whose middle the cursor stays.
function stripFrom() {
  const length = Math.min(SHOWN_S, replay.last - replay.first);
  return Math.min(Math.max(replay.time - length / 2, replay.first), replay.last - length);
}

function frame(at) {
  notePace(at);
  const seconds = Math.min((at - replay.lastFrame) / 1000, 0.25);
  replay.lastFrame = at;
  if (replay.playing) {
    seek(replay.time + seconds * replay.pace);
    if (replay.time >= replay.last - 1e-9) setPlaying(false);
  }
  if (replay.dirty) {
    replay.dirty = false;
    drawStage(replay.time);
    showFigures(replay.time);
    $("scrubOut").textContent = replay.time.toFixed(2) + " s";
    const from = stripFrom();
    drawStrips($("strips"), bipeds[0].track, Math.min(from + SHOWN_S, replay.last), from, replay.time);
  }
  requestAnimationFrame(frame);
}
speak();
requestAnimationFrame(frame);
