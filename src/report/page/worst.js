// The table of the worst lines or places.

class WorstTable {
  constructor(view) {
    this.view = view;
    this.host = el("div", { class: "worst" });
  }

  build() {
    const { view } = this, run = view.mainRun(), places = view.worstOfShown();
    const several = view.runs.length > 1;
    const figure = (values, index) => digits(values[index], 3);
    const header = ["#", ...(view.hasLines ? ["line", "program"] : []), "time s", "x y z mm", "what happens there, and why",
      ...view.runs.flatMap(of => [`MAX µm${several ? `, ${of.name}` : ""}`, ...(view.hasLines ? [`RMS µm${several ? `, ${of.name}` : ""}`] : [])])];
    const isText = name => ["program", "what happens there, and why"].includes(name);
    const rows = places.map((place, k) => {
      const jump = () => { view.jump(place.index); this.choose(row); };
      const cells = [String(k + 1), ...(view.hasLines ? [String(place.line || "–"), el("code", {}, view.text(place.line) || " ")] : []),
        view.time[place.index].toFixed(3), place.at_mm.map(v => v.toFixed(2)).join(" "), place.why,
        ...view.runs.flatMap((of, index) => [figure(place.max_um, index), ...(view.hasLines ? [figure(place.rms_um, index)] : [])])];
      const row = el("tr", {
        class: "jump", tabindex: "0", "data-index": String(place.index), title: "Show this place", onclick: jump,
        onkeydown: event => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); jump(); } },
      }, ...cells.map((cell, c) => el("td", { class: isText(header[c]) ? "text" : null }, cell)));
      return row;
    });
    const title = view.hasLines ? `Worst lines by the largest error, ${run.name}` : `Worst places, ${run.name}`;
    const content = () => [header, places.map((place, k) => [k + 1, ...(view.hasLines ? [place.line, view.text(place.line)] : []), view.time[place.index],
      place.at_mm.join(" "), place.why, ...view.runs.flatMap((of, index) => [place.max_um[index], ...(view.hasLines ? [place.rms_um[index]] : [])])])];
    this.host.replaceChildren(
      el("div", { class: "head" }, el("h3", {}, title), csvButton(title, content)),
      el("div", { class: "scroll" }, el("table", { class: "data" },
        el("thead", {}, el("tr", {}, ...header.map(name => el("th", { class: isText(name) ? "text" : null }, name)))),
        el("tbody", {}, ...rows))));
  }

  choose(row) {
    this.host.querySelectorAll("tr.chosen").forEach(other => other.classList.remove("chosen"));
    row.classList.add("chosen");
  }
}
