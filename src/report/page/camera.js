// A parallel view of space. The viewer stands at an azimuth about Z and an elevation above XY; the planes are special cases.

const VIEWS = { XY: [-90, 90], XZ: [-90, 0], YZ: [0, 0], "3D": [-60, 32] };

class Camera {
  constructor() {
    this.azimuth = -90;
    this.elevation = 90;
    this.center = [0, 0, 0];
    this.scale = 1;
    this.width = this.height = 1;
  }

  look(view) {
    [this.azimuth, this.elevation] = VIEWS[view];
  }

  turn(azimuth, elevation) {
    this.azimuth += azimuth;
    this.elevation = Math.min(90, Math.max(-90, this.elevation + elevation));
  }

  /** The plane that is seen, or null. */
  plane() {
    const found = Object.entries(VIEWS).find(([name, [a, e]]) => name !== "3D" && a === this.azimuth && e === this.elevation);
    return found ? found[0] : null;
  }

  /** Unit vectors to the right, up and to the viewer. */
  basis() {
    const a = this.azimuth * Math.PI / 180, e = this.elevation * Math.PI / 180;
    // Right angles are exact, so that a plane is one.
    const clean = v => (Math.abs(v) < 1e-12 ? 0 : v);
    const [ca, sa, ce, se] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)].map(clean);
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }

  /** Place on the canvas of a point, px. */
  project(x, y, z, basis = this.basis()) {
    const d = [x - this.center[0], y - this.center[1], z - this.center[2]];
    const along = b => b[0] * d[0] + b[1] * d[1] + b[2] * d[2];
    return [this.width / 2 + this.scale * along(basis[0]), this.height / 2 - this.scale * along(basis[1])];
  }

  /** Moves the view by px. */
  pan(dx, dy) {
    const [right, up] = this.basis();
    for (let c = 0; c < 3; c++) this.center[c] += (-dx * right[c] + dy * up[c]) / this.scale;
  }

  /** Magnifies about a place on the canvas. */
  zoom(factor, x = this.width / 2, y = this.height / 2) {
    const scale = Math.min(1e7, Math.max(1e-4, this.scale * factor));
    factor = scale / this.scale;
    this.pan((x - this.width / 2) * (1 / factor - 1), (y - this.height / 2) * (1 / factor - 1));
    this.scale = scale;
  }

  /** Shows those of the points `from` to `to` of three columns that count, with a margin; not closer than `least` mm. */
  fit(columns, counts, from, to, least) {
    const basis = this.basis();
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = from; k <= to; k++) {
      if (!counts[k]) continue;
      for (let b = 0; b < 3; b++) {
        const v = basis[b][0] * columns[0][k] + basis[b][1] * columns[1][k] + basis[b][2] * columns[2][k];
        if (v < low[b]) low[b] = v;
        if (v > high[b]) high[b] = v;
      }
    }
    if (!(low[0] <= high[0])) return;
    const middle = low.map((v, b) => (v + high[b]) / 2);
    for (let c = 0; c < 3; c++) this.center[c] = basis[0][c] * middle[0] + basis[1][c] * middle[1] + basis[2][c] * middle[2];
    const size = b => Math.max(high[b] - low[b], least, 1e-6);
    this.scale = Math.min((this.width - 110) / size(0), (this.height - 80) / size(1));
    if (!(this.scale > 0)) this.scale = 1;
  }
}
