// Pictures of sections of report pages: shots.mjs CHROMIUM FOLDER OUT

import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, Page } from "../../tests/report/browser.mjs";

const [, , chromium, folder, out] = process.argv;
/** Largest picture, bytes. */
const LARGEST = 100_000;

/** Page, picture, start of the section's title, the part of it that is shown, width of the window. */
const PICTURES = [
  ["sound", "sound.png", "What the logs say", null, 1000, 400],
  ["mismatch", "mismatch.png", "Servo mismatch: x-y", ".polar canvas", 620],
  ["feed-forward", "feed-forward.png", "Following lag: x", null, 860],
  ["friction", "friction.png", "Reversal peak: y", null, 860],
  ["backlash-circle", "backlash.png", "Circular test", ".polar canvas", 620],
  ["ripple", "ripple.png", "Ripple: y", null, 860],
  ["readme", "../before-after.png", "Where the error is", ".drawing", 900],
];

const browser = new Browser(chromium);
try {
  for (const [name, picture, title, part, width, most] of PICTURES) {
    const file = join(folder, `${name}.html`);
    if (!existsSync(file)) continue;
    const page = await Page.open(browser, pathToFileURL(file).href, { width, height: 1000 });
    // A demo has a section of this title for each path: that of its part.
    const index = await page.ask(`(() => {
      const all = [...document.querySelectorAll("section")].filter(s => s.dataset.title.startsWith(${JSON.stringify(title)}));
      const wanted = all.find(s => s.closest(".group").querySelector("h2")?.textContent === "pocket.nc") || all[0];
      wanted.scrollIntoView({ block: "center" });
      return wanted.id;
    })()`);
    await page.until(`document.getElementById("${index}").dataset.ready === "yes"`);
    await new Promise(resolve => setTimeout(resolve, 600));
    const selector = part ? `#${index} ${part}` : `#${index}`;
    const box = await page.ask(`(() => { const b = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect(); return { x: b.left + scrollX, y: b.top + scrollY, width: b.width, height: b.height }; })()`);
    if (most) box.height = Math.min(box.height, most);
    const image = await page.screenshot(box);
    if (page.faults.length || page.requests.length) throw new Error(`${picture}: ${image.length} bytes; ${[...page.faults, ...page.requests].join("; ")}`);
    if (image.length > LARGEST) console.log(`${picture} is large`);
    writeFileSync(join(out, picture), image);
    await page.close();
    const figures = join(folder, `${name}.json`);
    const poor = existsSync(figures) ? JSON.parse(readFileSync(figures)).findings.filter(f => ["fair", "poor"].includes(f.verdict)).map(f => `${f.quantity} ${f.axis} ${f.estimate.value.toPrecision(3)} [${f.estimate.low.toPrecision(3)}, ${f.estimate.high.toPrecision(3)}] ${f.unit} ${f.verdict}`) : [];
    console.log(`${picture}: ${image.length} bytes\n  ${poor.join("\n  ")}`);
  }
} finally {
  await browser.close();
}
