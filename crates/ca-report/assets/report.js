// Draws the plots of the page from its data, synchronised with the players. For tests, attributes of the root element
// count errors (data-errors, data-violations), and data-ready has the number of plots drawn.
"use strict";
(() => {
  const root = document.documentElement.dataset;
  root.errors = root.violations = 0;
  addEventListener("error", () => root.errors++);
  addEventListener("unhandledrejection", () => root.errors++);
  addEventListener("securitypolicyviolation", () => root.violations++);

  const data = JSON.parse(document.getElementById("data").textContent);

  // decodes 32-bit little-endian floats
  const unpack = text => {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0)), view = new DataView(bytes.buffer);
    return Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
  };
  const finite = v => Number.isFinite(v) ? v : null;
  const positive = v => v > 0 && v < Infinity ? v : null;

  const made = about => {
    const place = document.getElementById(about.id), image = document.getElementById(about.id + "-image");
    const x = typeof about.grid === "string" ? unpack(about.grid)
      : Array.from({ length: about.grid[2] }, (_, i) => about.grid[0] + i * about.grid[1]);
    const columns = about.curves.map(c => unpack(c.y).map(about.y.log ? positive : finite));
    if (image) image.remove();
    return new Plot(place, about, x, columns, image);
  };

  // plots over time share pointer and range of x; a click in one moves the sound to that time
  const join = plots => {
    const overTime = plots.filter(p => p.about.x.unit === "s" && !p.x.log);
    for (const p of plots) {
      const together = overTime.includes(p) ? overTime : [p];
      p.events.addEventListener("point", e => together.forEach(q => q.point(e.detail)));
      p.events.addEventListener("zoom", e => together.forEach(q => e.detail ? q.zoom(e.detail) : q.reset()));
      if (together === overTime) p.events.addEventListener("choose", e => seek(e.detail));
    }
    return overTime;
  };

  const players = [...document.querySelectorAll("audio")];
  const seek = t => {
    for (const p of players) if (t >= 0 && t < p.duration) p.currentTime = t;
    dispatchEvent(new CustomEvent("seek", { detail: t }));
  };

  const pictures = [...document.images].map(i => i.decode().catch(() => {}));
  Promise.all(pictures).then(() => {
    const plots = data.plots.map(made), overTime = join(plots);
    root.ready = plots.length;

    const follow = () => {
      const now = players.find(p => !p.paused);
      for (const p of overTime) {
        const at = now ? p.pixelOf(now.currentTime) : -1;
        p.playhead.hidden = !(at >= 0 && at <= p.over.clientWidth);
        p.playhead.style.left = at + "px";
      }
      if (now) requestAnimationFrame(follow);
    };
    players.forEach(p => p.addEventListener("play", () => {
      players.forEach(other => other !== p && other.pause());
      requestAnimationFrame(follow);
    }));
    const resized = new ResizeObserver(() => plots.forEach(p => {
      if (p.place.clientWidth && p.place.clientWidth !== p.width) p.draw();
    }));
    resized.observe(document.querySelector("main"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plots.forEach(p => p.draw()));
  });
})();
