// The clock of the page: slider, play, speed; what is shown follows it.
const flown = data.runs.filter(run => run.box && run.frames.q);
const master = data.runs.reduce((a, b) => b.frames.t.at(-1) > a.frames.t.at(-1) ? b : a);
const player = { t: master.frames.t[0], playing: false, speed: 1, last: 0 };
const most_tiles = 6;

const draw = () => {
  const visible = flown.filter(run => run.shown).slice(0, most_tiles), ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!flown.length || !width) return;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const columns = Math.min(visible.length, Math.ceil(Math.sqrt(visible.length * width / height))) || 1, lines = Math.ceil(visible.length / columns);
  visible.forEach((run, i) => {
    const tile = [i % columns * width / columns, Math.floor(i / columns) * height / lines, width / columns, height / lines];
    pen.save();
    pen.beginPath();
    pen.rect(...tile);
    pen.clip();
    drawRun(run, data.runs.indexOf(run), player.t, tile, data.runs.length > 1);
    pen.restore();
  });
};

const legend = () => {
  const run = flown.find(r => r.shown);
  if (!run) return;
  const at = stateAt(run, player.t).i;
  element("legend").replaceChildren(...[
    ...run.frames.arrows.filter(a => a.most > 0).map(a => [`var(--${a.name})`, `${a.label} ${short(Math.hypot(...a.v.subarray(3 * at, 3 * at + 3)))} ${a.unit}`]),
    ["var(--command)", "commands"], ["transparent", "solid: body axes"], ...(run.frames.q_ref ? [["transparent", "dashed: reference"]] : []),
    ...(run.frames.true ? [["transparent", `rim: true effectiveness${run.frames.estimate ? ", centre: estimated" : ""}`]] : []),
  ].map(([background, text]) => {
    const span = document.createElement("span"), mark = document.createElement("i");
    mark.style.background = background;
    span.append(...(background === "transparent" ? [] : [mark]), text);
    return span;
  }));
  if (data.runs.length > 1) return;
  const value = (name, i) => run.frames[name]?.[at * run.actuators.length + i];
  const spot = e => `<i class="spot" style="background:${health(e)}"></i>${short(e === undefined ? NaN : +e.toFixed(3))}`;
  const rows = run.actuators.map((a, i) => {
    const u = value("u", i), part = u === undefined ? 0 : Math.max(-1, Math.min(1, u / (run.most_u[i] || 1)));
    const bar = `<span class="bar"><i style="left:${50 + Math.min(part, 0) * 50}%;width:${Math.abs(part) * 50}%"></i></span>`;
    return `<tr><td>${a.kind} ${i}</td><td>${spot(value("true", i))}</td><td>${run.frames.estimate ? spot(value("estimate", i)) : "–"}</td><td>${bar} ${short(u)}</td></tr>`;
  });
  element("actuators").innerHTML = `<div class="wide"><table><tr><th>actuator</th><th>true</th><th>estimated</th><th>command, N m</th></tr>${rows.join("")}</table></div>`;
};

const show = () => {
  element("time").value = lastUntil(master.frames.t, player.t + 1e-9);
  element("clock").textContent = `${player.t.toFixed(span[1] - span[0] < 10 ? 3 : 2)} s`;
  draw();
  legend();
  cursors();
};
const seek = t => { player.t = Math.min(Math.max(t, master.frames.t[0]), master.frames.t.at(-1)); show(); };
const step = frames => {
  const f = master.frames.t;
  seek(f[Math.min(Math.max(lastUntil(f, player.t + 1e-9) + frames, 0), f.length - 1)]);
};
const play = on => {
  player.playing = on && master.frames.t.length > 1;
  element("play").textContent = player.playing ? "❚❚" : "▶";
  if (!player.playing) return;
  if (player.t >= master.frames.t.at(-1)) player.t = master.frames.t[0];
  player.last = performance.now();
  requestAnimationFrame(tick);
};
const tick = now => {
  if (!player.playing) return;
  const t = player.t + (now - player.last) / 1000 * player.speed;
  player.last = now;
  seek(t);
  if (t >= master.frames.t.at(-1)) play(false); else requestAnimationFrame(tick);
};

const setTheme = name => { document.documentElement.dataset.theme = name; if (panels.length) refresh(); legend(); };
const wire = () => {
  const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000], length = span[1] - span[0];
  player.speed = speeds.reduce((a, b) => Math.abs(Math.log(b * 25 / length)) < Math.abs(Math.log(a * 25 / length)) ? b : a);
  element("speed").innerHTML = speeds.map(s => `<option value="${s}"${s === player.speed ? " selected" : ""}>${s} ×</option>`).join("");
  element("speed").onchange = event => { player.speed = +event.target.value; };
  element("time").max = master.frames.t.length - 1;
  element("time").disabled = element("play").disabled = master.frames.t.length < 2;
  element("time").oninput = event => { play(false); seek(master.frames.t[+event.target.value]); };
  element("play").onclick = () => play(!player.playing);
  element("theme").onclick = () => setTheme(theme() === "dark" ? "light" : "dark");
  document.addEventListener("keydown", event => {
    if (["SELECT", "INPUT", "BUTTON"].includes(event.target.tagName)) return;
    const moves = { ArrowRight: () => step(1), ArrowLeft: () => step(-1), Home: () => step(-Infinity), End: () => step(Infinity), " ": () => play(!player.playing) };
    if (moves[event.key]) { event.preventDefault(); moves[event.key](); }
  });
  let held = null;
  canvas.addEventListener("pointerdown", event => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", event => {
    if (!held) return;
    camera.az -= (event.clientX - held[0]) / 150;
    camera.el = Math.min(Math.max(camera.el + (event.clientY - held[1]) / 150, -1.55), 1.55);
    held = [event.clientX, event.clientY];
    draw();
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); camera.zoom = Math.min(Math.max(camera.zoom * Math.exp(-event.deltaY / 800), 0.4), 6); draw(); }, { passive: false });
  canvas.addEventListener("dblclick", () => { Object.assign(camera, home); draw(); });
  new ResizeObserver(() => { draw(); cursors(); }).observe(element("panels"));
  if (data.runs.length > 1) {
    element("runs").hidden = false;
    data.runs.forEach(run => {
      const chip = document.createElement("span");
      chip.className = "chip";
      chip.append(document.createElement("i"), run.label);
      run.chip = chip;
      chip.title = "Click to hide or show";
      chip.onclick = () => { run.shown = !run.shown; chip.classList.toggle("off", !run.shown); refresh(); legend(); };
      element("runs").append(chip);
    });
  }
};

const spreadOf = line => {
  let low = Infinity, high = -Infinity;
  for (const y of line.y) { if (y < low) low = y; if (y > high) high = y; }
  return high >= low ? high - low : 0;
};
/// What the page computed about itself, for tests and for the curious.
window.gyrostat = {
  seek, step, play, setTheme,
  report: () => ({
    t: player.t, frame: +element("time").value, frames: master.frames.t.length, playing: player.playing, trouble: window.trouble,
    runs: data.runs.map((run, i) => ({ label: run.label, samples: run.clock.count, faults: run.marks.filter(m => m.kind === "fault").length, marks: run.marks.length, body: drawn[i] ?? null })),
    panels: panels.map(p => ({
      name: p.name, traces: p.gd.data.length, range: p.gd._fullLayout.xaxis.range.map(Number), shapes: p.gd._fullLayout.shapes.length,
      paths: p.gd.querySelectorAll(".scatterlayer .trace").length, points: p.gd.data.reduce((n, d) => n + d.x.length, 0),
      spread: Math.max(0, ...p.lines.map(spreadOf)),
      cursor: parseFloat(p.now.style.left), keys: p.head.textContent,
    })),
  }),
};

// Links reach an instant, and a theme (theme.js): index.html#t=30&theme=dark
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", event => setTheme(event.matches ? "dark" : "light"));
if (!flown.length) element("left").classList.add("none");
wire();
plotPanels();
seek(Number(asked.get("t") ?? player.t));
document.documentElement.dataset.ready = "yes";
