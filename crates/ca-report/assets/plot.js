// Plot on a canvas: curves over one grid, a picture behind them, marks, and a legend with the values at the pointer. A
// drag zooms along x, a double click shows all.
"use strict";

class Plot {
  // `x` and each of `columns` are numbers, null for a gap; `image` is behind the curves
  constructor(place, about, x, columns, image) {
    Object.assign(this, { place, about, grid: x, columns, image, events: new EventTarget() });
    this.x = new Axis(about.x);
    this.y = new Axis(about.y);
    this.hidden = columns.map(() => false);
    this.colours = columns.map((_, i) => "--c" + i % 8);
    this.#build();
    this.reset();
  }

  #build() {
    const make = (tag, name, parent) => {
      const e = document.createElement(tag);
      e.className = name;
      parent.append(e);
      return e;
    };
    this.root = make("div", "chart", this.place);
    this.canvas = make("canvas", "", this.root);
    this.over = make("div", "chart-over", this.root);
    this.line = make("div", "chart-line", this.over);
    this.selection = make("div", "chart-selection", this.over);
    this.playhead = make("div", "playhead", this.over);
    this.line.hidden = this.selection.hidden = this.playhead.hidden = true;
    this.legend = make("div", "chart-legend", this.root);
    const entry = name => {
      const b = make("button", "", this.legend), swatch = make("i", "", b);
      b.type = "button";
      b.append(name + " ");
      return { button: b, swatch, value: make("output", "", b) };
    };
    this.entries = [this.x.name, ...this.about.curves.map(c => c.name)].map(entry);
    this.entries[0].button.disabled = true;
    this.entries.slice(1).forEach(({ button, swatch }, i) => {
      swatch.style.background = `var(${this.colours[i]})`;
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        this.hidden[i] = !this.hidden[i];
        button.setAttribute("aria-pressed", String(!this.hidden[i]));
        this.draw();
      });
    });
    this.legend.hidden = Boolean(this.image);
    this.point(null);
    this.#listen();
  }

  #listen() {
    let down = null;
    const at = e => e.clientX - this.over.getBoundingClientRect().left;
    const send = (name, detail) => this.events.dispatchEvent(new CustomEvent(name, { detail }));
    this.over.addEventListener("pointerdown", e => {
      if (e.button !== 0) return;
      down = at(e);
      this.over.setPointerCapture(e.pointerId);
    });
    this.over.addEventListener("pointermove", e => {
      const now = at(e), from = Math.max(0, Math.min(down ?? now, now)), to = Math.min(this.over.clientWidth, Math.max(down ?? now, now));
      this.selection.hidden = down == null || to - from < 5;
      this.selection.style.left = from + "px";
      this.selection.style.width = to - from + "px";
      send("point", this.valueAt(now));
    });
    this.over.addEventListener("pointerup", e => {
      if (down == null) return;
      const now = Math.max(0, Math.min(this.over.clientWidth, at(e))), from = down;
      down = null;
      this.selection.hidden = true;
      if (Math.abs(now - from) >= 5) send("zoom", [from, now].map(p => this.valueAt(p)).sort((a, b) => a - b));
      else send("choose", this.valueAt(now));
    });
    this.over.addEventListener("pointercancel", () => {
      down = null;
      this.selection.hidden = true;
    });
    this.over.addEventListener("pointerleave", () => send("point", null));
    this.over.addEventListener("dblclick", () => send("zoom", null));
  }

  // converts a pixel of `over` to a value of x, and back
  valueAt(pixel) {
    return this.x.of(this.x.from + pixel);
  }
  pixelOf(value) {
    return this.x.at(value) - this.x.from;
  }

  reset() {
    this.zoom(this.x.wholeAlong(this.grid[0], this.grid[this.grid.length - 1]));
  }

  zoom([low, high]) {
    if (!(low < high)) return;
    this.x.show(low, high);
    this.draw();
  }

  // shows the values at x in the legend, none for null
  point(value) {
    const i = value == null ? null : this.#nearest(value);
    const inside = i != null && this.grid[i] >= this.x.low && this.grid[i] <= this.x.high;
    this.line.hidden = !inside;
    if (inside) this.line.style.left = this.pixelOf(this.grid[i]) + "px";
    this.entries.forEach((e, n) => e.value.textContent = inside ? plain(n ? this.columns[n - 1][i] : this.grid[i]) : "–");
  }

  // returns the index of the first grid point at or above a value
  #from(value) {
    let low = 0, high = this.grid.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.grid[middle] < value) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  #nearest(value) {
    const i = this.#from(value), last = this.grid.length - 1;
    if (i > last) return last;
    return i > 0 && value - this.grid[i - 1] < this.grid[i] - value ? i - 1 : i;
  }

  draw() {
    const ratio = devicePixelRatio || 1, c = this.canvas.getContext("2d"), width = this.place.clientWidth;
    const height = this.image ? 300 : 240;
    // one point beyond each edge, so that lines reach it
    this.first = Math.max(0, this.#from(this.x.low) - 1);
    this.end = Math.min(this.grid.length, this.#from(this.x.high) + 2);
    this.width = width;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.canvas.style.height = height + "px";
    c.scale(ratio, ratio);
    const style = getComputedStyle(document.documentElement);
    this.colour = name => style.getPropertyValue(name).trim();
    c.font = "12px system-ui, sans-serif";
    this.y.show(...this.#shownUp());
    const top = 8, bottom = height - 46;
    this.y.place(bottom, top);
    const ticksUp = this.y.ticks((bottom - top) / 30);
    const words = Math.max(28, ...ticksUp.map(([, text]) => c.measureText(text).width));
    this.x.place(Math.ceil(words) + 34, width - 14);
    const ticksAlong = this.x.ticks((this.x.to - this.x.from) / 60);
    const box = [this.x.from, top, this.x.to - this.x.from, bottom - top];
    ["left", "top", "width", "height"].forEach((side, i) => this.over.style[side] = box[i] + "px");
    this.#axes(c, ticksAlong, ticksUp, box);
    c.save();
    c.beginPath();
    c.rect(...box);
    c.clip();
    if (this.image) this.#picture(c, box);
    this.columns.forEach((y, i) => this.hidden[i] || this.#curve(c, y, this.about.curves[i].look, this.colour(this.colours[i])));
    this.#marks(c, box);
    c.restore();
  }

  #shownUp() {
    let low = Infinity, high = -Infinity;
    this.columns.forEach((y, n) => {
      if (this.hidden[n]) return;
      for (let i = this.first; i < this.end; i++) {
        if (y[i] == null) continue;
        low = Math.min(low, y[i]);
        high = Math.max(high, y[i]);
      }
    });
    return this.y.aroundUp(low, high);
  }

  #axes(c, along, up, [left, top, width, height]) {
    const bottom = top + height, line = (x0, y0, x1, y1) => {
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1, y1);
      c.stroke();
    };
    c.strokeStyle = this.colour("--line");
    c.fillStyle = this.colour("--soft");
    c.lineWidth = 1;
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const [value, text] of along) {
      const x = this.x.at(value);
      line(x, this.image ? bottom : top, x, bottom + 5);
      c.fillText(text, x, bottom + 8);
    }
    c.fillText(this.x.name, left + width / 2, bottom + 27);
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const [value, text] of up) {
      const y = this.y.at(value);
      line(left - 5, y, this.image ? left : left + width, y);
      c.fillText(text, left - 8, y);
    }
    c.save();
    c.translate(10, top + height / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = "center";
    c.fillText(this.y.name, 0, 0);
    c.restore();
  }

  #picture(c, [, top, , height]) {
    const [from, to] = [this.grid[0], this.grid[1]].map(v => this.x.at(v));
    c.drawImage(this.image, from, top, to - from, height);
  }

  #curve(c, y, look, colour) {
    c.strokeStyle = colour + (look === "line" ? "d9" : "");
    c.lineWidth = 1.25;
    if (look === "bars") return this.#bars(c, y, colour);
    if (look !== "points") this.#line(c, y, look === "both");
    if (look === "line") return;
    c.fillStyle = look === "both" ? colour : this.colour("--panel");
    this.#each(y, (px, py) => {
      c.beginPath();
      c.arc(px, py, look === "both" ? 3.5 : 3, 0, 2 * Math.PI);
      c.fill();
      c.stroke();
    });
  }

  #each(y, visit) {
    for (let i = this.first; i < this.end; i++) if (y[i] != null) visit(this.x.at(this.grid[i]), this.y.at(y[i]));
  }

  // draws the first, smallest, largest and last of all points in a column of pixels
  #line(c, y, spanGaps) {
    let column = null, pen = false;
    const flush = () => {
      if (!column) return;
      for (const v of [column.first, column.least, column.greatest, column.last]) {
        if (pen) c.lineTo(column.x, v);
        else c.moveTo(column.x, v);
        pen = true;
      }
      column = null;
    };
    c.beginPath();
    for (let i = this.first; i < this.end; i++) {
      if (y[i] == null) {
        if (spanGaps) continue;
        flush();
        pen = false;
        continue;
      }
      const px = this.x.at(this.grid[i]), py = this.y.at(y[i]);
      if (column && Math.floor(px) === Math.floor(column.x)) {
        column.least = Math.min(column.least, py);
        column.greatest = Math.max(column.greatest, py);
        column.last = py;
      } else {
        flush();
        column = { x: px, first: py, least: py, greatest: py, last: py };
      }
    }
    flush();
    c.stroke();
  }

  #bars(c, y, colour) {
    const places = Array.from({ length: this.end - this.first }, (_, i) => this.x.at(this.grid[this.first + i]));
    const least = places.slice(1).reduce((w, p, i) => Math.min(w, p - places[i]), this.x.to - this.x.from);
    const width = Math.max(1, least - 1), ground = Math.min(this.y.from, this.y.log ? this.y.from : this.y.at(Math.max(0, this.y.low)));
    c.fillStyle = colour + "66";
    this.#each(y, (px, py) => {
      c.fillRect(px - width / 2, py, width, ground - py);
      c.strokeRect(px - width / 2, py, width, ground - py);
    });
  }

  // a text that would cover another is left out until a zoom separates them
  #marks(c, [left, top, width, height]) {
    const taken = [];
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "left";
    c.textBaseline = "top";
    for (const [value, up, text] of this.about.marks) {
      const x = this.x.at(value);
      if (!(x >= left && x <= left + width)) continue;
      const wide = c.measureText(text).width;
      const textTop = Math.max(top + 3, up == null ? 0 : this.y.at(up) - 16);
      const textLeft = Math.max(left, Math.min(x + 3, left + width - wide - 2));
      if (taken.some(t => textLeft < t[0] + t[2] && t[0] < textLeft + wide && Math.abs(t[1] - textTop) < 12)) continue;
      taken.push([textLeft, textTop, wide]);
      if (up == null) {
        c.strokeStyle = this.colour("--soft");
        c.globalAlpha = 0.45;
        c.lineWidth = 1;
        c.setLineDash([3, 3]);
        c.beginPath();
        c.moveTo(x, top);
        c.lineTo(x, top + height);
        c.stroke();
        c.setLineDash([]);
        c.globalAlpha = 1;
      }
      c.fillStyle = this.colour("--ink");
      c.fillText(text, textLeft, textTop);
    }
  }
}
