// Plots by uPlot, with the colours of the page, zoom, pan and keys.

const WIDTHS = { line: 1.3, pale: 0.8, dashed: 1.3, points: 1.2, dots: 0, steps: 1.2, low: 0, high: 0 };

/** Samples from which on lines are as thin as a pixel: such are drawn several times as fast. */
const MANY = 20000;

function plotSeries(line, unit) {
  const color = line.css || lineColor(line.color);
  const value = (u, v) => (v === null || v === undefined ? "–" : `${digits(v)} ${unit}`);
  const series = { label: line.name, stroke: color, width: line.values.length > MANY ? Math.min(1, WIDTHS[line.style]) : WIDTHS[line.style], value, points: { show: false } };
  if (line.style === "pale") series.stroke = color + "55";
  if (line.style === "dashed" || line.dash) series.dash = line.dash || [7, 5];
  if (line.style === "points") series.points = { show: true, size: 5, fill: color };
  if (line.style === "dots") Object.assign(series, { paths: () => null, points: { show: true, size: 4, fill: color } });
  if (line.style === "steps") Object.assign(series, { paths: uPlot.paths.stepped({ align: -1 }), fill: color + "2e" });
  if (line.style === "low" || line.style === "high") series.stroke = color + "00";
  return series;
}

function plotAxis(name, unit, extra) {
  const soft = themed("soft"), line = themed("line");
  return {
    label: (unit ? `${name}, ${unit}` : name) || null, labelSize: 18, labelFont: "11px system-ui, sans-serif", font: "11px system-ui, sans-serif",
    stroke: soft, grid: { stroke: line, width: 0.6 }, ticks: { stroke: line, width: 0.6 }, ...extra,
  };
}

/**
 * A plot in `host`: `x` and `y` are { name, unit, log, format, shown }, `lines` are { name, style, color, values } with null for no value.
 * `moved(index)` is called when the cursor moves, `zoomed(min, max)` when the range of the abscissa changes.
 */
function makePlot(host, { x, y, xs, lines, height, sync, moved, zoomed }) {
  const bands = [];
  lines.forEach((line, k) => { if (line.style === "low") bands.push({ series: [k + 2, k + 1], fill: lineColor(line.color) + "30" }); });
  const values = (u, splits) => splits.map(v => (v === null ? "" : x.format(v)));
  const logged = (u, splits) => logTexts(splits);
  // Numbers of runs and of forecasts are whole.
  const counted = { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] };
  const options = {
    width: Math.max(200, host.clientWidth), height, bands,
    scales: { x: { time: false, distr: x.log ? 3 : 1 }, y: { distr: y.log ? 3 : 1 } },
    series: [{ label: x.name, value: (u, v) => (v === null ? "–" : x.format ? x.format(v) : `${digits(v)} ${x.unit}`) },
      ...lines.map(line => plotSeries(line, y.unit))],
    axes: [
      plotAxis(x.shown === false ? "" : x.name, x.shown === false ? "" : x.unit, { size: 26, ...(x.format ? { values } : x.log ? { values: logged } : x.unit ? {} : counted) }),
      plotAxis("", "", { size: 56, space: 24, ...(y.log ? { values: logged } : {}) }),
    ],
    cursor: { y: false, sync: sync ? { key: sync, setSeries: false } : undefined, drag: { x: true, y: false, setScale: true }, points: { size: 6 } },
    legend: { live: true },
    hooks: {
      setCursor: [u => { if (moved && Number.isInteger(u.cursor.idx)) moved(u.cursor.idx); }],
      setScale: [(u, key) => { if (key === "x" && zoomed) zoomed(u.scales.x.min, u.scales.x.max); }],
    },
  };
  const plot = new uPlot(options, [xs, ...lines.map(line => line.values)], host);
  plot.root.querySelectorAll(".u-series").forEach((row, k) => {
    if (k > 0 && ["pale", "low", "high"].includes(lines[k - 1].style)) row.style.display = "none";
  });
  new ResizeObserver(() => { if (host.clientWidth > 50) plot.setSize({ width: host.clientWidth, height }); }).observe(host);
  return plot;
}

/** Texts on a logarithmic axis: powers of ten, over up to two decades their double and fivefold too. */
function logTexts(splits) {
  const known = splits.filter(value => value > 0);
  const shown = Math.log10(known[known.length - 1] / known[0]) > 2.2 ? [1] : [1, 2, 5];
  return splits.map(value => {
    const power = Math.floor(Math.log10(value) + 1e-6);
    if (value === null || !shown.includes(Math.round(value / 10 ** power))) return "";
    return Math.abs(power) < 4 ? digits(value, 1) : value.toExponential(0);
  });
}

/** Keys and wheel on plots with a common abscissa: `range()` gives what is shown, `whole()` what there is, `show(min, max)` changes it. */
function navigate(host, { range, whole, show, step }) {
  const about = (factor, middle) => {
    const [min, max] = range();
    const [low, high] = whole();
    const at = middle === undefined ? (min + max) / 2 : middle;
    const from = Math.max(low, at - (at - min) * factor), to = Math.min(high, at + (max - at) * factor);
    if (to > from) show(from, to);
  };
  const shift = share => {
    const [min, max] = range(), [low, high] = whole();
    let by = share * (max - min);
    by = Math.max(low - min, Math.min(high - max, by));
    show(min + by, max + by);
  };
  host.addEventListener("wheel", event => {
    if (!host.contains(document.activeElement) && !event.ctrlKey) return;
    event.preventDefault();
    if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) return shift((event.deltaX || event.deltaY) * 0.001);
    const over = host.querySelector(".u-over").getBoundingClientRect();
    const [min, max] = range(), share = (event.clientX - over.left) / over.width;
    about(Math.exp(event.deltaY * 0.0015), min + share * (max - min));
  }, { passive: false });
  let from = null;
  host.addEventListener("pointerdown", event => {
    // Shift or another button than the first drags; the first alone chooses a range.
    if (!event.target.closest(".u-over") || (event.button === 0 && !event.shiftKey)) return;
    event.preventDefault();
    event.stopPropagation();
    from = { x: event.clientX, range: range(), width: event.target.closest(".u-over").clientWidth };
    host.setPointerCapture(event.pointerId);
  }, true);
  host.addEventListener("mousedown", event => { if (from) event.stopPropagation(); }, true);
  host.addEventListener("pointermove", event => {
    if (!from) return;
    const [min, max] = from.range, [low, high] = whole();
    let by = -(event.clientX - from.x) / from.width * (max - min);
    by = Math.max(low - min, Math.min(high - max, by));
    show(min + by, max + by);
  });
  host.addEventListener("pointerup", () => { from = null; });
  host.addEventListener("keydown", event => {
    if (event.key === "ArrowLeft") shift(-0.1);
    else if (event.key === "ArrowRight") shift(0.1);
    else if (event.key === "+" || event.key === "=") about(0.7);
    else if (event.key === "-") about(1 / 0.7);
    else if (event.key === "0") show(...whole());
    else if (step && (event.key === "," || event.key === ".")) step(event.key === "." ? 1 : -1);
    else return;
    event.preventDefault();
  });
}
