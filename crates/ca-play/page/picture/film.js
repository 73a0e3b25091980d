// Moving instrument of a report, without a server. If there is sound, the picture follows the player, and a new
// position applies to both. Without sound, the picture has a separate clock. It draws only while it is visible and
// something changed.

import { Scene } from "./scene.js";
import { Camera } from "./camera.js";
import { Picture } from "./gl.js";

class Film {
  constructor(about, numbers) {
    this.scene = new Scene({ drawing: about.drawing, generation: 1 });
    this.rate = about.rate; this.frames = about.frames; this.numbers = about.numbers;
    this.views = this.decode(about, numbers);
    this.speed = 0; this.far = 0;
    this.measure();
  }

  // decodes pictures to displacements [m], from 16-bit differences
  decode(about, bytes) {
    const n = about.numbers, count = n * about.frames, scales = new Float32Array(n), now = new Int16Array(n), views = [];
    for (let i = 0, at = 0; i < this.scene.n; i++) {
      const width = this.scene.space[i] ? 3 : 1;
      scales.fill(about.scale[width === 3 ? 1 : 0], at, at += width);
    }
    for (let f = 0, at = 0; f < about.frames; f++) {
      const u = new Float32Array(n);
      for (let i = 0; i < n; i++, at++) {
        now[i] += bytes[at] | (bytes[count + at] << 8);
        u[i] = now[i] * scales[i];
      }
      views.push({ u, seconds: f / about.rate, serial: f });
    }
    return views;
  }

  // the largest values in the film set the exaggeration and the speed scale
  measure() {
    const { scene, views } = this, { offset, space, counted } = scene;
    let line = 0;
    for (let f = 1; f < views.length; f++) {
      const u = views[f].u, before = views[f - 1].u;
      for (let i = 0; i < scene.n; i++) {
        if (!counted[i]) continue;
        const o = offset[i], wide = space[i] ? 3 : 1;
        let d = 0, v = 0;
        for (let k = 0; k < wide; k++) { d += u[o + k] ** 2; v += (u[o + k] - before[o + k]) ** 2; }
        if (wide === 1) line = Math.max(line, d);
        this.far = Math.max(this.far, d); this.speed = Math.max(this.speed, v);
      }
    }
    this.far = Math.sqrt(this.far); this.speed = Math.sqrt(this.speed) * this.rate;
    if (line > 0) scene.line = Math.min(1e9, Math.max(1e-3, 0.1 * scene.extent / Math.sqrt(line)));
  }

  get seconds() {
    return Math.max(0, this.frames - 1) / this.rate;
  }

  at(seconds) {
    const x = Math.min(Math.max(0, seconds), this.seconds) * this.rate, k = Math.min(Math.floor(x), this.frames - 1);
    const from = this.views[k], to = this.views[Math.min(k + 1, this.frames - 1)];
    return { a: from.u, b: to.u, mix: from === to ? 0 : x - k, dt: 1 / this.rate, from, to };
  }
}

(async () => {
  const find = id => document.getElementById(id), root = document.documentElement.dataset;
  const about = JSON.parse(find("data").textContent).film;
  const packed = Uint8Array.from(atob(about.bytes), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const film = new Film(about, new Uint8Array(await new Response(stream).arrayBuffer()));
  const canvas = find("filmCanvas"), slider = find("filmAt"), button = find("filmPlay"), time = find("filmTime");
  const camera = new Camera(), picture = new Picture(canvas);
  if (!picture.gl) { find("film").hidden = true; return; }
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const players = [...document.querySelectorAll("audio")];
  let at = 0, playing = false, last = 0, stale = true, seen = true;

  picture.load(film.scene);
  const theme = () => { picture.setTheme(dark.matches ? "dark" : "light"); stale = true; };
  dark.addEventListener("change", theme);
  theme();
  new ResizeObserver(() => {
    const w = canvas.clientWidth, h = canvas.clientHeight, ratio = Math.min(2, devicePixelRatio || 1);
    if (!w || !h) return;
    picture.ratio = ratio;
    canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio);
    camera.resize(w, h);
    if (!camera.touched) camera.fit(film.scene);
    stale = true;
  }).observe(canvas);
  new IntersectionObserver(all => { seen = all[0].isIntersecting; }).observe(canvas);

  const sounding = () => players.find(p => !p.paused);
  const show = () => {
    const on = !!sounding() || playing;
    button.textContent = on ? "Pause" : "Play";
    slider.value = at; time.textContent = at.toFixed(2) + " s";
    slider.setAttribute("aria-valuetext", time.textContent);
  };
  const seek = seconds => {
    at = Math.min(Math.max(0, seconds), film.seconds);
    for (const p of players) if (at < p.duration) p.currentTime = at;
    stale = true;
  };
  button.addEventListener("click", () => {
    const p = sounding();
    if (p) return p.pause();
    if (playing) { playing = false; stale = true; return; }
    if (at >= film.seconds - 1e-3) seek(0);
    const first = players.find(q => at < q.duration);
    if (first) first.play();
    else { playing = true; last = performance.now(); }
  });
  slider.max = film.seconds;
  slider.addEventListener("input", () => seek(+slider.value));
  addEventListener("seek", e => seek(e.detail));
  for (const p of players) for (const kind of ["play", "pause", "seeked", "ended"]) p.addEventListener(kind, () => { if (kind !== "ended") at = p.currentTime; stale = true; });

  const downs = new Map();
  canvas.addEventListener("pointerdown", e => { downs.set(e.pointerId, [e.clientX, e.clientY]); canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", e => {
    const was = downs.get(e.pointerId);
    if (!was) return;
    downs.set(e.pointerId, [e.clientX, e.clientY]);
    if (downs.size === 1) (e.shiftKey ? camera.pan : camera.orbit).call(camera, e.clientX - was[0], e.clientY - was[1]);
    stale = true;
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, e => downs.delete(e.pointerId));
  canvas.addEventListener("dblclick", () => { camera.fit(film.scene); stale = true; });
  canvas.addEventListener("wheel", e => {
    if (!e.ctrlKey && document.activeElement !== canvas) return;
    e.preventDefault();
    camera.zoom(Math.exp(0.0015 * e.deltaY), e.offsetX, e.offsetY);
    stale = true;
  }, { passive: false });
  canvas.addEventListener("keydown", e => {
    const turn = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }[e.key];
    if (turn) camera.orbit(...turn);
    else if (e.key === "+") camera.zoom(0.8);
    else if (e.key === "-") camera.zoom(1.25);
    else if (e.key === "0") camera.fit(film.scene);
    else if (e.key === " ") button.click();
    else return;
    e.preventDefault();
    stale = true;
  });

  const frame = now => {
    requestAnimationFrame(frame);
    const p = sounding();
    if (p) { at = p.currentTime; playing = false; }
    else if (playing) {
      at = Math.min(film.seconds, at + (now - last) / 1000);
      if (at >= film.seconds) playing = false;
    }
    last = now;
    if (!seen || !(p || playing || stale)) return;
    stale = false;
    picture.draw(camera, film.at(at), film);
    show();
    root.film = at.toFixed(3);
  };
  root.filmFrames = film.frames;
  requestAnimationFrame(frame);
})();
