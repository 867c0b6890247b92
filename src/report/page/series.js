// The time series of a path: panels over a common abscissa, linked with the drawing.

class Series {
  constructor(view, id) {
    this.view = view;
    this.key = `series-${id}`;
    this.by = "time";
    this.host = el("div", { class: "plots focusable", tabindex: "0", "aria-label": "Curves along the path. Arrow keys move, plus and minus zoom, 0 shows all, comma and full stop step." });
    this.plots = [];
    this.range = null;
    // Cursors move by themselves too, when a range changes: only those that a mouse moves point at something.
    this.host.addEventListener("mousemove", () => { this.pointing = true; }, true);
    this.host.addEventListener("mousemove", () => { this.pointing = false; });
    this.placeCursors = perFrame(() => this.placeCursorsNow());
    this.panels = this.known();
    this.chosen = new Set(this.panels.filter(panel => panel.usual).map(panel => panel.key));
    navigate(this.host, {
      range: () => this.range || this.whole(), whole: () => this.whole(), show: (min, max) => this.show(min, max),
      step: by => view.mark(Math.min(view.count - 1, Math.max(0, (view.index ?? 0) + by)), "keys"),
    });
  }

  /** The panels that there are data for. */
  known() {
    const { view } = this;
    const units = [...new Set(view.data.axes.map(axis => axis.unit))];
    const withCorrection = view.runs.some(run => run.correction);
    return [
      { key: "contour", name: "contour error", unit: "µm", usual: true },
      ...units.map(unit => ({ key: `tracking ${unit}`, name: unit === "µm" ? "tracking error" : "tracking error, rotary", unit, usual: true, title: "command − actual position" })),
      view.runs.some(run => run.turn) && { key: "turn", name: "tool direction", unit: "µrad", usual: true },
      { key: "speed", name: view.feed ? "speed, feed" : "speed", unit: "mm/s", usual: true },
      { key: "acceleration", name: "acceleration", unit: "mm/s²", usual: false },
      ...(withCorrection ? units.map(unit => ({ key: `correction ${unit}`, name: unit === "µm" ? "correction" : "correction, rotary", unit, usual: unit === "µm", title: "command − desired position" })) : []),
    ].filter(Boolean);
  }

  lines(panel) {
    const { view } = this, shown = view.shownRuns();
    const ofAxes = (of, runs) => runs.flatMap(index => view.data.axes.flatMap((axis, a) => {
      const columns = view.runs[index][of];
      if (!columns || axis.unit !== panel.unit) return [];
      const last = index === runs[runs.length - 1];
      return [{ name: runs.length > 1 ? `${axis.name}, ${view.runs[index].name}` : axis.name, style: "line", color: a, dash: last ? null : [3, 3], values: view.plain(columns[a]) }];
    }));
    const [kind] = panel.key.split(" ");
    if (kind === "contour") return shown.map(index => ({ name: view.runs[index].name, style: "line", color: index, values: view.plain(view.runs[index].magnitude) }));
    if (kind === "turn") return shown.map(index => ({ name: view.runs[index].name, style: "line", color: index, values: view.plain(view.runs[index].turn) }));
    if (kind === "tracking") return ofAxes("tracking", shown);
    if (kind === "correction") return ofAxes("correction", shown.some(index => view.runs[index].correction) ? shown : view.runs.map((run, index) => index));
    if (kind === "acceleration") return [{ name: "acceleration", style: "line", color: 1, values: view.plain(view.acceleration) }];
    const feed = view.feed ? [{ name: "programmed feed", style: "dashed", color: 0, values: view.plain(view.feed) }] : [];
    return [{ name: "speed", style: "line", color: 1, values: view.plain(view.speed) }, ...feed];
  }

  /** The abscissa: never falling. */
  abscissa() {
    const { view } = this;
    if (this.by === "arc") return { name: "length of path", unit: "mm", values: view.arc };
    if (this.by === "line") {
      const { values, numbers } = view.lineAbscissa();
      const format = v => { const number = numbers[Math.min(numbers.length - 1, Math.max(0, Math.floor(v)))]; return number ? String(number) : ""; };
      return { name: "program line, in the order of execution", unit: "", values, format };
    }
    return { name: "time", unit: "s", values: view.time };
  }

  whole() {
    const values = this.xs;
    return [values[0], Math.max(values[values.length - 1], values[0] + 1e-9)];
  }

  build() {
    const { view } = this;
    const index = this.range && this.indices(this.range);
    this.plots.forEach(({ plot }) => plot.destroy());
    this.host.replaceChildren();
    const x = this.abscissa();
    this.xs = Array.from(x.values);
    const panels = this.panels.filter(panel => this.chosen.has(panel.key));
    this.plots = panels.map((panel, k) => {
      const last = k === panels.length - 1;
      const box = el("div", { class: "plot", "data-panel": panel.key });
      this.host.append(el("div", { class: "plot" }, el("div", { class: "name", title: panel.title }, `${panel.name}, ${panel.unit}`), box));
      const plot = makePlot(box, {
        x: { ...x, shown: last }, y: { name: panel.name, unit: panel.unit }, xs: this.xs, lines: this.lines(panel),
        height: (k === 0 ? 180 : 130) + (last ? 18 : 0), sync: this.key,
        moved: at => { if (this.pointing) view.mark(at, "series"); },
        zoomed: (min, max) => this.show(min, max),
      });
      plot.over.addEventListener("dblclick", event => { event.stopImmediatePropagation(); this.show(...this.whole()); }, true);
      return { plot, panel };
    });
    this.range = null;
    const [low, high] = this.whole();
    if (index && (index[0] > 0 || index[1] < view.count - 1)) this.show(this.xs[index[0]], this.xs[index[1]]);
    else this.show(low, high);
  }

  indices([min, max]) {
    const first = lowerBound(this.xs, min), last = lowerBound(this.xs, max);
    return [Math.max(0, first), Math.min(this.xs.length - 1, last)];
  }

  show(min, max) {
    if (!(max > min) || (this.range && this.range[0] === min && this.range[1] === max)) return;
    this.range = [min, max];
    this.plots.forEach(({ plot }) => plot.setScale("x", { min, max }));
    if (this.view.index !== null) this.placeCursors();
    this.view.setRange(this.indices(this.range));
  }

  /** Shows the stretch around a sample, a second of time. */
  jump(index) {
    const half = 0.5, time = this.view.time;
    const from = lowerBound(time, time[index] - half), to = Math.min(this.xs.length - 1, lowerBound(time, time[index] + half));
    this.show(this.xs[from], Math.max(this.xs[to], this.xs[from] + 1e-6));
  }

  /** In the next frame, when a change of range before it has come into force. */
  mark() {
    this.placeCursors();
  }

  placeCursorsNow() {
    const { index } = this.view;
    for (const { plot } of this.plots) {
      const left = index === null ? -10 : plot.valToPos(this.xs[index], "x");
      plot.setCursor({ left, top: index === null ? -10 : 10 }, false, false);
    }
  }
}

/** Index of the first value that is not below `wanted`. */
function lowerBound(values, wanted) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}
