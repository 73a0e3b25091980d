// Draws the plots of the page from its data. What went wrong is counted in attributes of the root element, so that
// whoever tests the page can see it: data-errors, data-violations, and data-ready with the number of plots drawn.
"use strict";
(() => {
  const root = document.documentElement.dataset;
  root.errors = root.violations = 0;
  addEventListener("error", () => root.errors++);
  addEventListener("unhandledrejection", () => root.errors++);
  addEventListener("securitypolicyviolation", () => root.violations++);

  const data = JSON.parse(document.getElementById("data").textContent);
  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = i => css("--c" + i % 8);
  const font = "12px system-ui, sans-serif";

  // 32-bit floats, least byte first
  const unpack = text => {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0)), view = new DataView(bytes.buffer);
    return Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
  };
  const finite = v => Number.isFinite(v) ? v : null;
  const positive = v => v > 0 && v < Infinity ? v : null;

  // as many digits as a number has, and no more than six
  const plain = v => {
    if (v == null) return "–";
    const a = Math.abs(v);
    if (a !== 0 && (a < 1e-4 || a >= 1e7)) return v.toExponential(Number.isInteger(Math.log10(a)) ? 0 : 2);
    return String(+v.toPrecision(6));
  };
  const prefixed = v => v >= 1e6 && v < 1e9 ? plain(v / 1e6) + "M" : v >= 1e3 && v < 1e6 ? plain(v / 1e3) + "k" : plain(v);
  const exponent = v => {
    const e = Math.floor(Math.log10(v) + 1e-9), m = +(v / 10 ** e).toPrecision(3);
    return (m === 1 ? "" : m + "·") + "10" + String(e).replace(/[0-9-]/g, d => d === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);
  };
  // over up to four decades 1, 2 and 5, over more the decades
  const logTicks = (low, high) => {
    const from = Math.floor(Math.log10(low)), to = Math.ceil(Math.log10(high)), ticks = [];
    const skip = Math.max(1, Math.ceil((to - from) / 8));
    for (let e = from; e <= to; e += skip)
      for (const m of to - from <= 4 ? [1, 2, 5] : [1]) ticks.push(m * 10 ** e);
    return ticks.map(t => +t.toPrecision(3)).filter(t => t >= low && t <= high);
  };
  const name = a => a.label + (a.unit ? " [" + a.unit + "]" : "");

  // what the words beside an axis need, and no less than others have
  const wide = least => (u, values, i, cycle) => {
    const axis = u.axes[i];
    if (cycle > 1) return axis._size;
    u.ctx.font = axis.font[0];
    const words = (values || []).map(v => u.ctx.measureText(v == null ? "" : v).width);
    return Math.max(least, Math.ceil(axis.ticks.size + axis.gap + Math.max(0, ...words) / (devicePixelRatio || 1)));
  };

  const axisOf = (a, size) => ({
    label: name(a), labelSize: 20, labelFont: font, font, size, stroke: css("--soft"),
    grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line"), width: 1 },
    ...(a.log
      ? { splits: (u, i, low, high) => logTicks(low, high), filter: (u, s) => s,
          values: (u, s) => s.map(a.unit === "Hz" ? prefixed : v => v >= 1e-3 && v < 1e5 ? plain(v) : exponent(v)) }
      : { values: (u, s) => s.map(plain) }),
  });

  // along: all of it at first, then what is zoomed to; up: with some room
  const across = (a, x) => (u, low, high) => {
    const [first, last] = [x[0], x[x.length - 1]];
    if (low == null) return [0, 1];
    if (low > first || high < last) return [low, high];
    if (a.range) return a.range;
    return first < last ? [first, last] : a.log ? [first / 2, first * 2] : [first - 0.5, first + 0.5];
  };
  const upward = a => (u, low, high) => {
    if (a.range) return a.range;
    if (a.log) return low == null ? [1, 10]
      : low === high ? [low / 2, high * 2] : [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high))];
    if (low == null) return [0, 1];
    const pad = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
    return [low - pad, high + pad];
  };

  const marks = plot => u => {
    const c = u.ctx, ratio = devicePixelRatio || 1, taken = [];
    c.save();
    c.beginPath();
    c.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    c.clip();
    c.font = 11 * ratio + "px system-ui, sans-serif";
    c.textBaseline = "top";
    for (const [x, y, text] of plot.marks) {
      const at = u.valToPos(x, "x", true);
      if (!(at >= u.bbox.left && at <= u.bbox.left + u.bbox.width)) continue;
      const wide = c.measureText(text).width, most = u.bbox.left + u.bbox.width - wide - 2 * ratio;
      // whole at the edges too
      const top = Math.max(u.bbox.top + 3 * ratio, y == null ? 0 : u.valToPos(y, "y", true) - 16 * ratio);
      const left = Math.max(u.bbox.left, Math.min(at + 3 * ratio, most));
      // marks whose words would cover others are left out; zooming shows them
      if (taken.some(t => left < t[0] + t[2] && t[0] < left + wide && Math.abs(t[1] - top) < 12 * ratio)) continue;
      taken.push([left, top, wide]);
      if (y == null) {
        c.strokeStyle = css("--soft");
        c.globalAlpha = 0.45;
        c.lineWidth = ratio;
        c.setLineDash([3 * ratio, 3 * ratio]);
        c.beginPath();
        c.moveTo(at, u.bbox.top);
        c.lineTo(at, u.bbox.top + u.bbox.height);
        c.stroke();
        c.globalAlpha = 1;
      }
      c.fillStyle = css("--ink");
      c.fillText(text, left, top);
    }
    c.restore();
  };

  const picture = image => u => {
    const [x0, x1] = [u.data[0][0], u.data[0][1]].map(v => u.valToPos(v, "x", true));
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    u.ctx.clip();
    u.ctx.drawImage(image, x0, u.bbox.top, x1 - x0, u.bbox.height);
    u.ctx.restore();
  };

  const together = uPlot.sync("time");
  const seriesOf = (curve, i) => ({
    label: curve.name, stroke: colour(i) + (curve.look === "line" ? "d9" : ""), width: 1.25, value: (u, v) => plain(v),
    spanGaps: curve.look === "both",
    ...(curve.look === "line" ? { points: { show: false } } : {}),
    ...(curve.look === "points" ? { paths: () => null, points: { show: true, size: 6, fill: css("--panel") } } : {}),
    ...(curve.look === "both" ? { points: { show: true, size: 7, fill: colour(i) } } : {}),
    ...(curve.look === "bars" ? { paths: uPlot.paths.bars({ size: [1, Infinity] }), fill: colour(i) + "66", points: { show: false } } : {}),
  });

  const draw = plot => {
    const place = document.getElementById(plot.id), image = document.getElementById(plot.id + "-image");
    const x = typeof plot.grid === "string" ? unpack(plot.grid)
      : Array.from({ length: plot.grid[2] }, (_, i) => plot.grid[0] + i * plot.grid[1]);
    const columns = plot.curves.map(c => unpack(c.y).map(plot.y.log ? positive : finite));
    const time = plot.x.unit === "s" && !plot.x.log;
    if (image) image.remove();
    const options = {
      width: place.clientWidth, height: image ? 300 : 240,
      scales: {
        x: { time: false, distr: plot.x.log ? 3 : 1, range: across(plot.x, x) },
        y: { distr: plot.y.log ? 3 : 1, range: upward(plot.y) },
      },
      axes: [axisOf(plot.x, 34), axisOf(plot.y, wide(56))],
      series: [{ label: name(plot.x), value: (u, v) => plain(v) }, ...plot.curves.map(seriesOf)],
      cursor: { y: Boolean(image), ...(time ? { sync: { key: together.key, scales: ["x", null] } } : {}) },
      legend: { show: !image },
      hooks: { drawAxes: image ? [picture(image)] : [], draw: plot.marks.length ? [marks(plot)] : [] },
    };
    if (image) options.axes.forEach(a => a.grid = { show: false });
    const u = new uPlot(options, [x, ...columns], place);
    if (time) {
      // a click, which is no drag, goes to that place in the sound, and in the picture
      let down = null;
      u.over.addEventListener("pointerdown", e => { down = [e.clientX, e.clientY]; });
      u.over.addEventListener("click", e => {
        if (!down || Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4) return;
        seek(u.posToVal(e.clientX - u.over.getBoundingClientRect().left, "x"));
      });
      const head = document.createElement("div");
      head.className = "playhead";
      head.hidden = true;
      u.over.append(head);
      u.playhead = head;
    }
    u.shown = place;
    if (image) u.kept = image;
    return u;
  };

  let drawn = [];
  const all = () => {
    for (const u of drawn) {
      if (u.kept) u.shown.append(u.kept);
      u.destroy();
    }
    drawn = data.plots.map(draw);
    root.ready = drawn.length;
  };

  const players = [...document.querySelectorAll("audio")];
  const seek = t => {
    for (const p of players) if (t >= 0 && t < p.duration) p.currentTime = t;
    dispatchEvent(new CustomEvent("seek", { detail: t }));
  };
  const follow = () => {
    const now = players.find(p => !p.paused);
    for (const u of drawn.filter(u => u.playhead)) {
      const at = now ? u.valToPos(now.currentTime, "x") : -1;
      u.playhead.hidden = !(at >= 0 && at <= u.over.clientWidth);
      u.playhead.style.left = at + "px";
    }
    if (now) requestAnimationFrame(follow);
  };
  players.forEach(p => p.addEventListener("play", () => {
    players.forEach(other => other !== p && other.pause());
    requestAnimationFrame(follow);
  }));

  const pictures = [...document.images].map(i => i.decode().catch(() => {}));
  Promise.all(pictures).then(() => {
    all();
    const narrower = new ResizeObserver(() => drawn.forEach(u => {
      const width = u.shown.clientWidth;
      if (width && width !== u.width) u.setSize({ width, height: u.height });
    }));
    narrower.observe(document.querySelector("main"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", all);
  });
})();
