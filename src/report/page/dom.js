// Elements, numbers as text, downloads.

function el(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined));
  return element;
}

/** A row of buttons of which one is pressed; `chosen(value)` is called when that changes. */
function choice(label, entries, first, chosen) {
  const buttons = entries.map(([value, text, title]) => el("button", {
    type: "button", title, "data-value": value, "aria-pressed": String(value === first),
    onclick: () => { press(value); chosen(value); },
  }, text));
  const press = value => buttons.forEach(button => button.setAttribute("aria-pressed", String(button.dataset.value === value)));
  const set = el("span", { class: "set", role: "group", "aria-label": label }, ...buttons);
  set.press = press;
  return set;
}

/** A number with so many digits that count. */
function digits(value, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const decimals = Math.min(8, Math.max(0, count - 1 - Math.floor(Math.log10(Math.abs(value)))));
  return value.toFixed(decimals);
}

function download(name, text, type) {
  const link = el("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function fileName(text, ending) {
  return text.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "").toLowerCase() + ending;
}

/** Rows of numbers and texts as CSV (RFC 4180). */
function csv(header, rows) {
  const cell = value => {
    if (value === null || value === undefined || (typeof value === "number" && !Number.isFinite(value))) return "";
    const text = String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [header, ...rows].map(row => row.map(cell).join(",")).join("\r\n") + "\r\n";
}

function csvButton(title, content) {
  return el("button", {
    type: "button", class: "csv", title: `Download “${title}” as CSV`,
    onclick: () => { const [header, rows] = content(); download(fileName(title, ".csv"), csv(header, rows), "text/csv"); },
  }, "CSV");
}

/** The colour of a custom property. */
function themed(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Calls `run` once per frame, however often it is asked for. */
function perFrame(run) {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; run(); });
  };
}
