// A training run: its learning curve and evaluations; a click puts the controller of an evaluation on the stage.
const run = { data: null, chosen: null, plot: null };

async function lookAtRun() {
  try {
    const answer = await fetch("run.json");
    if (answer.ok) { run.data = await answer.json(); showRun(); }
  } catch { /* The socket says that the program is gone. */ }
  setTimeout(lookAtRun, 3000);
}

const million = (steps) => (steps >= 1e6 ? +(steps / 1e6).toFixed(2) + " M" : steps >= 1e3 ? Math.round(steps / 1e3) + " k" : String(Math.round(steps)));

function showRun() {
  const { data } = run;
  if (!data) return;
  $("runFolder").textContent = `${data.folder} · ${word(data.finished ? "finished" : "training")}`;
  const list = $("evaluation"), there = data.evaluations.filter((e) => e.controller);
  if (list.options.length !== there.length + 1) {
    const options = [["", word("best")], ...there.map((e) => [String(e.step), `${million(e.step)} · ${e.met}/${e.criteria}`])];
    list.replaceChildren(...options.map(([value, text]) => { const o = document.createElement("option"); o.value = value; o.textContent = text; o.disabled = !value; return o; }));
    list.value = run.chosen === null ? "" : String(run.chosen);
  }
  const evaluation = data.evaluations.find((e) => e.step === run.chosen) || data.evaluations[data.evaluations.length - 1];
  $("unmet").textContent = evaluation ? `${million(evaluation.step)}: ${evaluation.met}/${evaluation.criteria}` +
    (evaluation.unmet.length ? ` · ${word("unmet")}: ${evaluation.unmet.slice(0, 6).join("; ")}${evaluation.unmet.length > 6 ? " …" : ""}` : "") : word("noEvaluation");
  drawRun();
}

function drawRun() {
  const { data } = run;
  if (!data) return;
  const last = Math.max(1, ...data.curve.map((p) => p[0]), ...data.evaluations.map((e) => e.step));
  const place = (canvas) => {
    const context = fit(canvas);
    return [context, { left: 52, top: 20, width: canvas.clientWidth - 64, height: canvas.clientHeight - 54 }];
  };
  const x = { low: 0, high: last };
  {
    const [context, area] = place($("curve")), scale = new Scale();
    scale.hold(Math.min(0, ...data.curve.map((p) => p[2])), Math.max(1, ...data.curve.map((p) => p[2])), 1);
    const panel = new Panel(context, area, x, scale);
    panel.frame(word("returns"));
    panel.curve(data.curve.map((p) => [p[0], p[2]]), ink.left, 1.6);
    panel.bottom(word("steps"), million);
  }
  {
    const [context, area] = place($("criteria")), scale = new Scale();
    scale.hold(0, Math.max(1, ...data.evaluations.map((e) => e.criteria)), 1);
    const panel = new Panel(context, area, x, scale);
    panel.frame(word("criteria"));
    panel.curve(data.evaluations.map((e) => [e.step, e.met]), ink.quiet, 1);
    run.plot = panel;
    for (const e of data.evaluations) {
      context.beginPath();
      context.arc(panel.across(e.step), panel.up(e.met), e.step === run.chosen ? 6 : 3.5, 0, 2 * Math.PI);
      context.fillStyle = e.walking && e.running ? ink.command : e.walking ? ink.right : e.running ? ink.left : ink.quiet;
      context.fill();
    }
    panel.legend([[`${word("walks")} + ${word("runs")}`, ink.command], [word("walks"), ink.right], [word("runs"), ink.left]]);
    panel.bottom(word("steps"), million);
  }
}

function choose(step) {
  run.chosen = step;
  $("evaluation").value = String(step);
  control.send({ type: "evaluation", step });
  showRun();
}
$("criteria").addEventListener("click", (event) => {
  if (!run.plot || !run.data) return;
  const there = run.data.evaluations.filter((e) => e.controller);
  let best = null, nearest = 25;
  for (const e of there) {
    const distance = Math.abs(run.plot.across(e.step) - event.offsetX);
    if (distance < nearest) { nearest = distance; best = e; }
  }
  if (best) choose(best.step);
});
$("evaluation").addEventListener("change", () => { if ($("evaluation").value) choose(+$("evaluation").value); });
if (document.documentElement.dataset.mode === "run") {
  spoken.push(() => { $("evaluation").replaceChildren(); showRun(); });
  new ResizeObserver(drawRun).observe($("run"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => setTimeout(drawRun));
  lookAtRun();
}
