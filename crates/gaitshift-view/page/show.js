// The stage with one or two bipeds, and the figures above it.
const $ = (id) => document.getElementById(id);
const stageCanvas = $("stage");
let bipeds = []; // {body, weight, track, name, ground}: points [x, z] of the ground, nothing where it is flat
let views = [];  // how each was drawn last, for pushes by hand

function drawStage(time) {
  const context = fit(stageCanvas), width = stageCanvas.clientWidth, height = stageCanvas.clientHeight;
  const lane = height / Math.max(bipeds.length, 1);
  views = [];
  bipeds.forEach((biped, k) => {
    const pose = biped.track.pose(time);
    if (!pose) return;
    const top = k * lane, ground = top + lane - 28;
    const scale = Math.min((lane - 40) / (1.32 * biped.body.leg_length_m), width / (2.2 * biped.body.leg_length_m));
    const view = new View(biped.ground, pose.x, width * 0.46, ground, scale);
    context.save();
    context.beginPath();
    context.rect(0, top, width, lane);
    context.clip();
    drawGround(context, view, top + 8, width, top + lane);
    drawBiped(context, view, biped.body, biped.weight, pose);
    if (bipeds.length > 1) {
      context.fillStyle = ink.quiet;
      context.font = "12px system-ui, sans-serif";
      context.textAlign = "left";
      context.fillText(biped.name, 8, top + 16);
    }
    context.restore();
    views.push({ view, pose, top, lane });
  });
  return context;
}

const fixed = (value, digits) => (value === null || value === undefined ? "–" : (value + 0).toFixed(digits));

// Each number has a place of fixed width, so that nothing moves when it changes.
function showFigures(time) {
  bipeds.forEach((biped, k) => {
    const now = biped.track.figuresAt(time), suffix = k ? "2" : "";
    const gait = $("gait" + suffix), name = now ? now.gait : "";
    gait.textContent = now ? word(name) : "–";
    gait.dataset.gait = name;
    gait.classList.toggle("fallen", name === "fallen");
    $("speed" + suffix).textContent = fixed(now && now.speed, 2);
    $("froude" + suffix).textContent = fixed(now && now.froude, 2);
    $("cost" + suffix).textContent = fixed(now && now.cost, 3);
    $("time" + suffix).textContent = fixed(time, 1);
  });
  document.querySelector(".row.second").hidden = bipeds.length < 2;
}

// How evenly frames follow each other, for whoever measures.
const pacing = { last: 0, gaps: [] };
function notePace(at) {
  if (pacing.last) { pacing.gaps.push(at - pacing.last); if (pacing.gaps.length > 20000) pacing.gaps.splice(0, 10000); }
  pacing.last = at;
}
window.gaitshift = { pacing, get bipeds() { return bipeds; } };
