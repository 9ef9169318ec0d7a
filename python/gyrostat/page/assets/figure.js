// Figures: panels over a common axis, in the colours of the page. Point to read all lines, drag to zoom, double click to go
// back, click a name to hide its line. The data of a figure may lie in a file of its own that is loaded when it comes into view.
const figures = new Map();
const edge = { left: 58, right: 12, top: 8 };
const floats = text => new Float32Array(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
const escaped = text => text.replace(/[&<>"]/g, c => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const short = x => {
  if (x === undefined || Number.isNaN(x)) return "–";
  if (Math.abs(x) < 1e-300) return "0";
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(2) : String(Number(x.toPrecision(4)));
};
const tick = x => Math.abs(x) < 1e-300 ? "0" : Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential().replace("e+", "e") : String(Number(x.toPrecision(6)));

/// A stretch of an axis: from a value to the pixel and back, and round numbers in it.
const scaleOf = ([low, high], log, from, to) => {
  const f = log ? Math.log10 : x => x, a = f(low), b = f(high);
  return {
    px: x => from + (f(x) - a) / (b - a) * (to - from),
    value: px => { const v = a + (px - from) / (to - from) * (b - a); return log ? 10 ** v : v; },
    ticks: most => {
      if (log && b - a >= 1) {
        const step = Math.max(1, Math.ceil((b - a) / most)), out = [];
        for (let k = Math.ceil(a - 1e-9); k <= b + 1e-9; ++k) if (k % step === 0) out.push(10 ** k);
        return out;
      }
      const raw = (high - low) / most, size = 10 ** Math.floor(Math.log10(raw));
      const step = [1, 2, 5, 10].map(s => s * size).find(s => s >= raw * (1 - 1e-9)), out = [];
      for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; ++k) out.push(k * step);
      return out;
    },
  };
};
const padded = ([low, high], log) => {
  if (!(low <= high)) return log ? [0.1, 1] : [0, 1];
  if (low === high) return log ? [low / 2, high * 2] : [low - (Math.abs(low) || 1) * 0.1, high + (Math.abs(high) || 1) * 0.1];
  if (log) { const r = (high / low) ** 0.05; return [low / r, high * r]; }
  const r = 0.05 * (high - low);
  return [low - r, high + r];
};
const reach = (lines, key, inside) => {
  let low = Infinity, high = -Infinity;
  for (const line of lines) {
    for (let i = 0; i < line.x.length; ++i) {
      const v = line[key][i];
      if (v >= -Infinity && !(inside && (line.x[i] < inside[0] || line.x[i] > inside[1]))) { low = Math.min(low, v); high = Math.max(high, v); }
    }
  }
  return [low, high];
};

class Drawn {
  constructor(holder, data) {
    Object.assign(this, { holder, data, zoom: null, at: null });
    for (const panel of data.panels) for (const line of panel.lines) { line.x = floats(line.x); line.y = floats(line.y); line.off = false; }
    const all = data.panels.flatMap(p => p.lines);
    const whole = reach(all, "x", null);
    this.whole = data.x.range ?? (data.x.log ? padded(whole, true) : whole[0] < whole[1] ? whole : padded(whole, false));
    holder.textContent = "";
    this.boxes = data.panels.map((panel, row) => {
      const box = document.createElement("div");
      box.className = "panel";
      box.innerHTML = `<div class="head"></div><div class="plotted"></div>`;
      holder.append(box);
      box.lastChild.addEventListener("pointermove", e => this.move(e));
      box.lastChild.addEventListener("pointerleave", () => { this.at = null; this.read(); });
      box.lastChild.addEventListener("pointerdown", e => { if (e.pointerType === "mouse") { this.from = this.x(e); box.lastChild.setPointerCapture(e.pointerId); } });
      box.lastChild.addEventListener("pointerup", e => this.release(e));
      box.lastChild.addEventListener("dblclick", () => this.window(null));
      box.firstChild.addEventListener("click", e => {
        const key = e.target.closest(".key");
        if (key) { const line = panel.lines[key.dataset.line]; line.off = !line.off; this.render(); }
      });
      return box;
    });
    new ResizeObserver(() => { if (holder.clientWidth !== this.width) this.render(); }).observe(holder);
    this.render();
  }

  get range() { return this.zoom ?? this.whole; }
  window(range) { this.zoom = range; this.render(); }
  x(event) {
    const box = event.currentTarget.getBoundingClientRect();
    return this.across.value(Math.min(Math.max(event.clientX - box.left, edge.left), this.width - edge.right));
  }
  move(event) { this.at = this.x(event); this.read(); }
  release(event) {
    const to = this.x(event), from = this.from;
    this.from = undefined;
    if (from !== undefined && Math.abs(this.across.px(to) - this.across.px(from)) > 8) this.window([Math.min(from, to), Math.max(from, to)]);
    else this.read();
  }

  render() {
    this.width = this.holder.clientWidth;
    if (!this.width) return;
    const last = this.data.panels.length - 1;
    this.across = scaleOf(this.range, this.data.x.log, edge.left, this.width - edge.right);
    this.data.panels.forEach((panel, row) => this.panel(panel, this.boxes[row], row === last, last ? 118 : 230));
    this.read();
  }

  panel(panel, box, last, inner) {
    const height = edge.top + inner + (last ? 38 : 8), bottom = edge.top + inner;
    const seen = panel.lines.filter(line => !line.off);
    const values = reach(seen, "y", this.range);
    const levels = panel.levels.map(level => level[0]).filter(v => !panel.log || v > 0);
    const auto = this.zoom ? values : [Math.min(values[0], ...levels), Math.max(values[1], ...levels)];
    const up = scaleOf(this.zoom || !panel.range ? padded(auto, panel.log) : panel.range, panel.log, bottom, edge.top);
    const right = this.width - edge.right, across = this.across, parts = [];
    for (const x of across.ticks(this.width / 90)) {
      parts.push(`<path class="grid" d="M${across.px(x).toFixed(1)} ${edge.top}V${bottom}"/>`);
      if (last) parts.push(`<text text-anchor="middle" x="${across.px(x).toFixed(1)}" y="${bottom + 14}">${tick(x)}</text>`);
    }
    for (const y of up.ticks(inner / 32)) {
      parts.push(`<path class="grid" d="M${edge.left} ${up.px(y).toFixed(1)}H${right}"/>`);
      parts.push(`<text text-anchor="end" x="${edge.left - 5}" y="${(up.px(y) + 4).toFixed(1)}">${tick(y)}</text>`);
    }
    if (last) parts.push(`<text text-anchor="middle" x="${(edge.left + right) / 2}" y="${bottom + 32}">${escaped(this.data.x.title)}</text>`);
    this.data.marks.forEach(([x, label], k) => {
      if (x < this.range[0] || x > this.range[1]) return;
      const at = across.px(x), left = at > 0.8 * this.width;
      parts.push(`<path class="mark" d="M${at.toFixed(1)} ${edge.top}V${bottom}"/>`);
      if (panel === this.data.panels[0]) parts.push(`<text class="mark" text-anchor="${left ? "end" : "start"}" x="${(at + (left ? -3 : 3)).toFixed(1)}" y="${edge.top + 9 + 11 * (k % 2)}">${escaped(label)}</text>`);
    });
    for (const [y, label] of panel.levels) {
      const at = up.px(y);
      if (!(at >= edge.top && at <= bottom)) continue;
      parts.push(`<path class="level" d="M${edge.left} ${at.toFixed(1)}H${right}"/><text text-anchor="end" x="${right - 2}" y="${(at - 4).toFixed(1)}">${escaped(label)}</text>`);
    }
    const clip = `clip${Drawn.count = (Drawn.count ?? 0) + 1}`;
    const lines = seen.map(line => this.line(line, up)).join("");
    box.querySelector(".plotted").innerHTML = `<svg width="${this.width}" height="${height}" viewBox="0 0 ${this.width} ${height}" role="img" aria-label="${escaped(panel.title)}">`
      + `<clipPath id="${clip}"><rect x="${edge.left}" y="${edge.top - 2}" width="${right - edge.left}" height="${inner + 4}"/></clipPath>`
      + `${parts.join("")}<g clip-path="url(#${clip})">${lines}</g><rect class="chosen" y="${edge.top}" height="${inner}" width="0"/>`
      + `<path class="reading" d="M0 ${edge.top}V${bottom}" visibility="hidden"/></svg>`;
    const keys = panel.lines.map((line, i) => !line.name ? "" : `<span class="key${line.off ? " off" : ""}" data-line="${i}"><i style="background:var(--hue${line.hue})"></i>`
      + `<span>${escaped(line.name)}</span> <span class="value"></span></span>`);
    box.querySelector(".head").innerHTML = `<b>${escaped(panel.title)}</b>${keys.join("")}`;
  }

  line(line, up) {
    let path = "", pen = false, dots = "";
    for (let i = 0; i < line.x.length; ++i) {
      const x = this.across.px(line.x[i]), y = up.px(line.y[i]);
      if (!Number.isFinite(x) || !Number.isFinite(y)) { pen = false; continue; }
      const at = `${x.toFixed(1)} ${Math.min(Math.max(y, -1e4), 1e4).toFixed(1)}`;
      path += (pen ? "L" : "M") + at;
      pen = true;
      if (line.dots) dots += `<circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${line.bare ? 5 : 3}" fill="var(--hue${line.hue})"/>`;
    }
    return (line.bare ? "" : `<path class="line${line.dash ? " dash" : ""}" stroke="var(--hue${line.hue})" d="${path}"/>`) + dots;
  }

  /// Values at the place that is pointed at, and the stretch that is being chosen.
  read() {
    const at = this.at;
    this.data.panels.forEach((panel, row) => {
      const box = this.boxes[row], reading = box.querySelector(".reading"), chosen = box.querySelector(".chosen");
      reading.setAttribute("visibility", at === null ? "hidden" : "visible");
      if (at !== null) reading.setAttribute("transform", `translate(${this.across.px(at).toFixed(1)} 0)`);
      const ends = this.from === undefined || at === null ? [0, 0] : [this.across.px(this.from), this.across.px(at)];
      chosen.setAttribute("x", Math.min(...ends));
      chosen.setAttribute("width", Math.abs(ends[1] - ends[0]));
      box.querySelectorAll(".key").forEach(key => { key.lastChild.textContent = at === null ? "" : short(nearest(panel.lines[key.dataset.line], at)); });
    });
    const title = this.holder.parentElement.querySelector(".at");
    if (title) title.textContent = at === null ? "" : `at ${short(at)}`;
  }

  report() {
    return this.data.panels.map((panel, row) => ({
      title: panel.title,
      lines: panel.lines.length,
      points: panel.lines.reduce((n, line) => n + line.x.length, 0),
      spread: Math.max(...panel.lines.map(line => { const [low, high] = reach([line], "y", null); return high - low; })),
      drawn: this.boxes[row].querySelectorAll("path.line[d^=M], circle").length,
      shown: panel.lines.filter(line => !line.off).length,
      range: this.range,
    }));
  }
}
const nearest = (line, at) => {
  let best = Infinity, y;
  for (let i = 0; i < line.x.length; ++i) {
    const off = Math.abs(line.x[i] - at);
    if (off < best) { best = off; y = line.y[i]; }
  }
  return y;
};

window.gyrostat = {
  draw: (name, data) => {
    const figure = document.querySelector(`figure[data-name="${name}"]`);
    figures.set(name, new Drawn(figure.querySelector(".drawing"), data));
    figure.dataset.drawn = "yes";
  },
  load: figure => {
    if (!figure.dataset.src || figure.dataset.asked) return;
    figure.dataset.asked = "yes";
    const script = document.createElement("script");
    script.src = figure.dataset.src;
    script.onerror = () => { figure.querySelector(".drawing").textContent = `${figure.dataset.src} is missing beside this page: the figure needs it.`; };
    document.head.append(script);
  },
  zoom: (name, range) => figures.get(name).window(range),
  figures: () => Object.fromEntries([...figures].map(([name, drawn]) => [name, drawn.report()])),
};
const coming = new IntersectionObserver(entries => entries.forEach(entry => {
  if (entry.isIntersecting) { coming.unobserve(entry.target); gyrostat.load(entry.target); }
}), { rootMargin: "400px" });
document.querySelectorAll("figure[data-src]").forEach(figure => coming.observe(figure));
