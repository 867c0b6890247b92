// Checks of report pages in Chromium: check.mjs CHROMIUM FOLDER [SCREENSHOTS]

import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, Page } from "./browser.mjs";

const [, , chromium, folder, pictures] = process.argv;
const url = name => pathToFileURL(join(folder, name)).href;
let failures = 0;

function check(what, holds, found = "") {
  if (!holds) failures++;
  console.log(`${holds ? "ok  " : "FAIL"} ${what}${holds ? "" : `: ${JSON.stringify(found)}`}`);
}

/** Scrolls through the page, so that every section is drawn. */
async function drawAll(page) {
  for (let last = -1, y = 0; y > last;) {
    last = y;
    y = await page.ask(`(scrollBy(0, 800), new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(scrollY)))))`);
  }
  await page.until(`[...document.querySelectorAll("section")].every(s => s.dataset.ready === "yes")`, "every section is drawn");
  await page.ask("scrollTo(0, 0)");
  await page.frames();
}

/** Pixels of a canvas that are not empty, and how many colours they have. */
const painted = selector => `(() => {
  const canvas = document.querySelector(${JSON.stringify(selector)});
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data, colors = new Set();
  let count = 0, sum = 0;
  for (let k = 0; k < data.length; k += 4) if (data[k + 3] > 60) { count++; sum = (sum * 31 + data[k] * 3 + data[k + 1] * 5 + data[k + 2] * 7 + k) % 1000000007; colors.add(data[k] >> 4 << 8 | data[k + 1] >> 4 << 4 | data[k + 2] >> 4); }
  return { count, colors: colors.size, sum };
})()`;

/** What a canvas shows once that is another picture than `last` and stays. A picture follows its input by a few frames, by more on a busy machine; after five seconds it is returned as it is. */
async function repainted(page, selector, last) {
  let before = last;
  for (let k = 0; ; k++) {
    const now = await page.ask(painted(selector));
    if (now.sum !== last.sum && now.sum === before.sum || k === 100) return now;
    before = now;
    await new Promise(resolve => setTimeout(resolve, 50));
  }
}

const LINES = ".drawing canvas:nth-of-type(2)", OVER = ".drawing canvas:nth-of-type(3)";
const text = selector => `document.querySelector(${JSON.stringify(selector)}).textContent`;

async function picture(page, name, selector) {
  if (!pictures) return;
  const box = await page.ask(`(() => { const b = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect(); return { x: b.left + scrollX, y: b.top + scrollY, width: b.width, height: b.height }; })()`);
  writeFileSync(join(pictures, name), await page.screenshot(box));
}

async function quiet(page, name) {
  check(`${name}: nothing on the console`, page.faults.length === 0, page.faults);
  check(`${name}: no request to a network`, page.requests.length === 0, page.requests);
}

async function part(browser, { flat = false } = {}) {
  const name = flat ? "part without WebGL" : "part";
  const page = await Page.open(browser, url("part.html"));
  await drawAll(page);
  check(`${name}: drawn by ${flat ? "a plain canvas" : "WebGL"}`, await page.ask(`document.querySelector(".drawing").dataset.renderer`) === (flat ? "2d" : "webgl"));
  const before = await page.ask(painted(LINES));
  check(`${name}: the path is painted, in the colours of its error`, before.count > 1500 && before.colors > 12, before);
  const plots = await page.ask(`[...document.querySelectorAll(".u-over")].length`);
  check(`${name}: curves over time, distribution, spectrum, reversals, learning curve`, plots >= 8, plots);
  check(`${name}: a hostile comment of the program stays text`, await page.ask(`document.body.textContent.includes("</script><b>") && !document.querySelector("td b")`));

  // Plot to path, path to plot.
  const over = await page.at(".plots .u-over", [0.31, 0.5]);
  await page.mouse("mouseMoved", over);
  await page.frames();
  const place = await page.ask(text(".place"));
  check(`${name}: pointing at a curve tells the place and the line of the program`, /line \d+ .*N\d+.*mm\/s.*before .* µm/.test(place), place);
  const marked = await page.ask(painted(OVER));
  await page.mouse("mouseMoved", [over[0] + 90, over[1]]);
  await page.frames();
  check(`${name}: and moves the mark on the path`, (await repainted(page, OVER, marked)).sum !== marked.sum);
  await page.at(".drawing");
  const spot = await page.ask(`(() => { const c = document.querySelector(${JSON.stringify(LINES)}), box = c.getBoundingClientRect();
    const copy = new OffscreenCanvas(c.width, c.height).getContext("2d"); copy.drawImage(c, 0, 0);
    const data = copy.getImageData(0, 0, c.width, c.height).data;
    for (let y = Math.round(c.height * 0.3); y < c.height; y++) for (let x = c.width >> 1; x < c.width; x++) if (data[4 * (y * c.width + x) + 3] > 200) return [box.left + x * box.width / c.width, box.top + y * box.height / c.height];
  })()`);
  await page.mouse("mouseMoved", spot);
  await page.frames();
  const pointed = await page.ask(text(".place"));
  const legend = await page.ask(`document.querySelector(".plots .u-legend .u-value").textContent`);
  check(`${name}: pointing at the path moves the cursor of the curves`, pointed !== place && pointed.includes(legend.replace(" s", "")), [pointed, legend]);

  // Slider, runs, views, zoom.
  await page.ask(`(() => { const s = document.querySelector(".bar input[type=range]"); s.value = 4; s.dispatchEvent(new Event("input")); })()`);
  await page.frames();
  const larger = await repainted(page, LINES, before);
  check(`${name}: the slider magnifies the deviation`, larger.sum !== before.sum && (await page.ask(text(".bar output"))) === "× 10000", larger);
  await page.click(`.bar [data-value="1"]`);
  const after = await repainted(page, LINES, larger);
  const series = await page.ask(`document.querySelectorAll(".plots [data-panel=contour] .u-series").length`);
  check(`${name}: the run after compensation alone`, after.sum !== larger.sum && series === 2, series);
  check(`${name}: and its worst lines`, (await page.ask(text(".worst h3"))).endsWith("after"));
  await page.click(`.bar [data-value="0"]`);
  const worst = await page.ask(`(() => { const row = document.querySelector(".worst tbody tr"); return { text: row.textContent, index: Number(row.dataset.index) }; })()`);
  check(`${name}: the worst line has its text and what happens there`, /N\d+/.test(worst.text) && /reverses|corner|curve|straight|start/.test(worst.text), worst.text);
  await page.click(".worst tbody tr");
  await page.until(`document.querySelector(".place").textContent.startsWith("line ")`);
  const line = await page.ask(`document.querySelector(".worst tbody tr td:nth-child(2)").textContent`);
  check(`${name}: clicking it jumps there`, (await page.ask(text(".place"))).startsWith(`line ${line} `), line);
  const values = `[document.querySelector(".plots .u-legend .u-value").textContent, document.querySelector(".worst tbody tr td:nth-child(4)").textContent]`;
  for (let k = 0; k < 200 && await page.ask(`(([shown, wanted]) => parseFloat(shown) !== Number(wanted))(${values})`); k++) await new Promise(resolve => setTimeout(resolve, 25));
  const [shown, wanted] = await page.ask(values);
  check(`${name}: with the cursors of the curves`, Number.parseFloat(shown) === Number(wanted), [shown, wanted]);
  await page.ask(`[...document.querySelectorAll(".bar button")].find(b => b.textContent === "show all").click()`);
  await page.frames();
  const flatView = await page.ask(painted(LINES));
  await page.click(`.bar [data-value="3D"]`);
  const space = await repainted(page, LINES, flatView);
  const center = await page.at(".drawing", [0.5, 0.5]);
  await page.drag(center, [center[0] + 150, center[1] + 40]);
  const turned = await repainted(page, LINES, space);
  check(`${name}: in space, and turned by dragging`, space.sum !== flatView.sum && turned.sum !== space.sum && turned.count > 500, [flatView, space, turned]);
  const curve = await page.at(".plots .u-over", [0.2, 0.5]), width = await page.ask(`document.querySelector(".plots .u-over").clientWidth`);
  await page.drag(curve, [curve[0] + 0.2 * width, curve[1]]);
  const zoomed = await repainted(page, LINES, turned);
  check(`${name}: zooming the curves fades the rest of the path`, zoomed.sum !== turned.sum, zoomed);

  // Dark, data, narrow, printed.
  await page.click("#theme");
  const dark = await page.ask(`[getComputedStyle(document.body).backgroundColor, document.documentElement.dataset.theme]`);
  check(`${name}: dark`, dark[1] === "dark" && dark[0] !== "rgb(255, 255, 255)" && (await repainted(page, LINES, zoomed)).sum !== zoomed.sum, dark);
  await page.ask(`(window.saved = [], URL.createObjectURL = blob => { saved.push(blob.text()); return "#"; }, HTMLAnchorElement.prototype.click = () => {})`);
  await page.ask(`(document.getElementById("json").click(), document.querySelectorAll("button.csv").forEach(b => b.click()))`);
  const [json, ...tables] = await page.ask("Promise.all(saved)");
  const data = JSON.parse(json).groups[0].sections.find(section => section.kind === "path");
  const rms = data.runs[0].error_um[0].map((x, k) => (x === null ? null : Math.hypot(x, data.runs[0].error_um[1][k], data.runs[0].error_um[2][k]))).filter(v => v !== null);
  check(`${name}: the JSON holds the samples as numbers`, Math.abs(Math.max(...rms) - data.runs[0].max_um) < 2e-3, [Math.max(...rms), data.runs[0].max_um]);
  check(`${name}: every section can be had as CSV`, tables.length >= 8 && tables.every(table => table.split("\r\n").length > 2 && !table.includes("[object")), tables.map(table => table.length));
  await page.send("Emulation.setDeviceMetricsOverride", { width: 380, height: 800, deviceScaleFactor: 1, mobile: true });
  await page.frames();
  check(`${name}: fits a narrow screen`, await page.ask("document.documentElement.scrollWidth <= 380"), await page.ask("document.documentElement.scrollWidth"));
  await page.send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 1, mobile: false });
  const { data: pdf } = await page.send("Page.printToPDF", {});
  check(`${name}: prints`, pdf.length > 20000, pdf.length);
  await quiet(page, name);
  await page.close();
}

/** A page whose sections are all drawn, without a fault. */
async function other(browser, name, kinds) {
  const page = await Page.open(browser, url(`${name}.html`));
  await drawAll(page);
  const found = await page.ask(`[...new Set([...document.querySelectorAll("section")].map(s => s.dataset.kind))].sort().join(" ")`);
  check(`${name}: has ${kinds}`, found === kinds, found);
  const empty = await page.ask(`[...document.querySelectorAll("section canvas")].filter(c => c.clientHeight > 100).filter(c => !c.width).length`);
  check(`${name}: no figure is empty`, empty === 0, empty);
  await quiet(page, name);
  return page;
}

/** The verdicts of a diagnosis: rated in words and colours that can be read on either background, dots and circles painted. */
async function verdicts(page) {
  const rated = await page.ask(`[...document.querySelectorAll("td .verdict")].map(v => v.textContent)`);
  check("diagnosis: every verdict is a word", rated.length > 10 && rated.every(word => ["good", "fair", "poor"].includes(word)), rated);
  const order = rated.map(word => ["poor", "fair", "good"].indexOf(word));
  check("diagnosis: the worst stand first", order.every((rank, k) => k === 0 || rank >= order[k - 1]), rated);
  const note = await page.ask(`document.querySelector("section p.note").textContent`);
  check("diagnosis: thresholds with their source", /1\.6 µm.*3\.9 µm.*ISO 286-1/.test(note), note);
  const titles = await page.ask(`[...document.querySelectorAll("section")].map(s => s.dataset.title)`);
  const wanted = ["Servo mismatch", "Coulomb friction", "Reversal peak", "Ripple", "Following lag", "Friction by place", "Not observable", "Suggested settings"];
  check("diagnosis: a picture for each kind of finding", wanted.every(start => titles.some(title => title.startsWith(start))), titles);
  const chart = titles.findIndex(title => title.startsWith("Following lag"));
  check("diagnosis: logged points are painted beside the line", (await page.ask(painted(`#section-${chart} .u-wrap canvas`))).colors > 2);
  const circle = await page.ask(painted(".polar canvas"));
  check("diagnosis: the ellipse of the mismatch is painted", circle.count > 1500, circle);
  for (const theme of ["dark", "light"]) {
    if (await page.ask("document.documentElement.dataset.theme") !== theme) await page.click("#theme");
    const worst = await page.ask(`(() => {
      const of = text => { const [r, g, b] = text.match(/\\d+/g).map(v => { const c = v / 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
      const back = of(getComputedStyle(document.body).backgroundColor);
      return Math.min(...[...document.querySelectorAll("td .verdict")].map(v => of(getComputedStyle(v).color)).map(v => (Math.max(v, back) + 0.05) / (Math.min(v, back) + 0.05)));
    })()`);
    check(`diagnosis: ${theme}, verdicts have the contrast of WCAG 2 (4.5)`, worst >= 4.5, worst);
  }
  await page.send("Emulation.setDeviceMetricsOverride", { width: 380, height: 800, deviceScaleFactor: 1, mobile: true });
  await page.frames();
  check("diagnosis: fits a narrow screen", await page.ask("document.documentElement.scrollWidth <= 380"), await page.ask("document.documentElement.scrollWidth"));
  await page.send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 1, mobile: false });
}

/** A million samples: how soon the page stands, and how long a frame takes while it is panned. */
async function large(browser) {
  let page, ready;
  // The soonest of three: a machine that does something else beside it is not the page's fault.
  for (let k = 0; k < 3 && !(ready < 2000); k++) {
    if (page) await page.close();
    page = await Page.open(browser, url("large.html"));
    await page.until(`document.querySelector("[data-kind=path]").dataset.ready === "yes"`);
    ready = Math.min(ready ?? Infinity, await page.ask("Math.round(performance.now())"));
  }
  await drawAll(page);
  const frame = await page.ask(`(async () => {
    const host = document.querySelector(".plots");
    host.focus();
    const key = key => host.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
    const next = () => new Promise(requestAnimationFrame);
    for (let k = 0; k < 4; k++) key("+");
    const from = performance.now();
    for (let k = 0; k < 20; k++) { key(k % 2 ? "ArrowLeft" : "ArrowRight"); await next(); }
    return (performance.now() - from) / 20;
  })()`);
  console.log(`     a million samples: open after ${ready} ms, ${frame.toFixed(0)} ms for a frame while panning`);
  check("large: opens within two seconds", ready < 2000, ready);
  // A bound for a busy machine without a graphics card.
  check("large: pans smoothly", frame < 300, frame);
  await quiet(page, "large");
  await page.close();
}

const browser = new Browser(chromium);
try {
  await part(browser);
  if (pictures) {
    const page = await Page.open(browser, url("part.html"), { width: 1000, height: 1000 });
    await drawAll(page);
    await picture(page, "report-part.png", ".path .drawing");
    await page.ask(`(document.querySelector('.bar [data-value="0"]').click(), document.querySelector(".worst tbody tr").click())`);
    await new Promise(resolve => setTimeout(resolve, 700));
    await page.ask(`document.querySelectorAll(".plots .plot").forEach((plot, k) => { if (k > 3) plot.remove(); })`);
    await picture(page, "report-line.png", ".path");
    await page.close();
  }
  for (const [name, kinds, selector] of [["five-axis", "chart path table", ".path .drawing"], ["circle", "chart path polar table", ".polar canvas"], ["model", "chart polar table", null], ["diagnosis", "chart polar table", null], ["comparison", "chart path polar table", null]]) {
    const page = await other(browser, name, kinds);
    if (name === "diagnosis") await verdicts(page);
    if (selector) await picture(page, `report-${name}.png`, selector);
    await page.close();
  }
  await large(browser);
} finally {
  await browser.close();
}
const plain = new Browser(chromium, ["--disable-3d-apis"]);
try {
  await part(plain, { flat: true });
} finally {
  await plain.close();
}
if (failures) console.log(`${failures} checks failed`);
process.exit(failures ? 1 : 0);
