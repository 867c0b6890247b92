// The same lines on a plain canvas, where there is no WebGL.

class FlatLines {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  layer(points, pairs) {
    return { points, pairs };
  }

  drop() {}

  begin(camera, ratio, colors) {
    const context = this.context;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, camera.width, camera.height);
    Object.assign(this, { camera, colors, basis: camera.basis(), began: performance.now() });
  }

  end(done) {
    const took = performance.now() - this.began;
    setTimeout(() => done(took), 0);
  }

  draw({ points, pairs }, { magnify = 0, width, plain, rapid = plain, mapped = false, range = [0, Infinity], from = 0, to = Infinity }) {
    const { context, camera, basis, colors } = this;
    const style = value => {
      if (mapped && value > -0.5) {
        const k = 4 * Math.round(Math.min(1, value) * (STEPS - 1));
        return `rgb(${colors[k]},${colors[k + 1]},${colors[k + 2]})`;
      }
      const of = value < -1.5 ? rapid : plain;
      return `rgba(${of.slice(0, 3).map(c => Math.round(255 * c)).join()},${of[3]})`;
    };
    const place = at => camera.project(...[0, 1, 2].map(c => points[at + c] + magnify * points[at + 3 + c]), basis);
    const step = FLOATS * (pairs ? 2 : 1);
    let open = null;
    for (let at = from * step, k = from; k <= to && at + 2 * FLOATS <= points.length; at += step, k++) {
      const value = points[at + 2 * FLOATS - 1];
      if (!(points[at + FLOATS - 1] > -2.5) || !(value > -2.5)) { if (open) context.stroke(); open = null; continue; }
      const faded = k < range[0] || k > range[1];
      const key = style(mapped && value > -0.5 ? Math.round(value * 32) / 32 : value) + faded;
      const b = place(at + FLOATS);
      if (key !== open || pairs) {
        if (open) context.stroke();
        open = key;
        context.strokeStyle = style(mapped && value > -0.5 ? Math.round(value * 32) / 32 : value);
        context.globalAlpha = faded ? 0.16 : 1;
        context.lineWidth = value < -1.5 ? Math.min(width, 1) : width;
        context.beginPath();
        context.moveTo(...place(at));
      }
      context.lineTo(...b);
    }
    if (open) context.stroke();
    context.globalAlpha = 1;
  }
}
