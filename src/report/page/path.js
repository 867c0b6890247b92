// A path with its runs: what its parts share, and its controls.

class PathSection {
  constructor(data, id) {
    this.data = data;
    const vector = of => of.map(column);
    this.tip = vector(data.tip_mm);
    this.count = this.tip[0].length;
    this.time = Float64Array.from(column(data.sample), k => k * data.period_s);
    this.arc = column(data.arc_mm);
    this.counts = column(data.counts);
    this.line = column(data.line);
    this.hasLines = !!this.line;
    this.tool = data.tool && vector(data.tool);
    this.speed = column(data.speed_mm_s);
    this.acceleration = column(data.acceleration_mm_s2);
    this.feed = column(data.feed_mm_s);
    this.runs = data.runs.map(run => {
      const error = vector(run.error_um);
      const magnitude = Float32Array.from(error[0], (x, k) => Math.hypot(x, error[1][k], error[2][k]));
      return { name: run.name, foot: vector(run.foot_mm), error, magnitude, max: run.max_um, turn: column(run.turn_urad), tracking: vector(run.tracking), correction: run.correction && vector(run.correction) };
    });
    const samples = column(data.sample);
    this.worst = data.worst.map(places => places.map(place => ({ ...place, index: Math.min(this.count - 1, lowerBound(samples, place.sample)) })));
    this.texts = new Map(data.lines.numbers.map((number, k) => [number, data.lines.texts[k]]));
    this.sizes = this.tip.map(values => {
      let low = Infinity, high = -Infinity;
      values.forEach((v, k) => { if (this.counts[k]) { low = Math.min(low, v); high = Math.max(high, v); } });
      return high - low;
    });
    this.extent = Math.max(...this.sizes, 1e-3);
    this.index = null;
    this.range = [0, this.count - 1];
    this.selected = this.runs.length > 1 ? "all" : "0";
    this.colorBy = "error";
    this.showTools = true;
    const largest = Math.max(...this.runs.map(run => run.max), 1e-6);
    this.magnify = roundBelow(Math.max(1, DRAWN_SHARE * this.extent / (1e-3 * largest)));
    this.top = this.scaleTop();
    this.drawing = new Drawing(this);
    this.series = new Series(this, id);
    this.table = new WorstTable(this);
    this.place = el("div", { class: "place", "aria-live": "polite" }, "Point at the path or at a curve.");
    this.host = el("div", { class: "path" }, this.controls(), this.drawing.host, this.legend(), this.place, this.seriesControls(), this.series.host, this.table.host);
  }

  /** After the host stands in the page. */
  start() {
    this.drawing.look(this.firstView());
    this.drawing.relayer();
    this.series.build();
    this.table.build();
  }

  /** The plane in which the path extends, or space. */
  firstView() {
    const least = this.sizes.indexOf(Math.min(...this.sizes));
    const name = this.tool || this.sizes[least] > 0.2 * this.extent ? "3D" : ["YZ", "XZ", "XY"][least];
    this.viewName = name;
    if (this.viewButtons) this.viewButtons.press(name);
    return name;
  }

  shownRuns() {
    return this.selected === "all" ? this.runs.map((run, index) => index) : [Number(this.selected)];
  }

  /** The run that is picked and whose worst places are shown: the last one that is drawn. */
  mainRun() {
    const shown = this.shownRuns();
    return this.runs[shown[shown.length - 1]];
  }

  worstOfShown() {
    return this.worst[this.runs.indexOf(this.mainRun())] || [];
  }

  text(line) {
    return this.texts.get(line) || "";
  }

  plain(values) {
    return plain(values);
  }

  wholeRange() {
    return this.range;
  }

  /** End of the colour scale: a round number that all but the largest hundredth of the first run stay below. */
  scaleTop() {
    const of = this.colorBy === "speed" ? this.speed : this.colorBy === "acceleration" ? this.acceleration : null;
    const runs = of ? [of] : this.shownRuns().map(index => this.runs[index].magnitude);
    const high = Math.max(...runs.map(values => { const sorted = Float32Array.from(values.filter(Number.isFinite)).sort(); return sorted.length ? sorted[Math.floor(0.995 * (sorted.length - 1))] : 0; }));
    return high > 0 ? roundedUp(high) : 1;
  }

  colorValue(run, k) {
    if (!this.counts[k] || !Number.isFinite(run.magnitude[k])) return -3;
    if (this.colorBy === "run") return -1;
    const of = this.colorBy === "speed" ? this.speed : this.colorBy === "acceleration" ? this.acceleration : run.magnitude;
    return Math.max(0, Math.min(1, of[k] / this.top));
  }

  /** Position in the order of executed lines: whole part the stretch of one line, fraction the way through it. */
  lineAbscissa() {
    if (this.lineOrder) return this.lineOrder;
    const values = new Float64Array(this.count), numbers = [];
    for (let from = 0; from < this.count;) {
      let to = from;
      while (to < this.count && this.line[to] === this.line[from]) to++;
      for (let k = from; k < to; k++) values[k] = numbers.length + (k - from) / (to - from);
      numbers.push(this.line[from]);
      from = to;
    }
    return (this.lineOrder = { values, numbers });
  }

  controls() {
    const names = [...(this.runs.length > 1 ? [["all", "overlay", "All runs over one another"]] : []), ...this.runs.map((run, k) => [String(k), run.name])];
    this.runButtons = choice("Run", names, this.selected, value => { this.selected = value; this.changed(); });
    this.viewButtons = choice("View", Object.keys(VIEWS).map(name => [name, name]), "XY", name => { this.viewName = name; this.drawing.look(name); });
    const bounds = [0, 5];
    const slider = el("input", { type: "range", min: bounds[0], max: bounds[1], step: "0.02", value: Math.log10(this.magnify), "aria-label": "Magnification of the deviation" });
    const output = el("output", {}, `× ${digits(this.magnify, 2)}`);
    slider.addEventListener("input", () => {
      this.magnify = Number((10 ** Number(slider.value)).toPrecision(2));
      output.textContent = `× ${digits(this.magnify, 2)}`;
      this.drawing.relayer();
    });
    const colors = el("select", { "aria-label": "Colour by" }, ...[["error", "contour error"], ["run", "run"], ["speed", "speed"], ["acceleration", "acceleration"]].map(([value, text]) => el("option", { value }, text)));
    colors.addEventListener("change", () => { this.colorBy = colors.value; this.recolor(); });
    const tools = this.tool && el("input", { type: "checkbox", checked: true });
    if (tools) tools.addEventListener("change", () => { this.showTools = tools.checked; this.drawing.paint(); });
    return el("div", { class: "bar" }, this.runButtons, this.viewButtons,
      el("label", {}, "deviation", slider, output), el("label", {}, "colour", colors),
      tools && el("label", {}, tools, "tool directions"),
      el("button", { type: "button", onclick: () => this.reset() }, "show all"),
      csvButton(`${this.data.title || "path"} samples`, () => this.content()));
  }

  legend() {
    this.scaleHost = el("div", { class: "scale" });
    this.paintScale();
    return this.scaleHost;
  }

  paintScale() {
    const unit = { error: "µm", speed: "mm/s", acceleration: "mm/s²" }[this.colorBy];
    const runs = this.shownRuns().map(index => {
      const key = el("span", { class: "key" });
      key.style.borderTopColor = lineColor(index);
      return el("span", {}, key, this.runs[index].name);
    });
    if (this.colorBy === "run") { this.scaleHost.replaceChildren(...runs, el("span", {}, "thin line: desired path; rapids fainter")); return; }
    const canvas = el("canvas", { width: STEPS, height: 1 });
    canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(errorColors()), STEPS, 1), 0, 0);
    const name = { error: "contour error", speed: "speed", acceleration: "acceleration" }[this.colorBy];
    this.scaleHost.replaceChildren(`${name}  0`, canvas, `≥ ${digits(this.top, 2)} ${unit}`, el("span", {}, "thin grey line: desired path; rapids fainter. 1 to 5: the worst places"));
  }

  seriesControls() {
    const by = [["time", "time"], ["arc", "length of path"], ...(this.hasLines ? [["line", "program line"]] : [])];
    const chips = this.series.panels.map(panel => {
      const chip = el("button", { type: "button", "aria-pressed": String(this.series.chosen.has(panel.key)), "data-panel": panel.key, title: panel.title }, panel.name);
      chip.addEventListener("click", () => {
        const on = !this.series.chosen.delete(panel.key);
        if (on) this.series.chosen.add(panel.key);
        chip.setAttribute("aria-pressed", String(on));
        this.series.build();
      });
      return chip;
    });
    const help = el("span", { class: "hint" }, "drag: zoom · shift-drag: pan · double click: all · after a click the wheel zooms");
    return el("div", { class: "bar" }, el("label", {}, "over"), choice("Abscissa", by, "time", value => { this.series.by = value; this.series.range = null; this.series.build(); }),
      el("span", { class: "set" }, ...chips), help);
  }

  changed() {
    this.recolor();
    this.series.build();
    this.table.build();
    this.describe();
  }

  recolor() {
    this.top = this.scaleTop();
    this.paintScale();
    this.drawing.relayer();
  }

  repaint() {
    this.paintScale();
    this.drawing.relayer();
    this.series.build();
  }

  setRange(range) {
    this.range = range;
    this.drawing.paint();
  }

  reset() {
    this.series.show(...this.series.whole());
    this.drawing.look(this.viewName);
  }

  /** Marks a sample in all parts but the one that it was pointed at in. */
  mark(index, from) {
    if (index === this.index) return;
    this.index = index;
    if (from !== "series") this.series.mark();
    this.drawing.paintOver();
    this.describe();
  }

  jump(index) {
    this.series.jump(index);
    this.drawing.fit(...this.range, 4);
    this.index = null;
    this.mark(index, "table");
    this.drawing.host.scrollIntoView({ block: "nearest", behavior: "smooth" });
  }

  describe() {
    const k = this.index;
    if (k === null || k === undefined) { this.place.textContent = "Point at the path or at a curve."; return; }
    const at = this.tip.map((values, c) => `${"XYZ"[c]} ${values[k].toFixed(3)}`).join("  ");
    const errors = this.runs.map(run => `${run.name} ${Number.isFinite(run.magnitude[k]) ? `${digits(run.magnitude[k], 3)} µm` : "does not count (rapid)"}`).join(" · ");
    const line = this.hasLines && this.line[k] ? [`line ${this.line[k]} `, el("code", {}, this.text(this.line[k]) || " "), el("br", {})] : [];
    this.place.replaceChildren(...line, `${this.time[k].toFixed(3)} s · ${at} mm · ${digits(this.speed[k], 3)} mm/s · contour error: ${errors}`);
  }

  /** All samples, as the CSV has them. */
  content() {
    const axes = this.data.axes;
    const header = ["time_s", "arc_mm", ...(this.hasLines ? ["line"] : []), "x_mm", "y_mm", "z_mm", "speed_mm_s", "acceleration_mm_s2", ...(this.feed ? ["feed_mm_s"] : [])];
    const columns = [this.time, this.arc, ...(this.hasLines ? [this.line] : []), ...this.tip, this.speed, this.acceleration, ...(this.feed ? [this.feed] : [])];
    for (const run of this.runs) {
      const of = name => `${run.name}: ${name}`;
      header.push(...["x", "y", "z"].map(c => of(`contour_error_${c}_um`)), of("contour_error_um"));
      columns.push(...run.error, run.magnitude);
      const named = (what, unit) => what.replace(" ", "_") + (unit === "µm" ? "_um" : "_urad");
      axes.forEach((axis, a) => { header.push(of(named(`tracking_${axis.name}`, axis.unit))); columns.push(run.tracking[a]); });
      if (run.correction) axes.forEach((axis, a) => { header.push(of(named(`correction_${axis.name}`, axis.unit))); columns.push(run.correction[a]); });
      if (run.turn) { header.push(of("direction_urad")); columns.push(run.turn); }
    }
    return [header, Array.from({ length: this.count }, (_, k) => columns.map(values => values[k]))];
  }
}

/** A round number not below `value`: two digits. */
function roundedUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map(digit => digit * power).find(rounded => rounded >= value * (1 - 1e-9));
}
