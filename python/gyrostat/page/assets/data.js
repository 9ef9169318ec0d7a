// The data of the page, decoded; instants and samples.
const data = JSON.parse(document.getElementById("data").textContent);
const element = id => document.getElementById(id);
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const floats = text => new Float32Array(bytes(text));
const indices = (text, samples) => samples <= 65536 ? new Uint16Array(bytes(text)) : new Uint32Array(bytes(text));

/// Instant of sample k of a run.
const clockOf = ({ start, step, count, end, times }) => {
  if (times) {
    const t = new Float64Array(bytes(times));
    return k => t[k];
  }
  return k => k === count - 1 ? end : start + step * k;
};

/// Position of the last entry of a rising list that is not after t; 0 if all are.
const lastUntil = (list, t) => {
  let low = 0, high = list.length;
  while (low < high - 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= t) low = middle; else high = middle;
  }
  return low;
};

/// What the names of all runs begin with, up to a sign between words.
const common = (() => {
  const labels = data.runs.map(r => r.label);
  let n = 0;
  while (labels.length > 1 && labels[0][n] !== undefined && labels.every(l => l[n] === labels[0][n])) ++n;
  return n && Math.max(...["=", "/", " "].map(sign => labels[0].lastIndexOf(sign, n - 1))) + 1;
})();
for (const run of data.runs) {
  run.short = data.runs.length > 1 ? run.label.slice(common) : "";
  run.time = clockOf(run.clock);
  run.shown = true;
  const f = run.frames;
  f.k = indices(f.k, run.clock.count);
  f.t = Float64Array.from(f.k, run.time);
  for (const name of ["q", "q_ref", "u", "true", "estimate"]) if (f[name]) f[name] = floats(f[name]);
  for (const arrow of f.arrows) {
    arrow.v = floats(arrow.v);
    arrow.most = 0;
    for (let i = 0; i < arrow.v.length; i += 3) arrow.most = Math.max(arrow.most, Math.hypot(arrow.v[i], arrow.v[i + 1], arrow.v[i + 2]));
  }
}
for (const panel of data.panels) {
  for (const line of panel.lines) {
    const run = data.runs[line.run];
    line.t = Float64Array.from(indices(line.k, run.clock.count), run.time);
    line.y = floats(line.y);
  }
}

const color = name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
/// A number in four digits.
const short = x => {
  if (x === undefined || Number.isNaN(x)) return "–";
  if (x === 0) return "0";
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(2) : String(Number(x.toPrecision(4)));
};
