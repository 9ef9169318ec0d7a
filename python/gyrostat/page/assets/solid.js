// Sets of torques as solids that turn under the pointer: the first as glass, the last one filled, the ball that each holds as a ring.
const solid = (() => {
  const holder = document.getElementById("solid");
  if (!holder) return null;
  const data = JSON.parse(document.getElementById("solid-data").textContent);
  const size = Math.max(...data.sets.flatMap(set => set.faces.flat().map(p => Math.hypot(...p))), 1e-300);
  const view = { turn: -0.6, tilt: 0.45 };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  /// To the right, upwards and towards the eye, in the axes of the body.
  const frame = () => {
    const [c, s, ct, st] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.tilt), Math.sin(view.tilt)];
    return [[c, s, 0], [-s * st, c * st, ct], [s * ct, -c * ct, st]];
  };
  const render = () => {
    const width = holder.clientWidth, height = Math.min(0.85 * width, 460), scale = 0.42 * Math.min(width, height) / size;
    const [right, up, eye] = frame();
    const at = p => [width / 2 + scale * dot(p, right), height / 2 - scale * dot(p, up)];
    const text = p => at(p).map(v => v.toFixed(1)).join(",");
    const faces = data.sets.flatMap((set, k) => set.faces.map((face, j) => {
      const middle = [0, 1, 2].map(i => face.reduce((sum, p) => sum + p[i], 0) / face.length);
      return { k, set, face, depth: dot(middle, eye), facing: dot(set.normals[j], eye) };
    }));
    const glass = face => face.k === 0 && data.sets.length > 1;
    const order = face => glass(face) ? (face.facing < 0 ? -1 : 1) : 0;
    faces.sort((a, b) => order(a) - order(b) || a.depth - b.depth);
    const parts = [], reach = 1.12 * size;
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis, i) => {
      const tip = axis.map(v => v * reach), [x, y] = at(tip);
      return `<path class="grid" style="stroke:var(--dim)" d="M${text([0, 0, 0])}L${text(tip)}"/><text x="${x.toFixed(1)}" y="${(y - 4).toFixed(1)}">${"xyz"[i]}</text>`;
    });
    parts.push(...axes);
    for (const face of faces) {
      const light = 0.25 + 0.5 * Math.max(face.facing, 0);
      if (!glass(face) && face.facing < -1e-9) continue;
      parts.push(`<polygon data-set="${face.k}" points="${face.face.map(text).join(" ")}" fill="var(--hue${face.set.hue})" fill-opacity="${glass(face) ? 0.05 : light.toFixed(2)}"`
        + ` stroke="var(--hue${face.set.hue})" stroke-opacity="${glass(face) ? 0.35 : 0.9}" stroke-width="${glass(face) ? 0.8 : 1}" stroke-linejoin="round"/>`);
    }
    for (const set of data.sets) {
      if (set.ball > 0) parts.push(`<circle cx="${width / 2}" cy="${height / 2}" r="${(scale * set.ball).toFixed(1)}" fill="none" stroke="var(--hue${set.hue})" stroke-width="1.5" stroke-dasharray="5 4"/>`);
    }
    if (data.demand) {
      const [x, y] = at(data.demand);
      parts.push(`<path class="line" stroke="var(--hue1)" d="M${text([0, 0, 0])}L${text(data.demand)}"/><circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="4" fill="var(--hue1)"/>`
        + `<text x="${(x + 7).toFixed(1)}" y="${(y + 4).toFixed(1)}">demand</text>`);
    }
    holder.innerHTML = `<svg width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" role="img" aria-label="Torques within reach">${parts.join("")}</svg>`;
  };
  let from = null;
  holder.addEventListener("pointerdown", e => { from = [e.clientX, e.clientY]; holder.setPointerCapture(e.pointerId); });
  holder.addEventListener("pointermove", e => {
    if (!from) return;
    view.turn += 0.01 * (e.clientX - from[0]);
    view.tilt = Math.min(Math.max(view.tilt + 0.01 * (e.clientY - from[1]), -1.57), 1.57);
    from = [e.clientX, e.clientY];
    render();
  });
  holder.addEventListener("pointerup", () => { from = null; });
  holder.addEventListener("dblclick", () => { Object.assign(view, { turn: -0.6, tilt: 0.45 }); render(); });
  new ResizeObserver(render).observe(holder);
  render();
  return {
    frame,
    report: () => data.sets.map((set, k) => ({
      name: set.name, faces: set.faces.length, ball: set.ball, drawn: holder.querySelectorAll(`polygon[data-set="${k}"]`).length,
    })),
  };
})();
if (solid) gyrostat.solid = () => ({ sets: solid.report(), frame: solid.frame() });
