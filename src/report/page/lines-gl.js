// Lines by WebGL: a rectangle for every segment, displaced by the magnified error, coloured from a table.

// Points stand in a texture, two texels each, and every segment takes six vertices from there: instances of four vertices would take a call
// each where a processor does the work of the graphics card.
const VERTEX = `#version 300 es
precision highp sampler2D;
uniform sampler2D points; uniform int stride;
uniform mat3 view; uniform vec3 center; uniform vec2 size; uniform float scale; uniform float magnify; uniform float width; uniform vec2 range;
out float value; out float faded; out vec2 edge;
vec4 texel(int k) { return texelFetch(points, ivec2(k & 2047, k >> 11), 0); }
void main() {
  int segment = gl_VertexID / 6, corner = gl_VertexID - 6 * segment, first = stride * segment;
  vec4 p0 = texel(2 * first), e0 = texel(2 * first + 1), p1 = texel(2 * first + 2), e1 = texel(2 * first + 3);
  float c0 = p0.w, c1 = p1.w;
  vec2 a = (view * (p0.xyz + magnify * e0.xyz - center) * scale).xy;
  vec2 b = (view * (p1.xyz + magnify * e1.xyz - center) * scale).xy;
  // Two triangles: 0 1 2, 2 1 3; the first two corners are at the first point.
  int of = corner < 3 ? corner : 5 - corner == 0 ? 3 : 5 - corner;
  bool second = of > 1;
  float side = (of & 1) == 0 ? -1.0 : 1.0;
  vec2 d = b - a;
  float len = length(d);
  vec2 along = len > 0.0 ? d / len : vec2(1.0, 0.0);
  // Rapids, whose value is -2, are thin.
  float half_width = 0.5 * (c1 < -1.5 ? min(width, 1.0) : width);
  // Half a pixel more on either side, over which the line fades: its edge is smooth without multisampling.
  float reach = half_width + 0.5;
  edge = vec2(side * reach, half_width);
  vec2 at = (second ? b + along * half_width * 0.5 : a - along * half_width * 0.5) + side * reach * vec2(-along.y, along.x);
  value = second || c1 < -0.5 ? c1 : c0;
  float k = float(segment);
  faded = k < range.x || k > range.y ? 1.0 : 0.0;
  gl_Position = c0 < -2.5 || c1 < -2.5 ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(2.0 * at / size, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in float value; in float faded; in vec2 edge;
uniform sampler2D colors; uniform vec4 plain; uniform vec4 rapid; uniform float mapped;
out vec4 color;
void main() {
  vec4 c = mapped > 0.5 && value > -0.5 ? texture(colors, vec2(clamp(value, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)) : value < -1.5 ? rapid : plain;
  float alpha = c.a * (faded > 0.5 ? 0.2 : 1.0) * clamp(edge.y + 0.5 - abs(edge.x), 0.0, 1.0);
  color = vec4(c.rgb * alpha, alpha);
}`;

const FLOATS = 7;
const TEXELS = 2048;

class GlLines {
  /** Null where there is no WebGL. */
  static on(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, depth: false, preserveDrawingBuffer: true, premultipliedAlpha: true });
    if (!gl) return null;
    try { return new GlLines(canvas, gl); } catch { return null; }
  }

  constructor(canvas, gl) {
    this.canvas = canvas;
    this.gl = gl;
    const shader = (kind, source) => {
      const made = gl.createShader(kind);
      gl.shaderSource(made, source);
      gl.compileShader(made);
      if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
      return made;
    };
    this.program = gl.createProgram();
    gl.attachShader(this.program, shader(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(this.program, shader(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(this.program));
    this.uniforms = Object.fromEntries(["points", "stride", "view", "center", "size", "scale", "magnify", "width", "range", "colors", "plain", "rapid", "mapped"]
      .map(name => [name, gl.getUniformLocation(this.program, name)]));
    this.texture = gl.createTexture();
  }

  /** A layer of `count` points, seven numbers each: position, error, value. With `pairs` every two points make a line of their own. */
  layer(points, pairs) {
    const gl = this.gl, count = points.length / FLOATS, rows = Math.ceil(2 * count / TEXELS);
    const texels = new Float32Array(4 * TEXELS * Math.max(1, rows));
    for (let k = 0; k < count; k++) {
      const from = FLOATS * k, to = 8 * k;
      for (let c = 0; c < 3; c++) {
        // A value that is none would make the whole place none.
        texels[to + c] = points[from + c] || 0;
        texels[to + 4 + c] = points[from + 3 + c] || 0;
      }
      texels[to + 3] = points[from + 6] >= -2.5 ? points[from + 6] : -3;
    }
    const made = { texture: gl.createTexture(), count: pairs ? count / 2 : count - 1, stride: pairs ? 2 : 1 };
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, made.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, TEXELS, Math.max(1, rows), 0, gl.RGBA, gl.FLOAT, texels);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return made;
  }

  /** Frees a layer. */
  drop(layer) {
    if (layer) this.gl.deleteTexture(layer.texture);
  }

  begin(camera, ratio, colors) {
    const gl = this.gl, basis = camera.basis();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    // By columns: the first column is what X contributes.
    gl.uniformMatrix3fv(this.uniforms.view, false, [0, 1, 2].flatMap(c => basis.map(b => b[c])));
    gl.uniform3fv(this.uniforms.center, camera.center);
    gl.uniform2f(this.uniforms.size, this.canvas.width, this.canvas.height);
    gl.uniform1f(this.uniforms.scale, camera.scale * ratio);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, STEPS, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.uniform1i(this.uniforms.colors, 0);
    this.ratio = ratio;
  }

  /** Draws the segments `from` to `to` of a layer, those outside of `range` faded. */
  draw(layer, { magnify = 0, width, plain, rapid = plain, mapped = false, range = [0, Infinity], from = 0, to = Infinity }) {
    const gl = this.gl, count = Math.min(to, layer.count - 1) - from + 1;
    if (!(count > 0)) return;
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, layer.texture);
    gl.uniform1i(this.uniforms.points, 1);
    gl.uniform1i(this.uniforms.stride, layer.stride);
    gl.uniform1f(this.uniforms.magnify, magnify);
    gl.uniform1f(this.uniforms.width, width * this.ratio);
    gl.uniform4fv(this.uniforms.plain, plain);
    gl.uniform4fv(this.uniforms.rapid, rapid);
    gl.uniform1f(this.uniforms.mapped, mapped ? 1 : 0);
    gl.uniform2f(this.uniforms.range, range[0], Math.min(range[1], 1e9));
    gl.drawArrays(gl.TRIANGLES, 6 * from, 6 * count);
  }

  /** Calls `done` with the time that what was drawn took, ms. */
  end(done) {
    const gl = this.gl, began = performance.now(), fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const ask = () => {
      if (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED && performance.now() - began < 5000) { setTimeout(ask, 4); return; }
      gl.deleteSync(fence);
      done(performance.now() - began);
    };
    setTimeout(ask, 0);
  }
}
