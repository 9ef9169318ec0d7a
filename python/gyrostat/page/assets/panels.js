// Plots over time, one a panel: zoomed together, read together, with what happened marked in all of them.
const margin = { l: 66, r: 12, t: 4, b: 20 };
const config = { responsive: true, displayModeBar: false, doubleClick: "reset" };
const span = (() => {
  const ends = data.runs.map(r => [r.time(0), r.time(r.clock.count - 1)]);
  const t0 = Math.min(...ends.map(e => e[0])), t1 = Math.max(...ends.map(e => e[1]));
  return t1 > t0 ? [t0, t1] : [t0 - 0.5, t0 + 0.5];
})();
const panels = [];

const lineOf = line => {
  const width = { solid: 1.5, true: 5, lower: 0, upper: 0 }[line.style], tint = hue(line.color) + (line.style === "true" ? "50" : "");
  return {
    x: line.t, y: line.y, type: "scatter", mode: line.t.length < 2 ? "markers" : "lines", hoverinfo: "skip", showlegend: false,
    line: { color: tint, width, dash: line.color >= 8 && line.style === "solid" ? "dot" : "solid" },
    ...(line.style === "upper" ? { fill: "tonexty", fillcolor: hue(line.color) + "26" } : {}),
    visible: shown(line),
  };
};
const shown = line => data.runs[line.run].shown && !line.off;

/// Bands of faults and lines of events, in the colours of the theme.
const shapesOf = panel => {
  const shapes = [], bands = [], whole = { xref: "x", yref: "paper", y0: 0, y1: 1, layer: "below" };
  const faults = data.runs.flatMap(run => run.marks).filter(mark => mark.kind === "fault").length;
  for (const run of data.runs) {
    if (!run.shown) continue;
    for (const mark of run.marks) {
            if (mark.kind === "fault") {
        bands.push([mark.t, mark.end]);
        if (faults <= 60) shapes.push({ ...whole, type: "line", x0: mark.t, x1: mark.t, line: { color: `rgb(${color("fault")})`, width: 1.2 } });
      } else {
        shapes.push({ ...whole, type: "line", x0: mark.t, x1: mark.t, line: { color: color(mark.kind), width: 1.1, dash: "dot" } });
      }
    }
  }
  for (const [x0, x1] of joined(bands)) {
    shapes.push({ ...whole, type: "rect", x0, x1, fillcolor: `rgba(${color("fault")}, 0.08)`, line: { width: 0 } });
  }
  for (const [value] of panel.levels ?? []) {
    shapes.push({ type: "line", xref: "paper", x0: 0, x1: 1, y0: value, y1: value, line: { color: color("dim"), width: 1, dash: "longdash" } });
  }
  return shapes;
};
/// Stretches of time without what they have in common.
const joined = stretches => {
  const out = [];
  for (const [x0, x1] of stretches.sort((a, b) => a[0] - b[0])) {
    if (out.length && x0 <= out.at(-1)[1]) out.at(-1)[1] = Math.max(out.at(-1)[1], x1); else out.push([x0, x1]);
  }
  return out;
};
const annotationsOf = panel => [...(panel === panels[0] ? faultLabels() : []), ...(panel.levels ?? []).map(([value, label]) => ({
  xref: "paper", x: 1, xanchor: "right", y: panel.log ? Math.log10(value) : value, yanchor: panel.log || value <= 0 ? "bottom" : "top",
  text: `${label} ${short(value)}`, showarrow: false, font: { size: 10, color: color("dim") },
}))];
const faultLabels = () => {
  const faults = data.runs.length > 1 ? [] : data.runs[0].marks.filter(mark => mark.kind === "fault");
  return faults.length > 8 ? [] : faults.map((mark, i) => ({
    xref: "x", x: mark.t, xanchor: "left", yref: "paper", y: 1, yanchor: "top", yshift: -12 * (i % 4), text: mark.text, showarrow: false,
    font: { size: 10, color: `rgb(${color("fault")})` },
  }));
};

/// Range of values that shows what the lines do in a stretch of time, and those levels that are not far beyond it.
const rangeOf = (panel, [t0, t1]) => {
  const place = panel.log ? y => y > 0 ? Math.log10(y) : NaN : y => y;
  let low = Infinity, high = -Infinity;
  for (const line of panel.lines) {
    if (!shown(line)) continue;
    // from the last point before the stretch to the first after it: a line crosses the stretch between them
    for (let i = lastUntil(line.t, t0); i < line.t.length; ++i) {
      const y = place(line.y[i]);
      if (y < low) low = y;
      if (y > high) high = y;
      if (line.t[i] > t1) break;
    }
  }
  if (!(high >= low)) return panel.log ? [-3, 2] : [-1, 1];
  const [least, most] = panel.log ? [low - 1, high + 1] : [-3, 3].map(x => x * Math.max(Math.abs(low), Math.abs(high)));
  for (const y of (panel.levels ?? []).map(level => place(level[0]))) if (y >= least && y <= most) { low = Math.min(low, y); high = Math.max(high, y); }
  const pad = high > low ? 0.06 * (high - low) : panel.log ? 0.5 : Math.max(0.1 * Math.abs(high), 1e-12);
  return [low - pad, high + pad];
};
const layoutOf = panel => {
  const axis = { gridcolor: color("grid"), zerolinecolor: color("line"), linecolor: color("line"), tickfont: { size: 10 }, automargin: false };
  const range = panel.gd?.layout?.xaxis?.range.slice() ?? [...span];
  return {
    margin, dragmode: "zoom", hovermode: false, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { color: color("dim"), family: 'system-ui, "DejaVu Sans", sans-serif' }, shapes: shapesOf(panel), annotations: annotationsOf(panel),
    xaxis: { ...axis, range, ticksuffix: " s", nticks: 9 },
    yaxis: { ...axis, type: panel.log ? "log" : "linear", fixedrange: true, exponentformat: "power", nticks: 6,
             range: rangeOf(panel, range), ...panel.ticks },
  };
};

const addPanel = (panel, first) => {
  const box = document.createElement("div");
  box.className = "panel";
  box.innerHTML = `<div class="head"></div><div class="plot${first ? " first" : ""}"></div><div class="cursor hover"></div><div class="cursor now"></div>`;
  element("panels").append(box);
  const [head, gd, hover, now] = box.children;
  Object.assign(panel, { head, gd, hover, now });
  const title = document.createElement("span");
  title.innerHTML = `<b></b> <span class="dim"></span>`;
  title.firstChild.textContent = panel.title + (panel.unit ? `, ${panel.unit}` : "");
  title.lastChild.textContent = panel.note ?? "";
  head.append(title);
  panel.keys = [];
  for (const line of panel.lines) {
    let key = panel.keys.find(k => k.run === line.run && k.label === line.label);
    if (!key) {
      const mark = document.createElement("span");
      mark.className = "key";
      mark.title = [data.runs[line.run].label, "click to hide or show"].filter(x => x).join(": ");
      mark.innerHTML = `<i></i><span></span> <span></span><span class="dim"></span>`;
      mark.children[1].textContent = line.label;
      key = { run: line.run, label: line.label, mark, color: line.color, lines: {} };
      mark.onclick = () => { for (const l of Object.values(key.lines)) l.off = !l.off; refresh(); };
      panel.keys.push(key);
    }
    key.lines[line.style] = line;
  }
  panel.keys.sort((a, b) => a.run - b.run || a.color - b.color);
  head.append(...panel.keys.map(key => key.mark));
  panels.push(panel);
};

/// The strip of everything that happened, a row a kind.
const strip = () => {
  const rows = [];
  data.runs.forEach((run, r) => run.rows.forEach(row => {
    const same = rows.find(other => other.name === row.name && other.count === row.count && other.t.every((t, i) => t === row.t[i]));
    if (same) same.of.push(r); else rows.push({ ...row, of: [r] });
  }));
  const ticks = { tickvals: rows.map((_, i) => i), ticktext: rows.map(row => row.count > 1 ? `${row.count} ×` : ""), range: [rows.length - 0.5, -0.5], autorange: false, zeroline: false };
  return { name: "events", title: "What happened", unit: "", lines: [], rows, ticks };
};
const tracesOf = panel => panel.rows ? panel.rows.map((row, i) => ({
  x: row.t, y: row.t.map(() => i), type: "scatter", mode: "markers", hoverinfo: "skip", showlegend: false, visible: row.of.some(r => data.runs[r].shown),
  marker: { symbol: "line-ns-open", size: 13, color: row.kind === "fault" ? `rgb(${color("fault")})` : color(row.kind), line: { width: 1.5 } },
})) : panel.lines.map(lineOf);

const plotPanels = () => {
  if (typeof Plotly === "undefined") {
    element("panels").textContent = "{{plotly_file}} is missing beside this page: the plots need it.";
    return;
  }
  const events = strip();
  data.panels.forEach((panel, i) => addPanel(panel, i === 0));
  if (events.rows.length) {
    addPanel(events, false);
    events.gd.style.height = `${26 * Math.min(events.rows.length, 30) + 30}px`;
    events.rows.forEach(row => {
      const key = document.createElement("span");
      key.className = "key";
      key.innerHTML = `<i></i><span></span>`;
      key.lastChild.textContent = [row.of.length < data.runs.length ? row.of.map(r => data.runs[r].short).join(" and ") : "", row.name].filter(x => x).join(": ") + (row.count > row.t.length ? ` (${row.t.length} of ${row.count} drawn)` : "");
      row.key = key;
      events.head.append(key);
    });
  }
  for (const panel of panels) {
    Plotly.newPlot(panel.gd, tracesOf(panel), layoutOf(panel), config);
    panel.gd.on("plotly_relayout", change => follow(panel, change));
    panel.gd.addEventListener("mousemove", event => hoverAt(timeAt(panel, event.clientX)));
    panel.gd.addEventListener("mouseleave", () => hoverAt(null));
    let down = null;
    panel.gd.addEventListener("mousedown", event => { down = [event.clientX, event.clientY]; }, true);
    window.addEventListener("mouseup", event => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 3) { const t = timeAt(panel, event.clientX); if (t !== null) seek(t); }
      down = null;
    }, true);
  }
  keys();
};

/// Zoom of one panel goes to all others.
let following = false;
const follow = (source, change) => {
  if (following || !Object.keys(change).some(k => k.startsWith("xaxis"))) return;
  following = true;
  const range = change["xaxis.autorange"] ? [...span] : source.gd._fullLayout.xaxis.range.slice();
  Promise.all(panels.map(p => Plotly.relayout(p.gd, {
    "xaxis.range": range.slice(), "xaxis.autorange": false, ...(p.rows ? {} : { "yaxis.range": rangeOf(p, range) }),
  }))).then(() => { following = false; cursors(); });
};

const frameOf = panel => {
  const { _size: size, xaxis } = panel.gd._fullLayout;
  return { left: size.l, width: size.w, range: xaxis.range.map(Number) };
};
const timeAt = (panel, x) => {
  const { left, width, range } = frameOf(panel), part = (x - panel.gd.getBoundingClientRect().left - left) / width;
  return part < 0 || part > 1 ? null : range[0] + part * (range[1] - range[0]);
};
const placeCursor = (panel, cursor, t) => {
  const { left, width, range } = frameOf(panel), part = (t - range[0]) / (range[1] - range[0]);
  const visible = t !== null && part >= 0 && part <= 1;
  cursor.style.display = visible ? "block" : "none";
  if (!visible) return;
  cursor.style.left = `${left + part * width}px`;
  cursor.style.top = `${panel.gd.offsetTop + margin.t}px`;
  cursor.style.height = `${panel.gd.offsetHeight - margin.t - margin.b}px`;
};

let hovered = null;
const hoverAt = t => { hovered = t; cursors(); };
/// Cursors of the shown and the pointed instant, and the values of all lines there.
const cursors = () => {
  const t = hovered ?? player.t;
  for (const panel of panels) {
    placeCursor(panel, panel.now, player.t);
    placeCursor(panel, panel.hover, hovered);
    for (const { mark, lines } of panel.keys) {
      const [value, truth] = ["solid", "true"].map(style => lines[style] && valueAt(lines[style], t));
      mark.children[2].textContent = value ?? "";
      mark.children[3].textContent = truth === undefined ? "" : ` true ${truth}`;
    }
    if (panel.rows) panel.head.firstChild.lastChild.textContent = happened(t);
  }
};
const valueAt = (line, t) => t < line.t[0] || t > line.t.at(-1) + 1e-9 ? "" : short(line.y[nearest(line.t, t)]);
const nearest = (list, t) => {
  const i = lastUntil(list, t);
  return i + 1 < list.length && list[i + 1] - t < t - list[i] ? i + 1 : i;
};
/// What is marked near an instant, in words.
const happened = t => {
  const range = frameOf(panels[0]).range, near = (range[1] - range[0]) / 100;
  let best = null;
  for (const run of data.runs) for (const mark of run.marks) if (Math.abs(mark.t - t) < near && (!best || Math.abs(mark.t - t) < Math.abs(best.t - t))) best = mark;
  return best ? `${best.t.toFixed(2)} s: ${best.text}` : "";
};

const keys = () => {
  for (const run of data.runs) if (run.chip) run.chip.firstChild.style.background = hue(run.color);
  for (const panel of panels) {
    for (const { mark, color, run, lines } of panel.keys) {
      mark.firstChild.style.background = hue(color);
      mark.style.display = data.runs[run].shown ? "" : "none";
      mark.classList.toggle("off", Object.values(lines).some(l => l.off));
    }
    for (const row of panel.rows ?? []) row.key.firstChild.style.background = row.kind === "fault" ? `rgb(${color("fault")})` : color(row.kind);
  }
};
/// Draw everything again: another theme, other lines shown.
const refresh = () => {
  panels.forEach(panel => Plotly.react(panel.gd, tracesOf(panel), layoutOf(panel), config));
  keys();
  cursors();
  draw();
};
