// Chromium, driven through a pipe by its DevTools protocol: no library is needed.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const FLAGS = [
  "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--hide-scrollbars", "--disable-accelerated-2d-canvas", "--force-device-scale-factor=1", "--remote-debugging-pipe",
  "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];
/** Longest time for an answer, ms. */
const PATIENCE = 20000;

export class Browser {
  constructor(program, flags = []) {
    this.profile = mkdtempSync(join(tmpdir(), "report-"));
    this.process = spawn(program, [...FLAGS, ...flags, `--user-data-dir=${this.profile}`, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    this.waiting = new Map();
    this.heard = [];
    this.number = 0;
    let rest = Buffer.alloc(0);
    this.process.stdio[4].on("data", chunk => {
      rest = Buffer.concat([rest, chunk]);
      for (let end; (end = rest.indexOf(0)) >= 0; rest = rest.subarray(end + 1)) this.receive(JSON.parse(rest.subarray(0, end).toString()));
    });
  }

  receive(message) {
    const { resolve, reject } = this.waiting.get(message.id) || {};
    if (!resolve) { this.heard.forEach(listener => listener(message)); return; }
    this.waiting.delete(message.id);
    if (message.error) reject(new Error(message.error.message)); else resolve(message.result);
  }

  send(method, params = {}, sessionId = undefined) {
    const id = ++this.number;
    this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + "\0");
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => { this.waiting.delete(id); reject(new Error(`${method}: no answer`)); }, PATIENCE);
      const settle = then => value => { clearTimeout(timer); then(value); };
      this.waiting.set(id, { resolve: settle(resolve), reject: settle(reject) });
    });
  }

  async close() {
    const ended = new Promise(resolve => this.process.once("exit", resolve));
    await this.send("Browser.close").catch(() => this.process.kill());
    await ended;
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 100 });
  }
}

/** A page, with what it said on its console and asked of a network. */
export class Page {
  static async open(browser, url, { width = 1280, height = 900 } = {}) {
    const { targetId } = await browser.send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await browser.send("Target.attachToTarget", { targetId, flatten: true });
    const page = Object.assign(new Page(), { browser, sessionId, targetId, faults: [], requests: [] });
    browser.heard.push(message => page.hear(message));
    for (const domain of ["Page", "Runtime", "Network", "Log"]) await page.send(`${domain}.enable`);
    await page.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: false });
    const loaded = new Promise(resolve => { page.loaded = resolve; });
    const began = Date.now();
    await page.send("Page.navigate", { url });
    await loaded;
    page.openedMs = Date.now() - began;
    return page;
  }

  hear({ method, params, sessionId }) {
    if (sessionId !== this.sessionId) return;
    if (method === "Page.loadEventFired") this.loaded();
    if (method === "Runtime.exceptionThrown") this.faults.push(params.exceptionDetails.exception?.description || params.exceptionDetails.text);
    if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) this.faults.push(params.args.map(arg => arg.value || arg.description).join(" "));
    if (method === "Log.entryAdded" && params.entry.level === "error") this.faults.push(params.entry.text);
    if (method === "Network.requestWillBeSent" && !/^(file|data|blob):/.test(params.request.url)) this.requests.push(params.request.url);
  }

  send(method, params) {
    return this.browser.send(method, params, this.sessionId);
  }

  /** The value of an expression in the page; promises are awaited. */
  async ask(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description || exceptionDetails.text);
    return result.value;
  }

  /** Waits until an expression is true. */
  async until(expression, what = expression) {
    for (let k = 0; k < 200; k++) {
      if (await this.ask(expression)) return;
      await new Promise(resolve => setTimeout(resolve, 25));
    }
    throw new Error(`never: ${what}`);
  }

  /** Two frames, so that what was asked for is painted. */
  frames() {
    return this.ask("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
  }

  /** A place of an element on the screen, as shares of its width and height, once the page no longer scrolls. */
  async at(selector, shift = [0.5, 0.5]) {
    return this.ask(`(async () => {
      const element = document.querySelector(${JSON.stringify(selector)});
      element.scrollIntoView({ block: "center", behavior: "instant" });
      let box = element.getBoundingClientRect(), rest = 0;
      for (let k = 0; rest < 3 && k < 300; k++) {
        await new Promise(requestAnimationFrame);
        const now = element.getBoundingClientRect();
        rest = now.top === box.top && now.left === box.left ? rest + 1 : 0;
        box = now;
      }
      return [box.left + ${shift[0]} * box.width, box.top + ${shift[1]} * box.height];
    })()`);
  }

  mouse(type, [x, y], more = {}) {
    return this.send("Input.dispatchMouseEvent", { type, x, y, ...more });
  }

  async click(selector) {
    const at = await this.at(selector);
    await this.mouse("mousePressed", at, { button: "left", buttons: 1, clickCount: 1 });
    await this.mouse("mouseReleased", at, { button: "left", clickCount: 1 });
    await this.frames();
  }

  async drag(from, to, steps = 4) {
    await this.mouse("mouseMoved", from);
    await this.mouse("mousePressed", from, { button: "left", buttons: 1, clickCount: 1 });
    for (let k = 1; k <= steps; k++) {
      await this.mouse("mouseMoved", from.map((v, c) => v + (to[c] - v) * k / steps), { button: "left", buttons: 1 });
    }
    await this.mouse("mouseReleased", to, { button: "left", clickCount: 1 });
    await this.frames();
  }

  async screenshot(clip) {
    const { data } = await this.send("Page.captureScreenshot", { format: "png", ...(clip ? { clip: { ...clip, scale: 1 }, captureBeyondViewport: true } : {}) });
    return Buffer.from(data, "base64");
  }

  close() {
    return this.browser.send("Target.closeTarget", { targetId: this.targetId });
  }
}
