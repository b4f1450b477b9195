// Samples of one biped in time, and its pose between two of them.
const COLUMNS = ["x", "z", "theta", "phi0", "h0", "d0", "w0", "fx0", "fz0", "phi1", "h1", "d1", "w1", "fx1", "fz1", "omega",
  "kinetic", "gravitational", "elastic", "speed", "rEnergy", "rVelocity", "rForward", "rAlive", "rLeg", "rFriction", "rWork",
  "pushX", "pushZ"];

class Track {
  // `own`: columns of the reward terms of one's own.
  constructor(own = []) {
    this.time = [];
    this.own = own;
    this.names = [...COLUMNS, ...own];
    this.column = Object.fromEntries(this.names.map((name) => [name, []]));
    this.phases = [];  // [kind, begin, end]
    this.figures = []; // {time, gait, speed, froude, cost}
  }
  clear() {
    this.time.length = 0;
    for (const name of this.names) this.column[name].length = 0;
    this.phases = [];
    this.figures.length = 0;
  }
  // Forgets what is older than `seconds`, now and then.
  trim(seconds) {
    const first = this.time[this.time.length - 1] - seconds;
    if (!(this.time[0] < first - 0.25 * seconds)) return;
    const count = this.before(first);
    this.time.splice(0, count);
    for (const name of this.names) this.column[name].splice(0, count);
    const old = this.figures.findIndex((f) => f.time >= first);
    if (old > 0) this.figures.splice(0, old);
  }
  // Number of samples before `time`.
  before(time) {
    let low = 0, high = this.time.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < time) low = middle + 1; else high = middle;
    }
    return low;
  }
  get last() { return this.time.length ? this.time[this.time.length - 1] : 0; }
  pose(time) {
    if (!this.time.length) return null;
    const next = Math.min(this.before(time), this.time.length - 1);
    const previous = Math.max(next - 1, 0);
    const span = this.time[next] - this.time[previous];
    const share = span > 0 ? Math.min(Math.max((time - this.time[previous]) / span, 0), 1) : 1;
    const pose = {};
    for (const name of COLUMNS) {
      const values = this.column[name];
      pose[name] = values[previous] + (values[next] - values[previous]) * share;
    }
    return pose;
  }
  // The figures in force at `time`.
  figuresAt(time) {
    let low = 0, high = this.figures.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.figures[middle].time <= time + 1e-6) low = middle + 1; else high = middle;
    }
    return this.figures[low - 1];
  }
}
