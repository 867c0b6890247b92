// Lines by WebGL: a rectangle for every segment, displaced by the magnified error, coloured from a table.

const VERTEX = `#version 300 es
in vec3 p0; in vec3 e0; in float c0; in vec3 p1; in vec3 e1; in float c1;
uniform mat3 view; uniform vec3 center; uniform vec2 size; uniform float scale; uniform float depth; uniform float magnify; uniform float width; uniform vec2 range;
out float value; out float faded;
void main() {
  vec3 a = view * (p0 + magnify * e0 - center) * scale;
  vec3 b = view * (p1 + magnify * e1 - center) * scale;
  bool second = gl_VertexID > 1;
  bool none = c0 != c0 || c1 != c1 || c0 < -2.5 || c1 < -2.5;
  vec2 d = b.xy - a.xy;
  float len = length(d);
  vec2 along = len > 0.0 ? d / len : vec2(1.0, 0.0);
  // Rapids, whose value is -2, are thin.
  float half_width = 0.5 * (c1 < -1.5 ? min(width, 1.0) : width);
  float side = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
  vec2 at = (second ? b.xy + along * half_width * 0.5 : a.xy - along * half_width * 0.5) + side * half_width * vec2(-along.y, along.x);
  value = second ? c1 : c0;
  if (c1 < -0.5) value = c1;
  float k = float(gl_InstanceID);
  faded = k < range.x || k > range.y ? 1.0 : 0.0;
  gl_Position = none ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(2.0 * at / size, clamp(-(second ? b.z : a.z) / depth, -1.0, 1.0), 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in float value; in float faded;
uniform sampler2D colors; uniform vec4 plain; uniform vec4 rapid; uniform float mapped;
out vec4 color;
void main() {
  vec4 c = mapped > 0.5 && value > -0.5 ? texture(colors, vec2(clamp(value, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)) : value < -1.5 ? rapid : plain;
  float alpha = c.a * (faded > 0.5 ? 0.16 : 1.0);
  color = vec4(c.rgb * alpha, alpha);
}`;

const FLOATS = 7;

class GlLines {
  /** Null where there is no WebGL. */
  static on(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true, premultipliedAlpha: true });
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
    this.uniforms = Object.fromEntries(["view", "center", "size", "scale", "depth", "magnify", "width", "range", "colors", "plain", "rapid", "mapped"]
      .map(name => [name, gl.getUniformLocation(this.program, name)]));
    this.texture = gl.createTexture();
  }

  /** A layer of `count` points, seven numbers each: position, error, value. With `pairs` every two points make a line of their own. */
  layer(points, pairs) {
    const gl = this.gl;
    const made = { array: gl.createVertexArray(), count: pairs ? points.length / FLOATS / 2 : points.length / FLOATS - 1 };
    gl.bindVertexArray(made.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    const stride = 4 * FLOATS * (pairs ? 2 : 1);
    const attribute = (name, size, at) => {
      const location = gl.getAttribLocation(this.program, name);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, size, gl.FLOAT, false, stride, 4 * at);
      gl.vertexAttribDivisor(location, 1);
    };
    [["p", 3, 0], ["e", 3, 3], ["c", 1, 6]].forEach(([name, size, at]) => {
      attribute(`${name}0`, size, at);
      attribute(`${name}1`, size, FLOATS + at);
    });
    return made;
  }

  begin(camera, ratio, colors) {
    const gl = this.gl, basis = camera.basis();
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    // By columns: the first column is what X contributes.
    gl.uniformMatrix3fv(this.uniforms.view, false, [0, 1, 2].flatMap(c => basis.map(b => b[c])));
    gl.uniform3fv(this.uniforms.center, camera.center);
    gl.uniform2f(this.uniforms.size, this.canvas.width, this.canvas.height);
    gl.uniform1f(this.uniforms.scale, camera.scale * ratio);
    gl.uniform1f(this.uniforms.depth, 1e6);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, STEPS, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colors);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.uniform1i(this.uniforms.colors, 0);
    this.ratio = ratio;
  }

  draw(layer, { magnify = 0, width, plain, rapid = plain, mapped = false, range = [0, Infinity] }) {
    const gl = this.gl;
    if (layer.count < 1) return;
    gl.bindVertexArray(layer.array);
    gl.uniform1f(this.uniforms.magnify, magnify);
    gl.uniform1f(this.uniforms.width, width * this.ratio);
    gl.uniform4fv(this.uniforms.plain, plain);
    gl.uniform4fv(this.uniforms.rapid, rapid);
    gl.uniform1f(this.uniforms.mapped, mapped ? 1 : 0);
    gl.uniform2f(this.uniforms.range, range[0], Math.min(range[1], 1e9));
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, layer.count);
  }
}
