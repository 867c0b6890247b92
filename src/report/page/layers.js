// What is drawn of a path: as many of its points as can be told apart.

/**
 * Layers of points that lie `spacing` mm apart where they are drawn, be it by the path or by the magnified deviation of a run. Each has
 * the largest error of the points before it that are left out.
 */
function makeLevel(view, lines, spacing) {
  const shown = view.shownRuns().map(index => view.runs[index]), m = 1e-3 * view.magnify;
  const chosen = [0], reach = spacing * spacing, { tip, counts } = view;
  let last = 0;
  const apart = (k, run) => {
    let sum = 0;
    for (let c = 0; c < 3; c++) {
      let d = tip[c][k] - tip[c][last];
      if (run) d += run.foot[c][k] - run.foot[c][last] + m * (run.error[c][k] - run.error[c][last]);
      sum += d * d;
    }
    return sum;
  };
  for (let k = 1; k < view.count; k++) {
    if (k < view.count - 1 && counts[k] === counts[k - 1] && counts[k] === counts[k + 1] && apart(k) < reach && !shown.some(run => apart(k, run) >= reach)) continue;
    chosen.push(k);
    last = k;
  }
  const points = (values, foot, error) => {
    const out = new Float32Array(FLOATS * chosen.length);
    for (let n = 0, at = 0, from = 0; n < chosen.length; n++, at += FLOATS) {
      const k = chosen[n];
      for (let c = 0; c < 3; c++) {
        out[at + c] = tip[c][k] + (foot ? foot[c][k] : 0);
        out[at + 3 + c] = error ? 1e-3 * error[c][k] : 0;
      }
      let value = values(k);
      for (; from < k; from++) value = Math.max(value, values(from));
      out[at + 6] = values(k) < -2.5 ? -3 : value;
    }
    return out;
  };
  return {
    chosen,
    desired: lines.layer(points(k => (counts[k] ? -1 : -2))),
    runs: view.runs.map(run => (shown.includes(run) ? lines.layer(points(k => view.colorValue(run, k), run.foot, run.error)) : null)),
  };
}

/** Lines from the tip along the tool, at some places of the path. */
function toolLines(view) {
  const wanted = 160, out = [];
  const length = 0.1 * view.extent, total = view.arc[view.count - 1];
  let next = 0;
  for (let k = 0; k < view.count; k++) {
    if (view.arc[k] < next || !view.counts[k]) continue;
    next = view.arc[k] + total / wanted;
    for (const far of [0, length]) out.push(...[0, 1, 2].map(c => view.tip[c][k] + far * view.tool[c][k]), 0, 0, 0, -1);
  }
  return new Float32Array(out);
}
