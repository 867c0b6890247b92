// The path in space: lines, axes, scale bars, the place that is pointed at.

/** Share of the view at which the largest error is drawn at first. */
const DRAWN_SHARE = 1 / 18;
/** Points that are drawn at first, and at least: half of what a processor without a graphics card draws in a tenth of a second. */
const FIRST_POINTS = 16384, FEWEST_POINTS = 4096;
/** Points that are drawn at rest, whatever time that takes, and how long nothing has to move for it, ms. */
const REST_POINTS = 65536, REST_MS = 350;

class Drawing {
  /** `view` is the state that the parts of a path share (`path.js`). */
  constructor(view) {
    this.view = view;
    this.camera = new Camera();
    const canvas = () => el("canvas", { "aria-hidden": "true" });
    [this.under, this.canvas, this.over] = [canvas(), canvas(), canvas()];
    this.hint = el("div", { class: "hint" }, "");
    this.host = el("div", {
      class: "drawing focusable", tabindex: "0", role: "img",
      "aria-label": "Path of the tool, coloured by its error. Arrow keys move it, plus and minus magnify, 0 shows all.",
    }, this.under, this.canvas, this.over, this.hint);
    this.lines = GlLines.on(this.canvas);
    this.isFlat = !this.lines;
    if (this.isFlat) this.lines = new FlatLines(this.canvas);
    this.host.dataset.renderer = this.isFlat ? "2d" : "webgl";
    this.paint = perFrame(() => this.paintNow());
    this.paintOver = perFrame(() => this.paintOverNow());
    this.pointers = new Map();
    this.most = FIRST_POINTS;
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.host);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.ratio = Math.min(3, window.devicePixelRatio || 1);
    for (const canvas of [this.under, this.canvas, this.over]) {
      canvas.width = Math.round(width * this.ratio);
      canvas.height = Math.round(height * this.ratio);
    }
    const first = this.camera.width <= 1;
    Object.assign(this.camera, { width, height });
    if (first) this.fit();
    this.paint();
  }

  look(name) {
    this.camera.look(name);
    this.fit();
  }

  /** Shows the feed moves among some samples. */
  fit(from = 0, to = this.view.count - 1, least = 0) {
    this.camera.fit(this.view.tip, this.view.counts, from, to, least);
    // Room for the lines along the tool.
    if (this.view.tool && to - from === this.view.count - 1) this.camera.scale *= 0.85;
    this.paint();
  }

  /** Makes the layers anew: after a change of runs, colours or their scale. */
  relayer() {
    (this.levels || new Map()).forEach(level => [level.desired, ...level.runs].forEach(layer => layer && this.lines.drop(layer)));
    if (this.tools) this.lines.drop(this.tools);
    this.levels = new Map();
    if (this.view.tool) this.tools = this.lines.layer(toolLines(this.view), true);
    this.paint();
  }

  level(spacing) {
    if (!this.levels.has(spacing)) this.levels.set(spacing, makeLevel(this.view, this.lines, spacing));
    return this.levels.get(spacing);
  }

  /** The finest layers, from a pixel on, of which the samples `first` to `last` are no more points than can be drawn at a time. */
  levelOf(first, last, layers, most) {
    let spacing = 2 ** Math.floor(Math.log2(1.2 / this.camera.scale));
    for (; ; spacing *= 2) {
      const level = this.level(spacing);
      const from = Math.max(0, lowerBound(level.chosen, first) - 1), to = lowerBound(level.chosen, last);
      if ((to - from) * layers <= most || spacing > this.view.extent) return { level, from, to, isFinest: spacing < 1.2 / this.camera.scale };
    }
  }

  paintNow(atRest = false) {
    const { view, camera } = this;
    if (camera.width <= 1 || !this.levels) return;
    // A frame that is still being drawn is waited for, so that none pile up where a processor draws.
    if (this.busy) { this.again = true; return; }
    clearTimeout(this.resting);
    const soft = [...rgb(hexOf(themed("soft"))), 0.75], faint = [...rgb(hexOf(themed("soft"))), 0.4];
    this.lines.begin(camera, this.ratio, errorColors());
    const [first, last] = view.range, shown = view.shownRuns();
    const isWhole = first <= 0 && last >= view.count - 1;
    const most = atRest ? Math.max(this.most, REST_POINTS) : this.most;
    const whole = this.levelOf(0, view.count - 1, isWhole ? 1 + shown.length : 2, most), part = isWhole ? whole : this.levelOf(first, last, shown.length, most);
    const at = k => lowerBound(whole.level.chosen, k);
    this.lines.draw(whole.level.desired, { width: 1, plain: soft, rapid: faint, range: [at(first) - 1, at(last)] });
    if (view.tool && view.showTools) this.lines.draw(this.tools, { width: 1, plain: [...rgb(hexOf(themed("accent"))), 0.55] });
    shown.forEach(index => {
      const own = [...rgb(lineColor(index)), 1];
      const style = { magnify: view.magnify, width: shown.length > 1 ? 1.8 : 2.4, plain: own, mapped: view.colorBy !== "run" };
      if (!isWhole) this.lines.draw(whole.level.runs[index], { ...style, range: [-2, -1] });
      this.lines.draw(part.level.runs[index], { ...style, from: part.from, to: part.to });
    });
    this.busy = true;
    this.lines.end(took => this.painted(took, whole.isFinest && part.isFinest, atRest));
    this.paintUnder();
    this.paintOverNow();
  }

  /** All that can be told apart, at once: what is printed does not wait. */
  settle() {
    this.busy = false;
    this.paintNow(true);
  }

  /** After a frame that took so many ms: finer where that was quick, coarser where it was slow. */
  painted(took, isFinest, atRest) {
    this.busy = false;
    if (atRest) { if (this.again) this.paint(); this.again = false; return; }
    const before = this.most;
    if (took > 90 && this.most > FEWEST_POINTS) this.most /= 2;
    else if (took < 25 && !isFinest) this.most *= 2;
    if (this.again || this.most > before) this.paint();
    else if (!isFinest) this.resting = setTimeout(() => this.paintNow(true), REST_MS);
    this.again = false;
  }

  context(canvas) {
    const context = canvas.getContext("2d");
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.clearRect(0, 0, this.camera.width, this.camera.height);
    context.font = "11px system-ui, sans-serif";
    return context;
  }

  /** Grid and axes of a plane; of other views the three directions. */
  paintUnder() {
    const { camera } = this, context = this.context(this.under);
    const plane = camera.plane();
    context.fillStyle = themed("soft");
    context.strokeStyle = themed("line");
    context.lineWidth = 1;
    if (!plane) return;
    const [right, up] = camera.basis().map(b => b.findIndex(v => Math.abs(v) > 0.5));
    const { width, height, scale, center } = camera;
    const half = [width / 2 / scale, height / 2 / scale];
    const across = ticks(center[right] - half[0], center[right] + half[0], width / 110);
    const along = ticks(center[up] - half[1], center[up] + half[1], height / 70);
    context.globalAlpha = 0.55;
    context.beginPath();
    for (const value of across.values) {
      const x = width / 2 + (value - center[right]) * scale;
      context.moveTo(x, 0);
      context.lineTo(x, height - 18);
    }
    for (const value of along.values) {
      const y = height / 2 - (value - center[up]) * scale;
      context.moveTo(46, y);
      context.lineTo(width, y);
    }
    context.stroke();
    context.globalAlpha = 1;
    context.textAlign = "center";
    for (const value of across.values) {
      const x = width / 2 + (value - center[right]) * scale;
      if (x > 60 && x < width - 70) context.fillText(value.toFixed(across.decimals), x, height - 6);
    }
    context.textAlign = "right";
    for (const value of along.values) {
      const y = height / 2 - (value - center[up]) * scale;
      if (y > 24 && y < height - 26) context.fillText(value.toFixed(along.decimals), 42, y + 4);
    }
    context.fillStyle = themed("ink");
    context.fillText(`${"XYZ"[right]} mm`, width - 8, height - 22);
    context.textAlign = "left";
    context.fillText(`${"XYZ"[up]} mm`, 8, 14);
  }

  paintOverNow() {
    if (this.camera.width <= 1) return;
    const context = this.context(this.over), { view, camera } = this;
    if (!camera.plane()) this.paintDirections(context);
    this.paintScale(context);
    const basis = camera.basis();
    const worst = view.worstOfShown();
    context.font = "600 11px system-ui, sans-serif";
    context.textAlign = "center";
    // The first stands on top.
    worst.slice(0, 5).map((place, k) => [place, k]).reverse().forEach(([place, k]) => {
      const [x, y] = this.placed(view.mainRun(), place.index, basis);
      context.fillStyle = themed("back");
      context.strokeStyle = themed("ink");
      context.beginPath();
      context.arc(x + 13, y - 13, 8, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
      context.beginPath();
      context.moveTo(x, y);
      context.lineTo(x + 7.4, y - 7.4);
      context.stroke();
      context.fillStyle = themed("ink");
      context.fillText(String(k + 1), x + 13, y - 9);
    });
    if (view.index !== null) this.paintMark(context, basis);
  }

  paintMark(context, basis) {
    const { view, camera } = this, k = view.index;
    const tip = camera.project(...view.tip.map(c => c[k]), basis);
    context.lineWidth = 1.5;
    context.strokeStyle = themed("ink");
    context.beginPath();
    context.arc(...tip, 7, 0, 2 * Math.PI);
    context.stroke();
    for (const index of view.shownRuns()) {
      const at = this.placed(view.runs[index], k, basis);
      if (!Number.isFinite(at[0])) continue;
      context.fillStyle = lineColor(index);
      context.strokeStyle = themed("back");
      context.beginPath();
      context.arc(...at, 5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }

  /** Where a run is drawn at a sample, px. */
  placed(run, k, basis) {
    if (!run || !Number.isFinite(run.error[0][k])) return this.camera.project(...this.view.tip.map(c => c[k]), basis);
    const at = [0, 1, 2].map(c => this.view.tip[c][k] + run.foot[c][k] + 1e-3 * this.view.magnify * run.error[c][k]);
    return this.camera.project(...at, basis);
  }

  paintDirections(context) {
    const basis = this.camera.basis(), origin = [44, this.camera.height - 74];
    context.lineWidth = 2;
    ["X", "Y", "Z"].forEach((name, c) => {
      const [dx, dy] = [30 * basis[0][c], -30 * basis[1][c]];
      context.strokeStyle = context.fillStyle = lineColor(c);
      context.beginPath();
      context.moveTo(...origin);
      context.lineTo(origin[0] + dx, origin[1] + dy);
      context.stroke();
      context.textAlign = "center";
      context.fillText(name, origin[0] + 1.3 * dx, origin[1] + 1.3 * dy + 4);
    });
  }

  /** Two bars: of the part, and of the magnified deviation. */
  paintScale(context) {
    const { camera, view } = this;
    const x = 58, y = camera.height - 30;
    const bar = (at, length, text) => {
      context.strokeStyle = context.fillStyle = themed("ink");
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(x, at - 4);
      context.lineTo(x, at);
      context.lineTo(x + length, at);
      context.lineTo(x + length, at - 4);
      context.stroke();
      context.textAlign = "left";
      context.fillText(text, x + length + 6, at + 2);
    };
    const mm = roundBelow(130 / camera.scale), drawn = 1e-3 * view.magnify * camera.scale;
    bar(y, mm * camera.scale, `${mm >= 1 ? mm : digits(mm, 1)} mm of the part`);
    const um = roundBelow(130 / drawn);
    bar(y - 16, um * drawn, `${digits(um, 1)} µm of deviation, × ${digits(view.magnify, 2)}`);
  }

  /** The sample whose run is drawn nearest to a place, within some px. */
  pick(x, y) {
    const { view, camera } = this;
    const run = view.mainRun(), basis = camera.basis(), [right, up] = basis;
    const [from, to] = view.wholeRange();
    let best = null, least = 40 ** 2;
    const m = 1e-3 * view.magnify;
    for (let k = from; k <= to; k++) {
      const has = run && run.error[0][k] === run.error[0][k];
      let px = 0, py = 0;
      for (let c = 0; c < 3; c++) {
        const v = view.tip[c][k] - camera.center[c] + (has ? run.foot[c][k] + m * run.error[c][k] : 0);
        px += right[c] * v;
        py += up[c] * v;
      }
      const dx = camera.width / 2 + camera.scale * px - x, dy = camera.height / 2 - camera.scale * py - y;
      const off = dx * dx + dy * dy;
      if (off < least) [least, best] = [off, k];
    }
    return best;
  }

  listen() {
    const { host, camera } = this;
    const at = event => { const box = host.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    host.addEventListener("pointerdown", event => {
      this.pointers.set(event.pointerId, at(event));
      host.setPointerCapture(event.pointerId);
      this.moved = 0;
    });
    host.addEventListener("pointermove", event => {
      const here = at(event), before = this.pointers.get(event.pointerId);
      if (!before) { if (event.pointerType === "mouse") this.point(here); return; }
      const [dx, dy] = [here[0] - before[0], here[1] - before[1]];
      this.moved += Math.abs(dx) + Math.abs(dy);
      if (this.pointers.size === 2) {
        const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
        camera.zoom(apart(here) / Math.max(1, apart(before)), ...other);
      } else if (!camera.plane() && !event.shiftKey && !(event.buttons & 6)) {
        camera.turn(-dx * 0.4, dy * 0.4);
      } else {
        camera.pan(dx, dy);
      }
      this.pointers.set(event.pointerId, here);
      this.paint();
    });
    const lift = event => {
      if (this.pointers.delete(event.pointerId) && this.moved < 4) this.point(at(event), true);
    };
    host.addEventListener("pointerup", lift);
    host.addEventListener("pointercancel", lift);
    host.addEventListener("dblclick", () => this.fit());
    host.addEventListener("contextmenu", event => event.preventDefault());
    host.addEventListener("wheel", event => {
      if (document.activeElement !== host && !event.ctrlKey) return;
      event.preventDefault();
      camera.zoom(Math.exp(-event.deltaY * 0.0015), ...at(event));
      this.paint();
    }, { passive: false });
    host.addEventListener("keydown", event => {
      const step = event.shiftKey ? 5 : 40;
      const turn = camera.plane() ? null : [[-6, 0], [6, 0], [0, 6], [0, -6]];
      const keys = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], arrow = keys.indexOf(event.key);
      if (arrow >= 0 && turn && !event.shiftKey) camera.turn(...turn[arrow]);
      else if (arrow >= 0) camera.pan(...[[step, 0], [-step, 0], [0, step], [0, -step]][arrow]);
      else if (event.key === "+" || event.key === "=") camera.zoom(1.25);
      else if (event.key === "-") camera.zoom(0.8);
      else if (event.key === "0") this.fit();
      else return;
      event.preventDefault();
      this.paint();
    });
  }

  point(here, always) {
    const found = this.pick(...here);
    if (found !== null || always) this.view.mark(found, "drawing");
  }
}

/** A colour of the page as #rrggbb. */
function hexOf(text) {
  return text.length === 4 ? "#" + [...text.slice(1)].map(c => c + c).join("") : text;
}
