// A chart's panel: labelled axes with units, and a scale that does not twitch.
class Scale {
  constructor() { this.low = 0; this.high = 1; this.known = false; }
  // Grows at once, shrinks only when much of it is empty.
  hold(low, high, least) {
    if (!(low <= high)) return;
    if (high - low < least && low >= 0) high = low + least;
    if (high - low < least) { const middle = (low + high) / 2; low = middle - least / 2; high = middle + least / 2; }
    const roomy = this.known && low >= this.low && high <= this.high && high - low > 0.35 * (this.high - this.low);
    if (roomy) return;
    const step = niceStep((high - low) / 3);
    this.low = Math.floor(low / step + 1e-9) * step;
    this.high = Math.ceil(high / step - 1e-9) * step;
    this.known = true;
  }
  ticks() {
    const step = niceStep((this.high - this.low) / 3), ticks = [];
    for (let k = Math.ceil(this.low / step - 1e-6); k * step <= this.high + 1e-6 * step; k++) ticks.push(k * step);
    return { ticks, digits: Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9))) };
  }
}
function niceStep(rough) {
  const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1e-12)));
  for (const factor of [1, 2, 5, 10]) if (factor * power >= rough * 0.999) return factor * power;
  return 10 * power;
}

class Panel {
  constructor(context, area, x, y) { Object.assign(this, { context, area, x, y }); }
  across(value) { return this.area.left + (value - this.x.low) / (this.x.high - this.x.low) * this.area.width; }
  up(value) { return this.area.top + this.area.height - (value - this.y.low) / (this.y.high - this.y.low) * this.area.height; }
  frame(title) {
    const { context, area } = this, { ticks, digits } = this.y.ticks();
    context.font = "10px system-ui, sans-serif";
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const tick of ticks) {
      const y = this.up(tick);
      strokeLine(context, [[area.left, y], [area.left + area.width, y]], ink.faint, 0.7);
      context.fillStyle = ink.quiet;
      context.fillText(tick.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1"), area.left - 5, y);
    }
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = ink.text;
    context.fillText(title, area.left, area.top - 5);
  }
  legend(entries) {
    const { context, area } = this;
    context.font = "10px system-ui, sans-serif";
    context.textAlign = "left";
    let x = area.left + area.width;
    for (const [name, colour, dash] of [...entries].reverse()) {
      x -= context.measureText(name).width;
      context.fillStyle = ink.quiet;
      context.fillText(name, x, area.top - 5);
      x -= 17;
      context.setLineDash(dash || []);
      strokeLine(context, [[x, area.top - 8.5], [x + 14, area.top - 8.5]], colour, 2);
      context.setLineDash([]);
      x -= 8;
    }
  }
  curve(points, colour, width, dash) {
    const { context, area } = this;
    context.save();
    context.beginPath();
    context.rect(area.left, area.top - 1, area.width, area.height + 2);
    context.clip();
    context.beginPath();
    let pen = false;
    for (const [x, y] of points) {
      if (y === null || y === undefined || !isFinite(y)) { pen = false; continue; }
      const px = this.across(x), py = this.up(y);
      if (pen) context.lineTo(px, py); else context.moveTo(px, py);
      pen = true;
    }
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dash || []);
    context.stroke();
    context.restore();
  }
  // Whole and round numbers along the bottom.
  bottom(title, format) {
    const { context, area } = this, step = niceStep((this.x.high - this.x.low) / Math.max(area.width / 70, 2));
    context.font = "10px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillStyle = ink.quiet;
    for (let k = Math.ceil(this.x.low / step - 1e-9); k * step <= this.x.high + 1e-9 * step; k++) {
      const x = this.across(k * step);
      strokeLine(context, [[x, area.top + area.height], [x, area.top + area.height + 4]], ink.quiet, 1);
      context.fillText(format ? format(k * step) : String(+(k * step).toFixed(6)), x, area.top + area.height + 15);
    }
    context.fillStyle = ink.text;
    context.font = "11px system-ui, sans-serif";
    context.fillText(title, area.left + area.width / 2, area.top + area.height + 29);
  }
}
