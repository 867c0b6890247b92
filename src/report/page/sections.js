// The other kinds of sections: tables, charts, circles in polar form, ranges.

function tableSection({ header, rows, texts = [0], verdicts }) {
  const names = { good: "good", fair: "fair", poor: "poor" };
  const all = verdicts ? [...header, "verdict"] : header;
  return {
    element: el("div", { class: "scroll" }, el("table", { class: "data" },
      el("thead", {}, el("tr", {}, ...all.map((name, c) => el("th", { class: texts.includes(c) ? "text" : null }, name)))),
      el("tbody", {}, ...rows.map((row, r) => el("tr", {}, ...row.map((cell, c) => el("td", { class: texts.includes(c) ? "text" : null }, cell)),
        verdicts ? el("td", {}, el("span", { class: `verdict ${verdicts[r]}` }, names[verdicts[r]])) : null))))),
    content: () => [all, rows.map((row, r) => (verdicts ? [...row, verdicts[r]] : row))],
  };
}

function chartSection({ x, y, lines, log }) {
  const name = el("div", { class: "name" }, y.unit ? `${y.name}, ${y.unit}` : y.name);
  const host = el("div", { class: "plot" });
  const box = el("div", { class: "wide focusable", tabindex: "0", "aria-label": `${y.name} over ${x.name}` }, name, host);
  const xs = Array.from(column(x.values));
  let plot = null, range = null;
  const whole = () => [xs[0], xs[xs.length - 1]];
  const build = () => {
    if (plot) plot.destroy();
    const made = lines.map(line => ({ ...line, values: plain(column(line.values), log[1]) }));
    plot = makePlot(host, { x: { ...x, log: log[0] }, y: { ...y, log: log[1] }, xs, lines: made, height: 260, zoomed: (min, max) => { range = [min, max]; } });
  };
  navigate(box, { range: () => range || whole(), whole, show: (min, max) => { if (min > 0 || !log[0]) plot.setScale("x", { min, max }); } });
  return {
    element: box, start: build, repaint: build,
    content: () => [[`${x.name} ${x.unit}`.trim(), ...lines.map(line => `${line.name} ${y.unit}`)], xs.map((value, k) => [value, ...lines.map(line => column(line.values)[k])])],
  };
}

function polarSection({ radius_mm, plane, runs, header, rows }) {
  const canvas = el("canvas", { role: "img", "aria-label": "Radial deviation over the angle" });
  const place = el("div", { class: "place" }, "Point at the circle.");
  const figures = tableSection({ header, rows });
  const shown = new Set(runs.map((run, index) => index));
  const chips = el("div", { class: "bar" }, ...runs.map((run, index) => {
    const chip = el("button", { type: "button", "aria-pressed": "true" }, run.name);
    chip.addEventListener("click", () => { if (!shown.delete(index)) shown.add(index); chip.setAttribute("aria-pressed", String(shown.has(index))); paint(); });
    return chip;
  }), el("span", { class: "hint" }, "full line: counterclockwise, dashed: clockwise"));
  const host = el("div", { class: "polar" }, chips, canvas, place, figures.element);
  const of = runs.map(run => ({ angle: column(run.angle_rad), radial: column(run.radial_um), left: column(run.counterclockwise) }));
  let size = 0, unit = 1;
  const radius = deviation => size * 0.3 + deviation * unit;
  const at = (angle, deviation) => [size / 2 + radius(deviation) * Math.cos(angle), size / 2 - radius(deviation) * Math.sin(angle)];
  const paint = () => {
    size = Math.min(600, host.clientWidth);
    if (!size) return;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.height = Math.round(size * ratio);
    canvas.style.height = `${size}px`;
    canvas.style.width = `${size}px`;
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    let largest = 1e-3;
    shown.forEach(index => of[index].radial.forEach(v => { largest = Math.max(largest, Math.abs(v)); }));
    const division = roundedUp(largest / 3);
    unit = size * 0.16 / (3 * division);
    context.clearRect(0, 0, size, size);
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 0.7;
    for (let k = -3; k <= 3; k++) {
      context.strokeStyle = k ? themed("line") : themed("ink");
      context.beginPath();
      context.arc(size / 2, size / 2, radius(k * division), 0, 2 * Math.PI);
      context.stroke();
    }
    context.strokeStyle = themed("line");
    context.fillStyle = themed("soft");
    context.textAlign = "center";
    for (let degrees = 0; degrees < 360; degrees += 45) {
      const angle = degrees * Math.PI / 180, out = size * 0.49;
      context.beginPath();
      context.moveTo(...at(angle, -3 * division));
      context.lineTo(size / 2 + out * 0.96 * Math.cos(angle), size / 2 - out * 0.96 * Math.sin(angle));
      context.stroke();
      const name = degrees % 90 ? `${degrees}°` : `${degrees < 180 ? "+" : "−"}${plane[degrees % 180 / 90]}`;
      context.fillText(name, size / 2 + out * 0.95 * Math.cos(angle), size / 2 - out * 0.95 * Math.sin(angle) + 4);
    }
    of.forEach((run, index) => {
      if (!shown.has(index)) return;
      context.strokeStyle = lineColor(index);
      context.lineWidth = 1.4;
      for (const left of [1, 0]) {
        context.setLineDash(left ? [] : [5, 4]);
        context.beginPath();
        let open = false;
        for (let k = 0; k < run.angle.length; k++) {
          if (run.left[k] !== left) { open = false; continue; }
          const point = at(run.angle[k], run.radial[k]);
          if (open) context.lineTo(...point); else context.moveTo(...point);
          open = true;
        }
        context.stroke();
      }
      context.setLineDash([]);
    });
    context.fillStyle = themed("ink");
    context.fillText(`circle of ${radius_mm.toFixed(3)} mm`, size / 2, size / 2 - 8);
    context.fillText(`1 division = ${digits(division, 2)} µm`, size / 2, size / 2 + 10);
  };
  canvas.addEventListener("pointermove", event => {
    const box = canvas.getBoundingClientRect();
    // On a narrow page the circle is shown smaller than it was drawn.
    const scale = size / box.width;
    const here = [scale * (event.clientX - box.left), scale * (event.clientY - box.top)];
    let best = null, least = 900;
    of.forEach((run, index) => {
      if (!shown.has(index)) return;
      for (let k = 0; k < run.angle.length; k++) {
        const [x, y] = at(run.angle[k], run.radial[k]), off = (x - here[0]) ** 2 + (y - here[1]) ** 2;
        if (off < least) [least, best] = [off, [index, k]];
      }
    });
    if (!best) return;
    const [index, k] = best, degrees = (of[index].angle[k] * 180 / Math.PI + 360) % 360;
    place.textContent = `${runs[index].name}, ${of[index].left[k] ? "counterclockwise" : "clockwise"}: ${digits(of[index].radial[k], 3)} µm at ${degrees.toFixed(1)}°`;
  });
  const content = () => [["run", "direction", "angle deg", "radial deviation µm"], of.flatMap((run, index) => Array.from(run.angle, (angle, k) =>
    [runs[index].name, run.left[k] ? "counterclockwise" : "clockwise", (angle * 180 / Math.PI + 360) % 360, run.radial[k]]))];
  return { element: host, start: paint, repaint: paint, content };
}

function rangesSection({ names, rows }) {
  const grid = el("div", { class: "ranges" });
  for (const row of rows) {
    const low = Math.min(row.has[0], row.asks[0]), high = Math.max(row.has[1], row.asks[1]), span = Math.max(high - low, 1e-9);
    const bar = (kind, [from, to]) => {
      const bar = el("span", { class: kind });
      bar.style.left = `${100 * (from - low) / span}%`;
      bar.style.width = `${100 * (to - from) / span}%`;
      return bar;
    };
    const isOutside = row.asks[0] < row.has[0] - 1e-9 || row.asks[1] > row.has[1] + 1e-9;
    const text = range => `${digits(range[0], 3)} to ${digits(range[1], 3)}`;
    grid.append(el("span", {}, row.name), el("span", { class: "track" }, bar("has", row.has), bar(isOutside ? "asks outside" : "asks", row.asks)),
      el("span", {}, `asks ${text(row.asks)}, ${names[0]} ${text(row.has)} ${row.unit}`, isOutside ? el("b", { class: "verdict poor" }, " outside") : ""));
  }
  const key = el("p", { class: "note" }, `Wide grey bar: ${names[0]}. Narrow bar: ${names[1]}.`);
  return {
    element: el("div", {}, key, grid),
    content: () => [["quantity", "unit", `${names[0]} from`, "to", `${names[1]} from`, "to"], rows.map(row => [row.name, row.unit, ...row.has, ...row.asks])],
  };
}
