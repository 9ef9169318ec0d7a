// The body in three dimensions, on a canvas: faces, wheels and arrows sorted by depth, seen from the inertial frame.
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const unit = a => { const l = Math.hypot(...a); return l > 0 ? a.map(x => x / l) : a; };
/// v_N = q_NB v_B, scalar first.
const turn = (q, v) => {
  const u = [q[1], q[2], q[3]], t = cross(u, v).map(x => 2 * x), c = cross(u, t);
  return [v[0] + q[0] * t[0] + c[0], v[1] + q[0] * t[1] + c[1], v[2] + q[0] * t[2] + c[2]];
};
/// Between two quaternions, the short way.
const blend = (list, i, part) => {
  const a = list.subarray(4 * i, 4 * i + 4);
  if (part === 0) return Array.from(a);
  const b = list.subarray(4 * i + 4, 4 * i + 8), s = a[0] * b[0] + dot(a.subarray(1), b.subarray(1)) < 0 ? -1 : 1;
  const q = [0, 1, 2, 3].map(n => (1 - part) * a[n] + s * part * b[n]), l = Math.hypot(...q);
  return q.map(x => x / l);
};

const canvas = element("body"), pen = canvas.getContext("2d");
const home = { az: 0.75, el: 0.42, zoom: 1 };
const camera = { ...home };
const reach = 2.15;  // of axes and arrows, in half edges of the longest side of the box

const palette = [[0, [214, 69, 65]], [0.5, [233, 180, 76]], [0.9, [82, 170, 138]], [1, [38, 148, 136]]];
/// From red, nothing left, to green, healthy; grey when unknown.
const health = e => {
  if (e === undefined || Number.isNaN(e)) return "rgb(140, 150, 160)";
  const x = Math.min(Math.max(e, 0), 1), n = palette.findIndex(p => p[0] >= x), [b, B] = palette[n], [a, A] = palette[Math.max(n - 1, 0)];
  const part = b > a ? (x - a) / (b - a) : 0;
  return `rgb(${A.map((v, i) => Math.round(v + part * (B[i] - v))).join(", ")})`;
};

/// Directions across an axis.
const across = axis => {
  const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  return [u, cross(axis, u)];
};
const ring = (at, axis, radius, n = 28) => {
  const [u, w] = across(axis);
  return Array.from({ length: n }, (_, i) => {
    const a = 2 * Math.PI * i / n;
    return add(add(at, u, radius * Math.cos(a)), w, radius * Math.sin(a));
  });
};

/// What is seen from where, in one tile of the canvas.
const view = (x0, y0, width, height) => {
  const ca = Math.cos(camera.az), sa = Math.sin(camera.az), ce = Math.cos(camera.el), se = Math.sin(camera.el);
  const scale = camera.zoom * Math.min(width, height) / (2 * reach + 0.9), far = 9;
  const eye = v => { const x = -sa * v[0] + ca * v[1], y = ca * v[0] + sa * v[1]; return [x, ce * v[2] - se * y, ce * y + se * v[2]]; };
  return {
    depth: v => eye(v)[2],
    spot: v => { const e = eye(v), k = scale * far / (far - e[2]); return [x0 + width / 2 + e[0] * k, y0 + height / 2 - e[1] * k]; },
    toEye: unit([ca * ce, sa * ce, se]),
  };
};

const path = (points, close) => {
  pen.beginPath();
  points.forEach((p, i) => i ? pen.lineTo(...p) : pen.moveTo(...p));
  if (close) pen.closePath();
};
const stroke = (points, style, width, dash = []) => {
  pen.setLineDash(dash);
  pen.strokeStyle = style;
  pen.lineWidth = width;
  path(points, false);
  pen.stroke();
  pen.setLineDash([]);
};
const fill = (points, style, edge) => {
  path(points, true);
  pen.fillStyle = style;
  pen.fill();
  if (edge) { pen.strokeStyle = edge; pen.lineWidth = 1; pen.stroke(); }
};
const write = (text, [x, y], style, size = 12, align = "center") => {
  pen.font = `600 ${size}px system-ui, "DejaVu Sans", sans-serif`;
  pen.textAlign = align;
  pen.textBaseline = "middle";
  pen.fillStyle = style;
  pen.fillText(text, x, y);
};
/// A straight arrow on the canvas, from a to b.
const arrow = (a, b, style, width) => {
  const d = [b[0] - a[0], b[1] - a[1]], l = Math.hypot(...d);
  if (l < 2) return;
  const head = Math.min(4 * width, l), n = [d[0] / l, d[1] / l], root = [b[0] - head * n[0], b[1] - head * n[1]];
  stroke([a, root], style, width);
  fill([b, [root[0] - 0.45 * head * n[1], root[1] + 0.45 * head * n[0]], [root[0] + 0.45 * head * n[1], root[1] - 0.45 * head * n[0]]], style);
};

const drawn = [];  // by run: what the last drawing turned, and how
const axisColors = { light: ["#d6336c", "#2f9e44", "#1c7ed6"], dark: ["#ff6b9a", "#51cf66", "#4dabf7"] };

/// State of a run at an instant: its frame, and attitudes between frames.
const stateAt = (run, t) => {
  const f = run.frames, i = lastUntil(f.t, t), next = Math.min(i + 1, f.t.length - 1);
  const part = next > i ? Math.min(Math.max((t - f.t[i]) / (f.t[next] - f.t[i]), 0), 1) : 0;
  const q = list => list && blend(list, part === 1 ? next : i, part === 1 ? 0 : part);
  return { i: part === 1 ? next : i, q: q(f.q), q_ref: q(f.q_ref) };
};

const drawRun = (run, number, t, tile, labelled) => {
  const see = view(...tile), state = stateAt(run, t), q = state.q, place = v => see.spot(turn(q, v));
  const things = [], put = (at, draw) => things.push([see.depth(at), draw]), axes = axisColors[theme()];
  const sky = color("sky"), ink = color("ink"), command = color("command");
  const hueOfFace = color("face"), light = parseFloat(color("light")), shade = parseFloat(color("shade"));
  const value = (name, i) => run.frames[name] ? run.frames[name][state.i * run.actuators.length + i] : undefined;

  for (const axis of [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) {
    const points = ring([0, 0, 0], axis, reach, 64).map(see.spot);
    stroke([...points, points[0]], sky, 0.8);
  }
  const columns = [0, 1, 2].map(c => run.box.map(row => row[c]));
  const sun = unit(add(see.toEye, [0.2, -0.5, 0.9]));
  for (let a = 0; a < 3; ++a) {
    const u = columns[(a + 1) % 3], w = columns[(a + 2) % 3];
    for (const side of [-1, 1]) {
      const middle = columns[a].map(x => side * x), normal = unit(turn(q, middle)), centre = turn(q, middle);
      if (dot(normal, add(see.toEye.map(x => 9 * x), centre, -1)) <= 0) continue;
      const corners = [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([p, r]) => place(add(add(middle, u, p), w, r)));
      const bright = light + shade * (0.9 * dot(normal, sun) - 0.6);
      put(centre, () => fill(corners, `hsl(${hueOfFace}, ${bright}%)`, color("dim")));
    }
  }
  const turned = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(v => turn(q, v));
  drawn[number] = { turned, t, frame: state.i, sample: run.frames.k[state.i] };
  turned.forEach((v, i) => {
    const start = v.map(x => x * Math.hypot(...columns[i]) * 0.98), end = v.map(x => 0.86 * reach * x);
    put(add(start, end).map(x => x / 2), () => arrow(see.spot(start), see.spot(end), axes[i], 2.2));
    put(end.map(x => 1.05 * x), () => write("xyz"[i], see.spot(v.map(x => 0.93 * reach * x)), axes[i], 13));
  });
  run.actuators.forEach((actuator, i) => {
    const axis = actuator.axis, at = actuator.at, ratio = value("u", i) / (run.most_u[i] || 1), centre = turn(q, at);
    if (!axis.some(x => x)) return;
    const outer = health(value("true", i)), inner = health(value("estimate", i) ?? value("true", i));
    const out = add(at, axis, 0.32), towards = dot(turn(q, axis), add(see.toEye.map(x => 9 * x), centre, -1)) > 0 ? 1 : -1;
    if (actuator.kind === "wheel") {
      const front = add(at, axis, 0.06 * towards), back = add(at, axis, -0.06 * towards);
      put(centre, () => {
        fill(ring(back, axis, 0.27).map(place), outer, ink);
        const a = ring(back, axis, 0.27), b = ring(front, axis, 0.27);
        a.forEach((p, n) => fill([p, a[(n + 1) % a.length], b[(n + 1) % b.length], b[n]].map(place), outer));
        fill(b.map(place), outer, ink);
        fill(ring(front, axis, 0.17).map(place), inner, ink);
        write(String(i), place(front), "#fff", 12);
      });
    } else {
      put(centre, () => {
        stroke([place(add(at, axis, -0.14)), place(add(at, axis, 0.2))], ink, 4);
        stroke([place(add(at, axis, -0.14)), place(add(at, axis, 0.2))], outer, 2.5);
        fill(ring(at, axis, 0.15, 20).map(place), outer, ink);
        fill(ring(at, axis, 0.1, 20).map(place), inner, ink);
        write(String(i), place(at), "#fff", 11);
      });
    }
    if (ratio) {
      const length = 0.55 * Math.min(Math.abs(ratio), 1), [a, b] = ratio > 0 ? [at, add(at, axis, 0.1 + length)] : [add(at, axis, 0.1 + length), add(at, axis, 0.1)];
      put(turn(q, out), () => arrow(place(a), place(b), command, 2));
    }
  });
  things.sort((a, b) => a[0] - b[0]).forEach(([, draw]) => draw());
  if (state.q_ref) {
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((v, i) => {
      const end = turn(state.q_ref, v).map(x => reach * x);
      stroke([see.spot([0, 0, 0]), see.spot(end)], axes[i], 1.2, [5, 4]);
      write(`${"xyz"[i]}ᵣ`, see.spot(end.map(x => 1.06 * x)), axes[i], 12);
    });
  }
  for (const a of run.frames.arrows) {
    const v = Array.from(a.v.subarray(3 * state.i, 3 * state.i + 3));
    if (a.most > 0) arrow(see.spot([0, 0, 0]), place(v.map(x => x / a.most * 0.8 * reach)), color(a.name), 2.6);
  }
  const [x0, y0, , height] = tile, corner = [x0 + 34, y0 + height - 34], centre = see.spot([0, 0, 0]);
  [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((v, i) => {
    const p = see.spot(v), l = 24 / (tile[3] / (2 * reach + 0.9)) / camera.zoom, end = [corner[0] + (p[0] - centre[0]) * l, corner[1] + (p[1] - centre[1]) * l];
    stroke([corner, end], axes[i], 1.2);
    write("xyz"[i], [end[0] + (end[0] - corner[0]) * 0.3, end[1] + (end[1] - corner[1]) * 0.3], axes[i], 10);
  });
  write("N", [corner[0] - 8, corner[1] + 10], color("dim"), 11);
  if (labelled) write(run.short, [x0 + 10, y0 + 16], hue(run.color), 13, "left");
};
