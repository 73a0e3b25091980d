// Draws a scene with WebGL2. A frame costs the script only a few uniforms and calls. The only work that grows with the
// number of masses is one upload per view. The shaders smooth all edges, so multisampling is off. After a loss of the
// context, everything is rebuilt from the scene.

import { MASS, LINK, WIRE, SKIN } from "./shaders.js";
import { maps, kindColour } from "./colour.js";

const ROW = 1024;

function wires() {
  const out = [], turn = 2 * Math.PI, steps = 72;
  const ring = point => { for (let i = 0; i < steps; i++) out.push(...point(i / steps * turn), ...point((i + 1) / steps * turn)); };
  for (let k = 0; k < 6; k++) { const a = k * Math.PI / 6; ring(t => [Math.sin(t) * Math.cos(a), Math.cos(t), Math.sin(t) * Math.sin(a)]); }
  for (let k = 1; k < 6; k++) { const a = k * Math.PI / 6, r = Math.sin(a), y = Math.cos(a); ring(t => [r * Math.cos(t), y, r * Math.sin(t)]); }
  return new Float32Array(out);
}

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.scene = null;
    this.theme = "dark";
    this.mode = 0;
    this.contacts = false;
    this.hover = -1;
    this.held = [];
    this.ratio = 1;
    this.lost = false;
    canvas.addEventListener("webglcontextlost", event => { event.preventDefault(); this.lost = true; });
    canvas.addEventListener("webglcontextrestored", () => { this.lost = false; this.start(); if (this.scene) this.load(this.scene); });
    try {
      this.start();
    } catch (error) {
      console.error(error);
      this.gl = null;
    }
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: false, alpha: true, premultipliedAlpha: true, powerPreference: "high-performance" });
    this.gl = gl;
    if (!gl) return;
    this.mass = this.program(MASS);
    this.link = this.program(LINK, ["ends"]);
    this.wire = this.program(WIRE, ["from", "to"]);
    this.skin = this.program(SKIN);
    this.empty = gl.createVertexArray();
    this.wireArray = gl.createVertexArray();
    gl.bindVertexArray(this.wireArray);
    const points = wires();
    this.wireCount = points.length / 6;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    for (let k = 0; k < 2; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k);
      gl.vertexAttribDivisor(k, 1);
    }
    gl.bindVertexArray(null);
    this.colours = this.texture();
    this.setTheme(this.theme);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
  }

  /**
   * @param {string[]} shaders
   * @param {string[]} attributes
   */
  program([vertex, fragment], attributes = []) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    attributes.forEach((name, k) => gl.bindAttribLocation(program, k, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    const at = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) || 0;
    for (let i = 0; i < count; i++) { const { name } = gl.getActiveUniform(program, i); at[name] = gl.getUniformLocation(program, name); }
    return { program, at };
  }

  texture() {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const p of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, p, gl.NEAREST);
    for (const p of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, p, gl.CLAMP_TO_EDGE);
    return texture;
  }

  setTheme(theme) {
    this.theme = theme;
    const gl = this.gl;
    if (!gl) return;
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 3, 0, gl.RGBA, gl.UNSIGNED_BYTE, maps(theme));
    this.ink = theme === "dark" ? [0.93, 0.95, 0.98, 1] : [0.1, 0.13, 0.18, 1];
    this.ground = theme === "dark" ? [0.075, 0.09, 0.115] : [0.955, 0.962, 0.972];
    this.lineColour = theme === "dark" ? [0.55, 0.62, 0.72] : [0.42, 0.48, 0.57];
  }

  load(scene) {
    this.scene = scene;
    this.hover = -1;
    this.held = [];
    const gl = this.gl;
    if (!gl) return;
    for (const t of this.textures || []) gl.deleteTexture(t);
    for (const l of this.lines || []) { gl.deleteBuffer(l.buffer); gl.deleteVertexArray(l.array); }
    const rows = Math.max(1, Math.ceil(scene.n / ROW));
    this.rows = rows;
    this.room = new Float32Array(4 * ROW * rows);
    for (let i = 0; i < scene.n; i++) {
      this.room.set(scene.rest.subarray(3 * i, 3 * i + 3), 4 * i);
      this.room[4 * i + 3] = scene.space[i] + 2 * scene.fixed[i] + 4 * scene.kind[i];
    }
    this.textures = [0, 1, 2].map(() => {
      const t = this.texture();
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, ROW, rows);
      return t;
    });
    gl.bindTexture(gl.TEXTURE_2D, this.textures[0]);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RGBA, gl.FLOAT, this.room);
    this.room.fill(0);
    this.loaded = [null, null];
    this.lines = scene.links.map((l, k) => {
      const array = gl.createVertexArray(), buffer = gl.createBuffer();
      const ends = l.ends.every(e => e < scene.n) ? l.ends : l.ends.map(e => Math.min(e, scene.n - 1));
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, ends, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribIPointer(0, 2, gl.UNSIGNED_INT, 8, 0);
      gl.vertexAttribDivisor(0, 1);
      gl.bindVertexArray(null);
      return { array, buffer, count: ends.length >> 1, contact: l.contact, k };
    });
    this.count = this.lines.reduce((s, l) => s + (l.contact ? 0 : l.count), 0);
  }

  // uploads a view to one of the two textures, unless it is there already
  upload(view, spare) {
    const gl = this.gl;
    let k = this.loaded.indexOf(view);
    if (k >= 0) return k;
    k = this.loaded[0] === spare ? 1 : 0;
    this.scene.expand(view.u, this.room);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[1 + k]);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, this.rows, gl.RGBA, gl.FLOAT, this.room);
    this.loaded[k] = view;
    return k;
  }

  draw(camera, pair, motion) {
    const gl = this.gl, scene = this.scene;
    if (!gl || this.lost || !scene) return;
    const early = this.upload(pair.from, pair.to), late = this.upload(pair.to, pair.from);
    const { width, height } = this.canvas, scale = camera.scale * this.ratio;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    [this.textures[0], this.textures[1 + early], this.textures[1 + late], this.colours].forEach((t, k) => {
      gl.activeTexture(gl.TEXTURE0 + k);
      gl.bindTexture(gl.TEXTURE_2D, t);
    });
    gl.activeTexture(gl.TEXTURE0);
    const speed = pair.from === pair.to ? 0 : 1 / (Math.max(motion.speed, 1e-12) * pair.dt);
    const fading = scene.spatial ? 0.62 : 0.3;
    const use = p => {
      const at = p.at;
      gl.useProgram(p.program);
      ["rest", "early", "late", "colours"].forEach((name, k) => { if (at[name]) gl.uniform1i(at[name], k); });
      gl.uniformMatrix4fv(at.view, false, camera.view);
      gl.uniformMatrix4fv(at.projection, false, camera.projection);
      gl.uniform2f(at.size, width, height);
      gl.uniform1f(at.share, pair.mix);
      gl.uniform2f(at.factor, scene.line, scene.true);
      gl.uniform1f(at.reach, scene.reach);
      gl.uniform3f(at.amounts, speed, 1 / Math.max(motion.far, 1e-12), this.mode);
      gl.uniform4f(at.ground, ...this.ground, fading);
      gl.uniform2f(at.depths, camera.distance - 0.25 * scene.extent, 0.75 * scene.extent);
      gl.uniform1f(at.scale, scale);
      gl.uniform4fv(at.ink, this.ink);
      return at;
    };
    this.masses(use(this.mass), camera);
    this.strips(use(this.link));
    if (scene.spheres.length) this.balls(use, pair);
  }

  masses(at, camera) {
    const gl = this.gl, r = this.ratio, least = Math.min(2.6, Math.max(0.9, 1.4 * this.scene.radius * camera.scale / camera.distance));
    gl.depthMask(true);
    gl.bindVertexArray(this.empty);
    gl.uniform3f(at.ball, this.scene.radius, least * r, 15 * r);
    gl.uniform1i(at.under, this.hover);
    gl.uniform1iv(at["held[0]"], Int32Array.from({ length: 10 }, (_, k) => this.held[k] ?? -1));
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.scene.n);
  }

  strips(at) {
    const gl = this.gl, r = this.ratio;
    gl.depthMask(false);
    const half = (this.count < 400 ? 0.95 : this.count < 4000 ? 0.65 : 0.5) * r;
    for (const l of this.lines) {
      if (l.contact && !this.contacts) continue;
      gl.bindVertexArray(l.array);
      const byKind = this.mode === 2;
      const colour = byKind ? kindColour(this.theme, l.k + this.scene.kinds.length).map(v => v / 255) : this.lineColour;
      gl.uniform4f(at.line, ...colour, byKind ? 0 : l.contact ? 0 : 0.72);
      gl.uniform1f(at.half_width, l.contact ? 0.5 * r : half);
      gl.uniform1f(at.opacity, l.contact ? (l.count > 400 ? 0.18 : 0.5) : this.count > 4000 ? 0.6 : 0.85);
      gl.uniform1f(at.dash, l.contact ? 7 * r : 0);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, l.count);
    }
  }

  balls(use, pair) {
    const gl = this.gl, scene = this.scene, p = [0, 0, 0];
    gl.depthMask(false);
    for (const [program, half] of [[this.skin, 0], [this.wire, 0.5 * this.ratio]]) {
      const at = use(program);
      gl.bindVertexArray(half ? this.wireArray : this.empty);
      for (const s of scene.spheres) {
        for (let k = 0; k < 3; k++) p[k] = s.centre[k] - scene.middle[k];
        if (s.mass >= 0 && s.mass < scene.n) {
          scene.place(s.mass, pair, p);
          for (let k = 0; k < 3; k++) p[k] += s.centre[k] - scene.middle[k] - scene.rest[3 * s.mass + k];
        }
        gl.uniform4f(at.ball, ...p, s.radius);
        gl.uniform1f(at.opacity, half ? 0.2 : 1);
        if (half) {
          gl.uniform1f(at.half_width, half);
          gl.uniform1f(at.dash, 0);
          gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.wireCount);
        } else gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      }
    }
  }
}
