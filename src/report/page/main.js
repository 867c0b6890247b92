// The page: its sections, drawn when they come into sight; theme; downloads; printing.

const started = performance.now();
const DATA = JSON.parse(document.getElementById("data").textContent);
const parts = [];

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
}

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
setTheme(prefersDark.matches ? "dark" : "light");

const KINDS = {
  path: (section, id) => {
    const path = new PathSection({ ...section, title: section.groupName }, id);
    return { element: path.host, start: () => path.start(), repaint: () => path.repaint(), settle: () => path.drawing.settle() };
  },
  table: tableSection, chart: chartSection, polar: polarSection, ranges: rangesSection,
};

/** The section, its body made when it is first seen. */
function sectionElement(section, group, id) {
  const body = el("div", { class: `body ${section.kind}` });
  const head = el("div", { class: "head" }, el("h3", {}, section.title));
  const element = el("section", { id: `section-${id}`, "data-kind": section.kind, "data-title": section.title }, head, section.note ? el("p", { class: "note" }, section.note) : null, body);
  const placeholder = { path: 1100, chart: 320, polar: 700 }[section.kind];
  if (placeholder) body.style.minHeight = `${placeholder}px`;
  const part = {
    element, ready: false,
    make() {
      if (part.ready) return;
      part.ready = true;
      const made = KINDS[section.kind]({ ...section, groupName: group.name }, id);
      part.made = made;
      body.append(made.element);
      body.style.minHeight = "";
      if (made.content) head.append(csvButton(`${group.name} ${section.title}`, made.content));
      if (made.start) made.start();
      element.dataset.ready = "yes";
    },
  };
  parts.push(part);
  return element;
}

function build() {
  const main = document.getElementById("main"), nav = document.getElementById("nav");
  document.getElementById("lead").textContent = DATA.lead;
  main.replaceChildren();
  let id = 0;
  DATA.groups.forEach((group, g) => {
    const heading = DATA.groups.length > 1 || group.name !== DATA.title ? el("h2", { id: `group-${g}` }, group.name) : null;
    if (DATA.groups.length > 1) nav.append(el("a", { href: `#group-${g}` }, group.name));
    main.append(el("div", { class: "group" }, heading, ...group.sections.map(section => sectionElement(section, group, id++))));
  });
  if (DATA.groups.length === 1) {
    DATA.groups[0].sections.forEach((section, k) => nav.append(el("a", { href: `#section-${k}` }, section.title)));
  }
  nav.append(
    el("button", { type: "button", id: "theme", title: "Light or dark", onclick: () => { setTheme(isDark() ? "light" : "dark"); repaint(); } }, "light / dark"),
    el("button", { type: "button", id: "json", title: "All data of this page as JSON", onclick: () => download(fileName(DATA.title, ".json"), JSON.stringify(readable(DATA)), "application/json") }, "data (JSON)"),
    el("button", { type: "button", onclick: () => { parts.forEach(part => part.make()); requestAnimationFrame(() => requestAnimationFrame(() => print())); } }, "print"));
}

function repaint() {
  parts.forEach(part => { if (part.ready && part.made.repaint) part.made.repaint(); });
}

prefersDark.addEventListener("change", () => { setTheme(prefersDark.matches ? "dark" : "light"); repaint(); });
addEventListener("beforeprint", () => { parts.forEach(part => part.make()); if (isDark()) { setTheme("light"); repaint(); } parts.forEach(part => part.made.settle && part.made.settle()); });

build();
const seen = new IntersectionObserver(entries => entries.forEach(entry => {
  if (!entry.isIntersecting) return;
  seen.unobserve(entry.target);
  parts.find(part => part.element === entry.target).make();
}), { rootMargin: "300px" });
// What takes no drawing is there at once.
parts.forEach(part => { if (part.element.querySelector(".body").style.minHeight) seen.observe(part.element); else part.make(); });
document.documentElement.dataset.opened = String(Math.round(performance.now() - started));
