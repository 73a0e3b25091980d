// Draws a scene with WebGL2.
//
// Decides on two programs and three calls a frame: links as lines, spheres as rings, masses as instanced discs that a
// fragment shader makes round. Arrays are made once; a frame uploads places and colours alone.

const DISC = `#version 300 es
uniform mat4 u_matrix; uniform vec2 u_size; uniform float u_marked;
layout(location = 0) in vec3 at; layout(location = 1) in float tone; layout(location = 2) in float fixed_;
out vec2 corner; out float v_tone; out float v_fixed; out float v_marked;
void main() {
  vec2 c = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  corner = c; v_tone = tone; v_fixed = fixed_; v_marked = float(gl_InstanceID) == u_marked ? 1.0 : 0.0;
  vec4 p = u_matrix * vec4(at, 1.0);
  float grow = v_marked > 0.5 ? 1.7 : (fixed_ > 0.5 ? 0.9 : 1.0);
  gl_Position = p + vec4(c * u_size * grow, 0.0, 0.0);
}`;
const DISC_COLOUR = `#version 300 es
precision highp float;
uniform vec3 u_low; uniform vec3 u_middle; uniform vec3 u_high; uniform vec3 u_fixed; uniform vec3 u_mark;
in vec2 corner; in float v_tone; in float v_fixed; in float v_marked; out vec4 colour;
void main() {
  float r = length(corner);
  if (v_fixed > 0.5) { if (max(abs(corner.x), abs(corner.y)) > 0.8) discard; colour = vec4(u_fixed, 1.0); return; }
  float edge = fwidth(r);
  float cover = 1.0 - smoothstep(1.0 - edge, 1.0, r);
  if (cover <= 0.0) discard;
  vec3 normal = vec3(corner, sqrt(max(0.0, 1.0 - r * r)));
  float light = 0.55 + 0.45 * max(0.0, dot(normal, normalize(vec3(-0.4, 0.6, 0.75))));
  vec3 tone = v_tone < 0.5 ? mix(u_low, u_middle, v_tone * 2.0) : mix(u_middle, u_high, v_tone * 2.0 - 1.0);
  colour = vec4(mix(tone * light, u_mark, v_marked * 0.6), cover);
}`;
const LINE = `#version 300 es
uniform mat4 u_matrix; layout(location = 0) in vec3 at;
void main() { gl_Position = u_matrix * vec4(at, 1.0); }`;
const LINE_COLOUR = `#version 300 es
precision highp float; uniform vec4 u_colour; out vec4 colour;
void main() { colour = u_colour; }`;

const THEMES = {
  dark: { back: [0.059, 0.071, 0.086], low: [0.25, 0.35, 0.62], middle: [0.36, 0.78, 1], high: [1, 0.93, 0.55],
    fixed: [0.45, 0.49, 0.55], mark: [1, 1, 1], line: [0.55, 0.63, 0.74, 0.55], touch: [1, 0.6, 0.35, 0.8] },
  light: { back: [0.961, 0.965, 0.973], low: [0.45, 0.55, 0.75], middle: [0.06, 0.45, 0.75], high: [0.85, 0.3, 0.1],
    fixed: [0.6, 0.64, 0.69], mark: [0, 0, 0], line: [0.35, 0.4, 0.48, 0.5], touch: [0.8, 0.35, 0.1, 0.8] },
};

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: false });
    this.gl = gl;
    if (!gl) return;
    this.discs = program(gl, DISC, DISC_COLOUR);
    this.lines = program(gl, LINE, LINE_COLOUR);
    this.theme = THEMES.dark;
    this.rubber = new Float32Array(6);
  }

  wear(theme) {
    this.theme = THEMES[theme];
  }

  load(scene) {
    const gl = this.gl;
    this.scene = scene;
    if (!gl) return;
    this.places = buffer(gl, gl.ARRAY_BUFFER, scene.at, gl.DYNAMIC_DRAW);
    this.tones = buffer(gl, gl.ARRAY_BUFFER, scene.colour, gl.DYNAMIC_DRAW);
    const fixed = buffer(gl, gl.ARRAY_BUFFER, Float32Array.from(scene.fixed), gl.STATIC_DRAW);
    this.masses = gl.createVertexArray();
    gl.bindVertexArray(this.masses);
    for (const [slot, source, size] of [[0, this.places, 3], [1, this.tones, 1], [2, fixed, 1]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, source);
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, size, gl.FLOAT, false, 0, 0);
      gl.vertexAttribDivisor(slot, 1);
    }
    this.joined = [false, true].map((contact) => {
      const ends = Uint32Array.from(scene.links.filter((l) => l.contact === contact).flatMap((l) => l.ends));
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.places);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      buffer(gl, gl.ELEMENT_ARRAY_BUFFER, ends, gl.STATIC_DRAW);
      return { array, n: ends.length };
    });
    this.rings = scene.spheres.map(({ mass, centre, radius }) => ({ mass, centre, points: rings(radius) }));
    this.free = gl.createVertexArray();
    gl.bindVertexArray(this.free);
    this.loose = buffer(gl, gl.ARRAY_BUFFER, new Float32Array(3 * 3 * 2 * 64 + 6), gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
  }

  /** One frame; `show` has the camera, the mass to mark, whether contacts are shown, and what a pointer pulls. */
  draw({ camera, marked, contacts, pulled }) {
    const { gl, scene, theme, canvas } = this;
    if (!gl || !scene) return;
    const scale = Math.min(devicePixelRatio || 1, 2);
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    gl.viewport(0, 0, w, h);
    gl.clearColor(...theme.back, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const matrix = camera.matrix(canvas.clientWidth, canvas.clientHeight);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.places);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, scene.at);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.tones);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, scene.colour);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(this.lines.program);
    gl.uniformMatrix4fv(this.lines.at("u_matrix"), false, matrix);
    gl.uniform4fv(this.lines.at("u_colour"), theme.line);
    const line = (l) => {
      if (!l.n) return;
      gl.bindVertexArray(l.array);
      gl.drawElements(gl.LINES, l.n, gl.UNSIGNED_INT, 0);
    };
    line(this.joined[0]);
    if (contacts) {
      gl.uniform4fv(this.lines.at("u_colour"), theme.touch);
      line(this.joined[1]);
    }
    gl.bindVertexArray(this.free);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.loose);
    for (const ring of this.rings) {
      const at = ring.mass >= 0 ? scene.at.subarray(3 * ring.mass, 3 * ring.mass + 3) : ring.centre;
      gl.uniform4fv(this.lines.at("u_colour"), [...theme.line.slice(0, 3), 0.35]);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, ring.points.map((v, i) => v + at[i % 3]));
      gl.drawArrays(gl.LINES, 0, ring.points.length / 3);
    }
    if (pulled) {
      this.rubber.set(scene.at.subarray(3 * pulled.mass, 3 * pulled.mass + 3));
      this.rubber.set(pulled.to, 3);
      gl.uniform4fv(this.lines.at("u_colour"), theme.touch);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.rubber);
      gl.drawArrays(gl.LINES, 0, 2);
    }
    gl.useProgram(this.discs.program);
    gl.uniformMatrix4fv(this.discs.at("u_matrix"), false, matrix);
    const r = Math.max(scene.radius, 2.4 * camera.pixel);
    gl.uniform2f(this.discs.at("u_size"), r * camera.clip[0], r * camera.clip[1]);
    gl.uniform1f(this.discs.at("u_marked"), marked);
    for (const name of ["low", "middle", "high", "fixed", "mark"]) gl.uniform3fv(this.discs.at("u_" + name), theme[name]);
    gl.enable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.masses);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, scene.n);
    gl.bindVertexArray(null);
  }
}

function program(gl, vertex, fragment) {
  const all = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(all, shader);
  }
  gl.linkProgram(all);
  const places = new Map();
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(all, name));
    return places.get(name);
  };
  return { program: all, at };
}

function buffer(gl, target, data, usage) {
  const made = gl.createBuffer();
  gl.bindBuffer(target, made);
  gl.bufferData(target, data, usage);
  return made;
}

/** Three circles of a sphere, as pairs of points. */
function rings(radius) {
  const all = [];
  for (let plane = 0; plane < 3; plane++) {
    for (let i = 0; i < 64; i++) {
      for (const j of [i, i + 1]) {
        const [c, s] = [Math.cos((j * Math.PI) / 32) * radius, Math.sin((j * Math.PI) / 32) * radius];
        all.push(...(plane === 0 ? [c, s, 0] : plane === 1 ? [c, 0, s] : [0, c, s]));
      }
    }
  }
  return Float32Array.from(all);
}
